#pragma once

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "libmbd/base/coordinate.hpp"
#include "libmbd/element/constraint.hpp"

namespace subsoil::mbd {

/// Coupler: a coordinate of one body follows a coordinate of another, as through a screw, a rope over pulleys or a
/// linkage that is not drawn.
///   Phi = q_a - ratio q_b - offset = 0                                    (m, or rad where q_a is an angle)
/// q: x, y or angle of a body in the world; ratio in the unit of q_a over that of q_b, not 0: of a screw its lead over
/// 2 pi; offset is Phi of the start pose. Angles count over full turns. Reaction: generalised forces -lambda on q_a and
/// lambda ratio on q_b at the centres of gravity, so that the power of both is 0; what guides the bodies bears the
/// rest. Source: the coupler of multibody programs; Haug 1989, 3.2 (absolute coordinates).
struct Coupler {
  static constexpr ConstraintMembers has{.check = true, .initialise_from_pose = true, .reaction_point = true};
  static constexpr std::size_t rows = 1;
  std::array<bool, rows> angular{false};  ///< whether q_a is an angle, as describe() or check() finds it
  int body_a = -1, body_b = -1;
  Coordinate coordinate_a = Coordinate::x, coordinate_b = Coordinate::x;
  double ratio = std::numeric_limits<double>::quiet_NaN();
  double offset = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    v.card("coupler",
           "a coordinate of one body follows that of another, as through a screw or ropes that are not drawn");
    v.coordinate("coupler", body_a, coordinate_a, "the coordinate that follows: body.x, body.y or body.angle");
    v.coordinate("follows", body_b, coordinate_b, "the coordinate that it follows, of another body");
    v.quantity("ratio", ratio, unit(), "(-inf, inf)", "change of the first over change of the second, not 0");
    angular[0] = coordinate_a == Coordinate::angle;
  }
  void check() const {
    if (!std::isfinite(ratio) || ratio == 0)
      throw std::invalid_argument("ratio must be given and not 0; to hold a coordinate use a coordinate driver");
  }

  void initialise_from_pose(const BodyState& a, const BodyState& b, double /*t*/) {
    if (std::isnan(offset)) offset = value(a, coordinate_a) - ratio * value(b, coordinate_b);
  }
  void evaluate(const BodyState& a, const BodyState& b, double /*t*/, ConstraintRows<rows>& out) const {
    out[0] = {value(a, coordinate_a) - ratio * value(b, coordinate_b) - offset, {}, {}, 0, 0};
    out[0].on_a[static_cast<std::size_t>(coordinate_a)] = 1;
    out[0].on_b[static_cast<std::size_t>(coordinate_b)] = -ratio;
  }
  Vec2 reaction_point(const BodyState& a, const BodyState&) const { return a.r; }

 private:
  const char* unit() const {
    const bool a = coordinate_a == Coordinate::angle, b = coordinate_b == Coordinate::angle;
    return a == b ? "1" : a ? "rad/m" : "m/rad";
  }
  static double value(const BodyState& b, Coordinate c) {
    return c == Coordinate::x ? b.r.x : c == Coordinate::y ? b.r.y : b.angle;
  }
};

}  // namespace subsoil::mbd
