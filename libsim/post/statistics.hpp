#pragma once
#include <limits>
#include <span>
#include <string>
#include <vector>

/// Numbers of a time series over a window, with the interval that a correlated record allows.
namespace subsoil::sim {

struct TimeWindow {
  double from = 0, until = std::numeric_limits<double>::infinity();  ///< s
  std::string rule;                                                  ///< why so
};

/// What the rows of a record are: values at their times, means since the row before, or values without times, each of
/// which counts the same.
enum class RowKind { instant, mean, equal };

/// The rows of a record whose times lie in a window, and the time that each row of the record stands for there, s: of
/// means what of its interval lies in the window, the first row of the record none; of instants the integral of its
/// part in straight lines from row to row (trapezium rule), so that rows next to the window count where its ends lie
/// between rows; else 1. All 1 where that leaves no time.
struct WindowRows {
  std::size_t begin = 0, end = 0;  ///< in the window
  std::size_t weighed = 0;         ///< first row that has a weight
  std::vector<double> weights;     ///< from it on
  std::size_t count() const { return end - begin; }
  /// Sum of weight x value over the rows of the record.
  double integral(std::span<const double> values) const;
  double duration() const;  ///< sum of the weights
};
WindowRows rows_in(std::span<const double> time, const TimeWindow& window, RowKind kind);

/// Mean, spread and extremes of the rows of a series that lie in a window. Rows without a value, as the first of a
/// derivative, do not count. NaN where the window holds no other.
struct WindowStatistics {
  std::size_t rows = 0;
  double mean = std::numeric_limits<double>::quiet_NaN();
  double deviation = std::numeric_limits<double>::quiet_NaN();
  double half_width = std::numeric_limits<double>::quiet_NaN();  ///< of the 95 % interval of the mean
  double least = std::numeric_limits<double>::quiet_NaN(), least_time = 0;
  double largest = std::numeric_limits<double>::quiet_NaN(), largest_time = 0;
};

/// Mean and spread are weighted with the rows' times: deviation^2 = mean of (x - mean)^2 over the window; of equal
/// rows, a sample, over n - 1. The interval is that of BlockMean over the same times, as in the summary, which takes
/// every step in place of rows: there is one estimator. NaN where that has too few blocks.
WindowStatistics statistics(std::span<const double> time, std::span<const double> values, const TimeWindow& window,
                            RowKind kind);

/// The dominant frequency of a record.
struct SpectralLine {
  double period = std::numeric_limits<double>::quiet_NaN();  ///< s; NaN where there is none
  double amplitude = 0;                                      ///< of the sine, in the record's unit
};
/// The sine that with a mean and a trend fits the record by least squares, of periods from two rows, the widest apart,
/// to half the record's length, whole in it or not. Taken at a peak of the Fourier transform that reaches 70 % of its
/// maximum. Rows count with the time between them, means in the middle of theirs. None where the fit improves towards
/// longer periods, of fewer than 16 rows, and of a record that is constant or straight but for rounding, 1e-12 of its
/// maximum value or 2.2e-16 of its SI unit.
SpectralLine strongest_line(std::span<const double> time, std::span<const double> values, const TimeWindow& window,
                            RowKind kind);

}  // namespace subsoil::sim
