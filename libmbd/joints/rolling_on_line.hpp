#pragma once

#include "libmbd/joints/disk_on_line.hpp"

namespace subsoil::mbd {

/// Rolling on line, without slip: a disk of body b rolls on a straight line of body a.
///   Phi_1 = side n . w - R = 0                                                  (m)
///   Phi_2 = e . w + side R (angle_b - angle_a) - offset = 0                     (m)
/// Symbols as in DiskOnLine; offset is Phi_2 of the start pose: travel and turn count from there. In a plane rolling is
/// holonomic, so it holds at position level. Contact and rolling are kept, for any friction that they need.
/// Reaction: normal force and friction force at the contact point, no moment. Source: Haug 1989, 3.4 (rack and pinion).
struct RollingOnLine : DiskAndLine {
  static constexpr ConstraintMembers has{.check = true,
                                         .initialise_from_pose = true,
                                         .points = true,
                                         .reaction_point = true,
                                         .characteristic_length = true};
  static constexpr std::size_t rows = 2;
  static constexpr std::array<bool, rows> angular{false, false};
  double offset = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    describe_as(
        v, "rolling on line", "a disk of the second body rolls on a straight line of the first without slip",
        "the body with the line and the body with the disk; the reaction is reported on the first, at the contact");
  }

  void initialise_from_pose(const BodyState& a, const BodyState& b, double /*t*/) {
    const RelativePoint p(a, p_a, b, p_b);
    settle_side(p);
    if (std::isnan(offset)) offset = travel_row(p, along(), b.angle - a.angle, side * radius, 0).phi;
  }
  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    const RelativePoint p(a, p_a, b, p_b);
    out[0] = contact_row(p);
    out[1] = travel_row(p, along(), b.angle - a.angle, side * radius, offset);
  }
  Vec2 reaction_point(const BodyState& a, const BodyState& b) const { return contact(a, b); }
};

}  // namespace subsoil::mbd
