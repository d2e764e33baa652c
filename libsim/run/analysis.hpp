#pragma once
#include "libsim/run/runner.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

/// The analyses that do not run in time: assembly, equilibrium, modes. Writes scenario.yaml, summary.json, series.csv
/// with one row (pose, reactions, forces) and, for modes, modes.csv; prints what was found.
int run_analysis(const Loaded& loaded, const RunRequest& request);

}  // namespace subsoil::sim
