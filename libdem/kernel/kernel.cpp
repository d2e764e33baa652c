// Compiled once per instruction set with SUBSOIL_ISA naming it (libdem/CMakeLists.txt).
#include "libdem/kernel/accumulation.hpp"
#include "libdem/kernel/move.hpp"

namespace subsoil::dem {
inline namespace SUBSOIL_ISA {
Kernel kernel() {
#define SUBSOIL_NAME_(x) #x
#define SUBSOIL_NAME(x) SUBSOIL_NAME_(x)
  return {SUBSOIL_NAME(SUBSOIL_ISA), InstructionSet::SUBSOIL_ISA, keep, add_interface, observe, move};
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
