#pragma once
#include "libdem/contacts/blocks.hpp"

/// The kernels of one law, declared. CMake writes a file per law, with and without cohesion or bonds, and compiles it
/// once per instruction set; it defines law_kernels() of that law (plain_kernel_body.hpp, bonded_kernel_body.hpp),
/// which the law's interface refers to (laws/contact_law_of.hpp).
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

template <class L>
const LawKernels& law_kernels();

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
