#pragma once
#include "libdem/kernel/law_kernel.hpp"
#include "libdem/kernel/pairs.hpp"

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
void run_law_on_pairs(const void* parameters, PairJob& job) {
  const L& law = *static_cast<const L*>(parameters);
  with_rolling(law, [&](auto rolls) {
    if (job.book || !law.friction.usual())
      run_pairs<P, rolls.value, true>(law, job);
    else
      run_pairs<P, rolls.value, false>(law, job);
  });
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
