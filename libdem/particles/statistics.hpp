#pragma once
#include <span>
#include <vector>

#include "libdem/geometry/bounds.hpp"
#include "libdem/particles/particles.hpp"

namespace subsoil::dem {

/// What a rebuild asks of all spheres, from one pass; the same on any number of threads.
struct ParticleStatistics {
  Bounds box;                                  ///< of the centres
  double smallest = 0, largest = 0, mean = 1;  ///< radius, m
  std::vector<char> present;                   ///< by material: none, 1, or 2 for more
  bool all_free = true;                        ///< none is fixed or in a clump
};

/// Throws BedFault, at `time`, if a position is not finite.
ParticleStatistics particle_statistics(std::span<const Sphere> spheres, int materials, int threads, double time);

/// Kinetic energy of translation and rotation of one sphere, of its half-step velocities, J.
inline double kinetic_energy_of(const Sphere& s) {
  return 0.5 * s.m * dot(s.v, s.v) + 0.5 * inertia(s) * dot(s.w, s.w);
}

}  // namespace subsoil::dem
