#pragma once
#include "libdem/impact/impact.hpp"

namespace subsoil::dem::impact {

/// Hertz's elastic impact of spheres: F = 4/3 E* sqrt(R) x^1.5, nothing is lost.
///     x_max = (15 m V^2/(16 E* sqrt(R)))^(2/5),   duration (4/5) sqrt(pi) Gamma(2/5)/Gamma(9/10) x_max/V = 2.9433
///     x_max/V
/// Valid while x << R and no point yields. Source: Hertz 1882.
struct Hertz {
  template <class V>
  void describe(V& v) {
    v.card("hertz", "Hertz: elastic spheres");
  }
  double restitution_at(const Pair&, double) const { return 1; }
  Event strike(const Pair& pair, double speed, int samples = usual_samples) const;
};

}  // namespace subsoil::dem::impact
