#pragma once
#include "libdem/impact/impact.hpp"

namespace subsoil::dem::impact {

/// Elastic - ideally plastic sphere after Jackson, Green and Marghitu.
///     x_c = (pi C S_y/(2 E*))^2 R,   F_c = (4/3) (R/E*)^2 (pi C S_y/2)^3,   C = 1.295 exp(0.736 nu)
///     w = x/x_c < 1.9: Hertz, beyond (B = 0.14 exp(23 e_y), e_y = S_y/E*):
///     F/F_c = exp(-w^(5/12)/4) w^1.5 + 4 H/(C S_y) (1 - exp(-w^(5/9)/25)) w
///     H/S_y = 2.84 (1 - exp(-0.82 ((pi C e_y/2) sqrt(w) (w/1.9)^(B/2))^-0.7))
///     V_c = (4 F_c x_c/(5 m))^(1/2);  r = V/V_c: e = 1 for r <= 1,
///     e = 1 - 0.1 ln r ((r - 1)/59)^0.156 up to 60,  e = 1 - 0.1 ln 60 - 0.11 ln(r/60) (r - 60)^(2.36 e_y) above
/// Restitution is the source's fit; the unloading drawn here is Hertzian and gives back just that energy.
/// S_y yield strength (Pa) and nu Poisson ratio of the softer body. Source: Jackson & Green 2005, J. Tribol. 127, 343;
/// Jackson, Green & Marghitu 2010, Nonlinear Dyn. 60, 217.
struct JacksonGreen {
  double S_y = std::numeric_limits<double>::quiet_NaN();
  double poisson = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    v.card("jackson-green", "Jackson, Green, Marghitu 2010: elastic - ideally plastic sphere");
    v.derived("S_y", S_y, "Pa", "(0, inf)",
              "yield strength of the softer body; left out: the smaller one of the two bodies");
    v.quantity("nu", poisson, "1", "[0, 0.5]", "Poisson ratio of the softer body");
  }
  double strength(const Pair& pair) const;         ///< Pa
  double critical_speed(const Pair& pair) const;   ///< V_c, m/s
  double force(const Pair& pair, double x) const;  ///< loading, N
  double restitution_at(const Pair& pair, double speed) const;
  Event strike(const Pair& pair, double speed, int samples = usual_samples) const;
};

/// C of the yield onset.
double yield_coefficient(double poisson);

}  // namespace subsoil::dem::impact
