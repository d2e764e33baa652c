#pragma once

#include "libmbd/drivers/motion.hpp"
#include "libmbd/element/relative_point.hpp"

namespace subsoil::mbd {

/// Driver on the distance of two points (a cylinder or actuator with a pin at either end):
///   Phi = |w| - f(t) = 0,  Phi_t = -f'                                          (m)
///   gamma = f'' - (|w'|^2 - |w|'^2) / |w| - w . bend / |w|
/// w: p_b seen from p_a [m]. The force -lambda drives the points apart (N); power -lambda f'. At |w| = 0 the actuator
/// has no direction and the run ends. Source: Haug 1989, 3.5 (distance driver).
struct DistanceDriver {
  static constexpr ConstraintMembers has{.check = true, .initialise_from_pose = true, .points = true};
  static constexpr std::size_t rows = 1;
  int first = -1, second = -1;
  std::array<double, 2> p_a{0, 0}, p_b{0, 0};
  Motion motion{};

  bool angular() const { return false; }
  int body_a() const { return first; }
  int body_b() const { return second; }

  template <class V>
  void describe(V& v) {
    v.card("distance", "drives the distance of two points as a function of time, as a cylinder with a pin at each end");
    v.bodies("distance", first, second, "the two bodies that it joins; a positive force drives them apart");
    v.end_points(first, p_a, second, p_b, "its two ends");
    motion.describe(v, "m", "the distance");
  }
  void check() const { motion.check(); }

  void initialise_from_pose(const BodyState& a, const BodyState& b, double t) {
    const RelativePoint p(a, p_a, b, p_b);
    const double length = mbd::length(p.w);
    if (length == 0)
      throw std::invalid_argument(
          "its two ends lie on each other in the start pose, so it has no direction; start them apart");
    motion.initialise_from_pose(length, dot(p.w, p.rate) / length, t);
  }

  void evaluate(const BodyState& a, const BodyState& b, double t, ConstraintRows<rows>& out) const {
    const RelativePoint p(a, p_a, b, p_b);
    const double length = mbd::length(p.w);
    if (length == 0)
      throw std::runtime_error("a distance driver has no direction at t = " + std::to_string(t) +
                               " s: its two ends lie on each other");
    const Vec2 u = (1 / length) * p.w;
    const double across = cross(u, p.rate);
    out[0] = p.row(length - motion.value(t), u, across * across / length);
    out[0].gamma += motion.second(t);
    out[0].phi_t = -motion.rate(t);
  }
};

}  // namespace subsoil::mbd
