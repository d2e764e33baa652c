#pragma once
#include <limits>
#include <stdexcept>

#include "libdem/laws/bond.hpp"
#include "libdem/laws/cohesion.hpp"
#include "libdem/laws/damping_ratio.hpp"
#include "libdem/laws/friction.hpp"

/// Linear spring-dashpot.
///     delta > 0:  F = k_n delta + c_n d delta/dt,  c_n = 2 beta(e) sqrt(m_eff k_n)
///                 k_t = ratio k_n,  c_t = 2 beta(e) sqrt(m_eff k_t) = sqrt(ratio) c_n
/// Symbols: k_n N/m, e coefficient of restitution, beta damping ratio, m_eff effective mass kg. `damping` gives c_n in
/// N s/m in place of e; restitution then depends on the mass.
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
  double damping = std::numeric_limits<double>::quiet_NaN();  ///< N s/m, in place of restitution
  // Filled by resolved(): c_n = per_root_m sqrt(m_eff) + constant.
  double per_root_m = 0, constant = 0;

  template <class V>
  void describe(V& v) {
    v.card("linear", "linear spring-dashpot with restitution");
    v.quantity("k_n", k_n, "N/m", "(0, inf)", "normal stiffness");
    v.quantity("stiffness ratio", stiffness_ratio, "1", "[0, inf)", "tangential over normal stiffness");
    v.derived("restitution", restitution, "1", "(0, 1]", "coefficient of restitution; or give damping",
              "for no damping use 1");
    v.derived("damping", damping, "N s/m", "[0, inf)", "normal damping coefficient, in place of the restitution");
    v.flag("clip attraction", clip,
           "cut the normal force off at zero while separating (restitution then exceeds the given)");
    cohesion.describe(v);
    bond.describe(v);
    friction.describe(v);
  }

  /// Throws std::invalid_argument when the damping is given twice or not at all.
  Linear resolved() const {
    if (std::isnan(damping) == std::isnan(restitution))
      throw std::invalid_argument("needs either restitution or damping; for no damping restitution: 1");
    Linear law = *this;
    law.cohesion = cohesion.completed();
    law.bond = bond.completed();
    law.constant = std::isnan(damping) ? 0 : damping;
    law.per_root_m = std::isnan(damping) ? 2 * damping_ratio(restitution) * std::sqrt(k_n) : 0;
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
    const T zero(0.0);
    NormalForce<T> n;
    n.in_contact = a.overlap > zero;
    const T spring = T(k_n) * a.overlap;
    n.c_n = T(per_root_m) * a.root_m + T(constant);
    const T total = max(least_force<T>(clip), spring + n.c_n * a.rate);
    n.force = select(n.in_contact, total, zero);
    n.damping = select(n.in_contact, total - spring, zero);
    n.stored = select(n.in_contact, T(0.5) * spring * a.overlap, zero);
    n.limiting_force = max(zero, n.force);
    n.k_n = T(k_n);
    n.k_t = T(k_n * stiffness_ratio);
    n.stiffness_ratio = T(1.0);
    n.tangential_compliance = T(stiffness_ratio > 0 ? 1 / (k_n * stiffness_ratio) : 0.0);
    n.c_t = T(std::sqrt(stiffness_ratio)) * n.c_n;
    return n;
  }

  StiffnessBound bound(const WorstContact& w) const {
    const double c_n = per_root_m * std::sqrt(w.m_eff) + constant;
    return {.k_n = k_n, .c_n = c_n, .k_t = k_n * stiffness_ratio, .c_t = std::sqrt(stiffness_ratio) * c_n};
  }
};

}  // namespace subsoil::dem
