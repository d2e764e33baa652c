#pragma once

namespace subsoil::sim::test {

/// Some 240 spheres in a trench and a box on a given path that starts in them: 20 mm long, 30 mm below the surface. The
/// end that it goes to is open: rows of a lattice that are pushed against a wall press into each other without bound.
inline constexpr const char* trench = R"(subsoil: 1
materials: {soil: {density: 2600 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 40 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.2}
  - {<<: *dry, between: [soil, steel]}
soil:
  container: {size: 0.4 0.1 0.08 m, at: 0 -0.1 -0.04 m, open after settling: [+x], material: steel}
  surface: 0 m
  bed: {fill: rest-lattice, material: soil, radius: 10 mm, depth: 60 mm, inside machine: carve}
boundaries:
  - {name: tool, material: steel, shape: {box: 20 80 20 mm}, at: 60 10 0 mm, moves: [{velocity: 0.4 0 0 m/s}]}
time: {end: 0.8 s}
output: {every: 0.2 s, series every: 1 ms, monitor: {draft: {soil force: tool, along: -1 0}}}
)";

}  // namespace subsoil::sim::test
