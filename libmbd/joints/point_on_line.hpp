#pragma once

#include "libmbd/element/relative_point.hpp"

namespace subsoil::mbd {

/// Point on line (pin in slot): a point of body b stays on a straight line of body a; it may move along it and turn.
///   Phi = n . w = 0                                                             (m)
/// w: p_b seen from p_a, in a's axes [m]; e at angle_a [rad] from a's x axis, n = k x e.
/// Reaction: a force across the line at the point of b, no moment. The slot has no end.
/// Source: Haug 1989, 3.3 (the first equation of a translational joint).
struct PointOnLine {
  static constexpr ConstraintMembers has{.points = true};
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{false};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double angle_a = 0;

  template <class V>
  void describe(V& v) {
    v.card("point on line", "a pin in a slot: a point of the second body stays on a line of the first");
    v.bodies("point on line", body_a, body_b,
             "the body with the slot and the body with the pin; the reaction is reported on the first");
    v.joint_point(body_a, p_a, body_b, p_b, "the pin, and a point of the line");
    v.axis("along", body_a, angle_a, "direction of the line in the start pose");
  }

  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    const RelativePoint p(a, p_a, b, p_b);
    const Vec2 n{-std::sin(angle_a), std::cos(angle_a)};
    out[0] = p.row(dot(n, p.w), n, 0);
  }
};

}  // namespace subsoil::mbd
