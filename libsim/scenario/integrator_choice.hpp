#pragma once
#include "libmbd/integrators/integrator.hpp"

namespace subsoil::sim {

struct Scenario;

/// The method that integrates the machine: the one given, else by what the machine and its surroundings are
/// (`integrator: auto` of `time.machine`).
mbd::IntegratorKind integrator_of(const Scenario& s);

}  // namespace subsoil::sim
