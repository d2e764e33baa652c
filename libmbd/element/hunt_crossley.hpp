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
/// for any k, n and mass. With b given the restitution falls with the speed. With the restitution e = v_o/v_i given, b
/// is a constant of each contact: the first of these equations gives x = b v_i from e alone,
///   (1 + e) x = ln((1 + x)/(1 - e x)),   b = x/max(v_i, v_0)
/// v_i: speed at which the contact began; v_0: that below which b is the one of v_0, so that a body comes to rest.
/// Validity of e: no other force of the size of F acts along the normal during the contact.
/// Energy: stored = k d^(n+1)/(n+1), lost rate = (F - k d^n) d'.
/// Source: Hunt & Crossley 1975, J. Appl. Mech. 42, 440, with n = 3/2 there.
struct HuntCrossleyForce {
  double n = 1.5;
  double stiffness = std::numeric_limits<double>::quiet_NaN();
  double damping = 0;
  double restitution = std::numeric_limits<double>::quiet_NaN();
  double slowest_impact = 0.01;  ///< v_0

  /// Units of depth and force: "m" and "N", or "rad" and "N m".
  template <class V>
  void describe(V& v, const std::string& depth, const std::string& force) {
    v.exponent("n", n, "[1, inf)", "exponent of the depth: 1.5 of two spheres, 1 linear");
    v.quantity("stiffness", stiffness, (force + "/" + depth + "^(n)").c_str(), "(0, inf)", "force per depth^n");
    v.quantity("damping", damping, ("s/" + depth).c_str(), "[0, inf)",
               "b in force = k depth^n (1 + b rate of depth); restitution is about 1 - 2/3 b speed; 0: elastic");
    v.optional_quantity("restitution", restitution, "1", "(0, 1]",
                        "instead of `damping`: speed after an impact over the speed before, at any speed");
    v.quantity("restitution from", slowest_impact, (depth + "/s").c_str(), "(0, inf)",
               "impact speed below which the damping is that of this speed, so that a body comes to rest");
  }
  void check() const {
    if (!(stiffness > 0 && n >= 1 && damping >= 0))
      throw std::invalid_argument(
          "stiffness must be given and above 0, n at least 1, damping not negative; damping 0 is elastic");
    if (gives_restitution() && !(restitution > 0 && restitution <= 1 && slowest_impact > 0))
      throw std::invalid_argument(
          "restitution must be in (0, 1] and its smallest speed above 0; for no rebound take a large damping");
  }

  bool gives_restitution() const { return !std::isnan(restitution); }
  /// b of a contact that has begun at the speed `impact`, positive as the bodies approach.
  double damping_from(double impact) const {
    return gives_restitution() ? damping_number(restitution) / std::max(impact, slowest_impact) : damping;
  }
  /// x = b v_i of the restitution e in (0, 1].
  static double damping_number(double e) {
    if (e == 1) return 0;
    // The difference of both sides is negative from 0 to the root, then positive to 1/e.
    double low = 0, high = 1 / e;
    for (int halving = 0; halving < 200 && low < high; ++halving) {
      const double x = 0.5 * (low + high);
      if (x == low || x == high) break;
      (std::log1p(x) - std::log1p(-e * x) < (1 + e) * x ? low : high) = x;
    }
    return low;
  }

  struct Push {
    double force = 0, stored = 0, lost = 0;
  };
  Push at(double depth, double rate) const { return at(depth, rate, damping); }
  /// With the b that the contact has begun with.
  Push at(double depth, double rate, double b) const {
    if (!(depth > 0)) return {};
    const double spring = stiffness * std::pow(depth, n), force = std::max(0.0, spring * (1 + b * rate));
    return {force, spring * depth / (n + 1), (force - spring) * rate};
  }
};

}  // namespace subsoil::mbd
