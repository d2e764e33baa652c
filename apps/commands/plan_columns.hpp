#pragma once
#include <string>

#include "libsim/studies/sweep/study.hpp"

namespace subsoil::sim {

/// Before the first run of a study: throws ScenarioError for a number of a column that its first point has not.
void refuse_unknown_columns(const std::string& plan, const Study& study);

}  // namespace subsoil::sim
