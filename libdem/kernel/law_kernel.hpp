#pragma once
#include "libdem/kernel/streams.hpp"

/// The kernel's work for one law, declared. CMake makes a file per law and instruction set that instantiates the
/// definitions (law_kernel_body.hpp): a change in a law compiles that law.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

template <class L>
struct LawKernel {
  static void pairs(const L& law, PairJob& job);
  static void planes(const L& law, PlaneJob& job);
  static void surface(const L& law, SurfaceJob& job);
};

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
