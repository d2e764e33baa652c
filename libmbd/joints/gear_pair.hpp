#pragma once

#include "libmbd/joints/disk_on_disk.hpp"

namespace subsoil::mbd {

/// Gear pair: the pitch circles of two bodies roll on each other; pins on a frame or carrier hold their centres, which
/// may move. It is the same for fixed axes and for planets, since it follows the line of centres:
///   Phi = R_a (angle_a - phi) +- R_b (angle_b - phi) - const = 0                (m), up to whole turns of phi
/// phi: direction of the line from p_a to p_b in the world [rad]; + for outer, - for inner (ring) gears; R_a, R_b pitch
/// radii [m] > 0, of which only the ratio matters; const is that of the start pose. No backlash.
/// Reaction: the tooth force across the line of centres at the pitch point, no moment: the pins carry it. The
/// separating share of the pressure angle does no work and is left out. Source: Haug 1989, 3.4 (gear set).
struct GearPair : TwoDisks {
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
    describe_as(v, "gear pair", "two gears in mesh, on fixed axes or on a moving carrier; pins hold their centres",
                "the two gears, radii are those of the pitch circles; the tooth force is reported on the first, at the "
                "pitch point");
  }

  void initialise_from_pose(const BodyState& a, const BodyState& b, double /*t*/) {
    if (std::isnan(offset)) offset = start_offset(a, b);
  }
  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    out[0] = rolling_row(RelativePoint(a, p_a, b, p_b), b.angle - a.angle, offset);
  }
  /// Room between the two pitch circles, negative where they overlap (m).
  double room(const BodyState& a, const BodyState& b) const {
    const double apart = length(b.point_in_world(p_b) - a.point_in_world(p_a));
    return inside ? span() - apart : apart - span();
  }
  Vec2 reaction_point(const BodyState& a, const BodyState& b) const { return contact(a, b); }
};

}  // namespace subsoil::mbd
