#pragma once

#include <stdexcept>
#include <string>

#include "libmbd/element/relative_point.hpp"

namespace subsoil::mbd {

/// Distance (massless link with a pin at either end): two points keep their distance.
///   Phi = (w . w - L^2) / (2 L) = 0                                             (m)
/// w: p_b seen from p_a [m]; L length [m] > 0, kept from the start pose when not set. Two points on each other (L = 0)
/// are a revolute joint. Reaction: the force in the link, along it. Source: Haug 1989, 3.3 (distance constraint).
struct Distance {
  static constexpr ConstraintMembers has{
      .check = true, .initialise_from_pose = true, .points = true, .characteristic_length = true, .latch = true};
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{false};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double length = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    v.card("distance", "a massless link: two points keep their distance");
    v.bodies("distance", body_a, body_b, "the two bodies that the link joins; the reaction is reported on the first");
    v.end_points(body_a, p_a, body_b, p_b, "the two ends of the link");
    v.optional_quantity("length", length, "m", "(0, inf)", "length of the link; left out: that of the start pose");
  }
  void check() const {
    if (length <= 0)
      throw std::invalid_argument("length = " + std::to_string(length) +
                                  " m: must be in (0, inf); for two points on each other use a revolute joint");
  }
  double characteristic_length() const { return length; }

  void initialise_from_pose(const BodyState& a, const BodyState& b, double /*t*/) {
    if (std::isnan(length)) length = mbd::length(b.point_in_world(p_b) - a.r - a.vector_in_world(p_a));
    if (length == 0)
      throw std::invalid_argument(
          "the two points lie on each other in the start pose, so the link has no length; give `length`, or use a "
          "revolute joint");
  }

  void latch(const BodyState& a, const BodyState& b) {
    length = mbd::length(b.point_in_world(p_b) - a.point_in_world(p_a));
    if (!(length > 0)) throw std::runtime_error("a link closes where its two points lie on each other; use a revolute");
  }
  std::array<double, 3> latched() const { return {length, 0, 0}; }
  void set_latched(const std::array<double, 3>& m) { length = m[0]; }

  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    out[0] = distance_row(RelativePoint(a, p_a, b, p_b), length);
  }
};

}  // namespace subsoil::mbd
