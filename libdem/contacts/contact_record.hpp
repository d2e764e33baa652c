#pragma once
#include <cstdint>

#include "libdem/base/vec3.hpp"

namespace subsoil::dem {

/// One contact that carries a force at t_n, as results show it: a link of a force chain.
struct ContactRecord {
  std::uint32_t i = 0;  ///< id of the sphere
  std::uint32_t j = 0;  ///< id of the other sphere, or the index of the boundary
  bool at_surface = false;
  Vec3 point;         ///< m: between spheres the middle of overlap or gap, at a surface the point on it
  Vec3 normal;        ///< unit, towards i
  Vec3 force;         ///< on i, N
  Vec3 velocity;      ///< of i against j at the contact, m/s, at t_n - dt/2 like the spheres', turned with the normal
  double stored = 0;  ///< J, in springs and attraction
};

}  // namespace subsoil::dem
