#pragma once
// Small beds for the tests of the bed makers.
#include <array>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/laws/wet.hpp"
#include "libdem/packing/placement.hpp"
#include "libdem/packing/settle.hpp"

namespace subsoil::dem::test {

inline constexpr double density = 1800;  // kg/m3
inline constexpr BedMaterial soil_material{.density = density, .material = 0};

/// Table 3 of the source between particles (material 0) and at walls (material 1), in N/m.
inline LawTable table_3() {
  Wet pair{
      .K_X = 10e3, .C_X = 20, .K_Y = 8e3, .C_Y = 20, .K_B = 7e3, .dc = 2e-3, .dB = 2e-3, .bond = {}, .friction = {}};
  pair.friction.mu = 0.5, pair.friction.mu_r = 0.3;
  Wet wall{
      .K_X = 16e3, .C_X = 20, .K_Y = 12e3, .C_Y = 20, .K_B = 3e3, .dc = 2e-3, .dB = 2e-3, .bond = {}, .friction = {}};
  wall.friction.mu = 0.5, wall.friction.mu_r = 0.3;
  return {.materials = 2, .index = {0, 1, 1, -1}, .laws = {pair, wall}};
}

/// A softer wet soil for beds that must settle within a second of processor time: stable far beyond 0.1 ms (translation
/// 2 Z (K_X/3 + 2 K_Y/3)/m = 1e7 1/s2, damping 8e3 1/s: 0.2 ms). Attraction K_C dc = 1.5 N is 20 times a sphere's
/// weight.
inline constexpr double soft_step = 1e-4;
inline LawTable soft_wet() {
  Wet law{.K_X = 4e3, .C_X = 2, .K_Y = 3e3, .C_Y = 2, .K_B = 1.5e3, .dc = 1e-3, .dB = 1e-3, .bond = {}, .friction = {}};
  law.friction.mu = 0.5, law.friction.mu_r = 0.2;
  return {.materials = 2, .index = {0, 0, 0, -1}, .laws = {law}};
}

/// Bed in a box open at the top.
inline Bed boxed_bed(const LawTable& laws, const Bounds& box, int threads = 1) {
  BedOptions options;
  options.threads = threads;
  Bed bed(laws, options);
  const std::array<Plane, 5> walls{Plane(box.low, {0, 1, 0}), Plane(box.low, {1, 0, 0}), Plane(box.high, {-1, 0, 0}),
                                   Plane(box.low, {0, 0, 1}), Plane(box.high, {0, 0, -1})};
  for (const Plane& wall : walls) {
    Boundary b;
    b.name = "wall";
    b.shape = wall;
    b.material = 1;
    bed.add(b);
  }
  return bed;
}

/// The engine's record of spheres that no engine has seen.
inline std::vector<Sphere> as_spheres(const std::vector<SphereSpec>& specs) {
  std::vector<Sphere> out;
  for (const SphereSpec& s : specs)
    out.push_back({s.position, s.radius, s.velocity, s.density * sphere_volume(s.radius), s.angular_velocity,
                   static_cast<std::uint32_t>(out.size()), static_cast<std::uint16_t>(s.material), s.kind, 0});
  return out;
}

}  // namespace subsoil::dem::test
