#pragma once
#include "libdem/kernel/pair_kernel_body.hpp"
#include "libdem/kernel/planes.hpp"
#include "libdem/kernel/surface.hpp"

/// Kernels of a law without bonds.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

template <class L>
void run_law_on_planes(const void* parameters, PlaneJob& job) {
  const L& law = *static_cast<const L*>(parameters);
  with_rolling(law, [&](auto rolls) {
    with_accumulation(law, job.record, [&](auto accumulates) { run_planes<rolls.value, accumulates.value>(law, job); });
  });
}

template <class L>
void run_law_on_surface(const void* parameters, SurfaceJob& job) {
  const L& law = *static_cast<const L*>(parameters);
  with_rolling(law, [&](auto rolls) { run_surface<rolls.value>(law, job); });
}

template <class L>
const LawKernels& kernels_of_plain_law() {
  static constexpr LawKernels kernels{run_law_on_pairs<VecD, L>, run_law_on_pairs<VecF, L>, run_law_on_planes<L>,
                                      run_law_on_surface<L>};
  return kernels;
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
