#pragma once
#include <string>
#include <vector>

#include "libsim/setup/world.hpp"

namespace subsoil::sim {

/// Bodies on which the explicit exchange may be unstable (coupling/exchange_stability.hpp), before the run: with the
/// stiffness and the dashpot of every sphere that fits on a surface side by side. Soil below the spheres is taken as
/// rigid, which makes the bound smaller. Growth counts where it exceeds 1 % per period of the body on that spring:
/// below that, contacts open or friction takes it.
std::vector<std::string> exchange_warnings(const Loaded& loaded, const World& world);

}  // namespace subsoil::sim
