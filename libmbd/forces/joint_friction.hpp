#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "libmbd/force.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"

namespace subsoil::mbd {

/// Dry and viscous friction in a revolute or translational joint, from the joint's own reaction:
///   F = -mu(|v|) N tanh(v/v_reg) - c v,   mu(v) = mu_k + (mu_s - mu_k) exp(-(v/v_s)^2)                  (N)
///   revolute       v = radius (spin_b - spin_a),  N = |reaction|;  torque radius F on b, its opposite on a
///   translational  v = speed of b along the line,  N = |N_1| + |N_2| = max(|F_n|, 2 |M|/guide);  F along the line on b
/// N_1, N_2: forces on the two ends of a guide of the given length about the joint's point that carry the normal force
/// F_n and the moment M. radius, guide [m] > 0; mu_s >= mu_k >= 0 [1]; v_s Stribeck speed, v_reg regularisation
/// speed [m/s] > 0; c [N s/m] >= 0, of the sliding speed.
/// Validity: there is no sticking: below v_reg the joint creeps, v ~ v_reg F/(mu_s N), which the reported sliding speed
/// shows. The reaction depends on the friction and the friction on the reaction: both are solved together (see
/// Partition::accelerate), which has no answer where the joint locks itself, and the run then stops.
/// Energy: lost rate = -F v >= 0, nothing is stored.
/// Source: Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083, eq. 6, with tanh for the sign.
struct JointFriction {
  static constexpr std::array<ForceColumn, 4> columns{
      {{"force", "N"}, {"torque", "N m"}, {"sliding speed", "m/s"}, {"normal force", "N"}}};
  std::string joint{};  ///< its name; the bodies are the joint's
  double radius = std::numeric_limits<double>::quiet_NaN();
  double guide = std::numeric_limits<double>::quiet_NaN();
  double mu_s = std::numeric_limits<double>::quiet_NaN();
  double mu_k = std::numeric_limits<double>::quiet_NaN();
  double stribeck_speed = 0.01;
  double regularisation_speed = 1e-3;
  double viscous = 0;
  // Set by the system from the joint:
  int body_a = -1, body_b = -1, row = -1;  ///< row: its first equation
  bool slides = false;
  std::array<double, 2> p_b{0, 0};
  double angle_a = 0;

  template <class V>
  void describe(V& v) {
    v.card("joint friction", "Stribeck friction in a pin or slide, from the joint's reaction");
    v.joint("joint friction", joint, "the revolute or translational joint that it acts in");
    v.optional_quantity("radius", radius, "m", "(0, inf)", "radius of the pin, for a revolute joint");
    v.optional_quantity("guide", guide, "m", "(0, inf)", "length of the guide, for a translational joint");
    v.quantity("mu_s", mu_s, "1", "[0, inf)", "coefficient of friction near rest");
    v.quantity("mu_k", mu_k, "1", "[0, inf)", "coefficient of friction in fast sliding, at most mu_s");
    v.quantity("Stribeck speed", stribeck_speed, "m/s", "(0, inf)", "speed over which it falls from mu_s to mu_k");
    v.quantity("regularisation speed", regularisation_speed, "m/s", "(0, inf)",
               "speed below which the friction fades: the joint creeps instead of sticking");
    v.quantity("viscous", viscous, "N s/m", "[0, inf)", "further force per sliding speed");
  }

  void check() const {
    if (!(mu_s >= mu_k && mu_k >= 0 && std::isfinite(mu_s)))
      throw std::invalid_argument(
          "mu_s and mu_k must be given, mu_k not negative and at most mu_s; equal values are Coulomb's friction");
    if (!(stribeck_speed > 0 && regularisation_speed > 0 && viscous >= 0))
      throw std::invalid_argument("Stribeck and regularisation speed must be above 0 and viscous not negative");
  }

  /// Takes what it needs from the joint that it names.
  template <class Joint>
  void attach([[maybe_unused]] const Joint& j, [[maybe_unused]] int first_row) {
    if constexpr (std::is_same_v<Joint, Revolute> || std::is_same_v<Joint, Translational>) {
      slides = std::is_same_v<Joint, Translational>;
      if (slides && !(guide > 0))
        throw std::invalid_argument("joint '" + joint + "' is a slide: give the length of its guide");
      if (!slides && !(radius > 0)) throw std::invalid_argument("joint '" + joint + "' is a pin: give its radius");
      if constexpr (std::is_same_v<Joint, Translational>) angle_a = j.angle_a;
      body_a = j.body_a, body_b = j.body_b, p_b = j.p_b, row = first_row;
    } else {
      throw std::invalid_argument("joint '" + joint + "' is neither revolute nor translational; name one that is");
    }
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const BodyState &a = scene.bodies[static_cast<std::size_t>(body_a)],
                    &b = scene.bodies[static_cast<std::size_t>(body_b)];
    const double first = scene.lambda[static_cast<std::size_t>(row)],
                 second = scene.lambda[static_cast<std::size_t>(row) + 1];
    if (!slides) {
      const double v = radius * (b.spin - a.spin), normal = std::hypot(first, second), f = force(v, normal);
      loads.add_wrench(body_b, 0, 0, radius * f);
      loads.add_wrench(body_a, 0, 0, -radius * f);
      values = {0, radius * f, v, normal};
      return {0, -f * v, 0};
    }
    const Vec2 arm_b = b.world(p_b), arm_a = b.r + arm_b - a.r;
    const Vec2 e{std::cos(a.angle + angle_a), std::sin(a.angle + angle_a)};
    const double v = dot(e, b.velocity_at(arm_b) - a.velocity_at(arm_a));
    const double normal = std::max(std::abs(first), 2 * std::abs(second) / guide), f = force(v, normal);
    loads.add(body_b, arm_b, f * e);
    loads.add(body_a, arm_a, -f * e);
    values = {f, 0, v, normal};
    return {0, -f * v, 0};
  }

 private:
  double force(double v, double normal) const {
    const double x = v / stribeck_speed, mu = mu_k + (mu_s - mu_k) * std::exp(-x * x);
    return -mu * normal * std::tanh(v / regularisation_speed) - viscous * v;
  }
};

}  // namespace subsoil::mbd
