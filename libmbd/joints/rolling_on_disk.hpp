#pragma once

#include "libmbd/joints/disk_on_disk.hpp"

namespace subsoil::mbd {

/// Rolling on disk, without slip: a disk of body b rolls on a disk of body a, outside or inside.
///   Phi_1 = (w . w - D^2) / (2 D) = 0,  D = |R_a + R_b|                         (m)
///   Phi_2 = R_b (angle_b - angle_a) - (R_a + R_b) psi - offset = 0              (m), up to whole turns of psi
/// w: centre p_b seen from centre p_a, in a's axes [m]; psi its direction [rad]; R_a, R_b radii [m], R_b negative
/// inside; offset is Phi_2 of the start pose. Contact and rolling are kept, for any friction that they need.
/// Reaction: normal force and friction force at the contact point, no moment. Source: Haug 1989, 3.4 (gear set).
struct RollingOnDisk : TwoDisks {
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
    describe_as(v, "rolling on disk", "a disk of the second body rolls on or in a disk of the first without slip",
                "the two bodies with the disks; the reaction is reported on the first, at the contact");
  }

  void initialise_from_pose(const BodyState& a, const BodyState& b, double /*t*/) {
    if (std::isnan(offset)) offset = start_offset(a, b);
  }
  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    const RelativePoint p(a, p_a, b, p_b);
    out[0] = distance_row(p, span());
    out[1] = rolling_row(p, b.angle - a.angle, offset);
  }
  Vec2 reaction_point(const BodyState& a, const BodyState& b) const { return contact(a, b); }
};

}  // namespace subsoil::mbd
