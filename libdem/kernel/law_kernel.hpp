#pragma once
#include "libdem/contacts/blocks.hpp"

/// The kernel's work for one law, declared. CMake makes two files per law and instruction set that instantiate the
/// definitions (law_kernel_body.hpp), for double and for mixed precision: a change in a law compiles that law.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

template <class L>
struct LawKernel {
  static void pairs(const L& law, PairJob& job);
  static void planes(const L& law, PlaneJob& job);  ///< in double whatever the precision of pairs
  static void surface(const L& law, SurfaceJob& job);
};

template <class L>
struct MixedLawKernel {
  static void pairs(const L& law, PairJob& job);
};

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
