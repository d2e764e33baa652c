#include "libsim/io/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "libsim/base/json.hpp"
#include "libsim/io/atomic_file.hpp"

namespace subsoil::sim {
namespace {

Json json_of(const Extremes& e) {
  if (e.low > e.high) return nullptr;  // never full
  return {{"min", json_number(e.low)},
          {"at min [s]", e.low_time},
          {"max", json_number(e.high)},
          {"at max [s]", e.high_time}};
}

}  // namespace

Json steady_json(const BlockMean& mean) { return std::isfinite(mean.trend()) ? Json(mean.steady()) : Json(nullptr); }

void Extremes::take(double time, double value) {
  if (value < low) low = value, low_time = time;
  if (value > high) high = value, high_time = time;
}

Summary::Summary(std::vector<SeriesColumn> columns) : sections_(std::make_unique<Json>(Json::object())) {
  columns_.resize(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) columns_[i].column = std::move(columns[i]);
}
Summary::~Summary() = default;
Summary::Summary(Summary&&) noexcept = default;

Json& Summary::section(const std::string& name) { return (*sections_)[name]; }
void Summary::warn(const std::string& text) { warnings_.push_back(text); }

void Summary::set_window(double from, double until, std::string reason) {
  if (provisional_) empty_window();
  if (duration_ > 0) throw std::logic_error("the summary's window is open already and cannot be moved");
  from_ = from;
  until_ = until;
  reason_ = std::move(reason);
}

void Summary::set_provisional_window(double from, double until, std::string reason) {
  set_window(from, until, std::move(reason));
  provisional_ = true;
}

void Summary::drop_window() {
  empty_window();
  from_ = until_ = std::numeric_limits<double>::infinity();
  reason_.clear();
}

void Summary::empty_window() {
  provisional_ = false;
  duration_ = whole_duration_ = 0;
  for (Column& c : columns_) c.now = c.whole = {};
  if (block_ > 0) take_blocks_of(block_);
}

void Summary::take_blocks_of(double period) {
  block_ = period;
  for (Column& c : columns_) c.now.mean.take_blocks_of(period);
}

void Summary::close_window(double until) { until_ = std::min(until_, std::max(until, time_)); }

double Summary::window_until() const {
  if (!std::isfinite(from_)) return until_;
  return period_ > 0 ? from_ + whole_duration_ : std::min(until_, time_);
}

void Summary::take(Column& c, double time, double duration, double inside, double value) const {
  if (std::isnan(value)) {  // a quotient 0/0: means are of the time in which there is a value
    c.fine.restart(), c.coarse.restart();
    return;
  }
  c.now.mean.add(inside, value);
  const auto in_window = [&](double length) { return time - length >= from_ - 1e-9 * length && time <= until_; };
  const auto follow = [&](MovingMean& mean, Extremes& run, Extremes& window) {
    mean.add(time, duration, value);
    if (!mean.full()) return;
    run.take(time, mean.mean());
    if (in_window(mean.length())) window.take(time, mean.mean());
  };
  follow(c.fine, c.fine_run, c.now.fine);
  follow(c.coarse, c.coarse_run, c.now.coarse);
}

// A step belongs to the window with the part of it that lies inside.
double Summary::inside(double time, double duration) const {
  return std::max(0.0, std::min(time, until_) - std::max(time - duration, from_));
}

void Summary::refuse_other_count(std::size_t values) const {
  if (values != columns_.size())
    throw std::invalid_argument(fmt::format("summary sample: {} values for {} columns", values, columns_.size()));
}

void Summary::sample(double time, double duration, std::span<const double> values) {
  refuse_other_count(values.size());
  see(time - duration, values);
  sample_mean(time, duration, values);
}

void Summary::see(double time, std::span<const double> values) {
  refuse_other_count(values.size());
  if (!holds(time)) return;
  for (std::size_t i = 0; i < columns_.size(); ++i) columns_[i].now.steps.take(time, values[i]);
}

std::optional<std::pair<double, double>> Summary::extremes(std::size_t i, double time) const {
  const Extremes& e = columns_[i].now.steps;
  return holds(time) ? std::optional(std::pair(e.low, e.high)) : std::nullopt;
}

void Summary::sample_mean(double time, double duration, std::span<const double> means) {
  refuse_other_count(means.size());
  time_ = time;
  const double part = inside(time, duration);
  duration_ += part;
  for (std::size_t i = 0; i < columns_.size(); ++i) take(columns_[i], time, duration, part, means[i]);
  if (!(period_ > 0) || !(part > 0)) return;
  const double periods = std::floor((duration_ + 0.5 * duration) / period_);
  if (periods < 1 || periods * period_ <= whole_duration_ + 0.5 * period_) return;
  whole_duration_ = duration_;
  for (Column& c : columns_) c.whole = c.now;
}

std::size_t Summary::index(const std::string& name) const {
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (columns_[i].column.name == name) return i;
  throw std::invalid_argument("the summary has no column '" + name + "'");
}

const BlockMean& Summary::over_window(const std::string& column) const {
  return in_window(columns_[index(column)]).mean;
}

const std::string& Summary::unit(const std::string& column) const { return columns_[index(column)].column.unit; }

double Summary::mean(const std::string& column) const { return over_window(column).mean(); }

Json Summary::column_json(const Column& c) const {
  const InWindow& w = in_window(c);
  Json json{{"unit", c.column.unit}, {"mean in window", json_number(w.mean.mean())}};
  json["interval of the mean, 95 %"] = json_number(w.mean.interval());
  json["change over the window"] = json_number(w.mean.trend());
  json["steady"] = steady_json(w.mean);
  json["steps in window"] = json_of(w.steps);
  json["1 ms means in window"] = json_of(w.fine);
  json["50 ms means in window"] = json_of(w.coarse);
  json["1 ms means in run"] = json_of(c.fine_run);
  json["50 ms means in run"] = json_of(c.coarse_run);
  return json;
}

Json Summary::to_json() const {
  auto json = *sections_;
  const double covered = period_ > 0 ? whole_duration_ : duration_;
  json["window"] = {{"from [s]", json_number(from_)},
                    {"until [s]", json_number(window_until())},
                    {"covered [s]", covered},
                    {"rule", reason_}};
  if (period_ > 0) json["window"]["whole periods of [s]"] = period_;
  for (const auto& c : columns_) json["columns"][c.column.name] = column_json(c);
  json["warnings"] = warnings_;
  return json;
}

void Summary::archive(Archive& a) {
  for (Column& c : columns_) a("columns", c);
  a("from", from_)("until", until_)("reason", reason_)("duration", duration_)("whole duration", whole_duration_)(
      "time", time_)("block", block_)("period", period_)("provisional", provisional_)("warnings", warnings_);
}

void Summary::write(const std::filesystem::path& path) const { write_atomically(path, json_text(to_json(), 2) + "\n"); }

}  // namespace subsoil::sim
