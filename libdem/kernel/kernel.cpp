// Compiled once per instruction set with SUBSOIL_ISA naming it (libdem/CMakeLists.txt).
#include "libdem/kernel/move.hpp"
#include "libdem/kernel/pairs.hpp"
#include "libdem/kernel/planes.hpp"
#include "libdem/kernel/surface.hpp"

namespace subsoil::dem {
inline namespace SUBSOIL_ISA {
namespace {

/// Chooses law and rolling outside the loops over contacts: `run(law, rolls)` gets both as types.
template <class Run>
void with(const Law& law, const Run& run) {
  std::visit(
      [&](const auto& l) {
        if (l.friction.rolling != Rolling::none && l.friction.mu_r > 0)
          run(l, std::true_type{});
        else
          run(l, std::false_type{});
      },
      law);
}

void pairs(const Law& law, PairJob& job) {
  with(law, [&](const auto& l, auto rolls) {
    if (job.book)
      run_pairs<rolls.value, true>(l, job);
    else
      run_pairs<rolls.value, false>(l, job);
  });
}
void planes(const Law& law, PlaneJob& job) {
  with(law, [&](const auto& l, auto rolls) { run_planes<rolls.value>(l, job); });
}
void surface(const Law& law, SurfaceJob& job) {
  with(law, [&](const auto& l, auto rolls) { run_surface<rolls.value>(l, job); });
}

}  // namespace

Kernel kernel() {
#define SUBSOIL_NAME_(x) #x
#define SUBSOIL_NAME(x) SUBSOIL_NAME_(x)
  return {SUBSOIL_NAME(SUBSOIL_ISA), pairs, planes, surface, move};
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
