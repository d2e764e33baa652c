#pragma once

#include <stdexcept>

#include "libmbd/element/force_geometry.hpp"
#include "libmbd/element/spring_law.hpp"

namespace subsoil::mbd {

/// Rotational spring-damper-actuator between two bodies, theta = angle_b - angle_a:
///   T = preload + k d + f_s(d) + c d' + f_d(d') + f(t) + u,  d = theta_0 - theta   torque on b, opposite on a   (N m)
/// k stiffness [N m/rad] >= 0, theta_0 free angle [rad], c damping [N m s/rad] >= 0, preload [N m]; f_s spring curve
/// over d, f_d damper curve over d' (polynomial or table), f actuator torque, u output of a controller: none of them
/// unless given. Without a free angle theta_0 is the angle in the start pose. Angles count full turns. Energy: stored =
/// preload d + k d^2 / 2 + integral of f_s from 0 to d, lost rate = (c d' + f_d(d')) d', work rate =
/// -(f + u) d'. Source: Haug 1989, chapter 6, rotational spring-damper-actuator.
struct RotationalSpringDamper {
  static constexpr ForceMembers has{.check = true, .initialise_from_pose = true, .profiles = true, .controlled = true};
  static constexpr std::array<ForceColumn, 2> columns{{{"torque", "N m"}, {"angle", "rad"}}};
  int body_a = -1, body_b = -1;
  double stiffness = std::numeric_limits<double>::quiet_NaN();
  double free_angle = std::numeric_limits<double>::quiet_NaN();
  double preload = 0;
  double damping = 0;
  Characteristic spring_curve{}, damper_curve{};
  Function actuator{};
  std::string controller{};
  int signal = -1;  ///< set by the system

  template <class V>
  void describe(V& v) {
    v.card("rotational spring-damper", "a torsion spring and damper between two bodies");
    v.bodies("rotational spring-damper", body_a, body_b, "the two bodies; the torque is reported on the second");
    v.optional_quantity("stiffness", stiffness, "N m/rad", "[0, inf)",
                        "torque per angle; may only be left out where a spring curve is given");
    v.optional_quantity("free angle", free_angle, "rad", "(-inf, inf)",
                        "angle of the second body against the first without torque; left out: that of the start pose");
    v.quantity("preload", preload, "N m", "(-inf, inf)", "constant torque on top");
    v.quantity("damping", damping, "N m s/rad", "[0, inf)", "torque per rate of turn");
    v.optional_characteristic("spring curve", spring_curve, "rad", "N m",
                              "torque over (free angle - angle), on top of the stiffness");
    v.optional_characteristic("damper curve", damper_curve, "rad/s", "N m",
                              "torque over minus the rate of turn, on top of the damping");
    v.optional_function("actuator torque", actuator, "N m", "given torque on the second body, counter-clockwise");
    v.text("controller", controller,
           "name of the controller whose output, in N m, is added to it; left "
           "out: none");
  }

  void check() const { check_spring(*this); }

  void initialise_from_pose(const Scene& scene) {
    if (std::isnan(free_angle)) free_angle = angle(scene);
    if (std::isnan(stiffness)) stiffness = 0;
  }

  std::size_t profile_count() const { return spring_profile_count(*this); }
  void profile_arguments(const Scene& scene, std::span<double> out) const {
    const double rate = body_of(scene, body_b).omega - body_of(scene, body_a).omega;
    spring_profile_arguments(*this, free_angle - angle(scene), -rate, out);
  }
  double profile_value(std::size_t k, double x) const { return spring_profile(*this, k).value(x); }
  std::vector<double> profile_nodes(std::size_t k) const {
    const std::span<const double> nodes = spring_profile(*this, k).nodes();
    return {nodes.begin(), nodes.end()};
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const double theta = angle(scene), rate = body_of(scene, body_b).omega - body_of(scene, body_a).omega;
    const SpringLaw law = spring_law(*this, free_angle - theta, -rate, scene);
    loads.add_wrench(body_b, 0, 0, law.total());
    loads.add_wrench(body_a, 0, 0, -law.total());
    values = {law.total(), theta, 0, 0};
    return law.power;
  }

 private:
  double angle(const Scene& scene) const { return body_of(scene, body_b).angle - body_of(scene, body_a).angle; }
};

}  // namespace subsoil::mbd
