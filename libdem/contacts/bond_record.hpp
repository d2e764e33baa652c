#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "libdem/base/vec3.hpp"

namespace subsoil::dem {

/// A bond between two spheres that broke.
struct BrokenBond {
  double time = 0;                     ///< s, of the step whose forces broke it
  std::array<std::uint32_t, 2> ids{};  ///< of the spheres, the lower first
  Vec3 position;                       ///< middle between the surfaces, m, at the end of that step
  double energy = 0;                   ///< J that it stored
  bool in_tension = true;              ///< or in shear, or
  bool by_edge = false;                ///< cut
};

/// Bonds since the start.
struct BondCount {
  std::size_t formed = 0, broken_in_tension = 0, broken_in_shear = 0;
  std::size_t cut = 0;      ///< by edges
  std::size_t removed = 0;  ///< with a sphere that left the bed
  std::size_t broken() const { return broken_in_tension + broken_in_shear + cut; }
  std::size_t intact() const { return formed - broken() - removed; }
};

}  // namespace subsoil::dem
