#include "libsim/scenario/mean_columns.hpp"

#include <algorithm>

#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

bool is_mean_column(const Scenario& scenario, const std::string& name,
                    const std::function<std::string(const std::string&)>& unit_of) {
  if (scenario.instant_forces()) return false;
  for (const Watch& watch : scenario.output.watch) {
    if (watch.name != name) continue;
    if (watch.over_time()) return false;
    if (watch.kind != Watch::Kind::formula) break;
    return std::any_of(watch.inputs.begin(), watch.inputs.end(),
                       [&](const auto& input) { return is_mean_column(scenario, input.second, unit_of); });
  }
  const std::string unit = unit_of(name);
  return unit == "N" || unit == "N m";
}

}  // namespace subsoil::sim
