#pragma once
#include "libdem/laws/law_table.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

/// Index of a material by name; materials are numbered in the scenario's order. Throws std::invalid_argument.
int material_index(const Scenario& scenario, const std::string& name);

/// The bed's table of laws: every contact entry resolved (pair's values, continuity, elastic constants of materials).
/// Throws ScenarioError with the place of the entry that cannot be resolved.
dem::LawTable build_laws(const Loaded& loaded);

}  // namespace subsoil::sim
