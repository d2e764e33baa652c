#pragma once
#include "libdem/step/bed_impl.hpp"

namespace subsoil::dem {

/// What a rebuild asks of all spheres, from one pass; the same on any number of threads.
struct ParticleStatistics {
  Bounds box;                                  ///< of the centres
  double smallest = 0, largest = 0, mean = 1;  ///< radius, m
  std::vector<char> present;                   ///< by material
};

/// Throws BedFault, at `time`, if a position is not finite.
ParticleStatistics particle_statistics(const Spheres& spheres, int materials, int threads, double time);

}  // namespace subsoil::dem
