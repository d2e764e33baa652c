#pragma once
#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// Spheres inside the machine or given boundaries are refused or removed, by `soil.bed.inside machine`.
/// @param loose the bed stands as it was poured, above where it will lie: its spheres are removed and counted apart
void clear_machine(World& world, const Loaded& loaded, bool loose);

}  // namespace subsoil::sim
