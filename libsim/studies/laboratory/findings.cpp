#include "libsim/studies/laboratory/findings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "libsim/document/document.hpp"

namespace subsoil::sim {

std::vector<double> SpecimenCurve::column(std::size_t k, double factor) const {
  std::vector<double> out;
  out.reserve(rows.size());
  for (const std::vector<double>& row : rows) out.push_back(row[k] * factor);
  return out;
}

const Number& Findings::number(const std::string& name) const {
  std::vector<std::string> names;
  for (const Number& n : numbers) {
    if (n.name == name) return n;
    names.push_back(n.name);
  }
  throw std::invalid_argument("the test `" + test + "` gives no `" + name + "`" + suggestion(name, names));
}

Line fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  const double mx = std::accumulate(x.begin(), x.end(), 0.0) / n, my = std::accumulate(y.begin(), y.end(), 0.0) / n;
  double xx = 0, xy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) xx += (x[i] - mx) * (x[i] - mx), xy += (x[i] - mx) * (y[i] - my);
  const double b = xx > 0 ? xy / xx : 0;
  return {my - b * mx, b};
}

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double rounding_of_places(const std::vector<double>& x) {
  if (x.empty()) return 0;
  const auto [least, largest] = std::minmax_element(x.begin(), x.end());
  return 1e-9 * std::max({*largest - *least, std::abs(*least), std::abs(*largest)});
}

Line fit_robust_line(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> slopes, offsets;
  const double apart = rounding_of_places(x);
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (std::abs(x[i] - x[k]) > apart) slopes.push_back((y[i] - y[k]) / (x[i] - x[k]));
  const double b = median(std::move(slopes));
  for (std::size_t i = 0; i < x.size(); ++i) offsets.push_back(y[i] - b * x[i]);
  return {median(std::move(offsets)), b};
}

}  // namespace subsoil::sim
