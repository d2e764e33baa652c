#include "libsim/studies/sweep/number.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>

#include "libsim/document/document.hpp"
#include "libsim/document/expression.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/document/units.hpp"
#include "libsim/keys/ranges.hpp"
#include "libsim/post/run_folder.hpp"

namespace subsoil::sim {
namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
using Record = std::vector<double>;

/// The value at a path of keys with `/` between them. Units in keys have a `/` too, so that the longest key of an
/// object that the path begins with is the one meant: "soil/bulk density [kg/m3]".
double of_summary(const RunFolder& run, std::string_view path) {
  const Json* at = &run.summary;
  while (!path.empty()) {
    if (!at->is_object()) return no_number;
    const Json* next = nullptr;
    std::size_t taken = 0;
    for (const auto& [key, value] : at->items()) {
      const bool fits = path.starts_with(key) && (path.size() == key.size() || path[key.size()] == '/');
      if (fits && (next == nullptr || key.size() > taken)) next = &value, taken = key.size();
    }
    if (next == nullptr) return no_number;
    at = next;
    path.remove_prefix(std::min(path.size(), taken + 1));
  }
  return at->is_number() ? at->get<double>() : no_number;
}

/// Integral from x0 to x1 of the parabola through three points.
double parabola(double x0, double y0, double x1, double y1, double x2, double y2) {
  const double h = x1 - x0, k = x2 - x1, first = (y1 - y0) / h, second = ((y2 - y1) / k - first) / (h + k);
  return h * (y0 + y1) / 2 - second * h * h * h / 6;
}

/// Over what lies between the ends of the window and its first and last row, along straight lines from row to row.
double integral_at_ends(const Record& t, const Record& y, const WindowRows& rows, const TimeWindow& window) {
  const auto piece = [&](std::size_t i, double from, double until) {
    const double slope = (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
    return until > from ? (until - from) * (y[i] + slope * (0.5 * (from + until) - t[i])) : 0;
  };
  double sum = 0;
  if (rows.begin > 0) sum += piece(rows.begin - 1, window.from, t[rows.begin]);
  if (rows.end < t.size()) sum += piece(rows.end - 1, t[rows.end - 1], window.until);
  return sum;
}

/// At the end of the window: on the line to the row behind it, where there is one.
double last_value(const Record& t, const Record& y, const WindowRows& rows, const TimeWindow& window, RowKind kind) {
  const std::size_t last = rows.end - 1;
  if (kind != RowKind::instant || rows.end == t.size() || !(window.until > t[last])) return y[last];
  return y[last] + (y[rows.end] - y[last]) * (window.until - t[last]) / (t[rows.end] - t[last]);
}

NumberOfRun taken(const Record& time, const Record& values, const SweepNumber& n, const TimeWindow& window,
                  RowKind kind, const WindowStatistics& s) {
  const WindowRows rows = rows_in(time, window, kind);
  const auto begin = static_cast<std::ptrdiff_t>(rows.begin), end = static_cast<std::ptrdiff_t>(rows.end);
  const Record in_window(values.begin() + begin, values.begin() + end);
  switch (n.take) {
    case SweepNumber::Take::mean:
      return {s.mean, s.half_width};
    case SweepNumber::Take::least:
      return {s.least, no_number};
    case SweepNumber::Take::largest:
      return {s.largest, no_number};
    case SweepNumber::Take::span:
      return {s.largest - s.least, no_number};
    case SweepNumber::Take::deviation:
      return {s.deviation, no_number};
    case SweepNumber::Take::last:
      return {last_value(time, values, rows, window, kind), no_number};
    case SweepNumber::Take::rms: {
      Record squares = values;
      for (double& v : squares) v *= v;
      return {std::sqrt(rows.integral(squares) / rows.duration()), no_number};
    }
    case SweepNumber::Take::integral:
      if (kind == RowKind::mean) return {rows.integral(values), no_number};
      return {integral_over({time.begin() + begin, time.begin() + end}, in_window) +
                  integral_at_ends(time, values, rows, window),
              no_number};
  }
  return {no_number, no_number};
}

TimeWindow window_of(const RunFolder& run, const SweepNumber& n) {
  TimeWindow window = run.window;
  if (n.from || n.until) window.from = n.from.value_or(0), window.until = n.until.value_or(window.until);
  return window;
}

double nearest_distance(const Record& x, const Record& y, double px, double py) {
  double least = std::hypot(x[0] - px, y[0] - py);
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    const double dx = x[i + 1] - x[i], dy = y[i + 1] - y[i], size = dx * dx + dy * dy;
    const double s = size > 0 ? std::clamp(((px - x[i]) * dx + (py - y[i]) * dy) / size, 0.0, 1.0) : 0;
    least = std::min(least, std::hypot(x[i] + s * dx - px, y[i] + s * dy - py));
  }
  return least;
}

NumberOfRun of_path(const RunFolder& run, const SweepNumber& n, const TimeWindow& window) {
  const std::vector<std::string> names = split_at_semicolons(n.path_text);
  const int i = run.column(names[0]), j = run.column(names[1]);
  if (i < 0 || j < 0) return {no_number, no_number};
  const WindowRows rows = rows_in(run.series->at("time"), window, RowKind::equal);
  const auto of = [&](int column) {
    const Record& all = run.series->values[static_cast<std::size_t>(column)];
    Record part(all.begin() + static_cast<std::ptrdiff_t>(rows.begin),
                all.begin() + static_cast<std::ptrdiff_t>(rows.end));
    const Unit unit = parse_unit(run.series->columns[static_cast<std::size_t>(column)].unit);  // as are the points: m
    for (double& value : part) value = unit.to_si(value);
    return part;
  };
  const Record x = of(i), y = of(j);
  const std::size_t count = n.points.size() / 2;
  if (x.empty() || (n.match == SweepNumber::Match::order && x.size() < count)) return {no_number, no_number};
  Record distances, places;
  for (std::size_t k = 0; k < count; ++k) {
    const double px = n.points[2 * k], py = n.points[2 * k + 1];
    distances.push_back(n.match == SweepNumber::Match::order ? std::hypot(x[k] - px, y[k] - py)
                                                             : nearest_distance(x, y, px, py));
    places.push_back(static_cast<double>(k));
  }
  const TimeWindow all{.from = -1, .rule = ""};
  return {taken(places, distances, n, all, RowKind::equal, statistics(places, distances, all, RowKind::equal)).value,
          no_number};
}

}  // namespace

double integral_over(const std::vector<double>& t, const std::vector<double>& y) {
  const std::size_t n = t.size();
  if (n < 2) return n == 1 ? 0 : no_number;
  if (n == 2) return (t[1] - t[0]) * (y[0] + y[1]) / 2;
  double sum = 0;
  for (std::size_t i = 0; i + 2 < n; i += 2)
    sum += parabola(t[i], y[i], t[i + 1], y[i + 1], t[i + 2], y[i + 2]) -
           parabola(t[i + 2], y[i + 2], t[i + 1], y[i + 1], t[i], y[i]);
  if (n % 2 == 0) sum -= parabola(t[n - 1], y[n - 1], t[n - 2], y[n - 2], t[n - 3], y[n - 3]);
  return sum;
}

std::pair<std::string, std::string> SweepNumber::fault() const {
  const int kinds = (column.empty() ? 0 : 1) + (summary.empty() ? 0 : 1) + (path_text.empty() ? 0 : 1);
  if (kinds != 1)
    return {"", "needs one of `column` (of series.csv), `summary` (path in summary.json) and `path` (two columns)"};
  if (from && until && !(*until > *from)) return {"until", "must lie after `from`"};
  if (!path_text.empty() && split_at_semicolons(path_text).size() != 2)
    return {"path", "must name two columns: [tip.x, tip.y]"};
  if (!path_text.empty() && (points.empty() || points.size() % 2 != 0))
    return {"points", "must be x and y of one point or more"};
  if (path_text.empty() && !points.empty()) return {"points", "are held against a `path`, which is missing"};
  if (!path_text.empty() && take == Take::integral)
    return {"take", "is an integral over time, of which points know nothing; take mean, rms or largest"};
  if (off_text.empty()) return {};
  if (column.empty()) return {"off", "is taken off a `column`, which is missing"};
  try {
    static_cast<void>(make_formula_of(off_text, {"t"}));
  } catch (const std::exception& error) {
    return {"off", error.what()};
  }
  return {};
}

namespace {
/// Of all runs, s; empty: it is not known beforehand.
std::optional<double> common_end(const Node& scenario, const std::vector<std::string>& varied) {
  const auto is_of_time = [](const std::string& path) { return path == "time" || path.starts_with("time."); };
  const Node* const end = find_path(scenario, "time.end");
  if (end == nullptr || end->kind != Node::Kind::scalar || std::any_of(varied.begin(), varied.end(), is_of_time))
    return {};
  try {
    return parse_quantity(end->scalar, "s");
  } catch (const std::exception&) {  // of parameters, or a fault that the scenario's own check names
    return {};
  }
}

std::pair<std::string, std::string> window_fault(const SweepNumber& n, std::optional<double> end) {
  if (!end || !(*end > 0) || !n.from || *n.from < *end) return {};
  return {"from",
          fmt::format("{:g} s is not before the end of the runs, {:g} s: there is no row behind it", *n.from, *end)};
}
}  // namespace

std::vector<std::pair<std::string, std::string>> faults_of(const std::vector<SweepNumber>& numbers,
                                                           const Node& scenario,
                                                           const std::vector<std::string>& varied) {
  const std::optional<double> end = common_end(scenario, varied);
  std::vector<std::pair<std::string, std::string>> out;
  for (const SweepNumber& n : numbers)
    for (const auto& [key, rule] : {n.fault(), window_fault(n, end)})
      if (!rule.empty()) out.emplace_back("numbers." + n.name + (key.empty() ? "" : "." + key), rule);
  return out;
}

std::string unit_of(const RunFolder& run, const SweepNumber& n) {
  if (!n.summary.empty()) {
    const std::size_t open = n.summary.rfind('['), close = n.summary.rfind(']');
    return open != std::string::npos && close != std::string::npos && open < close
               ? n.summary.substr(open + 1, close - open - 1)
               : std::string();
  }
  if (!n.path_text.empty()) return "m";
  const int column = run.series ? run.column(n.column) : -1;
  if (column < 0) return {};
  const std::string& unit = run.series->columns[static_cast<std::size_t>(column)].unit;
  return n.take == SweepNumber::Take::integral ? (unit == "1" ? "s" : unit + " s") : unit;
}

NumberOfRun take_number(const RunFolder& run, const SweepNumber& n) {
  if (!n.summary.empty()) return {of_summary(run, n.summary), no_number};
  if (!run.series) return {no_number, no_number};
  const TimeWindow window = window_of(run, n);
  if (!n.path_text.empty()) return of_path(run, n, window);
  const int column = run.column(n.column);
  const Record& time = run.series->at("time");
  if (column < 0 || rows_in(time, window, RowKind::equal).count() == 0) return {no_number, no_number};
  Record values = run.series->values[static_cast<std::size_t>(column)];
  if (!n.off_text.empty()) {
    const auto formula = make_formula_of(n.off_text, {"t"});
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::abs(values[i] - formula(&time[i]));
  }
  const RowKind kind = run.kind_of(static_cast<std::size_t>(column));
  WindowStatistics s = statistics(time, values, window, kind);
  const bool own_window = window.from == run.window.from && window.until == run.window.until;
  if (n.off_text.empty() && own_window) {
    WindowStatistics unknown;
    const double mean_of_steps = run.window_numbers(n.column, unknown).mean;
    if (n.take == SweepNumber::Take::integral && std::isfinite(mean_of_steps))
      return {mean_of_steps * rows_in(time, window, kind).duration(), no_number};
    const WindowNumbers of_run = run.window_numbers(n.column, s);
    s.mean = of_run.mean, s.half_width = of_run.half_width, s.least = of_run.least, s.largest = of_run.largest;
  }
  return taken(time, values, n, window, kind, s);
}

}  // namespace subsoil::sim
