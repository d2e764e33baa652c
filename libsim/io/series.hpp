#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// series.csv: one row per sample; the first line holds names and units, `time [s],shovel.x [m],...`.
namespace subsoil::sim {

struct SeriesColumn {
  std::string name;
  std::string unit;  ///< "1" for pure numbers

  /// Columns of the scenario's `watch` carry the user's bare name; all others are `owner.quantity`.
  bool is_watch() const { return name.find('.') == std::string::npos && name != "time" && name != "step"; }
  std::string label() const { return name + " [" + unit + "]"; }
};

struct Series {
  std::vector<SeriesColumn> columns;
  std::vector<std::vector<double>> values;  ///< by column

  std::size_t rows() const { return values.empty() ? 0 : values.front().size(); }
  /// Index of a column or -1.
  int find(std::string_view name) const;
  /// Throws std::runtime_error naming the columns there are.
  const std::vector<double>& at(std::string_view name) const;
};

/// A last line cut short by a killed run is left out; anything else that is no number throws std::runtime_error.
Series read_series(const std::filesystem::path& path);

}  // namespace subsoil::sim
