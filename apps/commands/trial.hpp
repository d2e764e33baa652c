#pragma once
#include <chrono>

#include "apps/commands/commands.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// What a run will cost, found by steps, rows and frames of the real thing, written beside nobody's files.
struct Trial {
  Estimate cost;
  double spheres = 0;  ///< expected of the run; the bed of the dry run is a proxy where it is poured
  double settling = 0;
  double particle_rate = 0;
};

/// @param spheres expected of the run @param until_now s, that reading and building the scenario took
Trial try_out(const Loaded& loaded, World& world, double spheres, double until_now);

}  // namespace subsoil::sim
