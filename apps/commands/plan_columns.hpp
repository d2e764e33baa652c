#pragma once
#include <functional>
#include <string>

#include "libsim/studies/sweep/study.hpp"

namespace subsoil::sim {

/// Before the first run of a study: throws ScenarioError for a number of a column that its first point has not.
/// @param where names the place of a number in the user's words: `plan.yaml: numbers.pull.column`
void refuse_unknown_columns(const Study& study, const std::function<std::string(const SweepNumber&)>& where);
void refuse_unknown_columns(const std::string& plan, const Study& study);  ///< of a plan file

}  // namespace subsoil::sim
