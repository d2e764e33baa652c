#include "libsim/run/crossings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/base/json.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/run/columns.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

Crossings::Crossings(const Loaded& loaded, const Columns& columns) {
  for (const CrossingSection& s : loaded.scenario.output.crossings) {
    const std::string path = "output.crossings." + s.name;
    Crossing c;
    c.name = s.name;
    c.column = columns.find_or_throw(s.column, path + ".column", loaded);
    const std::string& unit = columns.list()[c.column].unit;
    try {
      c.level = s.at.empty() ? 0 : parse_quantity_in(s.at, unit);
    } catch (const UnitError& error) {
      throw ScenarioError(fmt::format("{} = {}: {}", loaded.where(path + ".at"), s.at, error.what()));
    }
    c.noise = columns.noise_of(c.column);
    c.rising = s.direction != CrossingDirection::falling, c.falling = s.direction != CrossingDirection::rising;
    c.stop_after = s.stop_after;
    needs_sums_ = needs_sums_ || columns.is_sum(c.column);
    of_history_ = of_history_ || columns.of_history(c.column);
    list_.push_back(std::move(c));
  }
  for (const StopSection& s : loaded.scenario.time.stop_when) {
    const std::string path = "time.stop when." + s.name, key = s.above.empty() ? ".below" : ".above";
    const std::string& level = s.above.empty() ? s.below : s.above;
    Stop stop{.name = s.name, .sign = s.above.empty() ? -1 : 1, .held = s.held.value_or(0)};
    stop.column = columns.find_or_throw(s.column, path + ".column", loaded);
    try {
      stop.level = parse_quantity_in(level, columns.list()[stop.column].unit);
    } catch (const UnitError& error) {
      throw ScenarioError(fmt::format("{} = {}: {}", loaded.where(path + key), level, error.what()));
    }
    stop.noise = columns.noise_of(stop.column);
    needs_sums_ = needs_sums_ || columns.is_sum(stop.column);
    of_history_ = of_history_ || columns.of_history(stop.column);
    stops_.push_back(std::move(stop));
  }
}

void Crossings::stop(const std::string& by, double at) {
  if (stopped_by_.empty() || at < stopped_at_) stopped_by_ = by, stopped_at_ = at;
}

void Crossings::look(Stop& s, double t, double value, const Locate& locate) {
  const bool before = looked_ && s.beyond;
  const bool now = std::abs(value) <= s.noise ? before : s.sign * value > 0;  // on the level it is where it came from
  double until = t;
  if (looked_ && now != before) {
    const int side = before ? s.sign : -s.sign;
    const double share = side * s.value <= 0 ? 0 : locate({s.column, s.level, side, s.value, value});
    const double passed = looked_at_ + share * (t - looked_at_);
    before ? until = passed : s.since = passed;
  } else if (now && !before) {
    s.since = t;
  }
  if ((now || before) && s.since + s.held <= until) stop(s.name, s.since + s.held);
  s.beyond = now, s.value = value;
}

bool Crossings::look(double t, std::span<const double> values, const Locate& locate) {
  for (Crossing& c : list_) {
    const double value = values[c.column] - c.level;
    if (pass(c, t, value, locate) && c.stop_after > 0 && static_cast<long>(c.times.size()) >= c.stop_after)
      stop(c.name, c.times.back());
    if (std::abs(value) > c.noise) c.side = value > 0 ? 1 : -1;  // on the value itself it is still where it came from
    c.value = value;
  }
  for (Stop& s : stops_) look(s, t, values[s.column] - s.level, locate);
  looked_ = true, looked_at_ = t;
  return !stopped_by_.empty();
}

void Crossings::request(std::vector<mbd::Request>& out) const {
  for (const Crossing& c : list_)
    out.push_back({c.column, static_cast<double>(c.side), c.level, mbd::Request::Kind::excursion});
  for (const Stop& s : stops_)
    out.push_back({s.column, static_cast<double>(s.beyond ? s.sign : -s.sign), s.level, mbd::Request::Kind::excursion});
}

/// Whether it has passed, in a direction that counts.
bool Crossings::pass(Crossing& c, double t, double value, const Locate& locate) {
  if (!looked_ || c.side == 0 || std::abs(value) <= c.noise || (value > 0) == (c.side > 0)) return false;
  if (!(value > 0 ? c.rising : c.falling)) return false;
  const double share = c.side * c.value <= 0 ? 0 : locate({c.column, c.level, c.side, c.value, value});
  c.times.push_back(looked_at_ + share * (t - looked_at_));
  return true;
}

void Crossings::write(Summary& summary) const {
  if (!stopped_by_.empty()) {
    summary.section("run")["stopped by"] = stopped_by_;
    summary.section("run")["stopped at [s]"] = stopped_at_;
  }
  if (list_.empty()) return;
  auto& section = summary.section("crossings");
  for (const Crossing& c : list_) {
    constexpr std::size_t most = 1000;
    Json& one = section[c.name];
    one["count"] = c.times.size();
    one["times [s]"] = std::vector<double>(
        c.times.begin(), c.times.begin() + static_cast<std::ptrdiff_t>(std::min(most, c.times.size())));
    if (c.times.size() > 1)
      one["mean interval [s]"] = (c.times.back() - c.times.front()) / static_cast<double>(c.times.size() - 1);
  }
}

}  // namespace subsoil::sim
