#pragma once
#include <functional>
#include <string>

namespace subsoil::sim {

struct Scenario;

/// Whether a column of series.csv holds means since the row before it: those with the unit N or N m, unless forces are
/// of an instant (`output.forces`), and formulas of such; not what is followed over time.
/// @param unit_of unit of the column of that name, empty where there is none
bool is_mean_column(const Scenario& scenario, const std::string& name,
                    const std::function<std::string(const std::string&)>& unit_of);

}  // namespace subsoil::sim
