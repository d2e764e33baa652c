#pragma once

#include "libmbd/element/constraint.hpp"

namespace subsoil::mbd {

/// Fixed joint (weld): body b neither moves nor turns against body a.
///   Phi_1,2 = r_a + A_a p_a - r_b - A_b p_b = 0                                 (m)
///   Phi_3   = angle_b - angle_a - relative_angle = 0                            (rad)
/// p_a, p_b [m] in body axes; relative_angle [rad] keeps its start value when not set.
/// Reaction: force at the point and a moment.
struct Fixed {
  static constexpr ConstraintMembers has{.initialise_from_pose = true, .points = true, .latch = true};
  static constexpr std::size_t rows = 3;
  static constexpr std::array<bool, rows> angular{false, false, true};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double relative_angle = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    v.card("fixed", "a weld: the second body neither moves nor turns against the first");
    v.bodies("fixed", body_a, body_b, "the two bodies that are one; the reaction is reported on the first");
    v.joint_point(body_a, p_a, body_b, p_b, "the point at which the reaction is reported");
  }

  /// What the scenario leaves to the start pose.
  void initialise_from_pose(const BodyState& a, const BodyState& b, double /*t*/) {
    if (std::isnan(relative_angle)) relative_angle = b.angle - a.angle;
  }

  void latch(const BodyState& a, const BodyState& b) {
    p_b = b.point_in_body(a.point_in_world(p_a));
    relative_angle = b.angle - a.angle;
  }
  std::array<double, 3> latched() const { return {p_b[0], p_b[1], relative_angle}; }
  void set_latched(const std::array<double, 3>& m) { p_b = {m[0], m[1]}, relative_angle = m[2]; }

  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    const Vec2 arm_a = a.vector_in_world(p_a), arm_b = b.vector_in_world(p_b);
    const Vec2 gap = a.r + arm_a - b.r - arm_b;
    const Vec2 gamma = a.omega * a.omega * arm_a - b.omega * b.omega * arm_b;
    out[0] = {gap.x, {1, 0, -arm_a.y}, {-1, 0, arm_b.y}, gamma.x, 0};
    out[1] = {gap.y, {0, 1, arm_a.x}, {0, -1, -arm_b.x}, gamma.y, 0};
    out[2] = {b.angle - a.angle - relative_angle, {0, 0, -1}, {0, 0, 1}, 0, 0};
  }
};

}  // namespace subsoil::mbd
