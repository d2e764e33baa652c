#pragma once
#include <cmath>
#include <concepts>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <utility>

#include "libdem/base/range.hpp"
#include "libdem/laws/bonded.hpp"
#include "libdem/laws/cohesive.hpp"
#include "libdem/laws/friction.hpp"
#include "libdem/laws/law.hpp"

/// ContactLaw of one law. Included by the file that CMake writes for each law of laws/list.cmake, and by nothing else.
namespace subsoil::dem {

// Defined in the law's kernels of each instruction set (kernel/law_kernel.hpp).
namespace portable {
template <class L>
const LawKernels& law_kernels();
}
namespace avx2 {
template <class L>
const LawKernels& law_kernels();
}
namespace avx512 {
template <class L>
const LawKernels& law_kernels();
}

/// What a law's describe() states of itself first.
struct LawWord {
  const char* word = "";
  void card(const char* its, const char*) { word = its; }
  void quantity(auto&&...) {}
  void derived(auto&&...) {}
  void exponent(auto&&...) {}
  void flag(auto&&...) {}
  template <class E>
  void choice(const char*, E&, std::initializer_list<std::pair<const char*, std::type_identity_t<E>>>, const char*) {}
};

/// Throws std::invalid_argument for a parameter that is missing or outside the range that describe() states.
struct ParameterCheck {
  void card(auto&&...) {}
  void quantity(const char* key, double value, const char*, const Range& range, auto&&...) {
    if (std::isnan(value))
      throw std::invalid_argument(std::string(key) + ": is missing; its range is " + std::string(range.text()));
    refuse_outside(key, value, range);
  }
  void derived(const char* key, double value, const char*, const Range& range, auto&&...) {
    if (!std::isnan(value)) refuse_outside(key, value, range);
  }
  void exponent(auto&&...) {}
  void flag(auto&&...) {}
  template <class E>
  void choice(const char*, E&, std::initializer_list<std::pair<const char*, std::type_identity_t<E>>>, const char*) {}

 private:
  static void refuse_outside(const char* key, double value, const Range& range) {
    if (!range.contains(value))
      throw std::invalid_argument(std::string(key) + " = " + std::to_string(value) + ": must be in " +
                                  std::string(range.text()));
  }
};

/// Throws std::invalid_argument for what a bond cannot have beside it.
template <class Normal>
void refuse_beside_bond(const Normal& law) {
  if constexpr (requires { law.cohesion; })
    if (law.cohesion.acts())
      throw std::invalid_argument("a bond and cohesion in one law: not offered; leave one of them out");
  // Of a stretched pair moment arms of the radius would not reach the bond: torques would not balance.
  if (law.friction.moment_arm != MomentArm::mid_overlap || law.friction.slip_moment_arm != SlipMomentArm::as_force)
    throw std::invalid_argument(
        "moment arm: a bond needs mid-overlap (and `slip moment arm: as-force`), else angular momentum is not kept");
}

namespace detail {
/// L::has is what L has.
template <class L>
concept LawHas = L::has.cutoff_by_radius == requires(const L law) {
  law.cutoff(1.0);
}
&&L::has.weaken == requires(L law) { law.weaken(1.0); }
&&L::has.may_gain == requires(const L law) { law.may_gain(); }
&&L::has.refuse_collapse == requires(const L law) { law.refuse_collapse(1.0); };
}  // namespace detail

/// A contact law, with or without cohesion or bonds.
template <class L>
concept IsLaw = requires(L law, LawWord visitor, const WorstContact worst) {
  law.describe(visitor);
  law.resolved();
  { law.rest_overlap() } -> std::convertible_to<double>;
  { law.bound(worst) } -> std::same_as<StiffnessBound>;
  { law.friction } -> std::same_as<Friction&>;
  L::has;
}
&&detail::LawHas<L>;

template <IsLaw L>
class ContactLawOf final : public ContactLaw {
 public:
  explicit ContactLawOf(const L& resolved) : law_(resolved) {}

  const char* name() const override {
    LawWord visitor;
    L prototype;
    prototype.describe(visitor);
    return visitor.word;
  }
  double cutoff(double r_eff) const override {
    if constexpr (L::has.cutoff_by_radius)
      return law_.cutoff(r_eff);
    else
      return law_.cutoff();
  }
  double pair_cutoff(double largest_radius) const override {
    if constexpr (kBonds<L>)
      return law_.pair_cutoff(largest_radius);
    else
      return cutoff(0.5 * largest_radius);
  }
  double rest_overlap() const override { return law_.rest_overlap(); }
  const Friction& friction() const override { return law_.friction; }
  const Bond* bond() const override {
    if constexpr (kBonds<L>)
      return &law_.bond;
    else
      return nullptr;
  }
  int own_memory() const override { return L::has.memory; }
  bool plastic() const override { return L::has.plastic; }
  bool may_gain() const override {
    if constexpr (L::has.may_gain)
      return law_.may_gain();
    else
      return false;
  }
  NormalForce<double> normal(const Approach<double>& a, double (&memory)[kOwnMemory]) const override {
    return normal_force(law_, a, memory);
  }
  StiffnessBound bound(const WorstContact& worst) const override { return law_.bound(worst); }
  void refuse_collapse(double r_eff) const override {
    if constexpr (L::has.refuse_collapse) law_.refuse_collapse(r_eff);
  }
  Law weakened(double share) const override {
    L law = law_;
    if constexpr (L::has.weaken) law.weaken(share);  // of laws that attract
    return Law(std::make_shared<ContactLawOf>(law));
  }
  Law with_friction(const Friction& friction) const override {
    L law = law_;
    law.friction = friction;
    return Law(std::make_shared<ContactLawOf>(law));
  }
  const LawKernels& kernels([[maybe_unused]] InstructionSet set) const override {
#if defined(SUBSOIL_HAS_avx512)
    if (set == InstructionSet::avx512) return avx512::law_kernels<L>();
#endif
#if defined(SUBSOIL_HAS_avx2)
    if (set == InstructionSet::avx2) return avx2::law_kernels<L>();
#endif
#if !defined(SUBSOIL_HAS_portable) && (defined(SUBSOIL_HAS_avx2) || defined(SUBSOIL_HAS_avx512))
    throw std::logic_error("this build has no kernels of this instruction set");  // choose_kernel offers none of them
#else
    return portable::law_kernels<L>();
#endif
  }
  const void* parameters() const override { return &law_; }
  const void* parameters_of(const std::type_info& type) const override { return type == typeid(L) ? &law_ : nullptr; }

 private:
  L law_;
};

template <class L>
std::shared_ptr<const ContactLaw> make_law(const L& given) {
  L stated = given;
  if (std::isnan(stated.friction.mu)) stated.friction.mu = 0;  // friction that is left out is none
  ParameterCheck check;
  stated.describe(check);
  const L ready = stated.resolved();
  ready.friction.check();
  if constexpr (requires { ready.bond; }) {
    if (ready.bond.acts()) {
      refuse_beside_bond(ready);
      return std::make_shared<ContactLawOf<Bonded<L>>>(Bonded<L>{ready});
    }
  }
  if constexpr (requires { ready.cohesion; }) {
    if (ready.cohesion.acts()) return std::make_shared<ContactLawOf<Cohesive<L>>>(Cohesive<L>{ready});
  }
  return std::make_shared<ContactLawOf<L>>(ready);
}

/// The list must state the same as the header of the law.
template <class L, bool ListsCohesion, bool ListsBond>
constexpr void check_listing() {
  static_assert(
      ListsCohesion == requires(L law) { law.cohesion; },
      "laws/list.cmake: a law says COHESION if and only if it has a member `cohesion`");
  static_assert(
      ListsBond == requires(L law) { law.bond; },
      "laws/list.cmake: a law says BOND if and only if it has a member `bond`");
  static_assert(
      requires { L::example(); },
      "a contact law has `static L example()`, numbers with which the property tests run it");
}

}  // namespace subsoil::dem
