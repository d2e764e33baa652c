#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "libdem/impact/energy_equivalent.hpp"
#include "libdem/laws/bond.hpp"
#include "libdem/laws/elastic_pair.hpp"
#include "libdem/laws/friction.hpp"

/// Restitution that falls with the speed of each impact, by equivalence of energies (impact/energy_equivalent.hpp).
///     Ce(V) = (1 + 2 s)^(-1/2),  s = A ((rho V^2/(S_y lambda_c))^B - 1) where that is positive, else 0
///     linear:  F = k_n delta + 2 beta sqrt(m_eff k_n) d delta/dt
///     hertz:   F = (4/3) E* sqrt(R delta^3) + 2 sqrt(5/6) beta sqrt(S_n m_eff) d delta/dt,  S_n = 2 E* sqrt(R delta)
///     k_t = ratio k_n (S_n),  c_t = 2 beta sqrt(m_eff k_t) (with sqrt(5/6));   friction limit mu max(0, F)
/// V approach speed when the surfaces first touch, m/s; beta = beta(Ce) as in damping_ratio.hpp, found at first touch
/// and kept by the contact until it opens: two bodies part with exactly Ce(V) V, with more where `clip attraction` cuts
/// the pull of the dashpot off. rho kg/m^3 density and S_y Pa yield strength of the yielding body. Slow contacts, V
/// below the speed at which lambda = lambda_c, are elastic; `maximum restitution` caps Ce, so that a bed of them can
/// come to rest. Contacts that begin at rest (a bed as placed) have the cap's damping. Valid for overlap << R; the map
/// holds for V up to some 1000 times the speed at which yield begins. Source: energies after the patent of Changsha
/// University of Science and Technology (2023); map and motion are ours.
namespace subsoil::dem {

struct VariableRestitution {
  static constexpr bool constant_stiffness = false;
  static constexpr LawMembers has{.memory = 1};  ///< memory: 1 + beta while in touch
  enum class Normal { hertz, linear };
  static constexpr double left_out = std::numeric_limits<double>::quiet_NaN();
  Normal part = Normal::hertz;
  bool clip = false;
  double k_n = left_out, E_eff = left_out;
  impact::EnergyEquivalent map;
  double largest = 1;
  int yields = 0;  ///< which of the two materials, 1 or 2; 0: neither has the lower yield strength, or S_y is given
  double stiffness_ratio = 2.0 / 7.0;
  Bond bond;
  Friction friction;

  template <class V>
  void describe(V& v) {
    v.card("variable-restitution", "restitution from the speed of each impact, by energy equivalence");
    v.choice("normal", part, {{"hertz", Normal::hertz}, {"linear", Normal::linear}}, "spring under the damping");
    v.derived("k_n", k_n, "N/m", "(0, inf)", "normal stiffness of the linear spring; not with hertz");
    v.derived("E_eff", E_eff, "Pa", "(0, inf)",
              "effective Young's modulus; left out: from both materials' young and poisson");
    map.parameters(v);
    v.quantity("maximum restitution", largest, "1", "(0, 1]", "upper bound of Ce");
    v.flag("clip attraction", clip, "cut the normal force off at zero while separating (restitution then exceeds Ce)");
    v.quantity("stiffness ratio", stiffness_ratio, "1", "[0, inf)", "tangential over normal stiffness");
    bond.describe(v);
    friction.describe(v);
  }

  /// Linear contacts with a given lambda_c do without.
  bool needs_materials() const { return std::isnan(E_eff) && (part == Normal::hertz || std::isnan(map.lambda_c)); }
  static constexpr const char* in_place_of_materials = "E_eff (or k_n and lambda_c)";
  void take_materials(double young_1, double poisson_1, double young_2, double poisson_2) {
    if (std::isnan(E_eff)) E_eff = effective_modulus(young_1, poisson_1, young_2, poisson_2);
  }

  bool needs_yield() const { return std::isnan(map.S_y); }
  static constexpr const char* in_place_of_yield = "S_y";
  void take_yield(double yield_1, double yield_2) {
    if (!needs_yield()) return;
    map.S_y = std::min(yield_1, yield_2);
    yields = yield_1 < yield_2 ? 1 : yield_2 < yield_1 ? 2 : 0;
  }

  bool needs_density() const { return std::isnan(map.density); }
  /// Behind take_yield: that of the material that yields.
  void take_density(double density_1, double density_2) {
    if (!needs_density()) return;
    if (density_1 == density_2 || yields == 1)
      map.density = density_1;
    else if (yields == 2)
      map.density = density_2;
  }

  /// With lambda_c filled in where E_eff is there for it. Throws std::invalid_argument when rho is missing, or the
  /// stiffness of the spring is missing or not its own.
  VariableRestitution resolved() const {
    if (needs_density())
      throw std::invalid_argument(
          "needs rho, a density: those of the two materials differ, and neither has the lower yield strength");
    if (needs_yield()) throw std::invalid_argument("needs S_y, the yield strength of the body that yields");
    if ((part == Normal::linear) == std::isnan(k_n))
      throw std::invalid_argument("k_n belongs to `normal: linear` and is needed there; hertz takes E_eff");
    VariableRestitution law = *this;
    law.bond = bond.completed();
    if (!needs_materials()) law.map.lambda_c = map.critical_lambda({.E_eff = E_eff});
    return law;
  }
  double cutoff() const { return 0; }
  /// Numbers that suit spheres of some millimetres, for the property tests.
  static VariableRestitution example() {
    VariableRestitution law;
    law.E_eff = 1e7, law.map.S_y = 2e5, law.map.density = 1800, law.largest = 0.95;
    law.friction.mu = 0.4, law.friction.mu_r = 0.05;
    return law;
  }
  double rest_overlap() const { return 0; }

  template <class T>
  [[gnu::always_inline]] NormalForce<T> normal(const Approach<T>& a, T (&memory)[1]) const {
    const T zero(0.0), one(1.0);
    NormalForce<T> n;
    n.in_contact = a.overlap > zero;
    const auto begins = both(n.in_contact, one > memory[0]);
    if (any(begins)) memory[0] = select(begins, one + ratio(a.rate), memory[0]);
    memory[0] = select(n.in_contact, memory[0], zero);
    const T beta = max(memory[0] - one, zero), depth = max(a.overlap, zero);
    const bool linear = part == Normal::linear;
    // Never zero, so that k_t stiffness_ratio is the stiffness before even when the contact has just ended.
    const T root = linear ? one : max(sqrt(a.r_eff * depth), tiny<T>());
    const T before = linear ? one : sqrt(a.r_eff * max(a.overlap - a.rate * a.elapsed, zero));
    n.k_n = (linear ? T(k_n) : T(2 * E_eff)) * root;
    const T spring = T(linear ? 1 : 2.0 / 3.0) * n.k_n * depth;
    const T damp = T(factor()) * beta * sqrt(n.k_n) * a.root_m;
    n.c_n = damp;
    const T viscous = select(n.in_contact, damp * a.rate, zero);
    n.force = max(least_force<T>(clip), spring + viscous);
    n.damping = clip ? n.force - spring : viscous;
    n.stored = T(linear ? 0.5 : 0.4) * spring * depth;
    n.limiting_force = max(zero, n.force);
    n.k_t = T(stiffness_ratio) * n.k_n;
    n.stiffness_ratio = before / root;
    n.tangential_compliance = stiffness_ratio > 0 ? select(n.in_contact, one / max(n.k_t, tiny<T>()), zero) : zero;
    n.c_t = T(std::sqrt(stiffness_ratio)) * damp;
    return n;
  }

  /// Stiffness at the overlap, damping at the restitution of the expected speed.
  StiffnessBound bound(const WorstContact& w) const {
    const double overlap =
        std::max(w.overlap, std::pow(15 * w.m_eff * w.speed * w.speed / (16 * E_eff * std::sqrt(w.r_eff)), 0.4));
    const double stiff = part == Normal::linear ? k_n : 2 * E_eff * std::sqrt(w.r_eff * overlap);
    const double damp = factor() * ratio(w.speed) * std::sqrt(w.m_eff * stiff);
    return {.k_n = stiff, .c_n = damp, .k_t = stiffness_ratio * stiff, .c_t = std::sqrt(stiffness_ratio) * damp};
  }

 private:
  double factor() const { return part == Normal::linear ? 2 : 2 * std::sqrt(5.0 / 6.0); }

  /// beta(Ce(V)), from -ln Ce = ln(1 + 2 s)/2 at once.
  template <class T>
  T ratio(T speed) const {
    const T one(1.0), approach = max(speed, T(0.0));
    const T over = T(map.density / (map.S_y * map.lambda_c)) * approach * approach;
    const T strain = T(map.A) * (pow(max(over, one), map.B) - one);
    const T log_e = max(T(0.5) * log(one + T(2.0) * strain), T(-std::log(largest)));
    return log_e * rsqrt(T(std::numbers::pi * std::numbers::pi) + log_e * log_e);
  }
};

}  // namespace subsoil::dem
