// Compiled once per instruction set with SUBSOIL_ISA naming it (libdem/CMakeLists.txt).
#include "libdem/kernel/adding.hpp"
#include "libdem/kernel/law_kernel.hpp"
#include "libdem/kernel/move.hpp"

namespace subsoil::dem {
inline namespace SUBSOIL_ISA {
namespace {

/// Chooses the law outside the loops over contacts.
template <class Job>
void with(const Law& law, Job& job) {
  std::visit(
      [&]<class L>(const L& l) {
        if constexpr (std::is_same_v<Job, PairJob>)
          job.mixed != nullptr ? MixedLawKernel<L>::pairs(l, job) : LawKernel<L>::pairs(l, job);
        if constexpr (std::is_same_v<Job, PlaneJob>) LawKernel<L>::planes(l, job);
        if constexpr (std::is_same_v<Job, SurfaceJob>) LawKernel<L>::surface(l, job);
      },
      law);
}

}  // namespace

Kernel kernel() {
#define SUBSOIL_NAME_(x) #x
#define SUBSOIL_NAME(x) SUBSOIL_NAME_(x)
  return {SUBSOIL_NAME(SUBSOIL_ISA), with<PairJob>, with<PlaneJob>, with<SurfaceJob>, keep, add_seam, observe, move};
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
