#pragma once

/// Two small scenarios that read without a fault; tests change one thing in them.
namespace subsoil::sim {

inline constexpr const char* sample_soil = R"(subsoil: 1
title: till
gravity: 9.81 m/s^2
materials:
  soil: {density: 1800 kg/m^3}
  steel: {density: 7850 kg/m^3}
contacts:
  - {between: [soil, soil], law: wet, values: per-body, K_X: 10 kN/m, C_X: 20 N s/m, K_Y: 8 kN/m, C_Y: 20 N s/m,
     K_B: 7 N/mm, dc: 2 mm, dB: 2 mm, mu: 0.5, mu_r: 0.3}
  - between: [soil, steel]
    law: wet
    values: per-body
    <<: {K_X: 16 kN/m, C_X: 20 N s/m, K_Y: 12 kN/m, C_Y: 20 N s/m, K_B: 3 kN/m, dc: 2 mm, dB: 2 mm}
    mu: 0.5
    mu_r: 0.3
soil:
  container: {size: 0.8 0.3 0.4 m, at: 0 -0.3 -0.2 m, open: [+y], open after settling: [-x], material: steel}
  surface: 0 m
  bed:
    fill: rest-lattice
    material: soil
    radius: 10 mm
    settle: {until: 0.02 m/s}
boundaries:
  - {name: plate, shape: {box: 100 100 10 mm}, at: 0 0.2 0 m, moves: [{velocity: 0.5 0 0 m/s}], material: steel}
time:
  end: 4 s
  soil step: auto
)";

inline constexpr const char* sample_machine = R"(subsoil: 1
title: an arm on a sled
time: {end: 2 s, machine: {integrator: ida}}
materials:
  steel: {density: 7850 kg/m^3}
machine:
  bodies:
    sled: {mass: 100 kg, inertia: 10 kg m^2, at: 0 0.5 m}
    arm: {mass: 10 kg, inertia: 1 kg m^2, at: 1 2 m, angle: 90 deg}
  joints:
    slide: {translational: [ground, sled], along: [1, 0]}
    pin: {revolute: [sled, arm], at: 1 1.5 m}
  drivers:
    pull: {coordinate: sled.x, velocity: 0.5 m/s}
  forces:
    wheel: {wheel on soil: arm, radius: 0.2 m, width: 0.12 m, n: 1.3126, k_c: 1434.81 kN/m^(n+1), k_phi: 165.79 kN/m^(n+2)}
  surfaces:
    blade: {body: arm, material: steel, extrude: [0 0 m, 0.1 0 m, 0 0.2 m], width: 50 mm}
  start: {towing equilibrium: 0.5 m/s}
output:
  monitor: {pull: {driver: pull}, pitch: arm.angle}
)";

}  // namespace subsoil::sim
