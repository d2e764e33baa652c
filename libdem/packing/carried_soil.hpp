#pragma once
#include <cstddef>

#include "libdem/base/archive.hpp"
#include "libdem/particles/clump.hpp"
#include "libdem/particles/particles.hpp"

namespace subsoil::dem {

/// What came into a bed, or left it, on the way: of spheres when they begin or cease to move freely.
struct CarriedSoil {
  std::size_t spheres = 0;                      ///< of inlets a clump counts once
  double mass = 0;                              ///< kg
  Vec3 momentum;                                ///< N s
  double kinetic = 0, gravity = 0, stored = 0;  /// J
  double energy() const { return kinetic + gravity + stored; }
  void add(const Sphere& sphere, const Vec3& acceleration);  ///< gravity's
  void add(const Clump& clump, const ClumpShape& shape, const Vec3& acceleration);
  void add(const CarriedSoil& more);
  void archive(Archive& a) {
    a("spheres", spheres)("mass", mass)("momentum", momentum)("kinetic", kinetic)("gravity", gravity)("stored", stored);
  }
};

}  // namespace subsoil::dem
