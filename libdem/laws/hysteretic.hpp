#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "libdem/laws/bond.hpp"
#include "libdem/laws/cohesion.hpp"
#include "libdem/laws/damping_ratio.hpp"
#include "libdem/laws/friction.hpp"

/// Hysteretic spring (Walton & Braun 1986), the HSCM of EDEM and of Ucgul, Fielke & Saunders 2014.
///     loading, K1 delta < K2 (delta - delta_0):  F_s = K1 delta,               delta_0 <- (1 - K1/K2) delta
///     unloading and reloading, delta > delta_0:  F_s = K2 (delta - delta_0)
///     delta <= delta_0:                          F_s = 0
///     K1 = 5 r_eff S_y,  K2 = K1/e^2;   F = F_s + n_c c d delta/dt,  c = 2 beta(e) sqrt(m_eff K1)
///     k_t = ratio K1,  c_t = 2 beta(e) sqrt(m_eff k_t);   friction limit mu max(0, F)
/// Symbols: delta_0 residual overlap, what the contact remembers, m; S_y yield strength, the smaller of the two
/// materials', Pa; e restitution; n_c damping factor; beta as in damping_ratio.hpp; ratio the tangential stiffness
/// factor. Two bodies part with exactly e at any speed when n_c = 0; n_c > 0 takes more. `residual overlap: follows`
/// (EDEM) lets delta_0 go back with the overlap once it is below it, and a contact that has opened is new; `kept` holds
/// it until then. The dashpot acts while delta > 0 and may pull, `clip attraction` cuts that off. Energy: stored K2
/// (delta - delta_0)^2/2; loading loses K1 (1 - K1/K2) delta d delta, exactly K1/(2 (1 - K1/K2)) times the growth of
/// delta_0^2. `cohesion: linear` with Hertz's contact area makes it the law of Ucgul, Fielke & Saunders 2015 for
/// cohesive soil. Sources: Walton & Braun 1986, Acta Mech. 63, 73; Walton 2006; Ucgul, Fielke & Saunders 2014, Biosyst.
/// Eng. 121, 105, whose n_c and n_k are `damping factor` and `stiffness ratio`, and whose attraction is `cohesion:
/// linear`. Valid for overlaps up to some tenth of the radius.
namespace subsoil::dem {

struct Hysteretic {
  static constexpr bool constant_stiffness = true;
  static constexpr LawMembers has{.memory = 1, .plastic = true};  ///< memory: residual overlap, m
  enum class Residual { follows, kept };
  static constexpr double left_out = std::numeric_limits<double>::quiet_NaN();
  double K1 = left_out, yield = left_out;
  double K2 = left_out, restitution = left_out;
  double damping_factor = 0;
  double stiffness_ratio = 2.0 / 7.0;
  Residual residual = Residual::follows;
  bool clip = false;
  Cohesion cohesion;
  Bond bond;
  Friction friction;

  template <class V>
  void describe(V& v) {
    v.card("hysteretic", "hysteretic spring (Walton & Braun; HSCM): loads along K1, unloads along K2");
    v.derived("K1", K1, "N/m", "(0, inf)", "loading stiffness; left out: 5 r_eff times the yield strength");
    v.derived(
        "yield strength", yield, "Pa", "(0, inf)",
        "when K1 is left out; left out too: the smaller of the two materials'; r_eff at a boundary is the radius");
    v.derived("restitution", restitution, "1", "(0, 1]", "coefficient of restitution, K2 = K1/e^2",
              "for no plastic loss use 1");
    v.derived("K2", K2, "N/m", "(0, inf)", "unloading stiffness, in place of the restitution, when K1 is given");
    v.quantity("damping factor", damping_factor, "1", "[0, 1]",
               "share of the linear dashpot of that restitution which acts besides; takes the restitution below it");
    v.quantity("stiffness ratio", stiffness_ratio, "1", "[0, inf)", "tangential over normal loading stiffness");
    v.choice("residual overlap", residual, {{"follows", Residual::follows}, {"kept", Residual::kept}},
             "below the residual overlap: it goes back with the overlap (EDEM), or stays until the contact opens");
    v.flag("clip attraction", clip, "cut the normal force off at zero where the dashpot would pull");
    cohesion.describe(v);
    bond.describe(v);
    friction.describe(v);
  }

  bool needs_yield() const { return std::isnan(K1) && std::isnan(yield); }
  static constexpr const char* in_place_of_yield = "K1 or yield strength";
  /// Fills the yield strength from those of the two materials: the softer one yields.
  void take_yield(double yield_1, double yield_2) {
    if (needs_yield()) yield = std::min(yield_1, yield_2);
  }

  /// With the restitution filled in. Throws std::invalid_argument when K1 or K2 is given twice or not at all, or K2 is
  /// below K1.
  Hysteretic resolved() const {
    if (std::isnan(K1) == std::isnan(yield))
      throw std::invalid_argument("needs either K1 or the yield strength, K1 = 5 r_eff S_y");
    if (std::isnan(K2) == std::isnan(restitution))
      throw std::invalid_argument("needs either the restitution or K2 = K1/restitution^2");
    if (!std::isnan(K2) && std::isnan(K1))
      throw std::invalid_argument("K2 needs K1 beside it; with the yield strength give the restitution");
    if (K2 < K1) throw std::invalid_argument("K2 must not be below K1: unloading cannot give back more than loading");
    Hysteretic law = *this;
    law.cohesion = cohesion.completed();
    law.bond = bond.completed();
    if (!std::isnan(K2)) law.restitution = std::sqrt(K1 / K2);
    law.K2 = left_out;
    return law;
  }
  double cutoff() const { return 0; }
  /// Numbers that suit spheres of some millimetres, for the property tests.
  static Hysteretic example() {
    Hysteretic law;
    law.yield = 5.88e5, law.restitution = 0.6;
    law.friction.mu = 0.4, law.friction.mu_r = 0.05;
    return law;
  }
  double rest_overlap() const { return 0; }

  template <class T>
  [[gnu::always_inline]] NormalForce<T> normal(const Approach<T>& a, T (&memory)[1]) const {
    const T zero(0.0), half(0.5);
    const double e2 = restitution * restitution, plastic = 1 - e2;
    const T k1 = std::isnan(K1) ? T(5 * yield) * a.r_eff : T(K1), k2 = T(1 / e2) * k1;
    const T depth = max(a.overlap, zero), before = memory[0], fresh = T(plastic) * depth;
    const auto loads = fresh >= before;
    const T reached = max(fresh, before);
    NormalForce<T> n;
    n.in_contact = a.overlap > zero;
    memory[0] = residual == Residual::follows ? min(reached, depth) : select(n.in_contact, reached, zero);
    const T spring = select(loads, k1 * depth, k2 * max(depth - reached, zero));
    n.c_n = damping_factor > 0 ? T(2 * damping_factor * damping_ratio(restitution)) * sqrt(k1) * a.root_m : zero;
    const T viscous = damping_factor > 0 ? n.c_n * a.rate : zero;
    const T total = max(least_force<T>(clip), spring + viscous);
    n.force = select(n.in_contact, total, zero);
    n.damping = n.force - spring;
    n.stored = half * spring * spring / k2;
    // What a run begins with it has not lost.
    n.lost = select(a.elapsed > zero,
                    T(plastic > 0 ? 0.5 / plastic : 0.0) * k1 * (reached - before) * (reached + before), zero);
    n.limiting_force = max(zero, n.force);
    n.k_n = k1;
    n.k_t = T(stiffness_ratio) * k1;
    n.stiffness_ratio = T(1.0);
    n.tangential_compliance = stiffness_ratio > 0 ? T(1.0) / n.k_t : zero;
    n.c_t = T(2 * damping_ratio(restitution)) * sqrt(n.k_t) * a.root_m;
    return n;
  }

  StiffnessBound bound(const WorstContact& w) const {
    const double k1 = std::isnan(K1) ? 5 * w.r_eff * yield : K1, k_t = stiffness_ratio * k1;
    const double damp = 2 * damping_ratio(restitution) * std::sqrt(w.m_eff);
    return {.k_n = k1 / (restitution * restitution),
            .c_n = damping_factor * damp * std::sqrt(k1),
            .k_t = k_t,
            .c_t = damp * std::sqrt(k_t)};
  }
};

}  // namespace subsoil::dem
