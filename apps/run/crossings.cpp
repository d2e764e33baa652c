#include "apps/run/crossings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/run/columns.hpp"
#include "apps/scenario/load.hpp"
#include "apps/scenario/units.hpp"

namespace subsoil::app {

Crossings::Crossings(const Loaded& loaded, const Columns& columns) {
  for (const CrossingSection& s : loaded.scenario.output.crossings) {
    const std::string path = "output.crossings." + s.name;
    Crossing c;
    c.name = s.name;
    c.column = columns.find_or_throw(s.column, path + ".column", loaded);
    const std::string& unit = columns.list()[c.column].unit;
    try {
      c.level = s.at.empty() ? 0 : parse_quantity(s.at, unit);
    } catch (const UnitError& error) {
      throw ScenarioError(fmt::format("{} = {}: {}", loaded.where(path + ".at"), s.at, error.what()));
    }
    c.rising = s.direction != CrossingDirection::falling, c.falling = s.direction != CrossingDirection::rising;
    c.stop_after = s.stop_after;
    needs_sums_ = needs_sums_ || columns.is_sum(c.column);
    list_.push_back(std::move(c));
  }
}

bool Crossings::look(double t, std::span<const double> values, const Locate& locate) {
  for (Crossing& c : list_) {
    const double value = values[c.column] - c.level;
    if (pass(c, t, value, locate) && c.stop_after > 0 && static_cast<long>(c.times.size()) >= c.stop_after &&
        (stopped_by_.empty() || c.times.back() < stopped_at_))
      stopped_by_ = c.name, stopped_at_ = c.times.back();
    if (value != 0) c.side = value > 0 ? 1 : -1;  // on the value itself it is still where it came from
    c.value = value;
  }
  looked_ = true, looked_at_ = t;
  return !stopped_by_.empty();
}

/// Whether it has passed, in a direction that counts.
bool Crossings::pass(Crossing& c, double t, double value, const Locate& locate) {
  if (!looked_ || c.side == 0 || value == 0 || (value > 0) == (c.side > 0)) return false;
  if (!(value > 0 ? c.rising : c.falling)) return false;
  const double share = c.value == 0 ? 0 : locate({c.column, c.level, c.side, c.value, value});
  c.times.push_back(looked_at_ + share * (t - looked_at_));
  return true;
}

void Crossings::write(Summary& summary) const {
  if (list_.empty()) return;
  auto& section = summary.section("crossings");
  for (const Crossing& c : list_) {
    constexpr std::size_t most = 1000;
    nlohmann::ordered_json& one = section[c.name];
    one["count"] = c.times.size();
    one["times [s]"] = std::vector<double>(
        c.times.begin(), c.times.begin() + static_cast<std::ptrdiff_t>(std::min(most, c.times.size())));
    if (c.times.size() > 1)
      one["mean interval [s]"] = (c.times.back() - c.times.front()) / static_cast<double>(c.times.size() - 1);
  }
  if (!stopped_by_.empty()) summary.section("run")["stopped by"] = stopped_by_;
}

}  // namespace subsoil::app
