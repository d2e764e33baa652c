#pragma once
#include <string>

#include "apps/build/world.hpp"

namespace subsoil::app {

/// What a run that an overlap stopped says beside the bed's own words (`fault`, which names the sphere): who overlaps,
/// under which law, with what force, and the stiffness that would halve the overlap. Empty for other faults.
std::string overlap_advice(const std::string& fault, const World& world, const Scenario& scenario);

}  // namespace subsoil::app
