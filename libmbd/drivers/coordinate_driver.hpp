#pragma once

#include "libmbd/base/coordinate.hpp"
#include "libmbd/drivers/motion.hpp"
#include "libmbd/element/constraint.hpp"

namespace subsoil::mbd {

/// Driver on a coordinate of a body:  Phi = q_i - f(t) = 0,  Phi_t = -f',  gamma = f''.
/// q_i: x or y of the centre of gravity (m) or the angle (rad); f: see Motion. The driver puts the force -lambda along
/// the coordinate on the body (N or N m): for the trolley of a towed rig that is the pull; its power is -lambda f'.
/// Source: Haug 1989, 3.5; H10 of the subsoiler model is this driver with f = x5(0) + v t.
struct CoordinateDriver {
  static constexpr ConstraintMembers has{.check = true, .initialise_from_pose = true};
  static constexpr std::size_t rows = 1;
  int body = -1;
  Coordinate coordinate = Coordinate::x;
  Motion motion{};

  bool angular() const { return coordinate == Coordinate::angle; }
  int body_a() const { return ground; }
  int body_b() const { return body; }

  template <class V>
  void describe(V& v) {
    v.card("coordinate", "moves one coordinate of a body in the world as a function of time");
    v.coordinate("coordinate", body, coordinate, "the driven coordinate: body.x, body.y or body.angle");
    motion.describe(v, angular() ? "rad" : "m", "the coordinate");
  }
  void check() const { motion.check(); }

  /// What is driven: the coordinate.
  double value(const BodyState&, const BodyState& b) const {
    return coordinate == Coordinate::x ? b.r.x : coordinate == Coordinate::y ? b.r.y : b.angle;
  }
  void initialise_from_pose(const BodyState& a, const BodyState& b, double t) {
    const double rate = coordinate == Coordinate::x ? b.v.x : coordinate == Coordinate::y ? b.v.y : b.omega;
    motion.initialise_from_pose(value(a, b), rate, t);
  }

  void evaluate(const BodyState& a, const BodyState& b, double t, ConstraintRows<rows>& out) const {
    out[0] = {value(a, b) - motion.value(t), {}, {}, motion.second(t), -motion.rate(t)};
    out[0].on_b[static_cast<std::size_t>(coordinate)] = 1;
  }
};

}  // namespace subsoil::mbd
