#pragma once
#include "libdem/kernel/pair_kernel_body.hpp"

/// Kernels of a law whose spheres may be bonded: at surfaces those of the law alone.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

template <class Normal>
const Normal* law_alone(const void* parameters) {
  return static_cast<const Bonded<Normal>*>(parameters);
}

template <class Normal>
const LawKernels& kernels_of_bonded_law() {
  using L = Bonded<Normal>;
  static constexpr LawKernels kernels{
      run_law_on_pairs<VecD, L>, run_law_on_pairs<VecF, L>,
      [](const void* p, PlaneJob& job) { law_kernels<Normal>().planes(law_alone<Normal>(p), job); },
      [](const void* p, SurfaceJob& job) { law_kernels<Normal>().surface(law_alone<Normal>(p), job); }};
  return kernels;
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
