#pragma once
#include "apps/scenario/load.hpp"
#include "libdem/laws/law_table.hpp"

namespace subsoil::app {

/// Index of a material by name; materials are numbered in the scenario's order. Throws std::invalid_argument.
int material_index(const Scenario& scenario, const std::string& name);

/// The bed's table of laws: every contact entry resolved (pair's values, continuity, elastic constants of materials).
/// Throws ScenarioError with the place of the entry that cannot be resolved.
dem::LawTable build_laws(const Loaded& loaded);

}  // namespace subsoil::app
