#include "libsim/base/replicates.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <numeric>

namespace subsoil::sim {

double student_t(double freedoms, double confidence) {
  return boost::math::quantile(boost::math::complement(boost::math::students_t(freedoms), 0.5 * (1 - confidence)));
}

Replicates::Replicates(const std::vector<double>& values)
    : count(values.size()), mean(std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(count)) {
  for (const double v : values) squares += (v - mean) * (v - mean);
}

double Replicates::deviation() const {
  return count > 1 ? std::sqrt(squares / static_cast<double>(count - 1)) : std::numeric_limits<double>::quiet_NaN();
}

double Replicates::standard_error() const { return deviation() / std::sqrt(static_cast<double>(count)); }

double Replicates::half_width() const {
  if (count < 2) return std::numeric_limits<double>::quiet_NaN();
  return student_t(static_cast<double>(count - 1)) * standard_error();
}

}  // namespace subsoil::sim
