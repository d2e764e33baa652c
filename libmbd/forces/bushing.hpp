#pragma once

#include <stdexcept>

#include "libmbd/element/force_geometry.hpp"

namespace subsoil::mbd {

/// Bushing: springs and dampers along two axes of body a and about z, between a point of a and a point of b.
///   d   = A^T (P_b - P_a),  A at angle_a + turn          offset of b's point in the bushing's axes           (m)
///   F_i = preload_i - k_i d_i - c_i d_i'                 on b along axis i = x, y, at P_b; its opposite on a there (N)
///   T   = preload_t - k_t phi - c_t phi',  phi = angle_b - angle_a - phi_0            on b, its opposite on a   (N m)
/// d' is the rate that an observer turning with body a sees. The force acts on both bodies at the place of b's point,
/// so the moment arm of the offset d is in the balance of moments and the energy closes for offsets of any size.
/// k_i [N/m], c_i [N s/m], k_t [N m/rad], c_t [N m s/rad], all >= 0; turn [rad] from body a's axes. Without a free
/// angle phi_0 is the angle in the start pose. Energy: stored = sum of k d^2 / 2 - preload d over the three, lost rate
/// = sum of c d'^2. Source: the linear bushing of MSC Adams, uncoupled, restricted to the plane.
struct Bushing {
  static constexpr ForceMembers has{.check = true, .initialise_from_pose = true};
  static constexpr std::array<ForceColumn, 4> columns{
      {{"force x", "N"}, {"force y", "N"}, {"torque", "N m"}, {"offset", "m"}}};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double turn = 0;
  double stiffness_x = std::numeric_limits<double>::quiet_NaN();
  double stiffness_y = std::numeric_limits<double>::quiet_NaN();
  double stiffness_turn = 0;
  double damping_x = 0, damping_y = 0, damping_turn = 0;
  double preload_x = 0, preload_y = 0, preload_turn = 0;
  double free_angle = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    v.card("bushing", "an elastic joint: springs and dampers along two axes of the first body and about z");
    v.bodies("bushing", body_a, body_b, "the two bodies; forces are reported on the second, in the bushing's axes");
    v.joint_point(body_a, p_a, body_b, p_b, "the bushing's centre, where the springs are without force");
    v.quantity("turn", turn, "rad", "(-inf, inf)", "angle of the bushing's axes against the first body's own");
    v.quantity("stiffness x", stiffness_x, "N/m", "[0, inf)", "force per offset along its x axis");
    v.quantity("stiffness y", stiffness_y, "N/m", "[0, inf)", "force per offset along its y axis");
    v.quantity("rotational stiffness", stiffness_turn, "N m/rad", "[0, inf)", "torque per angle");
    v.quantity("damping x", damping_x, "N s/m", "[0, inf)", "force per rate of offset along its x axis");
    v.quantity("damping y", damping_y, "N s/m", "[0, inf)", "force per rate of offset along its y axis");
    v.quantity("rotational damping", damping_turn, "N m s/rad", "[0, inf)", "torque per rate of turn");
    v.quantity("preload x", preload_x, "N", "(-inf, inf)", "constant force on the second body along its x axis");
    v.quantity("preload y", preload_y, "N", "(-inf, inf)", "constant force on the second body along its y axis");
    v.quantity("rotational preload", preload_turn, "N m", "(-inf, inf)", "constant torque on the second body");
    v.optional_quantity("free angle", free_angle, "rad", "(-inf, inf)",
                        "angle of the second body against the first without torque; left out: that of the start pose");
  }

  void check() const {
    for (const double value : {stiffness_x, stiffness_y, stiffness_turn, damping_x, damping_y, damping_turn})
      if (!(value >= 0))
        throw std::invalid_argument(
            "stiffness x and y must be given, and no stiffness or damping may be negative; 0 leaves a direction free");
  }

  void initialise_from_pose(const Scene& scene) {
    if (std::isnan(free_angle)) free_angle = body_of(scene, body_b).angle - body_of(scene, body_a).angle;
  }

  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const BodyState &a = body_of(scene, body_a), &b = body_of(scene, body_b);
    const Vec2 at = b.point_in_world(p_b), d = at - a.r - a.vector_in_world(p_a),
               d_rate = velocity_against(scene, body_a, body_b, at);
    const Vec2 ex{std::cos(a.angle + turn), std::sin(a.angle + turn)}, ey = turned(ex);
    ForcePower power;
    const auto spring = [&power](double k, double c, double preload, double offset, double rate) {
      power.stored += 0.5 * k * offset * offset - preload * offset;
      power.lost += c * rate * rate;
      return preload - k * offset - c * rate;
    };
    const double fx = spring(stiffness_x, damping_x, preload_x, dot(ex, d), dot(ex, d_rate));
    const double fy = spring(stiffness_y, damping_y, preload_y, dot(ey, d), dot(ey, d_rate));
    const double torque =
        spring(stiffness_turn, damping_turn, preload_turn, b.angle - a.angle - free_angle, b.omega - a.omega);
    add_pair(loads, scene, body_a, body_b, at, fx * ex + fy * ey);
    loads.add_wrench(body_b, 0, 0, torque);
    loads.add_wrench(body_a, 0, 0, -torque);
    values = {fx, fy, torque, length(d)};
    return power;
  }
};

}  // namespace subsoil::mbd
