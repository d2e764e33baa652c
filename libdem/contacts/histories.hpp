#pragma once
#include <cstdint>
#include <vector>

#include "libdem/base/vec3.hpp"
#include "libdem/contacts/contact_memory.hpp"

namespace subsoil::dem {

/// Contact history outside the blocks: between two lists by index of the spheres, in a saved state by their ids.
struct PairHistory {
  std::uint32_t i = 0, j = 0;
  PairState state;
};
struct BondHistory {
  std::uint32_t i = 0, j = 0;
  BondMemory<double> state;
};
/// Of a sphere at a boundary.
struct SurfaceHistory {
  std::uint32_t sphere = 0, boundary = 0;
  Vec3 normal;  ///< shape axes
  PairState state;
};

}  // namespace subsoil::dem
