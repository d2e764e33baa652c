#include "apps/output/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "apps/output/atomic_file.hpp"

namespace subsoil::app {
namespace {

/// JSON knows no infinity and no NaN.
nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json json_of(const Extremes& e) {
  if (e.low > e.high) return nullptr;  // never full
  return {{"min", number(e.low)}, {"at min [s]", e.low_time}, {"max", number(e.high)}, {"at max [s]", e.high_time}};
}

}  // namespace

void Extremes::take(double time, double value) {
  if (value < low) low = value, low_time = time;
  if (value > high) high = value, high_time = time;
}

Summary::Summary(std::vector<SeriesColumn> columns) {
  columns_.resize(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) columns_[i].column = std::move(columns[i]);
}

void Summary::set_window(double from, double until, std::string reason) {
  if (duration_ > 0) throw std::logic_error("the summary's window is open already and cannot be moved");
  from_ = from;
  until_ = until;
  reason_ = std::move(reason);
}

void Summary::sample(double time, double duration, std::span<const double> values) {
  if (values.size() != columns_.size())
    throw std::invalid_argument(
        fmt::format("summary sample: {} values for {} columns", values.size(), columns_.size()));
  time_ = time;
  // A step belongs to the window with the part of it that lies inside.
  const double inside = std::max(0.0, std::min(time, until_) - std::max(time - duration, from_));
  duration_ += inside;
  const auto in_window = [&](double length) { return time - length >= from_ - 1e-9 * length && time <= until_; };
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    auto& c = columns_[i];
    const double value = values[i];
    c.integral += value * inside;
    if (inside > 0) c.steps.take(time, value);
    const auto follow = [&](MovingMean& mean, Extremes& run, Extremes& window) {
      mean.add(time, duration, value);
      if (!mean.full()) return;
      run.take(time, mean.mean());
      if (in_window(mean.length())) window.take(time, mean.mean());
    };
    follow(c.fine, c.fine_run, c.fine_window);
    follow(c.coarse, c.coarse_run, c.coarse_window);
  }
  for (auto& share : shares_) {
    const double before = std::max(0.0, std::min(time, share.until) - std::max(time - duration, share.from));
    share.integral += values[share.wall] * before;
    share.duration += before;
  }
}

std::size_t Summary::index(const std::string& name) const {
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (columns_[i].column.name == name) return i;
  throw std::invalid_argument("the summary has no column '" + name + "'");
}

void Summary::share_of(const std::string& wall, const std::string& draft, double baseline_from, double baseline_until) {
  shares_.push_back({index(wall), index(draft), baseline_from, baseline_until});
}

double Summary::Share::peak(const Extremes& e) const {
  return e.low > e.high ? std::numeric_limits<double>::quiet_NaN()
                        : std::max(std::abs(e.low - baseline()), std::abs(e.high - baseline()));
}

double Summary::mean(const std::string& column) const {
  return duration_ > 0 ? columns_[index(column)].integral / duration_ : std::numeric_limits<double>::quiet_NaN();
}

nlohmann::ordered_json Summary::column_json(const Column& c) const {
  nlohmann::ordered_json json{{"unit", c.column.unit}, {"mean in window", number(mean(c.column.name))}};
  json["steps in window"] = json_of(c.steps);
  json["1 ms means in window"] = json_of(c.fine_window);
  json["50 ms means in window"] = json_of(c.coarse_window);
  json["1 ms means in run"] = json_of(c.fine_run);
  json["50 ms means in run"] = json_of(c.coarse_run);
  return json;
}

nlohmann::ordered_json Summary::to_json(double share_limit) const {
  auto json = sections_;
  auto warnings = warnings_;
  json["window"] = {{"from [s]", number(from_)},
                    {"until [s]", number(std::isfinite(from_) ? std::min(until_, time_) : until_)},
                    {"covered [s]", duration_},
                    {"rule", reason_}};
  if (duration_ <= 0) warnings.push_back("the window of the means was never reached: means are null");
  for (const auto& c : columns_) json["columns"][c.column.name] = column_json(c);
  for (const auto& share : shares_) {
    const auto& wall = columns_[share.wall].column.name;
    const auto& draft = columns_[share.draft].column.name;
    const double peak = share.peak(columns_[share.wall].coarse_window) / std::abs(mean(draft));
    json["wall shares"][wall] = {
        {"of", draft}, {"peak share", number(peak)}, {"force before the tool [N]", number(share.baseline())}};
    if (peak > share_limit)
      warnings.push_back(
          fmt::format("{} carries up to {:.1f} % of the {} (limit {:.0f} %): the domain is too small for "
                      "the depth; make it larger in that direction",
                      wall, 100 * peak, draft, 100 * share_limit));
  }
  json["warnings"] = warnings;
  return json;
}

void Summary::write(const std::filesystem::path& path) const {
  write_atomically(path, to_json().dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace subsoil::app
