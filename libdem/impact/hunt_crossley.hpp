#pragma once
#include <cmath>

#include "libdem/impact/impact.hpp"

namespace subsoil::dem::impact {

/// Hunt and Crossley's viscoelastic impact, solved exactly.
///     F = c x^n (1 + b v)
/// c N/m^n, n shape of the surfaces (3/2 spheres, 1 flat), b s/m. With nu = b V-, g0 = nu - ln(1 + nu) and the elastic
/// energy Pi = c x^(n+1)/(n+1) the motion has the first integral
///     b v - ln(1 + b v) + b^2 Pi(x)/m = g0,   b v = -1 - W_i(-exp(-1 - g0 + b^2 Pi/m)),
/// branch i = -1 of Lambert's function on the way in and 0 on the way out. From it follow
///     x_max = ((n+1) m g0/(c b^2))^(1/(n+1)),
///     restitution k: k nu + ln(1 - k nu) = ln(1 + nu) - nu, of c, n and m independent, 1 - 2 nu/3 + ... for small nu,
///     peak force before x_max, at a w - ln(1 + w) = g0, a = (2n+1)/(n+1), w = b v, x_F = (n m w/(b^2 c))^(1/(n+1)).
/// The separating bodies never reach 1/b, and F never pulls.
/// Source: Hunt & Crossley 1975, J. Appl. Mech. 42, 440; solution: Borovin, Dyagel, Lapshin, KIAM preprint 53, 2008.
struct HuntCrossley {
  static constexpr double left_out = std::numeric_limits<double>::quiet_NaN();
  double n = 1.5;
  double c = left_out;  ///< left out: Hertz's 4/3 E* sqrt(R), for n = 3/2
  double b = left_out;  ///< left out: from restitution at a speed
  double restitution = left_out, at_speed = left_out;

  template <class V>
  void describe(V& v) {
    v.card("hunt-crossley", "Hunt-Crossley: spring c x^n with damping that grows with it");
    parameters(v);
  }
  /// The normal part alone: the contact law of the same name has it too.
  template <class V>
  void parameters(V& v) {
    v.exponent("n", n, "[1, 4]", "exponent of the indentation: 1.5 of spheres, 1 of flat bodies");
    v.derived("c", c, "N/m^(n)", "(0, inf)", "stiffness; left out: Hertz's 4/3 E_eff sqrt(R), for n = 1.5");
    v.derived("b", b, "s/m", "[0, inf)", "damping; left out: from `restitution` and `at speed`; 0 is elastic");
    v.derived("restitution", restitution, "1", "(0, 1]",
              "coefficient of restitution at the speed below, in place of b");
    v.derived("at speed", at_speed, "m/s", "(0, inf)", "approach speed at which the restitution holds");
  }

  /// With b filled in. Throws std::invalid_argument when b is given twice or not at all, or c cannot be found.
  HuntCrossley completed() const;

  /// c, or Hertz's from the pair.
  double stiffness(const Pair& pair) const { return std::isnan(c) ? pair.hertz() : c; }
  double restitution_at(const Pair& pair, double speed) const;
  Event strike(const Pair& pair, double speed, int samples = usual_samples) const;
};

/// k(nu), nu = b V- >= 0, to rounding at any nu.
double hunt_crossley_restitution(double nu);
/// nu = b V- that gives a restitution in (0, 1].
double hunt_crossley_nu(double restitution);

}  // namespace subsoil::dem::impact
