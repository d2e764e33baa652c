#pragma once
#include <string>
#include <vector>

#include "libsim/base/replicates.hpp"
#include "libsim/io/series.hpp"
#include "libsim/plot/chart.hpp"

namespace subsoil::sim {

/// Columns of numbers over each other, as a CSV file holds them.
struct SpecimenCurve {
  std::string name;
  std::vector<SeriesColumn> columns;
  std::vector<std::vector<double>> rows;

  std::vector<double> column(std::size_t k, double factor = 1) const;
};

/// What one specimen gave.
struct Outcome {
  std::vector<double> values;
  SpecimenCurve curve;
};

/// A number of a test, once per packing, SI.
struct Number {
  std::string name, unit;
  std::vector<double> values;

  Replicates replicates() const { return Replicates(values); }
  double mean() const { return replicates().mean; }
};

struct NamedChart {
  std::string name;
  Chart chart;
};

/// What a test found.
struct Findings {
  std::string test;
  std::vector<Number> numbers;
  std::vector<SpecimenCurve> curves;
  std::vector<NamedChart> charts;
  std::vector<std::string> diagnostics;  ///< what a reader of the numbers must know

  /// Throws std::invalid_argument with the names there are.
  const Number& number(const std::string& name) const;
};

/// y = a + b x by least squares.
struct Line {
  double a = 0, b = 0;
};
Line fit_line(const std::vector<double>& x, const std::vector<double>& y);
/// Distance up to which two places differ by rounding alone.
double rounding_of_places(const std::vector<double>& x);
/// The same by Theil and Sen: b the median of the slopes of all pairs at different x, a the median of y - b x; up to 29
/// % of the points may be anywhere. Sen, J. Am. Stat. Assoc. 63 (1968) 1379.
Line fit_robust_line(const std::vector<double>& x, const std::vector<double>& y);
double median(std::vector<double> values);

}  // namespace subsoil::sim
