#pragma once
#include <vector>

#include "libdem/packing/inlet.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

struct World;

/// What stands in World::inlets.
struct PouredSoil {
  std::string name;
  dem::Inlet inlet;
};

/// What its spheres are like, before there is a bed. Not where all its grains are clumps.
dem::RadiusDistribution sizes_of(const InletSection& inlet, const Scenario& s);

/// Inlets of the scenario, for a bed that stands as it is when the run begins. Their spheres are numbered behind those
/// of the bed, of several inlets one after the other, so that each has a number before it comes.
void add_inlets(World& world, const Loaded& loaded);

/// Whether there are clumps among the grains, now or once inlets pour.
bool has_clumps(const World& world);

}  // namespace subsoil::sim
