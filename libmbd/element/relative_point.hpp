#pragma once

#include "libmbd/element/constraint.hpp"

namespace subsoil::mbd {

/// A point p_b of body b as body a sees it: from the point p_a of a, in a's axes. What most joints are made of.
///   w    = A_a^T d - p_a,  d = r_b + A_b p_b - r_a          place (m)
///   rate = A_a^T (d' - spin_a k x d)                        w'
///   bend = A_a^T (-spin_b^2 A_b p_b - 2 spin_a k x d' - spin_a^2 d), what is left of w'' where q'' = 0
/// A constraint Phi(w, relative_angle), relative_angle = angle_b - angle_a, then has its row by the chain rule:
///   Phi_q = Phi_w w_q + Phi_turn turn_q,   gamma = -(Phi_w . bend + second),
///   second = (w', relative_angle') Phi_ww (w', relative_angle')^T
class RelativePoint {
 public:
  double turn_rate;  ///< relative_angle'
  Vec2 w, rate, bend;

  RelativePoint(const BodyState& a, const std::array<double, 2>& p_a, const BodyState& b,
                const std::array<double, 2>& p_b)
      : turn_rate(b.omega - a.omega), a_(a), arm_b_(b.vector_in_world(p_b)) {
    const Vec2 d = b.r + arm_b_ - a.r, d_rate = b.v + b.omega * turned(arm_b_) - a.v;
    seen_ = in_a(d);
    w = {seen_.x - p_a[0], seen_.y - p_a[1]};
    rate = in_a(d_rate - a.omega * turned(d));
    bend = in_a(Vec2{} - b.omega * b.omega * arm_b_ - 2 * a.omega * turned(d_rate) - a.omega * a.omega * d);
  }

  ConstraintRow row(double phi, Vec2 phi_w, double second, double phi_turn = 0) const {
    const Vec2 g{a_.c * phi_w.x - a_.s * phi_w.y, a_.s * phi_w.x + a_.c * phi_w.y};
    return {phi,
            {-g.x, -g.y, -dot(phi_w, turned(seen_)) - phi_turn},
            {g.x, g.y, dot(g, turned(arm_b_)) + phi_turn},
            -dot(phi_w, bend) - second,
            0};
  }

 private:
  Vec2 in_a(Vec2 world) const { return {a_.c * world.x + a_.s * world.y, a_.c * world.y - a_.s * world.x}; }
  const BodyState& a_;
  Vec2 arm_b_, seen_;
};

/// |w| = length, as Phi = (w . w - length^2) / (2 length): its gradient is the unit vector along w where it holds, and
/// w = 0 does no harm. -lambda is the force that drives the two points apart.
inline ConstraintRow distance_row(const RelativePoint& p, double length) {
  return p.row((dot(p.w, p.w) - length * length) / (2 * length), (1 / length) * p.w, dot(p.rate, p.rate) / length);
}

/// Pitch circles of radius_a about p_a and radius_b about p_b that roll on each other (radius_b < 0: inside), psi the
/// direction of the line of centres in a's axes:
///   Phi = radius_b relative_angle - (radius_a + radius_b) psi - offset = 0                                  (m)
/// A turn of the line of centres changes Phi by a period and nothing else, so Phi is the remainder nearest to 0.
/// Source: Haug 1989, 3.4 (gear set).
inline ConstraintRow pitch_row(const RelativePoint& p, double relative_angle, double radius_a, double radius_b,
                               double offset) {
  constexpr double two_pi = 6.283185307179586476925;
  const double sum = radius_a + radius_b, r2 = dot(p.w, p.w);
  const double phi = radius_b * relative_angle - sum * std::atan2(p.w.y, p.w.x) - offset;
  const double second = 2 * sum * dot(p.w, p.rate) * cross(p.w, p.rate) / (r2 * r2);
  return p.row(std::remainder(phi, two_pi * sum), (-sum / r2) * turned(p.w), second, radius_b);
}

/// The travel of p_b along the direction `along` of a with a pitch radius rolling on that line:
///   Phi = along . w + radius relative_angle - offset = 0                                                     (m)
/// radius > 0: the line is on the right of the disk's centre, seen along it.
inline ConstraintRow travel_row(const RelativePoint& p, Vec2 along, double relative_angle, double radius,
                                double offset) {
  return p.row(dot(along, p.w) + radius * relative_angle - offset, along, 0, radius);
}

}  // namespace subsoil::mbd
