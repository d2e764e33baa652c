// Compiled once per instruction set, as kernel.cpp.
#include "libdem/kernel/any_bonded_law.hpp"

#include "libdem/kernel/pair_kernel_body.hpp"

namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

namespace {

constexpr int kNumbers = 12;

/// use(number, place) for each number of an answer.
template <class T, class Use>
void each_number(NormalForce<T>& n, const Use& use) {
  static_assert(sizeof(NormalForce<double>) == (kNumbers + 1) * sizeof(double), "beside in_contact");
  T* const numbers[kNumbers] = {&n.force, &n.damping, &n.limiting_force,  &n.stored,
                                &n.k_n,   &n.k_t,     &n.stiffness_ratio, &n.tangential_compliance,
                                &n.c_t,   &n.c_n,     &n.attraction,      &n.lost};
  for (int k = 0; k < kNumbers; ++k) use(*numbers[k], k);
}

}  // namespace

template <class T>
NormalForce<T> AnyBondedLaw::normal(const Approach<T>& a, T (&memory)[kOwnMemory]) const {
  using Real = typename T::Real;
  using Lanes = Real[T::kLanes];
  Lanes overlap, rate, root_m, r_eff, elapsed, per_sum, own[kOwnMemory], touches, answers[kNumbers];
  store(a.overlap, overlap), store(a.rate, rate), store(a.root_m, root_m);
  store(a.r_eff, r_eff), store(a.elapsed, elapsed), store(a.per_sum, per_sum);
  for (int i = 0; i < kOwnMemory; ++i) store(i < own_memory ? memory[i] : T(0.0), own[i]);
  for (int l = 0; l < T::kLanes; ++l) {
    double kept[kOwnMemory];
    for (int i = 0; i < kOwnMemory; ++i) kept[i] = own[i][l];
    NormalForce<double> n = normal_of(law, {overlap[l], rate[l], root_m[l], r_eff[l], elapsed[l], per_sum[l]}, kept);
    each_number(n, [&](double x, int k) { answers[k][l] = static_cast<Real>(x); });
    touches[l] = n.in_contact ? 1 : 0;
    for (int i = 0; i < kOwnMemory; ++i) own[i][l] = static_cast<Real>(kept[i]);
  }
  NormalForce<T> out;
  each_number(out, [&](T& x, int k) { x = load<T>(answers[k]); });
  out.in_contact = load<T>(touches) > T(0.5);
  for (int i = 0; i < own_memory; ++i) memory[i] = load<T>(own[i]);
  return out;
}

/// As of any law, but for the numbers that it keeps: how many is known when it runs.
template <bool Rolls>
struct Remembers<AnyBondedLaw, Rolls> {
  static constexpr bool rolls = Rolls;
  int own;
  bool twists, slip;

  explicit Remembers(const AnyBondedLaw& law)
      : own(law.own_memory), twists(law.friction.resists_twist()), slip(law.friction.remembers_slip()) {}
  MemoryShape shape(bool bonds, bool single) const {
    return {.rolls = rolls, .twists = twists, .bonds = bonds, .own = own, .single = single};
  }
};

void run_any_bonded_law(const AnyBondedLaw& law, bool mixed, PairJob& job) {
  mixed ? run_law_on_pairs<VecF, AnyBondedLaw>(&law, job) : run_law_on_pairs<VecD, AnyBondedLaw>(&law, job);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
