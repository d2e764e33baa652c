#pragma once
#include <string>

#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// What a run stopped by an overlap reports beside the bed's own text (`fault`, which names the sphere): who overlaps,
/// under which law, with what force, and the stiffness or speed that would do. Empty for other faults.
std::string overlap_advice(const dem::BedFault& fault, const World& world, const Scenario& scenario);

/// How deep tools may press single spheres, stated before the run.
///
/// The mean pressure on a tool is taken from the weight of the soil, its depth, its speed and a friction angle of 35
/// deg:
///     drawn along:  p = rho g h K_p (1/2 + h/w) + rho v^2,  K_p = tan^2(45 deg + phi/2)
///                   (Rankine's wedge, as wide as the tool and once its depth at either side)
///     pushed down:  p = rho g (33 h + 0.3 * 48 w) + rho v^2  (bearing capacity; N_q = 33, N_gamma = 48)
/// h its depth and w its width, a radius and a diameter more each, since whole spheres are moved. A single sphere bears
/// ten times its share p (2 r)^2: contact forces in a packing have an exponential tail. Or it is struck at v, and the
/// contact takes m v^2/2. The greater overlap counts. Against measured runs (docs/reference/command-line.md) good to a
/// factor of five.
struct ExpectedOverlap {
  std::string tool;
  double share = 0;  ///< of a radius
  double force = 0;  ///< N
  std::string
      stiffness;  ///< what would halve the limit: `k_n of contacts.soil-steel at least 120 kN/m; step 0.6 times`
};
/// Of the tool that is worst; empty name: none moves in soil as far as is known before a run.
ExpectedOverlap expected_overlap(const World& world, const Scenario& scenario);
std::string overlap_text(const ExpectedOverlap& expected, double limit);

}  // namespace subsoil::sim
