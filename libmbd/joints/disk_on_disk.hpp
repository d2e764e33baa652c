#pragma once

#include <algorithm>
#include <stdexcept>

#include "libmbd/element/relative_point.hpp"

namespace subsoil::mbd {

/// Two disks that touch from outside or, `inside`, the smaller one in the larger one: shared by the joints of two disks
/// and of gears. radius_b counts negative inside, so that radius_a + radius_b is what the line of centres spans.
struct TwoDisks {
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double radius_a = std::numeric_limits<double>::quiet_NaN(), radius_b = std::numeric_limits<double>::quiet_NaN();
  bool inside = false;

  template <class V>
  void describe_as(V& v, const char* word, const char* card, const char* which) {
    v.card(word, card);
    v.bodies(word, body_a, body_b, which);
    v.end_points(body_a, p_a, body_b, p_b, "the centres of the two circles");
    v.quantity("first radius", radius_a, "m", "(0, inf)", "radius of the first body's circle");
    v.quantity("second radius", radius_b, "m", "(0, inf)", "radius of the second body's circle");
    v.flag("inside", inside, "yes: the smaller circle is inside the larger one");
  }

  double signed_b() const { return inside ? -radius_b : radius_b; }
  double span() const { return std::abs(radius_a + signed_b()); }
  double characteristic_length() const { return std::max(radius_a, radius_b); }
  void check() const {
    if (!(radius_a > 0 && radius_b > 0)) throw std::invalid_argument("both radii must be given and above 0 m");
    if (span() == 0)
      throw std::invalid_argument(
          "a disk inside one of the same radius cannot move in it; make one smaller, or use a revolute joint");
  }
  /// World point on the line of centres where the two circles touch: it divides the line in the ratio of the radii.
  Vec2 contact(const BodyState& a, const BodyState& b) const {
    const Vec2 from = a.point_in_world(p_a), d = b.point_in_world(p_b) - from;
    return from + (radius_a / (radius_a + signed_b())) * d;
  }
  ConstraintRow rolling_row(const RelativePoint& p, double relative_angle, double offset) const {
    return pitch_row(p, relative_angle, radius_a, signed_b(), offset);
  }
  /// Phi of the start pose, which is where turns count from.
  double start_offset(const BodyState& a, const BodyState& b) const {
    const RelativePoint p(a, p_a, b, p_b);
    if (p.w.x == 0 && p.w.y == 0)
      throw std::invalid_argument(
          "the two centres lie on each other in the start pose, so their line has no direction; start them apart");
    return rolling_row(p, b.angle - a.angle, 0).phi;
  }
};

/// Disk on disk, slipping: a disk of body b touches a disk of body a, from outside or inside.
///   Phi = (w . w - D^2) / (2 D) = 0,  D = R_a + R_b outside, |R_a - R_b| inside (m)
/// w: centre p_b seen from centre p_a [m]; R_a, R_b radii [m] > 0. Contact is kept: it pulls where disks would part.
/// Reaction: a force along the line of centres at the contact point, no moment.
struct DiskOnDisk : TwoDisks {
  static constexpr ConstraintMembers has{
      .check = true, .points = true, .reaction_point = true, .characteristic_length = true};
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{false};

  template <class V>
  void describe(V& v) {
    describe_as(v, "disk on disk", "a disk of the second body slips on or in a disk of the first; contact is kept",
                "the two bodies with the disks; the reaction is reported on the first, at the contact");
  }

  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    out[0] = distance_row(RelativePoint(a, p_a, b, p_b), span());
  }
  Vec2 reaction_point(const BodyState& a, const BodyState& b) const { return contact(a, b); }
};

}  // namespace subsoil::mbd
