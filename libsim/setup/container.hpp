#pragma once
#include <cstddef>

#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// Number of spheres whose centres are beyond one of these sides of the container, if there is one, and beyond none of
/// `except`. The container of a moving bed travels with it.
std::size_t spheres_beyond(const Faces& faces, const Scenario& scenario, const World& world, const Faces& except = {});

}  // namespace subsoil::sim
