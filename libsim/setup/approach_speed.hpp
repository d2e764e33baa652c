#pragma once
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// Speed at which bodies may meet, m/s: what a nonlinear law's stiffness and the resolution of contacts are judged at.
/// The maximum of twice the fastest sphere's, that plus the fastest surface's (moves of boundaries with rotation,
/// the machine as it starts, its drivers, sampled over the run), a fall through the container, and 0.1 m/s.
double expected_speed(const Scenario& scenario, const World& world);

}  // namespace subsoil::sim
