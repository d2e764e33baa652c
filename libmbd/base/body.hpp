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
/// z component of a x b: the moment of a force b with the moment arm a.
inline double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
/// k x a, a quarter turn counter-clockwise: velocity of the tip of a at unit angular velocity.
inline Vec2 turned(Vec2 a) { return {-a.y, a.x}; }
inline double length(Vec2 a) { return std::sqrt(dot(a, a)); }

/// What the start pose or velocity of a body is to assembly.
///   given  kept as far as the joints allow; where a machine's start is fixed (MachineOptions::hold_start) a change
///   beyond
///          a small share of the body's size, or of a velocity that is not 0, is refused
///   exact  not changed at all: other bodies move, or the start is refused
///   about  a guess, changed as far as need be
enum class StartMark { given, exact, about };

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
  StartMark pose_is = StartMark::given, velocity_is = StartMark::given;
};

/// Where body B is and how it moves, with the sine and cosine that every joint needs. W: the world, with its origin and
/// axes; B: the body's centre of gravity and its axes. p_WP is the point P from the world's origin in world axes, p_BP
/// the same point from the body's centre of gravity in body axes.
struct BodyState {
  Vec2 r;            ///< p_WB: centre of gravity (m)
  double angle = 0;  ///< of the body's x axis from the world's (rad)
  Vec2 v;            ///< v_WB: velocity of the centre of gravity, world axes (m/s)
  double omega = 0;  ///< angular velocity, counter-clockwise (rad/s)
  double c = 1, s = 0;

  BodyState() = default;
  BodyState(Vec2 p_WB, double angle_WB, Vec2 v_WB, double omega_WB)
      : r(p_WB), angle(angle_WB), v(v_WB), omega(omega_WB), c(std::cos(angle_WB)), s(std::sin(angle_WB)) {}

  /// A vector given in body axes, in world axes: the moment arm of a body point about the centre of gravity.
  Vec2 vector_in_world(const std::array<double, 2>& p_BP) const {
    return {c * p_BP[0] - s * p_BP[1], s * p_BP[0] + c * p_BP[1]};
  }
  /// p_WP of a point given by its p_BP.
  Vec2 point_in_world(const std::array<double, 2>& p_BP) const { return r + vector_in_world(p_BP); }
  /// p_BP of a point given by its p_WP.
  std::array<double, 2> point_in_body(Vec2 p_WP) const {
    const Vec2 d = p_WP - r;
    return {c * d.x + s * d.y, c * d.y - s * d.x};
  }
  /// Velocity of the material point whose moment arm about the centre of gravity is `arm`, world axes.
  Vec2 velocity_at(Vec2 arm) const { return v + omega * turned(arm); }
};

}  // namespace subsoil::mbd
