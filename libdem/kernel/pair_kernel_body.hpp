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

/// Whether loops that accumulate nothing, for the usual friction alone, are compiled beside the general ones, which
/// give the same bits.
#ifdef SUBSOIL_GENERAL_LOOPS_ONLY
inline constexpr bool kUsualLoops = false;
#else
inline constexpr bool kUsualLoops = true;
#endif

/// Chooses the loop outside of it: `run(accumulates)` gets as a type whether it is the general one.
template <class L, class Run>
void with_accumulation(const L& law, bool record, const Run& run) {
  if constexpr (!kUsualLoops)
    run(std::true_type{});
  else if (record || !law.friction.usual())
    run(std::true_type{});
  else
    run(std::false_type{});
}

template <class P, class L>
void run_law_on_pairs(const void* parameters, PairJob& job) {
  const L& law = *static_cast<const L*>(parameters);
  with_rolling(law, [&](auto rolls) {
    with_accumulation(law, job.record,
                      [&](auto accumulates) { run_pairs<P, rolls.value, accumulates.value>(law, job); });
  });
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
