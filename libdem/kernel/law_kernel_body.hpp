#pragma once
#include "libdem/kernel/law_kernel.hpp"
#include "libdem/kernel/pairs.hpp"
#include "libdem/kernel/planes.hpp"
#include "libdem/kernel/surface.hpp"

namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

/// Chooses rolling resistance outside the loops over contacts: `run(rolls)` gets it as a type.
template <class L, class Run>
void with_rolling(const L& law, const Run& run) {
  if constexpr (kBonds<L>)
    run(std::true_type{});  // moments of bonds need what rolling resistance does
  else if (law.friction.resists_rolling())
    run(std::true_type{});
  else
    run(std::false_type{});
}

template <class P, class L>
void pairs_of(const L& law, PairJob& job) {
  with_rolling(law, [&](auto rolls) {
    if (job.book || !law.friction.usual())
      run_pairs<P, rolls.value, true>(law, job);
    else
      run_pairs<P, rolls.value, false>(law, job);
  });
}

template <class L>
void LawKernel<L>::pairs(const L& law, PairJob& job) {
  pairs_of<VecD>(law, job);
}

template <class L>
void MixedLawKernel<L>::pairs(const L& law, PairJob& job) {
  pairs_of<VecF>(law, job);
}

template <class L>
void LawKernel<L>::planes(const L& law, PlaneJob& job) {
  with_rolling(law, [&](auto rolls) {
    if (job.book || !law.friction.usual())
      run_planes<rolls.value, true>(law, job);
    else
      run_planes<rolls.value, false>(law, job);
  });
}

template <class L>
void LawKernel<L>::surface(const L& law, SurfaceJob& job) {
  with_rolling(law, [&](auto rolls) { run_surface<rolls.value>(law, job); });
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
