#pragma once

// What forces between two points of two bodies share: who the bodies are, the line between the points, and equal and
// opposite forces that act in one place, so that the pair neither pushes nor turns the two bodies together.

#include "libmbd/element/force.hpp"

namespace subsoil::mbd {

inline const BodyState& body_of(const Scene& scene, int body) { return scene.bodies[static_cast<std::size_t>(body)]; }

/// The line from a point of body a to a point of body b: moment arms in world axes, unit vector, length and its rate
/// (m, m/s). At length 0 there is no direction and `e` is zero.
struct LineOfAction {
  Vec2 arm_a, arm_b, e;
  double length = 0, rate = 0;

  LineOfAction(const BodyState& a, const std::array<double, 2>& p_a, const BodyState& b,
               const std::array<double, 2>& p_b)
      : arm_a(a.vector_in_world(p_a)), arm_b(b.vector_in_world(p_b)) {
    const Vec2 d = b.r + arm_b - a.r - arm_a;
    length = mbd::length(d);
    e = length > 0 ? (1 / length) * d : Vec2{};
    rate = dot(e, b.velocity_at(arm_b) - a.velocity_at(arm_a));
  }
};

/// Force `f` on body b and its opposite on body a, both on the material points that are at the world point `at` now.
inline void add_pair(Loads& loads, const Scene& scene, int body_a, int body_b, Vec2 at, Vec2 f) {
  loads.add(body_b, at - body_of(scene, body_b).r, f);
  loads.add(body_a, at - body_of(scene, body_a).r, -1.0 * f);
}

/// Velocity of b's material point at the world point `at` against a's material point there (m/s): the velocity that an
/// observer on body a sees.
inline Vec2 velocity_against(const Scene& scene, int body_a, int body_b, Vec2 at) {
  const BodyState &a = body_of(scene, body_a), &b = body_of(scene, body_b);
  return b.velocity_at(at - b.r) - a.velocity_at(at - a.r);
}

/// Bound on the speed at which b's points within `reach` of its origin move against a (m/s).
inline double speed_against(const Scene& scene, int body_a, int body_b, double reach) {
  const BodyState &a = body_of(scene, body_a), &b = body_of(scene, body_b);
  return length(velocity_against(scene, body_a, body_b, b.r)) + std::abs(b.omega - a.omega) * reach;
}

}  // namespace subsoil::mbd
