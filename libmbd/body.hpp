#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace subsoil::mbd {

/// Body 0 of every system is the ground: fixed, with its axes on the world's.
inline constexpr int ground = 0;

/// A vector of the machine's plane: x along travel, y up (m, m/s, N ...).
struct Vec2 {
  double x = 0, y = 0;
};
inline Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
inline Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
inline Vec2 operator*(double k, Vec2 a) { return {k * a.x, k * a.y}; }
inline double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
/// z component of a x b: the moment of a force b at the lever a.
inline double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
/// k x a, a quarter turn counter-clockwise: velocity of the tip of a at unit spin.
inline Vec2 turned(Vec2 a) { return {-a.y, a.x}; }
inline double length(Vec2 a) { return std::sqrt(dot(a, a)); }

/// A rigid planar body.
///   pose      (x, y) of the centre of gravity in the world [m], angle counter-clockwise about +z [rad]
///   velocity  (x', y', angle') in the world [m/s, m/s, rad/s]; made consistent with the joints at the start
/// Joint points and shapes are given in body axes: origin in the centre of gravity, x along the world's at angle 0.
struct Body {
  std::string name;
  double mass = std::numeric_limits<double>::quiet_NaN();     ///< kg, > 0
  double inertia = std::numeric_limits<double>::quiet_NaN();  ///< about the centre of gravity, kg m^2, > 0
  std::array<double, 3> pose{0, 0, 0};
  std::array<double, 3> velocity{0, 0, 0};
};

/// Where a body is and how it moves, with the sine and cosine that every joint needs.
struct BodyState {
  Vec2 r;            ///< centre of gravity, world (m)
  double angle = 0;  ///< rad
  Vec2 v;            ///< m/s
  double spin = 0;   ///< rad/s
  double c = 1, s = 0;

  BodyState() = default;
  BodyState(Vec2 position, double turn, Vec2 velocity, double spin_rate)
      : r(position), angle(turn), v(velocity), spin(spin_rate), c(std::cos(turn)), s(std::sin(turn)) {}

  /// A vector of body axes in world axes.
  Vec2 world(const std::array<double, 2>& p) const { return {c * p[0] - s * p[1], s * p[0] + c * p[1]}; }
  /// A world point in body axes.
  std::array<double, 2> local(Vec2 p) const {
    const Vec2 d = p - r;
    return {c * d.x + s * d.y, c * d.y - s * d.x};
  }
  /// Velocity of the material point at world lever `arm` from the centre of gravity.
  Vec2 velocity_at(Vec2 arm) const { return v + spin * turned(arm); }
};

}  // namespace subsoil::mbd
