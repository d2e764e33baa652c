#pragma once

#include "libmbd/element/constraint.hpp"

namespace subsoil::mbd {

/// Revolute joint (pin): a point of body a and a point of body b coincide, the bodies turn freely about it.
///   Phi = r_a + A_a p_a - r_b - A_b p_b = 0                         (2 equations, m)
///   gamma = omega_a^2 A_a p_a - omega_b^2 A_b p_b
/// p_a, p_b [m] in the bodies' own axes. Reaction: (-lambda) at the pin on body a, (+lambda) on body b, no moment.
/// Source: Haug, Computer Aided Kinematics and Dynamics, 1989, 3.3.
struct Revolute {
  static constexpr ConstraintMembers has{.points = true, .pin = true, .latch = true};
  static constexpr std::size_t rows = 2;
  static constexpr std::array<bool, rows> angular{false, false};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};

  template <class V>
  void describe(V& v) {
    v.card("revolute", "a pin: one point of each body coincide and the bodies turn freely about it");
    v.bodies("revolute", body_a, body_b, "the two bodies that the pin joins; the reaction is reported on the first");
    v.joint_point(body_a, p_a, body_b, p_b, "the pin");
  }

  void latch(const BodyState& a, const BodyState& b) { p_b = b.point_in_body(a.point_in_world(p_a)); }
  std::array<double, 3> latched() const { return {p_b[0], p_b[1], 0}; }
  void set_latched(const std::array<double, 3>& m) { p_b = {m[0], m[1]}; }

  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    const Vec2 arm_a = a.vector_in_world(p_a), arm_b = b.vector_in_world(p_b);
    const Vec2 gap = a.r + arm_a - b.r - arm_b;
    const Vec2 gamma = a.omega * a.omega * arm_a - b.omega * b.omega * arm_b;
    out[0] = {gap.x, {1, 0, -arm_a.y}, {-1, 0, arm_b.y}, gamma.x, 0};
    out[1] = {gap.y, {0, 1, arm_a.x}, {0, -1, -arm_b.x}, gamma.y, 0};
  }
};

}  // namespace subsoil::mbd
