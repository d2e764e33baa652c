#pragma once
#include <cstddef>
#include <vector>

namespace subsoil::sim {

/// Half of the two-sided interval of Student's t with so many degrees of freedom (> 0), in standard errors.
double student_t(double freedoms, double confidence = 0.95);

/// Independent values of one number: their mean m, the sum of squares about it, and what follows from these.
struct Replicates {
  std::size_t count = 0;
  double mean = 0, squares = 0;

  explicit Replicates(const std::vector<double>& values);
  double deviation() const;       ///< s = sqrt(squares/(n - 1)), the standard deviation; NaN of one value
  double standard_error() const;  ///< of the mean, s/sqrt(n); NaN of one value
  double half_width() const;      ///< of the 95 % interval of the mean by Student's t; NaN of one value
};

}  // namespace subsoil::sim
