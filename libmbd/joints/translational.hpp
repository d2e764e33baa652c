#pragma once

#include "libmbd/element/constraint.hpp"

namespace subsoil::mbd {

/// Translational joint (slide): body b moves along a line of body a and does not turn against it.
///   Phi_1 = n . d,  d = (r_b + A_b p_b) - (r_a + A_a p_a)                       (m)
///   Phi_2 = angle_b - angle_a - relative_angle                                  (rad)
///   gamma_1 = omega_a^2 n.d + 2 omega_a e.d' + n.(omega_b^2 A_b p_b - omega_a^2 A_a p_a),  gamma_2 = 0
/// e: the line's direction, at angle_a [rad] from body a's x axis; n = k x e. p_a, p_b [m] in body axes.
/// relative_angle [rad] keeps its start value when not set. Reaction: normal force at p_b's place, and a moment.
/// Source: Haug 1989, 3.3, with the unit normal in place of the vector product.
struct Translational {
  static constexpr ConstraintMembers has{.initialise_from_pose = true, .points = true};
  static constexpr std::size_t rows = 2;
  static constexpr std::array<bool, rows> angular{false, true};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double angle_a = 0;
  double relative_angle = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    v.card("translational", "a slide: the second body moves along a line of the first and does not turn against it");
    v.bodies("translational", body_a, body_b,
             "the two bodies that slide on each other; the reaction is reported on the first");
    v.joint_point(body_a, p_a, body_b, p_b,
                  "a point of the line; it travels with the second body, and a guide with friction is centred at it");
    v.axis("along", body_a, angle_a, "direction of the line in the start pose");
  }

  /// What the scenario leaves to the start pose.
  void initialise_from_pose(const BodyState& a, const BodyState& b, double /*t*/) {
    if (std::isnan(relative_angle)) relative_angle = b.angle - a.angle;
  }

  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    const Vec2 arm_a = a.vector_in_world(p_a), arm_b = b.vector_in_world(p_b);
    const Vec2 e{std::cos(a.angle + angle_a), std::sin(a.angle + angle_a)};
    const Vec2 n = turned(e);
    const Vec2 d = b.r + arm_b - a.r - arm_a;
    const Vec2 d_rate = b.velocity_at(arm_b) - a.velocity_at(arm_a);
    const double gamma = a.omega * a.omega * dot(n, d) + 2 * a.omega * dot(e, d_rate) +
                         dot(n, b.omega * b.omega * arm_b - a.omega * a.omega * arm_a);
    out[0] = {dot(n, d), {-n.x, -n.y, -dot(n, turned(arm_a)) - dot(e, d)}, {n.x, n.y, dot(n, turned(arm_b))}, gamma, 0};
    out[1] = {b.angle - a.angle - relative_angle, {0, 0, -1}, {0, 0, 1}, 0, 0};
  }
};

}  // namespace subsoil::mbd
