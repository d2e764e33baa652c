#pragma once
#include "libdem/impact/impact.hpp"

namespace subsoil::dem::impact {

/// Elastic - perfectly plastic spheres after Thornton: the contact pressure is cut off at p_y.
///     x <= x_y: F = 4/3 E* sqrt(R) x^1.5;   beyond: F = F_y + pi p_y R (x - x_y);   x_y = (pi p_y/(2 E*))^2 R
///     unloading: Hertz with the flattened radius R F_elastic(x*)/F*, down to x_p
///     V_y = 3.194 (p_y^5 R^3/(E*^4 m))^(1/2), the speed at which yield begins; for V > V_y, u = V_y/V,
///     e = (6 sqrt3/5)^(1/2) (1 - u^2/6)^(1/2) (u/(u + 2 sqrt(6/5 - u^2/5)))^(1/4)
/// which is what these forces give exactly. p_y: contact pressure at yield, Pa, about 1.6 to 2.8 yield strengths.
/// Source: Thornton 1997, J. Appl. Mech. 64, 383.
struct Thornton {
  double p_y = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    v.card("thornton", "Thornton 1997: Hertz with the contact pressure cut off at yield");
    v.quantity("p_y", p_y, "Pa", "(0, inf)", "contact pressure at yield, about 1.6 to 2.8 times the yield strength");
  }
  /// m/s; the pair's E*, R and m must be known.
  double yield_speed(const Pair& pair) const;
  double restitution_at(const Pair& pair, double speed) const;
  Event strike(const Pair& pair, double speed, int samples = usual_samples) const;
};

}  // namespace subsoil::dem::impact
