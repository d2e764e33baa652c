#include "apps/commands/plan_columns.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libsim/base/problems.hpp"
#include "libsim/run/runner.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

void refuse_unknown_columns(const Study& study, const std::function<std::string(const SweepNumber&)>& where) {
  const auto has_column = [](const SweepNumber& n) { return !n.column.empty(); };
  if (std::none_of(study.numbers.begin(), study.numbers.end(), has_column)) return;
  const std::vector<std::string> sets = study.points.empty() ? std::vector<std::string>{} : study.points.front().sets;
  std::vector<std::string> known;
  for (const SeriesColumn& c : place_and_list_columns(load_scenario(study.scenario, sets))) known.push_back(c.name);
  if (known.empty()) return;
  for (const SweepNumber& n : study.numbers)
    if (has_column(n) && std::find(known.begin(), known.end(), n.column) == known.end())
      throw ScenarioError(
          fmt::format("{} = {}: series.csv has no such column{}", where(n), n.column, suggestion(n.column, known)));
}

void refuse_unknown_columns(const std::string& plan, const Study& study) {
  refuse_unknown_columns(study,
                         [&](const SweepNumber& n) { return fmt::format("{}: numbers.{}.column", plan, n.name); });
}

}  // namespace subsoil::sim
