#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "libmbd/base/curve.hpp"
#include "libmbd/element/relative_point.hpp"

namespace subsoil::mbd {

/// Point on curve (prescribed path): a point of body b stays on a curve of body a; it may move along it and turn.
///   Phi = d(w) = 0                                                              (m)
/// d: distance of w from the curve, positive on its left (see Curve); w: p_b in a's axes [m]. The curve goes through
/// given points of a's axes, x and y cubic splines over the length of the chords, periodic when closed, else natural
/// and straight on beyond its ends.
/// Validity: the curve does not cross itself (checked), since at a crossing the state does not determine which branch
/// the point is on; and during assembly the point is closer to its own stretch of the curve than to another. Reaction:
/// a force along the curve's normal at the point, no moment.
struct PointOnCurve {
  static constexpr ConstraintMembers has{.check = true, .initialise_from_pose = true};
  static constexpr std::size_t rows = 1;
  static constexpr std::array<bool, rows> angular{false};
  int body_a = -1, body_b = -1;
  std::array<double, 2> p_b{0, 0};
  std::vector<std::array<double, 2>> points{};
  bool closed = false;
  std::shared_ptr<const Curve> curve{};  ///< through the points; made at the start

  template <class V>
  void describe(V& v) {
    v.card("point on curve", "a point of the second body follows a curve of the first");
    v.bodies("point on curve", body_a, body_b,
             "the body with the curve and the body with the point; the reaction is reported on the first");
    v.point("at", body_b, p_b, "the point of the second body; left out: its centre of gravity");
    v.outline("curve", points,
              "three or more points `x y` of the curve in the first body's own axes (of the ground: the world's), or a "
              "CSV file of "
              "them whose header names the unit; a cubic spline through them");
    v.flag("closed", closed,
           "yes: from its last point the curve continues to its first; no: straight on beyond its ends");
  }
  void check() const {
    Vec2 where;
    if (Curve::through(points, closed).crosses_itself(where))
      throw std::invalid_argument("the curve crosses itself near " + std::to_string(where.x) + " " +
                                  std::to_string(where.y) +
                                  " m, where a point could leave on either branch; end it before, or part it in two");
  }

  void initialise_from_pose(const BodyState& /*a*/, const BodyState& /*b*/, double /*t*/) {
    curve = std::make_shared<const Curve>(Curve::through(points, closed));
  }
  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    const RelativePoint p(a, {0, 0}, b, p_b);
    const Curve::Nearest c = curve->nearest(p.w);
    const double slide = dot(c.tangent, p.rate);
    out[0] = p.row(c.distance, c.normal, c.bend() * slide * slide);
  }
};

}  // namespace subsoil::mbd
