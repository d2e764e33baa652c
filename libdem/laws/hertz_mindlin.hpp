#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "libdem/laws/bond.hpp"
#include "libdem/laws/cohesion.hpp"
#include "libdem/laws/damping_ratio.hpp"
#include "libdem/laws/elastic_pair.hpp"
#include "libdem/laws/friction.hpp"

/// Hertz-Mindlin with Tsuji's damping.
///     delta > 0:  F = (4/3) E* sqrt(R delta^3) + 2 sqrt(5/6) beta(e) sqrt(S_n m_eff) d delta/dt,  S_n = 2 E* sqrt(R
///     delta)
///                 k_t = 8 G* sqrt(R delta),  c_t = 2 sqrt(5/6) beta(e) sqrt(k_t m_eff)
/// Symbols: E*, G* of the two materials (elastic_pair.hpp), Pa; R effective radius m; e restitution (exact for the
/// unclipped force: Tsuji, Tanaka, Ishida 1992); beta as in damping_ratio.hpp. Tangential unloading: while the overlap
/// falls the spring is kept and the force falls with k_t (Mindlin & Deresiewicz 1953 as simplified by Thornton,
/// Cummins, Cleary 2013); while it grows the force is kept. Both lose energy, accumulated as sliding. Valid for overlap
/// << R.
namespace subsoil::dem {

struct HertzMindlin : ElasticPair {
  static constexpr bool constant_stiffness = false;
  static constexpr LawMembers has{};
  double restitution = std::numeric_limits<double>::quiet_NaN();
  bool clip = false;
  Cohesion cohesion;
  Bond bond;
  Friction friction;
  double damping = 0;  ///< 2 sqrt(5/6) beta(e); filled by resolved()

  template <class V>
  void describe(V& v) {
    v.card("hertz-mindlin", "Hertz normal force, Mindlin tangential stiffness, Tsuji damping");
    describe_elasticity(v);
    v.quantity("restitution", restitution, "1", "(0, 1]", "coefficient of restitution", "for no damping use 1");
    v.flag("clip attraction", clip,
           "cut the normal force off at zero while separating (restitution then exceeds the given)");
    cohesion.describe(v);
    bond.describe(v);
    friction.describe(v);
  }

  HertzMindlin resolved() const {
    HertzMindlin law = *this;
    law.cohesion = cohesion.completed();
    law.bond = bond.completed();
    law.damping = 2 * std::sqrt(5.0 / 6.0) * damping_ratio(restitution);
    return law;
  }
  double cutoff() const { return 0; }
  /// Numbers that suit spheres of some millimetres, for the property tests.
  static HertzMindlin example() {
    HertzMindlin law;
    law.take_materials(1e7, 0.3, 1e7, 0.3);
    law.restitution = 0.7;
    law.friction.mu = 0.4, law.friction.mu_r = 0.05;
    return law;
  }
  double rest_overlap() const { return 0; }

  template <class T>
  [[gnu::always_inline]] NormalForce<T> normal(const Approach<T>& a) const {
    const T zero(0.0), damp(damping);
    NormalForce<T> n;
    n.in_contact = a.overlap > zero;
    // Never zero, so that k_t stiffness_ratio is the stiffness before even when the contact has just ended.
    const T root = max(sqrt(a.r_eff * max(a.overlap, zero)), tiny<T>());
    const T root_before = sqrt(a.r_eff * max(a.overlap - a.rate * a.elapsed, zero));
    const T spring = T(4.0 / 3.0 * E_eff) * root * max(a.overlap, zero);
    n.k_n = T(2 * E_eff) * root;
    n.k_t = T(8 * G_eff) * root;
    n.stiffness_ratio = root_before / root;
    n.tangential_compliance = select(n.in_contact, T(1.0) / max(n.k_t, tiny<T>()), zero);
    n.c_n = damp * sqrt(n.k_n) * a.root_m;
    n.c_t = T(std::sqrt(4 * G_eff / E_eff)) * n.c_n;
    const T total = max(least_force<T>(clip), spring + n.c_n * a.rate);
    n.force = select(n.in_contact, total, zero);
    n.damping = select(n.in_contact, total - spring, zero);
    n.stored = T(0.4) * spring * max(a.overlap, zero);
    n.limiting_force = max(zero, n.force);
    return n;
  }

  /// Stiffness at the overlap that the expected speed reaches: delta = (15 m v^2/(16 E* sqrt R))^(2/5).
  StiffnessBound bound(const WorstContact& w) const {
    const double overlap =
        std::max(w.overlap, std::pow(15 * w.m_eff * w.speed * w.speed / (16 * E_eff * std::sqrt(w.r_eff)), 0.4));
    const double root = std::sqrt(w.r_eff * overlap);
    const double damp = 2 * std::sqrt(5.0 / 6.0) * damping_ratio(restitution);
    const double k_n = 2 * E_eff * root, k_t = 8 * G_eff * root;
    return {.k_n = k_n, .c_n = damp * std::sqrt(k_n * w.m_eff), .k_t = k_t, .c_t = damp * std::sqrt(k_t * w.m_eff)};
  }
};

}  // namespace subsoil::dem
