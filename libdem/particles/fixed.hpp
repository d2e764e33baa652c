#pragma once
#include <cmath>
#include <cstdint>

#include "libdem/particles/particles.hpp"

namespace subsoil::dem {

/// A fixed sphere keeps velocity and angular velocity whatever acts on it: its kind states it, its mass is that of its
/// matter.
inline bool is_fixed(const Sphere& s) { return s.kind == SphereKind::fixed; }
/// The sphere that keeps its linear and angular velocity.
inline SphereSpec fixed(SphereSpec s) {
  s.kind = SphereKind::fixed;
  return s;
}

/// What acts on a fixed sphere at t_n: contacts alone.
struct FixedSphere {
  std::uint32_t id = 0;
  Vec3 position, velocity, angular_velocity;  ///< m, m/s, rad/s
  Vec3 force, torque;                         ///< N, N m, about the centre
};

}  // namespace subsoil::dem
