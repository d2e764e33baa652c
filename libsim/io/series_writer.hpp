#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "libdem/base/archive.hpp"
#include "libsim/io/disk.hpp"
#include "libsim/io/series.hpp"

namespace subsoil::sim {

/// Writes a series.csv that may be killed, cut off and taken up again.
class SeriesWriter {
 public:
  /// `digits` of a number, or csv::exact_digits. Throws DiskFault, as do all that write.
  /// @param keep bytes of the file that is there, of the same columns, to append to
  SeriesWriter(const std::filesystem::path& path, const std::vector<SeriesColumn>& columns, int digits = 9,
               std::optional<std::uint64_t> keep = std::nullopt);
  ~SeriesWriter();
  /// One sample, a value per column. Handed to the system at least once per second of wall time.
  void write(std::span<const double> values);
  void flush();
  /// All rows so far are on the disk when this returns: so many bytes.
  std::uint64_t sync();

 private:
  std::size_t columns_;
  int digits_;
  OutFile file_;
  std::string rows_;  ///< not yet handed over
  std::chrono::steady_clock::time_point flushed_;
};

/// Means over a sample interval, weighted with the length of each step: add() every step, take() every sample.
class IntervalMean {
 public:
  explicit IntervalMean(std::size_t columns) : sum_(columns, 0.0), mean_(columns, 0.0) {}
  void add(double duration, std::span<const double> values);
  /// The means since the last take(); before any add() the values of the last sample again.
  const std::vector<double>& take();
  void archive(Archive& a) { a("sum", sum_)("mean", mean_)("duration", duration_); }

 private:
  std::vector<double> sum_, mean_;
  double duration_ = 0;
};

}  // namespace subsoil::sim
