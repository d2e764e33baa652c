#pragma once
#include <memory>

#include "apps/scenario/load.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::app {

/// The machine of a scenario at its start: assembled from the given pose, or in the steady towing equilibrium. Null
/// when the scenario has none. Throws ScenarioError (place added) for what libmbd refuses.
std::unique_ptr<mbd::Machine> build_machine(const Loaded& loaded);

}  // namespace subsoil::app
