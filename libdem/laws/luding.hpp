#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "libdem/laws/adhesive_friction.hpp"
#include "libdem/laws/bond.hpp"
#include "libdem/laws/damping_ratio.hpp"
#include "libdem/laws/friction.hpp"

/// Adhesive elasto-plastic contact (Luding 2008), MercuryDPM's linear plastic viscoelastic law and LIGGGHTS'
/// hooke/hysteresis: linear branches between k1 delta and -k_c delta.
///     loading, delta = M:                         F = k1 delta
///     unloading and reloading:                    F = k1 delta - (p - k1) (M - delta)
///     where that is below -k_c delta:             F = -k_c delta, and M falls so that the line ends there
///     p = k1 + (k2 - k1) M/delta_f,  M <= delta_f = k2/(k2 - k1) phi_f 2 r_eff
///     beyond delta_f ("fluid" limit branch):      F = k2 (delta - 2 phi_f r_eff), elastic
/// and c d delta/dt besides, while delta > 0. M maximum overlap, what the contact remembers, m; k1, k2, k_c N/m; p the
/// unloading stiffness, from k1 of a gentle touch to k2; phi_f dimensionless plastic depth; the force vanishes at
/// (1 - k1/p) M and the maximum pull is k_c (p - k1) M/(p + k_c). `unloading stiffness: constant` has p = k2 always.
/// Damping c, N s/m (Luding's gamma_0, MercuryDPM's dissipation), or by `restitution`, that of the dashpot with the
/// spring k1 alone (LIGGGHTS): what comes out is less. Tangential: k_t = ratio k1, c_t = sqrt(ratio) c, the same
/// damping ratio. Friction limit: adhesive_friction.hpp. Energy: stored is the elastic line's, counted from where it
/// meets the adhesive branch: 0 there and when apart, negative when pulled from rest. Loading and tearing lose, as
/// differences of functions of M (comments below). Valid for overlaps up to delta_f and somewhat beyond. Source: Luding
/// 2008, Granular Matter 10, 235.
namespace subsoil::dem {

struct Luding {
  static constexpr bool constant_stiffness = true;
  static constexpr LawMembers has{.memory = 1, .plastic = true, .weaken = true};  ///< memory: M, m
  enum class Unloading { grows, constant };
  static constexpr double required = std::numeric_limits<double>::quiet_NaN();
  double k1 = required, k2 = required, k_c = required, phi_f = required;
  double damping = required, restitution = required;
  double stiffness_ratio = 2.0 / 7.0;
  Unloading unloading = Unloading::grows;
  AdhesiveLimit limit = AdhesiveLimit::force_plus_adhesion;
  Bond bond;
  Friction friction;

  template <class V>
  void describe(V& v) {
    v.card("luding", "adhesive elasto-plastic law in linear branches (Luding 2008; MercuryDPM)");
    v.quantity("k1", k1, "N/m", "(0, inf)", "loading stiffness");
    v.quantity("k2", k2, "N/m", "(0, inf)", "maximum unloading stiffness; above k1");
    v.quantity("k_c", k_c, "N/m", "[0, inf)", "adhesive stiffness; 0: no attraction");
    v.quantity("phi_f", phi_f, "1", "(0, 1]",
               "plastic depth over the effective diameter 2 r_eff at which unloading is stiffest");
    v.derived("damping", damping, "N s/m", "[0, inf)", "damping coefficient; left out: by the restitution");
    v.derived("restitution", restitution, "1", "(0, 1]", "of the dashpot with the spring k1 alone, in place of damping",
              "for no damping use 1");
    v.quantity("stiffness ratio", stiffness_ratio, "1", "[0, inf)", "tangential stiffness over k1");
    v.choice("unloading stiffness", unloading, {{"grows", Unloading::grows}, {"constant", Unloading::constant}},
             "from k1 to k2 with the maximum overlap (Luding), or k2 always");
    dem::describe(v, limit);
    bond.describe(v);
    friction.describe(v);
  }

  /// Throws std::invalid_argument for k2 <= k1, or when damping is given twice or not at all.
  Luding resolved() const {
    if (!(k2 > k1)) throw std::invalid_argument("k2 must be above k1; for a contact without plasticity take `linear`");
    if (std::isnan(damping) == std::isnan(restitution))
      throw std::invalid_argument("needs either damping or restitution; for no damping restitution: 1");
    Luding law = *this;
    law.bond = bond.completed();
    return law;
  }
  /// Takes a share of the attraction, while a bed settles.
  void weaken(double share) { k_c *= share; }
  double cutoff() const { return 0; }
  /// Numbers that suit spheres of some millimetres, for the property tests.
  static Luding example() {
    Luding law;
    law.k1 = 1e4, law.k2 = 5e4, law.k_c = 1e4, law.phi_f = 0.1, law.damping = 0.05;
    law.friction.mu = 0.4, law.friction.mu_r = 0.05;
    return law;
  }
  double rest_overlap() const { return 0; }

  template <class T>
  [[gnu::always_inline]] NormalForce<T> normal(const Approach<T>& a, T (&memory)[1]) const {
    const T zero(0.0), half(0.5);
    const T fluid = T(2 * phi_f * k2 / (k2 - k1)) * a.r_eff;  // delta_f
    const T depth = max(a.overlap, zero), before = memory[0];
    const T reached = max(before, min(depth, fluid));
    const Line<T> loaded = line(reached, fluid);
    const T on_line = T(k1) * depth - loaded.excess * (reached - depth);
    const T pull = T(k_c) * depth;
    const auto tears = -pull >= on_line;
    // The line that ends at -k_c delta: (p - k1)(M - delta) = (k1 + k_c) delta.
    const T torn = unloading == Unloading::constant
                       ? T((k2 + k_c) / (k2 - k1)) * depth
                       : half * depth + sqrt(depth * (T(0.25) * depth + T((k1 + k_c) / (k2 - k1)) * fluid));
    const T now = select(tears, min(torn, reached), reached);
    const Line<T> at = line(now, fluid);
    memory[0] = now;
    NormalForce<T> n;
    n.in_contact = a.overlap > zero;
    const T spring = select(tears, -pull, on_line);
    n.c_n = coefficient(a.root_m);
    const T viscous = n.c_n * a.rate;
    n.force = select(n.in_contact, spring + viscous, zero);
    n.damping = select(n.in_contact, viscous, zero);
    n.stored = half * (spring - at.tear) * (spring + at.tear) / at.stiffness;
    // On the way in what is not stored of k1 delta; on the way out k_c delta, the line being stored 0 all along.
    n.lost = select(a.elapsed > zero,
                    spent(loaded, reached) - spent(line(before, fluid), before) +
                        half * T(k_c) * (tear_overlap(loaded, reached) - tear_overlap(at, now)) *
                            (tear_overlap(loaded, reached) + tear_overlap(at, now)),
                    zero);
    n.attraction = select(n.in_contact, pull, zero);
    n.limiting_force = limiting_force_of(limit, n.force, pull);
    n.k_n = T(k1);
    n.k_t = T(stiffness_ratio * k1);
    n.stiffness_ratio = T(1.0);
    n.tangential_compliance = T(stiffness_ratio > 0 ? 1 / (stiffness_ratio * k1) : 0.0);
    n.c_t = T(std::sqrt(stiffness_ratio)) * n.c_n;
    return n;
  }

  StiffnessBound bound(const WorstContact& w) const {
    const double c_n = coefficient(std::sqrt(w.m_eff));
    return {.k_n = std::max(k2, k_c), .c_n = c_n, .k_t = stiffness_ratio * k1, .c_t = std::sqrt(stiffness_ratio) * c_n};
  }

 private:
  /// The elastic line of a contact that was loaded to M.
  template <class T>
  struct Line {
    T stiffness;  ///< p
    T excess;     ///< p - k1
    T tear;       ///< pull where it meets the adhesive branch, N
  };
  template <class T>
  Line<T> line(T M, T fluid) const {
    Line<T> l;
    l.excess = unloading == Unloading::constant ? T(k2 - k1) : T(k2 - k1) * M / fluid;
    l.stiffness = T(k1) + l.excess;
    l.tear = T(k_c) * l.excess * M / (l.stiffness + T(k_c));
    return l;
  }
  /// Overlap there.
  template <class T>
  T tear_overlap(const Line<T>& l, T M) const {
    return l.excess * M / (l.stiffness + T(k_c));
  }
  /// Work of loading to M less what the line then stores: k1 M^2/2 - ((k1 M)^2 - tear^2)/(2 p).
  template <class T>
  T spent(const Line<T>& l, T M) const {
    return T(0.5) * (T(k1) * M * M * l.excess + l.tear * l.tear) / l.stiffness;
  }
  template <class T>
  T coefficient(T root_m) const {
    if (std::isnan(restitution)) return T(damping);
    return T(2 * damping_ratio(restitution) * std::sqrt(k1)) * root_m;
  }
};

}  // namespace subsoil::dem
