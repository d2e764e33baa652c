#pragma once
#include "libdem/impact/impact.hpp"

namespace subsoil::dem::impact {

/// Adhesive elastic spheres after Johnson, Kendall and Roberts, a contact radius:
///     F(a) = 4 E* a^3/(3 R) - sqrt(8 pi w E* a^3),   x(a) = a^2/R - sqrt(2 pi w a/E*)
///     U(a) = 8 E* a^5/(15 R^2) - (4 E*/(3 R)) sqrt(2 pi w/E*) a^(7/2) + pi w a^2        (dU = F dx)
/// The surfaces snap together at x = 0, a_0^3 = 2 pi w R^2/E*, F = -(4/3) pi w R; separating, the bridge holds to
/// a_f^3 = pi w R^2/(8 E*), x_f = -(3/4) (pi^2 w^2 R/E*^2)^(1/3), where F = -(5/6) pi w R, after a maximum pull of
/// (3/2) pi w R. What this branch takes, (m/2) V_s^2 = U(a_f) - U(a_0) = 7.09 (w^5 R^4/E*^2)^(1/3), is lost:
///     e = (1 - (V_s/V)^2)^(1/2),  and at V <= V_s the bodies stick (and swing, which this model leaves out).
/// w work of adhesion, J/m^2. F < 0 pulls. Valid for a << R and a large Tabor number.
/// Source: Johnson, Kendall & Roberts 1971; impact: Johnson & Pollock 1994; Thornton & Ning 1998, Powder Technol. 99,
/// 154.
struct Jkr {
  double w = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    v.card("jkr", "Johnson, Kendall, Roberts: elastic spheres with adhesion");
    v.quantity("w", w, "J/m^2", "(0, inf)", "work of adhesion");
  }
  double pull_off(const Pair& pair) const;         ///< maximum pull (3/2) pi w R, N
  double rupture(const Pair& pair) const;          ///< x_f < 0, m
  double sticking_speed(const Pair& pair) const;   ///< V_s, m/s
  double force(const Pair& pair, double x) const;  ///< on the branch of contact, x >= rupture, N
  double restitution_at(const Pair& pair, double speed) const;
  Event strike(const Pair& pair, double speed, int samples = usual_samples) const;
};

}  // namespace subsoil::dem::impact
