#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "libdem/impact/hunt_crossley.hpp"
#include "libdem/laws/bond.hpp"
#include "libdem/laws/cohesion.hpp"
#include "libdem/laws/elastic_pair.hpp"
#include "libdem/laws/friction.hpp"

/// Hunt-Crossley with Coulomb friction.
///     delta > 0:  F = max(0, c delta^n (1 + b d delta/dt)),   stored c delta^(n+1)/(n+1), all else is damping
///                 k_n = n c delta^(n-1),  k_t = ratio k_n,  c_t = ratio b c delta^n
/// Symbols: c N/m^n, n exponent (3/2 spheres, 1 flat bodies), b s/m; c left out: 4/3 E* sqrt(R), n = 3/2.
/// Restitution is a result and falls with the speed, k = 1 - 2 b V/3 + ..., for any c, n and masses; b may be
/// given as a restitution at a speed (impact/hunt_crossley.hpp has the exact map). The force begins and ends at zero,
/// so nothing is clipped in an impact of two; only what others pull apart faster than 1/b leaves it without force.
/// Tangential stiffness follows the normal one, its dashpot in the same proportion; on unloading the spring is kept, as
/// in hertz_mindlin.hpp. Cost: whole and half n as Hertz; any other n takes pow of each contact twice
/// (docs/theory/impact.md). Source: Hunt & Crossley 1975, J. Appl. Mech. 42, 440; the tangential part is ours.
namespace subsoil::dem {

struct HuntCrossley {
  static constexpr bool constant_stiffness = false;
  static constexpr LawMembers has{};
  impact::HuntCrossleyModel impact;
  double E_eff = std::numeric_limits<double>::quiet_NaN();
  double stiffness_ratio = 2.0 / 7.0;
  Cohesion cohesion;
  Bond bond;
  Friction friction;

  template <class V>
  void describe(V& v) {
    v.card("hunt-crossley", "Hunt-Crossley: spring c delta^n with damping that grows with it");
    impact.parameters(v);
    v.derived("E_eff", E_eff, "Pa", "(0, inf)",
              "effective Young's modulus, when c is left out; left out: from both materials' young and poisson");
    v.quantity("stiffness ratio", stiffness_ratio, "1", "[0, inf)", "tangential over normal stiffness");
    cohesion.describe(v);
    bond.describe(v);
    friction.describe(v);
  }

  bool needs_materials() const { return std::isnan(impact.c) && std::isnan(E_eff); }
  static constexpr const char* in_place_of_materials = "c or E_eff";
  /// Fills E_eff from the elastic constants of the two materials where neither it nor c is given.
  void take_materials(double young_1, double poisson_1, double young_2, double poisson_2) {
    if (needs_materials()) E_eff = effective_modulus(young_1, poisson_1, young_2, poisson_2);
  }

  HuntCrossley resolved() const {
    HuntCrossley law = *this;
    law.cohesion = cohesion.completed();
    law.bond = bond.completed();
    law.impact = impact.completed();
    return law;
  }
  double cutoff() const { return 0; }
  /// Numbers that suit spheres of some millimetres, for the property tests.
  static HuntCrossley example() {
    HuntCrossley law;
    law.impact.n = 1.5, law.impact.b = 0.3, law.E_eff = 5e6;
    law.friction.mu = 0.4, law.friction.mu_r = 0.05;
    return law;
  }
  double rest_overlap() const { return 0; }

  template <class T>
  [[gnu::always_inline]] NormalForce<T> normal(const Approach<T>& a) const {
    const T zero(0.0), one(1.0);
    NormalForce<T> n;
    n.in_contact = a.overlap > zero;
    const bool hertz = std::isnan(impact.c);
    const T c = hertz ? T(4.0 / 3.0 * E_eff) * sqrt(a.r_eff) : T(impact.c);
    // Never zero, so that k_t stiffness_ratio is the stiffness before even when the contact has just ended; 1 pm, whose
    // powers are still floats.
    const T depth = max(a.overlap, T(1e-12));
    const T stiff = c * power(depth, impact.n - 1);
    const T before = c * power(max(a.overlap - a.rate * a.elapsed, zero), impact.n - 1);
    const T spring = select(n.in_contact, stiff * depth, zero);
    n.force = max(zero, spring * (one + T(impact.b) * a.rate));
    n.damping = n.force - spring;
    n.stored = spring * depth * T(1 / (impact.n + 1));
    n.limiting_force = n.force;
    n.k_n = T(impact.n) * stiff;
    n.k_t = T(stiffness_ratio) * n.k_n;
    n.stiffness_ratio = impact.n > 1 ? before / stiff : one;
    n.tangential_compliance = select(n.k_t > zero, one / max(n.k_t, tiny<T>()), zero);
    n.c_n = T(impact.b) * spring;
    n.c_t = T(stiffness_ratio * impact.b) * spring;
    return n;
  }

  /// At the overlap that the expected speed reaches without damping: c delta^(n+1)/(n+1) = m v^2/2.
  StiffnessBound bound(const WorstContact& w) const {
    const double c = impact.stiffness({.mass = w.m_eff, .radius = w.r_eff, .E_eff = E_eff});
    const double overlap =
        std::max(w.overlap, std::pow((impact.n + 1) * w.m_eff * w.speed * w.speed / (2 * c), 1 / (impact.n + 1)));
    const double spring = c * std::pow(overlap, impact.n), k_n = impact.n * spring / overlap;
    // While approaching, damping stiffens the tangent by 1 + b v.
    return {.k_n = k_n * (1 + impact.b * w.speed),
            .c_n = impact.b * spring,
            .k_t = stiffness_ratio * k_n,
            .c_t = stiffness_ratio * impact.b * spring};
  }
};

}  // namespace subsoil::dem
