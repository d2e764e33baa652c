#pragma once
#include "libdem/kernel/any_bonded_law.hpp"
#include "libdem/kernel/bonded_kernel_body.hpp"
#include "libdem/kernel/plain_kernel_body.hpp"

/// Kernels of a law without bonds, and with them those that all such laws share.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

template <class Normal>
AnyBondedLaw any_bonded_law(const void* parameters) {
  const auto& law = *static_cast<const Bonded<Normal>*>(parameters);
  return {
      .law = static_cast<const Normal*>(&law),
      .normal_of = [](const void* of, const Approach<double>& a,
                      double(&memory)[kOwnMemory]) { return normal_force(*static_cast<const Normal*>(of), a, memory); },
      .own_memory = Normal::has.memory,
      .friction = law.friction,
      .bond = law.bond};
}

template <class Normal>
const LawKernels& kernels_of_bondable_law() {
  static constexpr LawKernels kernels{
      [](const void* p, PairJob& job) { run_any_bonded_law(any_bonded_law<Normal>(p), false, job); },
      [](const void* p, PairJob& job) { run_any_bonded_law(any_bonded_law<Normal>(p), true, job); },
      [](const void* p, PlaneJob& job) { run_law_on_planes<Normal>(law_alone<Normal>(p), job); },
      [](const void* p, SurfaceJob& job) { run_law_on_surface<Normal>(law_alone<Normal>(p), job); }};
  return kernels;
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
