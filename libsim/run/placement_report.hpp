#pragma once
#include <string>
#include <vector>

#include "libsim/scenario/load.hpp"
#include "libsim/setup/world.hpp"

/// Places and ways that cannot be meant, seen before a run.
namespace subsoil::sim {

/// Box of all spheres.
dem::Bounds bed_box(const World& world);

/// Tools through the floor or below it, or through two opposite walls of the container at the start, pins far from both
/// of their bodies: what `check` and `run` warn of.
std::vector<std::string> placement_warnings(const Scenario& scenario, const World& world);

/// Tools whose known way leads to a wall or is too short for means: `check` reports before the run what a run reports.
std::vector<std::string> travel_warnings(const Scenario& scenario, const World& world);

/// Bodies that no joint and no driver holds; nodes of beams are held by these.
std::vector<std::string> free_bodies(const Scenario& scenario, const World& world);

}  // namespace subsoil::sim
