#pragma once

#include <stdexcept>

#include "libmbd/force.hpp"

namespace subsoil::mbd {

/// Rotational spring-damper between two bodies, theta = angle_b - angle_a:
///   T = preload + k (theta_0 - theta) - c theta'        torque on b, its opposite on a           (N m)
/// k stiffness [N m/rad] >= 0, theta_0 free angle [rad], c damping [N m s/rad] >= 0, preload [N m]. Without a free
/// angle theta_0 is the angle in the start pose. Angles count full turns.
/// Energy: stored = k (theta_0 - theta)^2 / 2 - preload (theta - theta_0), lost rate = c theta'^2.
struct RotationalSpringDamper {
  static constexpr std::array<ForceColumn, 2> columns{{{"torque", "N m"}, {"angle", "rad"}}};
  int body_a = -1, body_b = -1;
  double stiffness = std::numeric_limits<double>::quiet_NaN();
  double free_angle = std::numeric_limits<double>::quiet_NaN();
  double preload = 0;
  double damping = 0;

  template <class V>
  void describe(V& v) {
    v.card("rotational spring-damper", "a torsion spring and damper between two bodies");
    v.bodies("rotational spring-damper", body_a, body_b, "the two bodies; the torque is reported on the second");
    v.quantity("stiffness", stiffness, "N m/rad", "[0, inf)", "torque per angle");
    v.optional_quantity("free angle", free_angle, "rad", "(-inf, inf)",
                        "angle of the second body against the first without torque; left out: that of the start pose");
    v.quantity("preload", preload, "N m", "(-inf, inf)", "constant torque on top");
    v.quantity("damping", damping, "N m s/rad", "[0, inf)", "torque per rate of turn");
  }

  void check() const {
    if (!(stiffness >= 0 && damping >= 0))
      throw std::invalid_argument(
          "stiffness and damping must be given and not negative; stiffness 0 is a damper alone");
  }

  void settle_start(const Scene& scene) {
    if (std::isnan(free_angle)) free_angle = second(scene).angle - first(scene).angle;
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const double theta = second(scene).angle - first(scene).angle, rate = second(scene).spin - first(scene).spin;
    const double torque = preload + stiffness * (free_angle - theta) - damping * rate;
    loads.add_wrench(body_b, 0, 0, torque);
    loads.add_wrench(body_a, 0, 0, -torque);
    values = {torque, theta, 0, 0};
    const double beyond = theta - free_angle;
    return {0.5 * stiffness * beyond * beyond - preload * beyond, damping * rate * rate, 0};
  }

 private:
  const BodyState& first(const Scene& scene) const { return scene.bodies[static_cast<std::size_t>(body_a)]; }
  const BodyState& second(const Scene& scene) const { return scene.bodies[static_cast<std::size_t>(body_b)]; }
};

}  // namespace subsoil::mbd
