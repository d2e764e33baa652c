#pragma once
#include "libdem/bed_impl.hpp"

namespace subsoil::dem {

/// What a rebuild asks of all spheres, from one pass; the same on any number of threads.
struct Census {
  Bounds box;                                  ///< of the centres
  double smallest = 0, largest = 0, mean = 1;  ///< radius, m
  std::vector<char> present;                   ///< by material
};

/// Throws BedFault, at `time`, if a position is not finite.
Census take_census(const Spheres& spheres, int materials, int threads, double time);

}  // namespace subsoil::dem
