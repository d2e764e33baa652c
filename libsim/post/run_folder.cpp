#include "libsim/post/run_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libsim/scenario/load.hpp"
#include "libsim/scenario/mean_columns.hpp"

namespace subsoil::sim {
namespace {

constexpr const char* kRunFiles[] = {"scenario.yaml", "series.csv", "summary.json", "run.h5"};

/// The first line of what an exception says.
std::string first_line(const std::exception& error) {
  const std::string text = error.what();
  return text.substr(0, text.find('\n'));
}

const Json* find(const Json& json, const std::vector<std::string>& keys) {
  const Json* node = &json;
  for (const std::string& key : keys) {
    if (!node->is_object() || !node->contains(key)) return nullptr;
    node = &(*node)[key];
  }
  return node;
}

void read_scenario(RunFolder& run) {
  try {
    run.scenario = load_scenario((run.path / "scenario.yaml").string()).scenario;
  } catch (const std::exception& error) {
    run.missing.push_back("scenario.yaml: " + first_line(error) + "; no title, sides and theory");
  }
}

void read_rows(RunFolder& run) {
  try {
    Series series = read_series(run.path / "series.csv");
    const std::vector<double>& time = series.at("time");
    if (time.size() < 2) throw std::runtime_error("series.csv has fewer than two rows");
    if (!std::is_sorted(time.begin(), time.end())) throw std::runtime_error("time does not rise");
    run.series = std::move(series);
  } catch (const std::exception& error) {
    run.missing.push_back("series.csv: " + first_line(error) + "; no curves and no means");
  }
}

void read_summary(RunFolder& run) {
  try {
    run.summary = read_json(run.path / "summary.json");
    if (!run.summary.is_object()) throw std::runtime_error("is no object");
  } catch (const std::exception& error) {
    run.summary = nullptr;
    run.missing.push_back("summary.json: " + first_line(error) +
                          "; no energy balance and no cost (a run that was killed writes none)");
  }
}

/// The summary's window where it was reached, else the whole record.
TimeWindow window_of(const RunFolder& run) {
  const double from = run.number({"window", "from [s]"}), until = run.number({"window", "until [s]"});
  if (until > from) return {from, until, run.text({"window", "rule"})};
  if (!run.series) return {};
  const std::vector<double>& time = run.series->at("time");
  return {time.front(), time.back(), "the whole record: no window of steady work was reached"};
}

}  // namespace

RowKind RunFolder::kind_of(std::size_t column) const {
  if (!scenario || !series) return RowKind::instant;
  const auto unit_of = [&](const std::string& name) {
    const int found = series->find(name);
    return found < 0 ? std::string() : series->columns[static_cast<std::size_t>(found)].unit;
  };
  return is_mean_column(*scenario, series->columns[column].name, unit_of) ? RowKind::mean : RowKind::instant;
}

double RunFolder::number(const std::vector<std::string>& keys) const {
  const Json* node = find(summary, keys);
  return node != nullptr && node->is_number() ? node->get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string RunFolder::text(const std::vector<std::string>& keys) const {
  const Json* node = find(summary, keys);
  return node != nullptr && node->is_string() ? node->get<std::string>() : std::string();
}

double RunFolder::of_summary(const std::string& column, const std::vector<std::string>& keys) const {
  if (window.from != number({"window", "from [s]"}) || window.until != number({"window", "until [s]"}))
    return std::numeric_limits<double>::quiet_NaN();
  std::vector<std::string> path{"columns", column};
  path.insert(path.end(), keys.begin(), keys.end());
  return number(path);
}

WindowNumbers RunFolder::window_numbers(const std::string& column, const WindowStatistics& rows) const {
  const auto of = [&](const std::vector<std::string>& keys) { return of_summary(column, keys); };
  WindowNumbers out{of({"mean in window"}), of({"interval of the mean, 95 %"}), of({"steps in window", "min"}),
                    of({"steps in window", "max"}), true};
  if (!std::isfinite(out.mean)) out.mean = rows.mean, out.half_width = rows.half_width;
  if (!std::isfinite(out.least) || !std::isfinite(out.largest))
    out.least = rows.least, out.largest = rows.largest, out.of_steps = false;
  return out;
}

RunFolder read_run_folder(const std::filesystem::path& path, const std::optional<TimeWindow>& window) {
  if (!std::filesystem::is_directory(path))
    throw std::invalid_argument(path.string() + ": is no directory; name the result directory of a run");
  RunFolder run;
  run.path = path;
  const auto whole = std::filesystem::absolute(path).lexically_normal();
  run.name = whole.has_filename() ? whole.filename().string() : whole.parent_path().filename().string();
  const bool any = std::any_of(std::begin(kRunFiles), std::end(kRunFiles),
                               [&](const char* file) { return std::filesystem::exists(path / file); });
  if (!any)
    throw std::invalid_argument(path.string() +
                                ": holds none of scenario.yaml, series.csv, summary.json, run.h5; name the result "
                                "directory of a run");
  read_scenario(run);
  read_rows(run);
  read_summary(run);
  run.frames = std::filesystem::exists(path / "run.h5");
  if (!run.frames) run.missing.push_back("run.h5: there is none; no spheres, no furrow");
  run.window = window ? *window : window_of(run);
  return run;
}

}  // namespace subsoil::sim
