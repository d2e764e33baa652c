#pragma once
#include "libdem/impact/impact.hpp"

namespace subsoil::dem::impact {

/// Hysteretic spring of Walton and Braun, the HSCM of EDEM: the contact law of that name without its dashpot.
///     in:  F = K1 x;   out:  F = K2 (x - x_r),  x_r = (1 - K1/K2) x_max
///     x_max = V (m/K1)^(1/2),  F_max = V (m K1)^(1/2),  e = (K1/K2)^(1/2) at every speed,
///     T = (pi/2) ((m/K1)^(1/2) + (m/K2)^(1/2)) = (pi/2) (1 + e) (m/K1)^(1/2)
/// K1 N/m, left out: 5 R S_y with R the pair's radius and S_y the smaller yield strength, Pa; K2 N/m. What is lost,
/// (1 - e^2) m V^2/2, is plastic work; the bodies part at the residual indentation x_r.
/// Source: Walton & Braun 1986, Acta Mech. 63, 73; K1 = 5 R S_y after Walton 2006.
struct Hysteretic {
  static constexpr double left_out = std::numeric_limits<double>::quiet_NaN();
  double K1 = left_out, S_y = left_out;
  double K2 = left_out, restitution = left_out;

  template <class V>
  void describe(V& v) {
    v.card("hysteretic", "Walton & Braun: loads along K1, unloads along K2 = K1/e^2");
    v.derived("K1", K1, "N/m", "(0, inf)", "loading stiffness; left out: 5 R S_y");
    v.derived("S_y", S_y, "Pa", "(0, inf)",
              "yield strength of the softer body; left out: the smaller one of the two bodies");
    v.derived("K2", K2, "N/m", "(0, inf)", "unloading stiffness; left out: by the restitution");
    v.derived("restitution", restitution, "1", "(0, 1]", "in place of K2", "for no plastic loss use 1");
  }
  /// Throws std::invalid_argument when a stiffness is given twice, or the unloading not at all.
  void check() const;

  double loading(const Pair& pair) const;    ///< K1, N/m
  double unloading(const Pair& pair) const;  ///< K2, N/m; not below K1
  double restitution_at(const Pair& pair, double speed) const;
  Event strike(const Pair& pair, double speed, int samples = usual_samples) const;
};

}  // namespace subsoil::dem::impact
