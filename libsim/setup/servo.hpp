#pragma once
#include "coupling/servo.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

/// The servo of a boundary. Throws ScenarioError with `place` for a pressure on a plane, which has no area, and for a
/// load that is zero throughout and leaves the gain open. A lag that is left out is negative until the step is known.
coupling::Servo servo_of(const ServoSection& section, const dem::Boundary& boundary, const dem::PeriodicCell& cell,
                         double end, const std::string& place);

}  // namespace subsoil::sim
