#include "apps/report/statistics.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "apps/student.hpp"

namespace subsoil::app {
namespace {

/// tau in rows, by the initial positive sequence.
double correlation_time(std::span<const double> x, double mean, double variance) {
  double tau = 1;
  const auto n = static_cast<double>(x.size());
  for (std::size_t lag = 1; lag < x.size() / 2; ++lag) {
    double sum = 0;
    for (std::size_t i = 0; i + lag < x.size(); ++i) sum += (x[i] - mean) * (x[i + lag] - mean);
    const double rho = sum / n / variance;
    if (rho <= 0) break;
    tau += 2 * rho;
  }
  return tau;
}

}  // namespace

double WindowRows::integral(std::span<const double> values) const {
  double sum = 0;
  for (std::size_t k = 0; k < weights.size(); ++k) sum += weights[k] * values[weighed + k];
  return sum;
}

double WindowRows::duration() const {
  double sum = 0;
  for (const double w : weights) sum += w;
  return sum;
}

WindowRows rows_in(std::span<const double> time, const TimeWindow& window, RowKind kind) {
  constexpr double rounding = 1e-9;  // s
  const auto first = std::lower_bound(time.begin(), time.end(), window.from - rounding);
  const auto last = std::upper_bound(time.begin(), time.end(), window.until + rounding);
  WindowRows rows{static_cast<std::size_t>(first - time.begin()), static_cast<std::size_t>(last - time.begin()), 0, {}};
  rows.end = std::max(rows.begin, rows.end);
  if (rows.count() == 0) return rows;
  rows.weighed = rows.begin > 0 ? rows.begin - 1 : 0;
  rows.weights.assign(std::min(rows.end + 1, time.size()) - rows.weighed, 0.0);
  for (std::size_t k = 0; kind != RowKind::equal && k + 1 < rows.weights.size(); ++k) {
    const double t0 = time[rows.weighed + k], t1 = time[rows.weighed + k + 1];
    const double from = std::max(t0, window.from), until = std::min(t1, window.until), inside = until - from;
    if (!(inside > 0)) continue;
    const double share = kind == RowKind::mean ? 1 : (0.5 * (from + until) - t0) / (t1 - t0);
    rows.weights[k] += (1 - share) * inside, rows.weights[k + 1] += share * inside;
  }
  if (!(rows.duration() > 0)) rows.weighed = rows.begin, rows.weights.assign(rows.count(), 1.0);
  return rows;
}

WindowStatistics statistics(std::span<const double> time, std::span<const double> values, const TimeWindow& window,
                            RowKind kind) {
  WindowStatistics out;
  const WindowRows rows = rows_in(time, window, kind);
  const std::span<const double> x = values.subspan(rows.begin, rows.count());
  out.rows = x.size();
  if (x.empty()) return out;
  const auto n = static_cast<double>(x.size());
  out.least = out.largest = x[0];
  out.least_time = out.largest_time = time[rows.begin];
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (x[i] < out.least) out.least = x[i], out.least_time = time[rows.begin + i];
    if (x[i] > out.largest) out.largest = x[i], out.largest_time = time[rows.begin + i];
  }
  out.mean = rows.integral(values) / rows.duration();
  std::vector<double> squares(values.begin(), values.end());
  for (double& v : squares) v = (v - out.mean) * (v - out.mean);
  const double variance = rows.integral(squares) / rows.duration();
  const double of_sample = x.size() > 1 ? n / (n - 1) : 0;
  out.deviation = std::sqrt(kind == RowKind::equal ? variance * of_sample : variance);
  if (variance <= 1e-24 * out.mean * out.mean) {  // a constant
    out.half_width = x.size() > 1 ? 0 : out.half_width;
    return out;
  }
  const double independent = n / correlation_time(x, out.mean, variance);
  if (independent >= 2) out.half_width = student_t(independent - 1) * std::sqrt(variance * of_sample / independent);
  return out;
}

namespace {

/// Mean, trend and a sine of k periods by least squares: y ~ a + b u + c cos(phi) + d sin(phi), u in [-1/2, 1/2],
/// phi = 2 pi k u.
struct SineFit {
  double amplitude = 0, left = 0;  ///< of the sine; sum of squares that is left
};
SineFit fit_sine(std::span<const double> y, double k) {
  const auto n = static_cast<double>(y.size());
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double squares = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double u = (static_cast<double>(i) + 0.5) / n - 0.5, phase = 2 * std::numbers::pi * k * u;
    const Eigen::Vector4d row{1, u, std::cos(phase), std::sin(phase)};
    normal.noalias() += row * row.transpose();
    right += y[i] * row, squares += y[i] * y[i];
  }
  const Eigen::Vector4d x = normal.ldlt().solve(right);
  return {std::hypot(x[2], x[3]), squares - x.dot(right)};
}

}  // namespace

SpectralLine strongest_line(std::span<const double> time, std::span<const double> values, const TimeWindow& window) {
  SpectralLine line;
  const WindowRows rows = rows_in(time, window, RowKind::equal);
  const std::size_t n = rows.count();
  if (n < 16) return line;
  // Trend by least squares over the row number.
  const double middle = 0.5 * static_cast<double>(n - 1);
  double mean = 0, slope = 0, weight = 0;
  for (std::size_t i = 0; i < n; ++i) mean += values[rows.begin + i] / static_cast<double>(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double u = static_cast<double>(i) - middle;
    slope += u * values[rows.begin + i], weight += u * u;
  }
  slope /= weight;
  std::vector<double> x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = values[rows.begin + i] - mean - slope * (static_cast<double>(i) - middle);
  const double length = (time[rows.end - 1] - time[rows.begin]) * static_cast<double>(n) / static_cast<double>(n - 1);
  const std::size_t highest = std::min<std::size_t>(n / 2, 400);  // above 400 lines nothing of a machine is found
  double periods = 0, strongest = 0;                              // of the record
  for (std::size_t k = 2; k <= highest; ++k) {
    const std::complex<double> turn =
        std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n));
    std::complex<double> sum = 0, phase = 1;
    for (const double v : x) sum += v * phase, phase *= turn;
    const double amplitude = 2 * std::abs(sum) / static_cast<double>(n);
    if (amplitude > strongest) periods = static_cast<double>(k), strongest = amplitude;
  }
  if (!(strongest > 0)) return line;
  const auto left = [&](double k) { return fit_sine(x, k).left; };
  const double k = boost::math::tools::brent_find_minima(left, std::max(1.5, periods - 1), periods + 1, 26).first;
  return {length / k, fit_sine(x, k).amplitude};
}

}  // namespace subsoil::app
