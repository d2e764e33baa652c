#pragma once

#include "libmbd/drivers/motion.hpp"
#include "libmbd/element/constraint.hpp"

namespace subsoil::mbd {

/// Driver on the angle between two bodies (a motor in a revolute joint):
///   Phi = angle_b - angle_a - f(t) = 0,  Phi_t = -f',  gamma = f''                 (rad)
/// The torque on b is -lambda (N m), its opposite acts on a; power -lambda f'. Source: Haug 1989, 3.5.
struct AngleDriver {
  static constexpr ConstraintMembers has{.check = true, .initialise_from_pose = true};
  static constexpr std::size_t rows = 1;
  int first = -1, second = -1;
  Motion motion{};

  bool angular() const { return true; }
  int body_a() const { return first; }
  int body_b() const { return second; }

  template <class V>
  void describe(V& v) {
    v.card("angle", "turns a body against another as a function of time, as a motor in their pin");
    v.bodies("angle", first, second,
             "the angle of the second body against the first; the torque is reported on the second");
    motion.describe(v, "rad", "the angle");
  }
  void check() const { motion.check(); }

  double value(const BodyState& a, const BodyState& b) const { return b.angle - a.angle; }
  void initialise_from_pose(const BodyState& a, const BodyState& b, double t) {
    motion.initialise_from_pose(value(a, b), b.omega - a.omega, t);
  }

  void evaluate(const BodyState& a, const BodyState& b, double t, ConstraintRows<rows>& out) const {
    out[0] = {value(a, b) - motion.value(t), {0, 0, -1}, {0, 0, 1}, motion.second(t), -motion.rate(t)};
  }
};

}  // namespace subsoil::mbd
