#include "libmbd/base/spline.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace subsoil::mbd {

PiecewiseCubic::PiecewiseCubic(std::vector<double> x, std::vector<double> y, Ends ends, const char* places,
                               Between between)
    : ends_(ends), x_(std::move(x)), y_(std::move(y)) {
  if (x_.size() != y_.size() || x_.empty())
    throw std::invalid_argument("needs as many values as " + std::string(places) + ", and at least one point");
  for (std::size_t i = 1; i < x_.size(); ++i)
    if (!(x_[i] > x_[i - 1]))
      throw std::invalid_argument(places + (" must increase; point " + std::to_string(i + 1)) +
                                  " does not come after the one before");
  if (ends_ == Ends::periodic) {
    double largest = 0;
    for (const double value : y_) largest = std::max(largest, std::abs(value));
    if (x_.size() < 2 || std::abs(y_.back() - y_.front()) > 1e-12 * largest)
      throw std::invalid_argument(
          "what repeats itself must end with the value it begins with; add a last point with the first one's value");
    y_.back() = y_.front();
  }
  bend_.assign(x_.size(), {});
  if (between == Between::spline) solve();
  if (between == Between::monotone) take_monotone_slopes();
  sum();
}

/// Slopes that meet at the points: h_{i-1} m_{i-1} + 2 (h_{i-1} + h_i) m_i + h_i m_{i+1} = 6 (slope_i - slope_{i-1})
/// for the second derivatives m, a symmetric matrix that its diagonal dominates.
void PiecewiseCubic::solve() {
  const auto n = static_cast<int>(x_.size());
  const bool periodic = ends_ == Ends::periodic;
  const int first = periodic ? 0 : 1, count = periodic ? n - 1 : n - 2;  // unknowns are m_first, ...
  if (count <= 0) return;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  for (int i = 0; i + 1 < n; ++i) {  // what each interval adds
    const auto k = static_cast<std::size_t>(i);
    const double h = x_[k + 1] - x_[k], slope = (y_[k + 1] - y_[k]) / h;
    const int left_row = i - first, right_row = periodic ? (i + 1) % count : i + 1 - first;
    const bool has_left = left_row >= 0, has_right = right_row < count;
    if (has_left) entries.emplace_back(left_row, left_row, 2 * h), right[left_row] += 6 * slope;
    if (has_right) entries.emplace_back(right_row, right_row, 2 * h), right[right_row] -= 6 * slope;
    if (has_left && has_right)
      entries.emplace_back(left_row, right_row, h), entries.emplace_back(right_row, left_row, h);
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd bend = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
  for (int i = 0; i < count; ++i) {
    const auto point = static_cast<std::size_t>(first + i);
    bend_[point].left = bend[i];
    if (point > 0) bend_[point - 1].right = bend[i];
  }
  if (periodic) bend_[x_.size() - 2].right = bend_.front().left;
}

namespace {
struct Secant {
  double width, slope;
};
/// Slope at a point between two intervals.
double monotone_slope(const Secant& a, const Secant& b) {
  if (!(a.slope * b.slope > 0)) return 0;
  const double w_a = 2 * b.width + a.width, w_b = b.width + 2 * a.width;
  return (w_a + w_b) / (w_a / a.slope + w_b / b.slope);
}
/// Slope at the end of interval a whose neighbour is b: of the parabola through three points, where that keeps the
/// sense of a and does not overshoot.
double end_slope(const Secant& a, const Secant& b) {
  const double slope = ((2 * a.width + b.width) * a.slope - a.width * b.slope) / (a.width + b.width);
  if (!(slope * a.slope > 0)) return 0;
  if (a.slope * b.slope <= 0 && std::abs(slope) > 3 * std::abs(a.slope)) return 3 * a.slope;
  return slope;
}
}  // namespace

void PiecewiseCubic::take_monotone_slopes() {
  const std::size_t n = x_.size(), intervals = n - 1;
  if (intervals < 2) return;
  std::vector<Secant> secants;
  for (std::size_t i = 0; i < intervals; ++i)
    secants.push_back({x_[i + 1] - x_[i], (y_[i + 1] - y_[i]) / (x_[i + 1] - x_[i])});
  std::vector<double> slopes(n);
  for (std::size_t i = 1; i < intervals; ++i) slopes[i] = monotone_slope(secants[i - 1], secants[i]);
  if (ends_ == Ends::periodic) {
    slopes.front() = slopes.back() = monotone_slope(secants.back(), secants.front());
  } else {
    slopes.front() = end_slope(secants[0], secants[1]);
    slopes.back() = end_slope(secants[intervals - 1], secants[intervals - 2]);
  }
  for (std::size_t i = 0; i < intervals; ++i) {
    const double d = secants[i].slope, h = secants[i].width;
    bend_[i] = {(6 * d - 4 * slopes[i] - 2 * slopes[i + 1]) / h, (2 * slopes[i] + 4 * slopes[i + 1] - 6 * d) / h};
  }
}

void PiecewiseCubic::sum() {
  sum_.assign(x_.size(), 0.0);
  double_sum_.assign(x_.size(), 0.0);
  for (std::size_t i = 0; i + 1 < x_.size(); ++i) {
    sum_[i + 1] = sum_[i] + integral_within(i, 1);
    double_sum_[i + 1] = double_sum_[i] + sum_[i] * (x_[i + 1] - x_[i]) + double_integral_within(i, 1);
  }
}

std::size_t PiecewiseCubic::interval(double x) const {
  const auto above = std::upper_bound(x_.begin() + 1, x_.end() - 1, x);
  return static_cast<std::size_t>(above - x_.begin()) - 1;
}

PiecewiseCubic::Value PiecewiseCubic::inside(std::size_t i, double x) const {
  const double h = x_[i + 1] - x_[i], b = (x - x_[i]) / h, a = 1 - b;
  const auto [left, right] = bend_[i];
  return {a * y_[i] + b * y_[i + 1] + ((a * a - 1) * a * left + (b * b - 1) * b * right) * h * h / 6,
          (y_[i + 1] - y_[i]) / h + ((1 - 3 * a * a) * left + (3 * b * b - 1) * right) * h / 6, a * left + b * right};
}

PiecewiseCubic::Value PiecewiseCubic::at(double x) const {
  if (x_.size() == 1) return {y_[0], 0, 0};
  if (ends_ == Ends::periodic) {
    const double period = back() - front();
    x -= std::floor((x - front()) / period) * period;
  } else if (x < front() || x > back()) {
    const bool before = x < front();
    const Value end = inside(before ? 0 : x_.size() - 2, before ? front() : back());
    return {end.value + end.first * (x - (before ? front() : back())), end.first, 0};
  }
  return inside(interval(x), x);
}

/// Over the interval with b = (x - x_i) / h from 0 to 1 and a = 1 - b: the spline's four terms, integrated.
double PiecewiseCubic::integral_within(std::size_t i, double b) const {
  const double h = x_[i + 1] - x_[i], a = 1 - b;
  const double straight = y_[i] * (b - b * b / 2) + y_[i + 1] * b * b / 2;
  const double left = (1 - a * a * a * a) / 4 - (1 - a * a) / 2, right = b * b * b * b / 4 - b * b / 2;
  return h * straight + h * h * h / 6 * (left * bend_[i].left + right * bend_[i].right);
}
double PiecewiseCubic::double_integral_within(std::size_t i, double b) const {
  const double h = x_[i + 1] - x_[i], a = 1 - b, a3 = a * a * a, b3 = b * b * b;
  const double straight = y_[i] * (b * b / 2 - b3 / 6) + y_[i + 1] * b3 / 6;
  const double left = -b / 4 - (1 - a3 * a * a) / 20 + (1 - a3) / 6, right = b3 * b * b / 20 - b3 / 6;
  return h * h * straight + h * h * h * h / 6 * (left * bend_[i].left + right * bend_[i].right);
}

double PiecewiseCubic::integral(double x) const {
  if (x_.size() == 1) return 0;
  const std::size_t i = interval(x);
  return sum_[i] + integral_within(i, (x - x_[i]) / (x_[i + 1] - x_[i]));
}
double PiecewiseCubic::double_integral(double x) const {
  if (x_.size() == 1) return 0;
  const std::size_t i = interval(x);
  const double along = x - x_[i];
  return double_sum_[i] + sum_[i] * along + double_integral_within(i, along / (x_[i + 1] - x_[i]));
}

}  // namespace subsoil::mbd
