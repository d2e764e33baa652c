#pragma once
#include "libdem/geometry/boundary.hpp"

/// A sphere at a surface in the middle of the step that ended: velocities of spheres and surfaces are those of
/// t_n - dt/2 (leapfrog), and so is the geometry that they are put into. The normal, the arm to the contact point and
/// the distance of t_n in their place leave slips of first order in dt: a sphere that rides on a turning surface creeps
/// inward, one that rotates about the normal of a curved one is driven aside.
namespace subsoil::dem {

/// n less the normal of the middle of the step. @param before normal at the step before, shape axes; null of a contact
/// that begins: then as on a flat face, an error of one step's slip in second order
inline Vec3 normal_turn(const Boundary& b, const Vec3& normal, const Vec3* before, double dt) {
  const Vec3 n = b.pose.attitude.rotate(normal);
  Vec3 turn = (0.5 * dt) * cross(b.angular_velocity, n);
  if (before == nullptr) return turn;
  turn += 0.5 * b.pose.attitude.rotate(normal - *before);
  return turn - dot(turn, n) * n;
}

/// Velocity of the surface's point under a sphere, m/s, world axes: v_B + Omega x (x_m - d_m n_m - x_Bm), with
///     x_m - x_Bm = x - x_B - (dt/2)(v - v_B),   d_m = d - (dt/2) v_n,   n_m = n - turn
/// @param x,v of the sphere; n, d normal and distance now
inline Vec3 surface_velocity(const Boundary& b, const Vec3& x, const Vec3& v, const Vec3& n, double d, const Vec3& turn,
                             double dt) {
  const Vec3 relative = v - b.velocity, arm = x - d * n - b.pose.position;
  const double v_n = dot(relative - cross(b.angular_velocity, arm), n);
  return b.velocity + cross(b.angular_velocity, arm - (0.5 * dt) * (relative - v_n * n) + d * turn);
}

/// A velocity of the middle of the step, turned to its end as the normal is: Q of contact_core.hpp.
inline Vec3 turned(const Vec3& v, const Vec3& n, const Vec3& turn) { return v + dot(v, n) * turn - dot(v, turn) * n; }

/// Of a sphere against a surface at the contact, m/s. @param v of its centre against the surface's point
inline Vec3 contact_velocity(const Vec3& v, const Vec3& w, const Vec3& n, double d, const Vec3& turn, double dt) {
  const double middle = d - 0.5 * dt * dot(v, n);
  return turned(v - middle * cross(w, n - turn), n, turn);
}

}  // namespace subsoil::dem
