#pragma once
#include <algorithm>
#include <cmath>

#include "libdem/base/vec3.hpp"

namespace subsoil::dem {

/// Angular velocity, rad/s, world axes, of a body with angular momentum L, N m s, world axes, and principal moments J,
/// kg m2: w = R J^-1 R^T L.
inline Vec3 angular_velocity_of(const Quaternion& attitude, const Vec3& inertia, const Vec3& momentum) {
  const Vec3 l = attitude.conjugate().rotate(momentum);
  return attitude.rotate({l.x / inertia.x, l.y / inertia.y, l.z / inertia.z});
}
/// And back: L = R J R^T w.
inline Vec3 angular_momentum_of(const Quaternion& attitude, const Vec3& inertia, const Vec3& angular_velocity) {
  const Vec3 w = attitude.conjugate().rotate(angular_velocity);
  return attitude.rotate({w.x * inertia.x, w.y * inertia.y, w.z * inertia.z});
}

struct RotationStep {
  Vec3 angular_velocity;  ///< at the middle of the step, rad/s, world axes
  Quaternion attitude;    ///< at its end
};

/// Rotation over a step dt, s, in which the angular momentum L stays as it is in the world:
///     q_{n+1} = q_n c(dt w), w = R_m J^-1 R_m^T L, R_m the attitude half way,
/// c(a) the rotation by 2 atan(|a|/2) about a (Cayley). So a point at the arm r moves by dt w x (r_n + r_{n+1})/2,
/// exactly. w in body axes is that at the middle and at both ends. It is found by iteration from the second order; each
/// iterate has at most dt |L|/(2 J_min) of the error of the one before, so that the last need not be seen to stand
/// still. Second order, symmetric in time; L is kept by construction, the energy to second order without drift. A
/// sphere gets w = L/J. This is the implicit mid-step form of Svanberg (1997), J. Chem. Phys. 107, 5402, with the exact
/// rotation replaced by Cayley's.
inline RotationStep rotate_freely(const Quaternion& attitude, const Vec3& inertia, const Vec3& momentum, double dt) {
  const Vec3 l = attitude.conjugate().rotate(momentum), by{1 / inertia.x, 1 / inertia.y, 1 / inertia.z};
  const auto divided = [&](const Vec3& v) { return Vec3{v.x * by.x, v.y * by.y, v.z * by.z}; };
  Vec3 w = divided(l);
  const double half = 0.5 * dt;
  if (!(inertia.x == inertia.y && inertia.y == inertia.z)) {
    constexpr int most = 50;
    constexpr double rounding2 = 1e-31;
    const double most_by = std::max({by.x, by.y, by.z});
    const double shrinks2 = std::min(1.0, half * half * most_by * most_by * dot(l, l));
    w = divided(l + half * cross(l, w));
    for (int k = 0; k < most; ++k) {
      // (1, a) is the whole rotation but for its length n; half of it is (1 + n, a), or (1, b).
      const Vec3 a = half * w;
      const Vec3 b = (1 / (1 + std::sqrt(1 + dot(a, a)))) * a, t = cross(l, b);
      const Vec3 next = divided(l + (2 / (1 + dot(b, b))) * (t + cross(t, b)));
      const Vec3 off = next - w;
      w = next;
      if (shrinks2 * dot(off, off) <= rounding2 * dot(w, w)) break;
    }
  }
  const Vec3 a = half * w;
  return {attitude.rotate(w), (attitude * Quaternion{1, a.x, a.y, a.z}).normalized()};
}

}  // namespace subsoil::dem
