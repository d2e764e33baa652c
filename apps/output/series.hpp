#pragma once
#include <chrono>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// series.csv: one row per sample; the first line holds names and units, `time [s],shovel.x [m],...`.
namespace subsoil::app {

struct SeriesColumn {
  std::string name;
  std::string unit;  ///< "1" for pure numbers

  /// Columns of the scenario's `watch` carry the user's bare name; all others are `owner.quantity`.
  bool is_watch() const { return name.find('.') == std::string::npos && name != "time" && name != "step"; }
  std::string label() const { return name + " [" + unit + "]"; }
};

class SeriesWriter {
 public:
  /// `digits` of a number, or csv::exact_digits.
  SeriesWriter(const std::filesystem::path& path, std::vector<SeriesColumn> columns, int digits = 9);
  /// One sample, a value per column. Written to disk at least once per second of wall time.
  void write(std::span<const double> values);
  void flush();
  const std::vector<SeriesColumn>& columns() const { return columns_; }

 private:
  std::filesystem::path path_;
  std::vector<SeriesColumn> columns_;
  int digits_;
  std::ofstream file_;
  std::string row_;
  std::chrono::steady_clock::time_point flushed_;
};

/// Means over a sample interval, weighted with the length of each step: add() every step, take() every sample.
class IntervalMean {
 public:
  explicit IntervalMean(std::size_t columns) : sum_(columns, 0.0) {}
  void add(double duration, std::span<const double> values);
  /// The means since the last take(); before any add() the values of the last sample again.
  const std::vector<double>& take();

 private:
  std::vector<double> sum_;
  std::vector<double> mean_ = std::vector<double>(sum_.size(), 0.0);
  double duration_ = 0;
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

}  // namespace subsoil::app
