#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace subsoil::mbd {

/// Unilateral spring and damper of contacts and stops, depth d > 0, its rate d':
///   F = k d^n (1 + b d'),  never below 0                                              (N, or N m over an angle)
/// n exponent (1.5: Hertz's point contact, 1: linear), k stiffness [N/m^n], b damping [s/m] >= 0. Damping that grows
/// with the depth leaves no jump of force at touch. An impact at speed v_i against a fixed body ends at v_o with
///   b v_i - ln(1 + b v_i) = -b v_o - ln(1 - b v_o),  so restitution v_o / v_i = 1 - 2 b v_i / 3 for small b v_i,
/// for any k, n and mass: the restitution is a result and cannot be given, since it falls with the speed.
/// Energy: stored = k d^(n+1)/(n+1), lost rate = (F - k d^n) d'.
/// Source: Hunt & Crossley 1975, J. Appl. Mech. 42, 440, with n = 3/2 there.
struct HuntCrossleyForce {
  double n = 1.5;
  double stiffness = std::numeric_limits<double>::quiet_NaN();
  double damping = 0;

  /// Units of depth and force: "m" and "N", or "rad" and "N m".
  template <class V>
  void describe(V& v, const std::string& depth, const std::string& force) {
    v.exponent("n", n, "[1, inf)", "exponent of the depth: 1.5 of two spheres, 1 linear");
    v.quantity("stiffness", stiffness, (force + "/" + depth + "^(n)").c_str(), "(0, inf)", "force per depth^n");
    v.quantity("damping", damping, ("s/" + depth).c_str(), "[0, inf)",
               "b in force = k depth^n (1 + b rate of depth); restitution is about 1 - 2/3 b speed; 0: elastic");
  }
  void check() const {
    if (!(stiffness > 0 && n >= 1 && damping >= 0))
      throw std::invalid_argument(
          "stiffness must be given and above 0, n at least 1, damping not negative; damping 0 is elastic");
  }

  struct Push {
    double force = 0, stored = 0, lost = 0;
  };
  Push at(double depth, double rate) const {
    if (!(depth > 0)) return {};
    const double spring = stiffness * std::pow(depth, n), force = std::max(0.0, spring * (1 + damping * rate));
    return {force, spring * depth / (n + 1), (force - spring) * rate};
  }
};

}  // namespace subsoil::mbd
