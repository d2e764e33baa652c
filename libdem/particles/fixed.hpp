#pragma once
#include <cmath>
#include <cstdint>

#include "libdem/particles/particles.hpp"

namespace subsoil::dem {

/// A fixed sphere keeps velocity and angular velocity whatever acts on it: its kind states it. The mass in its record
/// is kFixedScale times its own, so that every law finds the limit of a pair with a body that does not yield,
///   m_eff = m M/(m + M) -> m of the free sphere
/// to m/M <= 1e-21 for a free sphere up to a million times as heavy, as in LAMMPS (`fix freeze`); r_eff is
/// that of both. A power of two: the own mass comes back to the bit, and 2^90 kg fits in single precision.
constexpr double kFixedScale = 0x1p90;

inline bool is_fixed(const Sphere& s) { return s.kind == SphereKind::fixed; }
/// Mass of its matter, kg; of a clump's member that of the clump.
inline double own_mass(const Sphere& s) { return is_fixed(s) ? s.m / kFixedScale : s.m; }
/// Density of its matter, kg/m3.
inline double own_density(const Sphere& s) { return own_mass(s) / sphere_volume(s.r); }
/// The sphere that keeps its linear and angular velocity.
inline SphereSpec fixed(SphereSpec s) {
  s.kind = SphereKind::fixed;
  return s;
}
/// Changes the kind of a record, and the mass in it.
inline void set_kind(Sphere& s, SphereKind kind) {
  s.m = kind == SphereKind::fixed ? kFixedScale * own_mass(s) : own_mass(s);
  s.kind = kind;
}

/// What acts on a fixed sphere at t_n: contacts alone.
struct FixedSphere {
  std::uint32_t id = 0;
  Vec3 position, velocity, angular_velocity;  ///< m, m/s, rad/s
  Vec3 force, torque;                         ///< N, N m, about the centre
};

}  // namespace subsoil::dem
