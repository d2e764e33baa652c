#include "libsim/studies/sweep/effects.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "libmbd/base/dense.hpp"
#include "libsim/base/replicates.hpp"
#include "libsim/post/statistics.hpp"

namespace subsoil::sim {
namespace {

constexpr double no_interval = std::numeric_limits<double>::quiet_NaN();

/// Points that gave this number.
std::vector<std::size_t> finished(const std::vector<PointResult>& results, std::size_t number) {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < results.size(); ++k)
    if (results[k].end == PointResult::End::reached && std::isfinite(results[k].value[number])) out.push_back(k);
  return out;
}

std::vector<LevelMean> levels(const Study& study, const std::vector<PointResult>& results,
                              const std::vector<std::size_t>& points, std::size_t parameter, std::size_t number) {
  std::vector<LevelMean> out;
  std::vector<std::vector<double>> values;
  for (const std::size_t k : points) {
    const std::string& value = study.points[k].values[parameter];
    auto at = std::find_if(out.begin(), out.end(), [&](const LevelMean& l) { return l.value == value; });
    if (at == out.end()) {
      out.push_back({value, study.points[k].places[parameter]});
      values.emplace_back();
      at = out.end() - 1;
    }
    values[static_cast<std::size_t>(at - out.begin())].push_back(results[k].value[number]);
  }
  if (out.size() == points.size() && points.size() > 8) return {};  // a Latin hypercube: no two share a value
  for (std::size_t l = 0; l < out.size(); ++l) {
    const Replicates over(values[l]);
    out[l].count = over.count, out[l].mean = over.mean, out[l].half_width = over.half_width();
  }
  return out;
}

/// The numeric parameters that vary, and the plane through the points.
struct Plane {
  std::vector<std::size_t> parameters;
  Eigen::VectorXd slope, half;
};

Plane plane(const Study& study, const std::vector<PointResult>& results, const std::vector<std::size_t>& points,
            std::size_t number) {
  Plane out;
  std::vector<std::pair<double, double>> range;
  for (std::size_t p = 0; p < study.parameters.size(); ++p) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    bool numeric = p != study.packings;
    for (const std::size_t k : points) {
      const double v = study.points[k].places[p];
      numeric = numeric && std::isfinite(v);
      low = std::min(low, v), high = std::max(high, v);
    }
    if (numeric && high > low) out.parameters.push_back(p), range.emplace_back(low, high);
  }
  const auto n = static_cast<Eigen::Index>(points.size()), m = static_cast<Eigen::Index>(out.parameters.size()) + 1;
  if (m < 2 || n <= m) return {};
  Eigen::MatrixXd x(n, m);
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t k = points[static_cast<std::size_t>(i)];
    x(i, 0) = 1, y[i] = results[k].value[number];
    for (Eigen::Index j = 1; j < m; ++j) {
      const auto& [low, high] = range[static_cast<std::size_t>(j - 1)];
      x(i, j) = (study.points[k].places[out.parameters[static_cast<std::size_t>(j - 1)]] - low) / (high - low);
    }
  }
  const auto [b, rank] = mbd::least_squares(x, y);
  if (rank < m) return {};
  const double variance = (y - x * b).squaredNorm() / static_cast<double>(n - m);
  const Eigen::MatrixXd inverse = mbd::inverse_of_square(x);
  out.slope = b.tail(m - 1);
  out.half = (student_t(static_cast<double>(n - m)) * (variance * inverse.diagonal()).array().sqrt()).tail(m - 1);
  return out;
}

}  // namespace

std::optional<Scatter> scatter(const Study& study, const std::vector<PointResult>& results, std::size_t number) {
  if (!study.packings) return {};
  std::map<std::vector<std::string>, std::vector<double>> settings;
  for (const std::size_t k : finished(results, number)) {
    std::vector<std::string> others = study.points[k].values;
    others[*study.packings].clear();
    settings[others].push_back(results[k].value[number]);
  }
  Scatter out;
  double squares = 0;
  for (const auto& [others, values] : settings) {
    const Replicates over(values);
    out.mean = over.mean, squares += over.squares;
    out.packings += over.count, ++out.settings;
  }
  if (out.packings < out.settings + 1) return {};
  const auto free = static_cast<double>(out.packings - out.settings);
  out.deviation = std::sqrt(squares / free);
  out.half_width = student_t(free) * out.deviation / std::sqrt(free + 1);
  if (out.settings > 1) out.mean = out.half_width = no_interval;
  return out;
}

std::vector<Effect> effects(const Study& study, const std::vector<PointResult>& results) {
  std::vector<Effect> out;
  for (std::size_t number = 0; number < study.numbers.size(); ++number) {
    const std::vector<std::size_t> points = finished(results, number);
    if (points.empty()) continue;
    const Plane fit = plane(study, results, points, number);
    for (std::size_t p = 0; p < study.parameters.size(); ++p) {
      Effect e{p, number, levels(study, results, points, p, number), no_interval, no_interval};
      const auto found = std::find(fit.parameters.begin(), fit.parameters.end(), p);
      if (found != fit.parameters.end()) {
        e.slope = fit.slope[found - fit.parameters.begin()];
        e.slope_half = fit.half[found - fit.parameters.begin()];
      }
      out.push_back(std::move(e));
    }
  }
  return out;
}

std::optional<std::size_t> best_point(const std::vector<PointResult>& results, std::size_t number, bool largest) {
  std::optional<std::size_t> best;
  for (const std::size_t k : finished(results, number)) {
    const double v = results[k].value[number];
    if (!best || (largest ? v > results[*best].value[number] : v < results[*best].value[number])) best = k;
  }
  return best;
}

}  // namespace subsoil::sim
