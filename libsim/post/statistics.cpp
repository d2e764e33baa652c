#include "libsim/post/statistics.hpp"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "libmbd/base/dense.hpp"
#include "libsim/io/block_mean.hpp"

namespace subsoil::sim {
namespace {

double widest_gap(std::span<const double> time) {
  double widest = 0;
  for (std::size_t i = 1; i < time.size(); ++i) widest = std::max(widest, time[i] - time[i - 1]);
  return widest;
}

/// Half width of the interval of the mean of what lies in the window.
double half_width_in(std::span<const double> time, std::span<const double> x, const TimeWindow& window, RowKind kind,
                     const WindowRows& rows) {
  BlockMean mean;
  if (kind == RowKind::equal) {
    for (std::size_t i = rows.begin; i < rows.end; ++i)
      if (!std::isnan(x[i])) mean.add(1, x[i]);
    return mean.interval();
  }
  for (std::size_t i = rows.weighed; i + 1 < rows.weighed + rows.weights.size(); ++i) {
    const double from = std::max(time[i], window.from), until = std::min(time[i + 1], window.until);
    if (!(until > from)) continue;
    if (std::isnan(x[i + 1]) || (kind == RowKind::instant && std::isnan(x[i]))) continue;
    const double share = (0.5 * (from + until) - time[i]) / (time[i + 1] - time[i]);
    mean.add(until - from, kind == RowKind::mean ? x[i + 1] : x[i] + share * (x[i + 1] - x[i]));
  }
  return mean.interval();
}

}  // namespace

double WindowRows::integral(std::span<const double> values) const {
  double sum = 0;
  for (std::size_t k = 0; k < weights.size(); ++k)
    if (weights[k] != 0) sum += weights[k] * values[weighed + k];
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
  WindowRows rows = rows_in(time, window, kind);
  for (std::size_t k = 0; k < rows.weights.size(); ++k)
    if (std::isnan(values[rows.weighed + k])) rows.weights[k] = 0;
  if (!(rows.duration() > 0)) {
    rows.weighed = rows.begin, rows.weights.clear();
    for (std::size_t i = rows.begin; i < rows.end; ++i) rows.weights.push_back(std::isnan(values[i]) ? 0 : 1);
  }
  const std::span<const double> x = values.subspan(rows.begin, rows.count());
  out.rows = static_cast<std::size_t>(std::count_if(x.begin(), x.end(), [](double v) { return !std::isnan(v); }));
  if (out.rows == 0) return out;
  // A mean is of the time before its row: that of a row at the window's begin lies outside.
  std::size_t first = kind == RowKind::mean && x.size() > 1 && time[rows.begin] <= window.from ? 1 : 0;
  while (first < x.size() && std::isnan(x[first])) ++first;
  if (first == x.size()) first = 0;  // the only value stands at the begin
  out.least = out.largest = x[first];
  out.least_time = out.largest_time = time[rows.begin + first];
  for (std::size_t i = first; i < x.size(); ++i) {
    if (x[i] < out.least) out.least = x[i], out.least_time = time[rows.begin + i];
    if (x[i] > out.largest) out.largest = x[i], out.largest_time = time[rows.begin + i];
  }
  out.mean = rows.integral(values) / rows.duration();
  std::vector<double> squares(values.begin(), values.end());
  for (double& v : squares) v = (v - out.mean) * (v - out.mean);
  const double variance = rows.integral(squares) / rows.duration();
  const auto n = static_cast<double>(out.rows);
  out.deviation = std::sqrt(kind == RowKind::equal && n > 1 ? variance * n / (n - 1) : variance);
  const bool constant = variance <= 1e-24 * out.mean * out.mean;
  out.half_width = constant && out.rows > 1 ? 0 : half_width_in(time, values, window, kind, rows);
  return out;
}

namespace {

/// The rows of a window: where in it, u in [-1/2, 1/2], their values, and the share of it that each stands for.
struct Samples {
  std::vector<double> u, values, shares;
  double length = 0;  ///< of the window, s
  double widest = 0;  ///< gap, s
};
Samples samples_in(std::span<const double> time, std::span<const double> values, const TimeWindow& window,
                   RowKind kind) {
  const WindowRows rows = rows_in(time, window, kind);
  const bool means = kind == RowKind::mean;
  Samples out;
  std::vector<double> t;
  for (std::size_t i = means ? std::max<std::size_t>(rows.begin, 1) : rows.begin; i < rows.end; ++i) {
    if (std::isnan(values[i])) continue;
    t.push_back(means ? 0.5 * (time[i - 1] + time[i]) : time[i]);
    out.values.push_back(values[i]);
  }
  if (t.size() < 2) return out;
  out.widest = widest_gap(t);
  // Half of the gap to either neighbour; the first and the last row stand for as much outside as inside.
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double before = i > 0 ? t[i] - t[i - 1] : t[1] - t[0];
    const double after = i + 1 < t.size() ? t[i + 1] - t[i] : before;
    out.shares.push_back(0.5 * (before + after));
    out.length += out.shares.back();
  }
  for (double& share : out.shares) share /= out.length;
  for (const double at : t) out.u.push_back((at - 0.5 * (t.front() + t.back())) / out.length);
  return out;
}

void take_trend_off(Samples& s) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < s.u.size(); ++i) {
    const Eigen::Vector2d row{1, s.u[i]};
    normal.noalias() += s.shares[i] * row * row.transpose();
    right += s.shares[i] * s.values[i] * row;
  }
  const Eigen::Vector2d x = mbd::solve(normal, right);
  for (std::size_t i = 0; i < s.u.size(); ++i) s.values[i] -= x[0] + x[1] * s.u[i];
}

/// Mean, trend and a sine of k periods by least squares: y ~ a + b u + c cos(phi) + d sin(phi), phi = 2 pi k u.
struct SineFit {
  double amplitude = 0, left = 0;  ///< of the sine; mean square that is left
};
SineFit fit_sine(const Samples& s, double k) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double squares = 0;
  for (std::size_t i = 0; i < s.u.size(); ++i) {
    const double phase = 2 * std::numbers::pi * k * s.u[i], y = s.values[i];
    const Eigen::Vector4d row{1, s.u[i], std::cos(phase), std::sin(phase)};
    normal.noalias() += s.shares[i] * row * row.transpose();
    right += s.shares[i] * y * row, squares += s.shares[i] * y * y;
  }
  const Eigen::Vector4d x = mbd::solve(normal, right);
  return {std::hypot(x[2], x[3]), squares - x.dot(right)};
}

/// Of 2, 2 1/4, 2 1/2, ... periods: a sine between two of them keeps 97 % of its amplitude or more.
constexpr double line_spacing = 0.25;

struct FourierLine {
  double periods = 0, amplitude = 0;
};
std::vector<FourierLine> spectrum(const Samples& s, double highest) {
  using Complex = std::complex<double>;
  std::vector<Complex> turns, terms;  // exp(-2 pi i u line_spacing), and share x value x its powers
  for (std::size_t i = 0; i < s.u.size(); ++i) {
    turns.push_back(std::polar(1.0, -2 * std::numbers::pi * line_spacing * s.u[i]));
    terms.push_back(s.shares[i] * s.values[i] * std::polar(1.0, -2 * std::numbers::pi * (2 - line_spacing) * s.u[i]));
  }
  std::vector<FourierLine> lines;
  for (std::size_t n = 0; 2 + line_spacing * static_cast<double>(n) <= highest; ++n) {
    Complex sum = 0;
    for (std::size_t i = 0; i < terms.size(); ++i) sum += terms[i] *= turns[i];
    lines.push_back({2 + line_spacing * static_cast<double>(n), 2 * std::abs(sum)});
  }
  return lines;
}

/// Peaks of a spectrum that a fit of their sines may find to be the strongest: neighbours and the trend add to a peak
/// or take from it.
std::vector<FourierLine> peaks_of(const std::vector<FourierLine>& lines, double largest) {
  constexpr double share = 0.7;
  std::vector<FourierLine> peaks;
  for (std::size_t n = 0; n < lines.size(); ++n) {
    const double here = lines[n].amplitude;
    const bool falls =
        (n == 0 || here >= lines[n - 1].amplitude) && (n + 1 == lines.size() || here > lines[n + 1].amplitude);
    if (falls && here >= share * largest) peaks.push_back(lines[n]);
  }
  return peaks;
}

}  // namespace

SpectralLine strongest_line(std::span<const double> time, std::span<const double> values, const TimeWindow& window,
                            RowKind kind) {
  Samples s = samples_in(time, values, window, kind);
  if (s.values.size() < 16 || !(s.widest > 0)) return {};
  double largest = 0;
  for (const double v : s.values) largest = std::max(largest, std::abs(v));
  take_trend_off(s);
  constexpr double most = 400;  // above 400 periods nothing of a machine is found
  constexpr double rounding = 1e-6;
  const double highest = std::min(most, 0.5 * s.length / s.widest + rounding);
  const std::vector<FourierLine> lines = spectrum(s, highest);
  double amplitude = 0;
  for (const FourierLine& line : lines) amplitude = std::max(amplitude, line.amplitude);
  if (!(amplitude > std::max(1e-12 * largest, std::numeric_limits<double>::epsilon()))) return {};
  const auto left = [&](double k) { return fit_sine(s, k).left; };
  double best = std::numeric_limits<double>::infinity(), periods = 0;
  for (const FourierLine& peak : peaks_of(lines, amplitude)) {
    const auto [k, rest] = boost::math::tools::brent_find_minima(left, peak.periods - line_spacing,
                                                                 std::min(highest, peak.periods + line_spacing), 26);
    // Nearer to the end of the search than rounding of a sine there: it falls on towards a longer period.
    if (k > 2 * (1 - 1e-3) && rest < best) best = rest, periods = k;
  }
  if (periods == 0) return {};
  return {s.length / periods, fit_sine(s, periods).amplitude};
}

}  // namespace subsoil::sim
