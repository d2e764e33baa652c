#pragma once
#include <limits>

#include "libdem/laws/bond.hpp"
#include "libdem/laws/cohesion.hpp"
#include "libdem/laws/damping_ratio.hpp"
#include "libdem/laws/friction.hpp"

/// Linear spring-dashpot.
///     delta > 0:  F = k_n delta + c_n d delta/dt,  c_n = 2 beta(e) sqrt(m_eff k_n)
///                 k_t = ratio k_n,  c_t = 2 beta(e) sqrt(m_eff k_t)
/// Symbols: k_n N/m, e coefficient of restitution, beta damping ratio, m_eff effective mass kg.
/// The force is not clipped at zero by default, so that restitution out equals e exactly; with `clip attraction` the
/// end of the rebound is cut off and restitution comes out larger than e.
/// Source: Cundall & Strack 1979; damping map Schwager & Poeschel 2007, eq. (14).
namespace subsoil::dem {

struct Linear {
  static constexpr bool constant_stiffness = true;
  static constexpr LawMembers has{.needs_radius = false};
  double k_n = std::numeric_limits<double>::quiet_NaN();
  double stiffness_ratio = 2.0 / 7.0;
  double restitution = std::numeric_limits<double>::quiet_NaN();
  bool clip = false;
  Cohesion cohesion;
  Bond bond;
  Friction friction;
  double beta = 0;  ///< damping ratio; filled by resolved()

  template <class V>
  void describe(V& v) {
    v.card("linear", "linear spring-dashpot with restitution");
    v.quantity("k_n", k_n, "N/m", "(0, inf)", "normal stiffness");
    v.quantity("stiffness ratio", stiffness_ratio, "1", "[0, inf)", "tangential over normal stiffness");
    v.quantity("restitution", restitution, "1", "(0, 1]", "coefficient of restitution", "for no damping use 1");
    v.flag("clip attraction", clip,
           "cut the normal force off at zero while separating (restitution then exceeds the given)");
    cohesion.describe(v);
    bond.describe(v);
    friction.describe(v);
  }

  Linear resolved() const {
    Linear law = *this;
    law.cohesion = cohesion.completed();
    law.bond = bond.completed();
    law.beta = damping_ratio(restitution);
    return law;
  }
  double cutoff() const { return 0; }
  /// Numbers that suit spheres of some millimetres, for the property tests.
  static Linear example() {
    Linear law;
    law.k_n = 1e5, law.restitution = 0.6;
    law.friction.mu = 0.4, law.friction.mu_r = 0.05;
    return law;
  }
  double rest_overlap() const { return 0; }

  template <class T>
  [[gnu::always_inline]] NormalForce<T> normal(const Approach<T>& a) const {
    const T zero(0.0), damp(2 * beta * std::sqrt(k_n));
    NormalForce<T> n;
    n.in_contact = a.overlap > zero;
    const T spring = T(k_n) * a.overlap;
    const T viscous = damp * a.root_m * a.rate;
    const T total = max(least_force<T>(clip), spring + viscous);
    n.force = select(n.in_contact, total, zero);
    n.damping = select(n.in_contact, total - spring, zero);
    n.stored = select(n.in_contact, T(0.5) * spring * a.overlap, zero);
    n.limiting_force = max(zero, n.force);
    n.k_n = T(k_n);
    n.k_t = T(k_n * stiffness_ratio);
    n.stiffness_ratio = T(1.0);
    n.tangential_compliance = T(stiffness_ratio > 0 ? 1 / (k_n * stiffness_ratio) : 0.0);
    n.c_t = T(2 * beta * std::sqrt(k_n * stiffness_ratio)) * a.root_m;
    return n;
  }

  StiffnessBound bound(const WorstContact& w) const {
    const double beta = damping_ratio(restitution), k_t = k_n * stiffness_ratio;
    return {
        .k_n = k_n, .c_n = 2 * beta * std::sqrt(w.m_eff * k_n), .k_t = k_t, .c_t = 2 * beta * std::sqrt(w.m_eff * k_t)};
  }
};

}  // namespace subsoil::dem
