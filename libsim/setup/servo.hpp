#pragma once
#include "coupling/servo.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

/// The servo of a boundary. Throws ScenarioError with `place` for a pressure on a plane, which has no area, and for a
/// load that is zero throughout and leaves the gain open. A lag that is left out is negative until the step is known.
coupling::Servo servo_of(const ServoSection& section, const dem::Boundary& boundary, const dem::PeriodicCell& cell,
                         double end, const std::string& place);

/// Area that a surface shows along a unit vector, m^2: that of its shadow, of a cylinder that of the round one. What
/// lies beyond periodic sides meets no spheres and does not count.
double shown_area(const dem::Boundary& boundary, const Vec3& along, const dem::PeriodicCell& cell);

}  // namespace subsoil::sim
