#pragma once

#include <stdexcept>

#include "libmbd/element/relative_point.hpp"

namespace subsoil::mbd {

/// The straight line of body a, the disk of body b on it, and the side on which it lies: shared by the joints of a disk
/// and a line. side is +1 left of the direction e, -1 right of it, and is kept from the start pose.
struct DiskAndLine {
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double angle_a = 0;
  double radius = std::numeric_limits<double>::quiet_NaN();
  double side = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe_as(V& v, const char* word, const char* card, const char* which) {
    v.card(word, card);
    v.bodies(word, body_a, body_b, which);
    v.end_points(body_a, p_a, body_b, p_b, "a point of the line and the centre of the disk or pinion");
    v.axis("along", body_a, angle_a, "direction of the line in the start pose; the centre keeps its side of it");
    v.quantity("radius", radius, "m", "(0, inf)", "radius of the disk, or of the pinion's pitch circle");
  }

  Vec2 along() const { return {std::cos(angle_a), std::sin(angle_a)}; }
  double characteristic_length() const { return radius; }
  void check() const {
    if (!(radius > 0)) throw std::invalid_argument("radius must be given and above 0 m");
  }
  void settle_side(const RelativePoint& p) {
    if (!std::isnan(side)) return;
    const double height = cross(along(), p.w);
    if (height == 0)
      throw std::invalid_argument(
          "the disk's centre lies on the line in the start pose, so its side is not known; start it on its side of the "
          "line");
    side = height > 0 ? 1 : -1;
  }
  /// n . w - radius = 0, n to the disk's side.
  ConstraintRow contact_row(const RelativePoint& p) const {
    const Vec2 n = side * turned(along());
    return p.row(dot(n, p.w) - radius, n, 0);
  }
  /// World point where the disk is nearest to the line.
  Vec2 contact(const BodyState& a, const BodyState& b) const {
    const Vec2 n = side * turned(along());
    return b.point_in_world(p_b) - radius * a.vector_in_world({n.x, n.y});
  }
};

/// Disk on line, slipping: a disk of body b touches a straight line of body a.
///   Phi = side n . w - R = 0                                                    (m)
/// w: centre p_b seen from the line's point p_a, in a's axes [m]; R radius [m] > 0; e at angle_a [rad] from a's x axis,
/// n = k x e; side: see DiskAndLine. Contact is kept: it pulls where a disk would lift off.
/// Reaction: a force across the line at the contact point, no moment.
struct DiskOnLine : DiskAndLine {
  static constexpr ConstraintMembers has{.check = true,
                                         .initialise_from_pose = true,
                                         .points = true,
                                         .reaction_point = true,
                                         .characteristic_length = true};
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{false};

  template <class V>
  void describe(V& v) {
    describe_as(
        v, "disk on line", "a disk of the second body slips on a straight line of the first; contact is kept",
        "the body with the line and the body with the disk; the reaction is reported on the first, at the contact");
  }

  void initialise_from_pose(const BodyState& a, const BodyState& b, double /*t*/) {
    settle_side(RelativePoint(a, p_a, b, p_b));
  }
  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    out[0] = contact_row(RelativePoint(a, p_a, b, p_b));
  }
  Vec2 reaction_point(const BodyState& a, const BodyState& b) const { return contact(a, b); }
};

}  // namespace subsoil::mbd
