#pragma once
#include <cmath>
#include <cstdint>

#include "libdem/particles/particles.hpp"

namespace subsoil::dem {

/// A fixed sphere keeps its velocity and angular velocity whatever acts on it. Its record holds 2^90 times its mass, so
/// that every law finds the limit of a pair with a body that does not yield,
///   m_eff = m M/(m + M) -> m of the free sphere
/// to m/M <= 1e-21 for a free sphere up to a million times as heavy, which is how LAMMPS (fix freeze) has it; r_eff is
/// that of both. No density of matter comes near the bound by which such records are known.
constexpr int kFixedPower = 90;
constexpr double kFixedDensity = 1e28;  // kg/m3; 2^90 times water has 1e30, and its mass fits in single precision

inline bool is_fixed(const Sphere& s) { return s.m > kFixedDensity * sphere_volume(s.r); }
/// Density of its matter, kg/m3.
inline double own_density(const Sphere& s) { return is_fixed(s) ? std::ldexp(density(s), -kFixedPower) : density(s); }
/// The sphere that keeps its linear and angular velocity.
inline SphereSpec fixed(SphereSpec s) {
  s.density = std::ldexp(s.density, kFixedPower);
  return s;
}

/// What acts on a fixed sphere at t_n: contacts alone.
struct FixedSphere {
  std::uint32_t id = 0;
  Vec3 position, velocity, angular_velocity;  ///< m, m/s, rad/s
  Vec3 force, torque;                         ///< N, N m, about the centre
};

}  // namespace subsoil::dem
