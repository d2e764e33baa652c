#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "libdem/laws/bond.hpp"
#include "libdem/laws/friction.hpp"

/// Wet-particle law (Yuan & Yu 2020, doi:10.6041/j.issn.1000-1298.2020.S1.003, equations (12) to (21), with (17) and
/// (19) read so that the force is continuous). Normal force, compression positive, delta overlap (negative is a gap):
///     delta > dc + D:              F =  K_X (delta - dc - D) + C_X d delta/dt
///     D <= delta <= dc + D:        F = -K_C (dc + D - delta)
///     D - dB <= delta < D:         F = -K_B (dB - D + delta)
///     delta < D - dB:              F =  0
/// Symbols: K_X, K_C, K_B stiffness N/m; C_X damping N s/m; dc contact adhesion distance, dB separation adhesion
/// distance, D offset of the maximum attraction, m; K_Y, C_Y tangential stiffness and damping.
/// Continuity at delta = D asks K_B dB = K_C dc; K_C follows from it unless given, and a K_C that breaks it is refused.
/// Tangential spring, friction and rolling act for delta > D only. Friction limit mu * limiting_force, limiting_force
/// by `friction limit`:
///     signed-force:     max(0, N + K_C dc), N the signed normal force with damping (default)
///     elastic-force:    F_rep + K_C dc, F_rep the repulsion without damping
///     repulsion-only:   F_rep
/// The printed damping acts in the repulsive band only, so F jumps by C_X d delta/dt at delta = dc + D;
/// `damping: all-bands` extends it over the attractive bands.
/// Values of one body each (`values: per-body`) combine in series, K = K1 K2/(K1 + K2): half of the given value.
/// Valid for any size; K in N/m is soil, Table 3's printed N/mm is not (docs/theory).
namespace subsoil::dem {

struct Wet {
  static constexpr bool constant_stiffness = true;
  static constexpr LawMembers has{.needs_radius = false, .weaken = true};
  enum class Values { pair, per_body };
  enum class FrictionLimit { signed_force, elastic_force, repulsion_only };
  enum class Damping { repulsion, all_bands };

  static constexpr double required = std::numeric_limits<double>::quiet_NaN();
  Values values = Values::pair;
  double K_X = required, C_X = required;
  double K_Y = required, C_Y = required;
  double K_B = required;
  double dc = required, dB = required, D = 0;
  double K_C = required;  ///< left out: from continuity
  Damping damping = Damping::repulsion;
  FrictionLimit limit = FrictionLimit::signed_force;
  Bond bond;
  Friction friction;

  template <class V>
  void describe(V& v) {
    v.card("wet", "wet-particle law: repulsion, and attraction in two linear bands (Yuan & Yu 2020)");
    v.choice("values", values, {{"pair", Values::pair}, {"per-body", Values::per_body}},
             "whether K and C are the pair's, or each body's and combined in series");
    v.quantity("K_X", K_X, "N/m", "(0, inf)", "normal stiffness of the repulsion");
    v.quantity("C_X", C_X, "N s/m", "[0, inf)", "normal damping coefficient");
    v.quantity("K_Y", K_Y, "N/m", "[0, inf)", "tangential stiffness (the source's K_Y = K_Z)");
    v.quantity("C_Y", C_Y, "N s/m", "[0, inf)", "tangential damping coefficient (the source's C_Y = C_Z)");
    v.quantity("K_B", K_B, "N/m", "[0, inf)", "adhesion stiffness while separating, across the gap");
    v.quantity("dc", dc, "m", "(0, inf)", "adhesion distance in contact");
    v.quantity("dB", dB, "m", "[0, inf)", "adhesion distance while separating");
    v.quantity("D", D, "m", "(-inf, inf)", "overlap at the maximum attraction");
    v.derived("K_C", K_C, "N/m", "[0, inf)", "adhesion stiffness in contact; left out: K_B dB/dc (continuity)");
    v.choice("damping", damping, {{"repulsion", Damping::repulsion}, {"all-bands", Damping::all_bands}},
             "where normal damping acts: as printed in the repulsive band, or in the attractive bands too");
    v.choice("friction limit", limit,
             {{"signed-force", FrictionLimit::signed_force},
              {"elastic-force", FrictionLimit::elastic_force},
              {"repulsion-only", FrictionLimit::repulsion_only}},
             "what friction and rolling are limited by under attraction");
    bond.describe(v);
    friction.describe(v);
  }

  /// The law that the sweep evaluates: the pair's values, K_C filled in. Throws std::invalid_argument when the force
  /// would jump at delta = D.
  Wet resolved() const {
    Wet law = *this;
    if (std::isnan(law.K_C)) law.K_C = K_B * dB / dc;
    if (std::abs(law.K_C * dc - K_B * dB) > 1e-9 * std::max(law.K_C * dc, K_B * dB))
      throw std::invalid_argument("K_C dc and K_B dB differ: the force must be continuous at overlap D; leave K_C out");
    if (values == Values::per_body)
      for (double* value : {&law.K_X, &law.C_X, &law.K_Y, &law.C_Y, &law.K_B, &law.K_C}) *value /= 2;
    law.values = Values::pair;
    law.bond = bond.completed();
    return law;
  }

  /// Takes a share of the attraction, while a bed settles.
  void weaken(double share) {
    K_B *= share;
    K_C *= share;  // left out it is NaN and stays so: it follows from K_B
  }

  /// Maximum gap across which the law acts, m.
  double cutoff() const { return K_B > 0 ? std::max(0.0, dB - D) : std::max(0.0, -D); }
  /// Numbers that suit spheres of some millimetres, for the property tests.
  static Wet example() {
    Wet law;
    law.K_X = 10000, law.C_X = 20, law.K_Y = 8000, law.C_Y = 20, law.K_B = 7000, law.dc = law.dB = 2e-3;
    law.friction.mu = 0.5, law.friction.mu_r = 0.3;
    return law;
  }
  /// Overlap of a pair at rest without load, m.
  double rest_overlap() const { return dc + D; }

  template <class T>
  [[gnu::always_inline]] NormalForce<T> normal(const Approach<T>& a) const {
    const T zero(0.0), rest(dc + D), half(0.5);
    const T press = a.overlap - rest;        // > 0: repulsive band
    const T within = a.overlap - T(D - dB);  // > 0: attracted at least
    const auto repels = press > zero;
    const auto attracts = within >= zero;
    const auto holds = a.overlap >= T(D);
    NormalForce<T> n;
    const T spring =
        select(repels, T(K_X) * press, select(holds, T(K_C) * press, select(attracts, T(-K_B) * within, zero)));
    const T viscous = T(C_X) * a.rate;
    n.damping = damping == Damping::repulsion ? select(repels, viscous, zero) : select(attracts, viscous, zero);
    n.force = spring + n.damping;
    const T deepest(-0.5 * (K_B * dB * dB + K_C * dc * dc));
    n.stored = select(repels, deepest + half * T(K_X) * press * press,
                      select(holds, deepest + half * T(K_C) * press * press,
                             select(attracts, T(-0.5 * K_B) * within * within, zero)));
    const T cohesion(K_C * dc);
    const T elastic = select(repels, T(K_X) * press, zero);
    n.limiting_force = limit == FrictionLimit::signed_force    ? max(zero, n.force + cohesion)
                       : limit == FrictionLimit::elastic_force ? elastic + cohesion
                                                               : elastic;
    n.in_contact = a.overlap > T(D);
    n.k_n = T(K_X);
    n.k_t = T(K_Y);
    n.stiffness_ratio = T(1.0);
    n.tangential_compliance = T(K_Y > 0 ? 1 / K_Y : 0.0);
    n.c_t = T(C_Y);
    n.c_n = T(C_X);
    n.attraction = select(n.in_contact, cohesion, zero);
    return n;
  }

  StiffnessBound bound(const WorstContact&) const {
    return {.k_n = std::max({K_X, K_C, K_B}), .c_n = C_X, .k_t = K_Y, .c_t = C_Y};
  }
};

}  // namespace subsoil::dem
