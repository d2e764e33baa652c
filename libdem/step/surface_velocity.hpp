#pragma once
#include "libdem/geometry/boundary.hpp"

namespace subsoil::dem {

/// Velocity of a surface's point under a sphere in the middle of the step that ended, m/s, world axes:
///     v_B + Omega x (p - x_B - (dt/2)(v_i - v_B)),
/// p the point now. Velocities of spheres and surfaces are those of t_n - dt/2 (leapfrog); the arm of t_n with them
/// would leave a slip of Omega v dt/2 in the contact of a sphere that rides on a turning surface, which then creeps
/// inward.
inline Vec3 surface_velocity(const Boundary& b, const Vec3& point, const Vec3& sphere_velocity, double dt) {
  return b.velocity + cross(b.angular_velocity, point - b.pose.position - (0.5 * dt) * (sphere_velocity - b.velocity));
}

}  // namespace subsoil::dem
