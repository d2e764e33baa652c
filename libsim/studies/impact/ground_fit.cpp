#include "libsim/studies/impact/ground_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmbd/base/dense.hpp"
#include "libsim/studies/impact/intervals.hpp"
#include "libsim/studies/impact/measured.hpp"

namespace subsoil::sim {
namespace {

struct Point {
  double v, z, m, K;
};

std::vector<Point> points_of(const std::filesystem::path& file, double striker, const GroundImpact& model) {
  const MeasuredTable table =
      read_measured_table(file, {{"speed", "m/s"}, {"depth", "m"}, {"force", "N"}, {"mass", "kg"}});
  std::vector<Point> points;
  for (std::size_t row = 0; row < table.values.size(); ++row) {
    const std::vector<double>& r = table.values[row];
    const auto refuse = [&](const std::string& rule) {
      throw ScenarioError(fmt::format("{}:{}: {}", file.string(), table.lines[row], rule));
    };
    if (std::isnan(r[0]) || std::isnan(r[1]) || std::isnan(r[2])) refuse("needs speed, depth and force");
    const double m = std::isnan(r[3]) ? striker : r[3];
    const double spring = r[2] * (1 + model.share) - model.share * m * model.gravity;
    if (!(spring > 0)) refuse("the force is below what carries the follower: no K' follows from it");
    points.push_back({r[0], r[1], m, spring / r[1]});
  }
  return points;
}

/// One regressor: its name, the exponent it finds, and its value at a point.
struct Regressor {
  const char* name;
  double* exponent;
  std::function<double(const Point&)> of;
};

}  // namespace

ImpactFit fit_ground(const LoadedStudy& loaded, const std::filesystem::path& file) {
  ImpactFit fit;
  fit.model = loaded.study.model;
  GroundImpact& model = std::get<GroundImpact>(fit.model);
  auto* law = std::get_if<mbd::PowerStiffness>(&model.stiffness);
  if (law == nullptr)
    throw ScenarioError(loaded.where("stiffness") +
                        ": a fit finds the powers of stiffness: {power: ...}; use that form");
  const std::vector<Point> points = points_of(file, pair_of(loaded.study).mass, model);

  const double z1 = law->z1;
  std::vector<Regressor> regressors{
      {"alpha", &law->alpha, [=](const Point& p) { return std::log(std::min(p.z, z1) / law->z0); }},
      {"alpha_1", &law->alpha_1, [=](const Point& p) { return p.z > z1 ? std::log(p.z / z1) : 0.0; }},
      {"beta", &law->beta, [=](const Point& p) { return std::log(p.v / law->v0); }},
      {"gamma", &law->gamma, [=](const Point& p) { return std::log(p.m / law->m0); }}};
  // What the data do not vary cannot be found: it stays, and its part is taken off before.
  const auto varies = [&](const Regressor& r) {
    return std::any_of(points.begin(), points.end(),
                       [&](const Point& p) { return std::abs(r.of(p) - r.of(points[0])) > 1e-9; });
  };
  const auto fixed = std::stable_partition(regressors.begin(), regressors.end(), varies);
  const auto rows = static_cast<Eigen::Index>(points.size());
  const auto columns = static_cast<Eigen::Index>(fixed - regressors.begin()) + 1;
  if (rows < columns)
    throw ScenarioError(
        fmt::format("{}: {} points cannot tell {} parameters; measure more", file.string(), rows, columns));
  Eigen::MatrixXd a(rows, columns);
  Eigen::VectorXd y(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Point& p = points[static_cast<std::size_t>(i)];
    a(i, 0) = 1, y[i] = std::log(p.K);
    for (auto r = fixed; r != regressors.end(); ++r) y[i] -= *r->exponent * r->of(p);
    for (Eigen::Index k = 1; k < columns; ++k) a(i, k) = regressors[static_cast<std::size_t>(k - 1)].of(p);
  }
  const auto [p, rank] = mbd::least_squares(a, y);
  if (rank < columns)
    throw ScenarioError(file.string() +
                        ": depth, speed and mass change together here, so their powers cannot be told "
                        "apart; measure one depth at several speeds");
  const Eigen::VectorXd residual = a * p - y;
  law->K0 = std::exp(p[0]);
  for (Eigen::Index k = 1; k < columns; ++k) *regressors[static_cast<std::size_t>(k - 1)].exponent = p[k];
  std::vector<FitName> names{{"K0", "N/m", true}};
  for (auto r = regressors.begin(); r != fixed; ++r) names.push_back({r->name, "1", false});
  add_intervals(fit, a, p, residual, names);
  return fit;
}

}  // namespace subsoil::sim
