#pragma once

#include "libmbd/joints/disk_on_line.hpp"

namespace subsoil::mbd {

/// Rack and pinion: the pitch circle of body b rolls on the pitch line of body a; other joints hold them in mesh.
///   Phi = e . w + side R (angle_b - angle_a) - offset = 0                       (m)
/// w: pinion's centre p_b seen from p_a of the rack's pitch line, in a's axes [m]; R pitch radius [m] > 0; e at angle_a
/// [rad] from a's x axis; side: see DiskAndLine; offset is Phi of the start pose. No backlash.
/// Reaction: the tooth force along the line at the pitch point, no moment; the separating share of the pressure angle
/// does no work and belongs to the bearings, it is left out. Source: Haug 1989, 3.4.
struct RackAndPinion : DiskAndLine {
  static constexpr ConstraintMembers has{.check = true,
                                         .initialise_from_pose = true,
                                         .points = true,
                                         .reaction_point = true,
                                         .characteristic_length = true};
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{false};
  double offset = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    describe_as(v, "rack and pinion", "travel of the first body's rack turns the second body's pinion, and the reverse",
                "the rack and the pinion; the tooth force is reported on the first, at the pitch point");
  }

  void initialise_from_pose(const BodyState& a, const BodyState& b, double /*t*/) {
    const RelativePoint p(a, p_a, b, p_b);
    settle_side(p);
    if (std::isnan(offset)) offset = travel_row(p, along(), b.angle - a.angle, side * radius, 0).phi;
  }
  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    out[0] = travel_row(RelativePoint(a, p_a, b, p_b), along(), b.angle - a.angle, side * radius, offset);
  }
  /// Room between pitch line and pitch circle, negative where they overlap (m).
  double room(const BodyState& a, const BodyState& b) const { return contact_row(RelativePoint(a, p_a, b, p_b)).phi; }
  Vec2 reaction_point(const BodyState& a, const BodyState& b) const { return contact(a, b); }
};

}  // namespace subsoil::mbd
