#pragma once

#include "libmbd/drivers/motion.hpp"
#include "libmbd/element/constraint.hpp"

namespace subsoil::mbd {

/// Driver along a slide (a cylinder between two bodies that a translational joint guides):
///   Phi = e . d - f(t) = 0,  d = (r_b + A_b p_b) - (r_a + A_a p_a),  Phi_t = -f'             (m)
///   gamma = f'' - 2 spin_a n.d' + spin_a^2 e.d + e.(spin_b^2 A_b p_b - spin_a^2 A_a p_a)
/// e: unit vector at angle_a [rad] from body a's x axis, n = k x e. The force on b along e is -lambda (N), its opposite
/// acts on a at the same point; power -lambda f'. Source: Haug 1989, 3.5, along a fixed line of body a.
struct SlideDriver {
  static constexpr ConstraintMembers has{.check = true, .initialise_from_pose = true, .points = true};
  static constexpr std::size_t rows = 1;
  int first = -1, second = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  double angle_a = 0;
  Motion motion{};

  bool angular() const { return false; }
  int body_a() const { return first; }
  int body_b() const { return second; }

  template <class V>
  void describe(V& v) {
    v.card("slide", "moves a body along a line of another as a function of time, as a cylinder in their slide");
    v.bodies("slide", first, second,
             "the second body is moved along a line of the first; the force is reported on the second");
    v.joint_point(first, p_a, second, p_b, "the point from and to which the distance along the line counts");
    v.axis("along", first, angle_a, "direction of the line in the start pose");
    motion.describe(v, "m", "the distance along the line");
  }
  void check() const { motion.check(); }

  double value(const BodyState& a, const BodyState& b) const { return dot(direction(a), span(a, b)); }
  void initialise_from_pose(const BodyState& a, const BodyState& b, double t) {
    const Vec2 d_rate = b.velocity_at(b.vector_in_world(p_b)) - a.velocity_at(a.vector_in_world(p_a));
    const double rate = dot(direction(a), d_rate) + a.omega * dot(turned(direction(a)), span(a, b));
    motion.initialise_from_pose(value(a, b), rate, t);
  }

  void evaluate(const BodyState& a, const BodyState& b, double t, ConstraintRows<rows>& out) const {
    const Vec2 arm_a = a.vector_in_world(p_a), arm_b = b.vector_in_world(p_b), e = direction(a), n = turned(e),
               d = span(a, b);
    const Vec2 d_rate = b.velocity_at(arm_b) - a.velocity_at(arm_a);
    const double gamma = motion.second(t) - 2 * a.omega * dot(n, d_rate) + a.omega * a.omega * dot(e, d) +
                         dot(e, b.omega * b.omega * arm_b - a.omega * a.omega * arm_a);
    out[0] = {dot(e, d) - motion.value(t),
              {-e.x, -e.y, dot(n, d) - dot(e, turned(arm_a))},
              {e.x, e.y, dot(e, turned(arm_b))},
              gamma,
              -motion.rate(t)};
  }

 private:
  Vec2 direction(const BodyState& a) const { return {std::cos(a.angle + angle_a), std::sin(a.angle + angle_a)}; }
  Vec2 span(const BodyState& a, const BodyState& b) const {
    return b.point_in_world(p_b) - a.r - a.vector_in_world(p_a);
  }
};

}  // namespace subsoil::mbd
