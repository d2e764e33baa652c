#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libsim/base/json.hpp"
#include "libsim/io/series.hpp"
#include "libsim/post/statistics.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {

/// A column over the window.
struct WindowNumbers {
  double mean;
  double half_width;  ///< of the mean's interval, 95 %
  double least, largest;
  bool of_steps;  ///< the extremes are of all steps; else of the rows
};

/// What could be read of a result directory. A report draws what is there and names what is missing.
struct RunFolder {
  std::filesystem::path path;
  std::string name;                  ///< last part of the path
  std::optional<Scenario> scenario;  ///< scenario.yaml
  std::optional<Series> series;      ///< series.csv with a column `time` and two rows or more
  Json summary;                      ///< summary.json; null when it is missing
  bool frames = false;               ///< run.h5 is there
  std::vector<std::string> missing;  ///< a line for each part that could not be read, and why
  TimeWindow window;                 ///< of the numbers

  /// Index of a column of the series, -1 without.
  int column(const std::string& name) const { return series ? series->find(name) : -1; }
  /// What the rows of a column are; instants where the scenario could not be read.
  RowKind kind_of(std::size_t column) const;
  /// A number of the summary below sections, NaN without it: number({"soil", "bulk density [kg/m3]"}).
  double number(const std::vector<std::string>& keys) const;
  std::string text(const std::vector<std::string>& keys) const;
  /// A number of a column over the window, as the summary has it of every step: of_summary("pull", {"mean in window"}).
  /// NaN where the window is not the summary's.
  double of_summary(const std::string& column, const std::vector<std::string>& keys) const;
  /// Numbers of a column over `window`: the summary's, which take every step, or those of the rows where it has none.
  WindowNumbers window_numbers(const std::string& column, const WindowStatistics& rows) const;
};

/// Reads a result directory. Throws std::invalid_argument for a path that is no directory, and for one that holds
/// nothing of a run. `window`: in place of the summary's.
RunFolder read_run_folder(const std::filesystem::path& path, const std::optional<TimeWindow>& window = {});

}  // namespace subsoil::sim
