#pragma once
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// What is back within this share of the farthest that it went has come nowhere: its travel has no direction.
inline constexpr double came_nowhere = 0.1;

/// 1 or -1: towards +x or -x by what drivers do until the end to the bodies with surfaces; 0: by none, or nowhere.
/// Drivers of an x and those that move a body along a slide against another count.
int way_of_drivers(const Scenario& scenario, const World& world);
/// 1 or -1: the sense along x in which a machine works, which a draft is against. That of `soil.moving`; else of its
/// drivers; else of the speed, or from rest the acceleration, of the bodies with surfaces at the start; else +x.
int travel_direction(const Scenario& scenario, const World& world);

}  // namespace subsoil::sim
