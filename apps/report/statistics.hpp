#pragma once
#include <limits>
#include <span>
#include <string>
#include <vector>

/// Numbers of a time series over a window, with the interval that a correlated record allows.
namespace subsoil::app {

struct TimeWindow {
  double from = 0, until = std::numeric_limits<double>::infinity();  ///< s
  std::string rule;                                                  ///< why so
};

/// Mean, spread and extremes of the rows of a series that lie in a window. NaN where the window holds no row.
struct WindowStatistics {
  std::size_t rows = 0;
  double mean = std::numeric_limits<double>::quiet_NaN();
  double deviation = std::numeric_limits<double>::quiet_NaN();
  double half_width = std::numeric_limits<double>::quiet_NaN();  ///< of the 95 % interval of the mean
  double least = std::numeric_limits<double>::quiet_NaN(), least_time = 0;
  double largest = std::numeric_limits<double>::quiet_NaN(), largest_time = 0;
};

/// Rows are equally weighted. The interval is mean +- t s / sqrt(n_e), t of Student with n_e - 1 degrees of freedom,
/// n_e = n / tau rows that count as independent, tau = 1 + 2 sum_k rho_k the integrated correlation time in rows,
/// summed until rho_k < 0 (Geyer, Statistical Science 7 (1992) 473: initial positive sequence). NaN where n_e < 2.
WindowStatistics statistics(std::span<const double> time, std::span<const double> values, const TimeWindow& window);

/// The strongest line of a record.
struct SpectralLine {
  double period = std::numeric_limits<double>::quiet_NaN();  ///< s; NaN of a record that is too short or constant
  double amplitude = 0;                                      ///< of the sine, in the record's unit
};
/// Largest |DFT| of the record without its mean and trend, periods from two rows to half the record's length.
SpectralLine strongest_line(std::span<const double> time, std::span<const double> values, const TimeWindow& window);

}  // namespace subsoil::app
