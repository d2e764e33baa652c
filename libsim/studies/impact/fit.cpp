#include "libsim/studies/impact/fit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unsupported/Eigen/NonLinearOptimization>

#include "libmbd/base/dense.hpp"
#include "libsim/studies/impact/intervals.hpp"
#include "libsim/studies/impact/measured.hpp"

namespace subsoil::sim {
namespace {

using dem::impact::Event;
using dem::impact::Pair;

constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();
constexpr double apart = 1e7;  ///< condition of the scaled Jacobian beyond which parameters cannot be told apart

/// A column of measurements: its name, dimension, and what the model says of it.
struct FitColumn {
  const char* name;
  const char* unit;
  double Measured::*value;
  double (*of)(const Event&);
};
constexpr std::array<FitColumn, 5> columns{{
    {"speed", "m/s", &Measured::speed, nullptr},
    {"restitution", "1", &Measured::restitution, [](const Event& e) { return e.restitution; }},
    {"peak force", "N", &Measured::peak_force, [](const Event& e) { return e.peak_force; }},
    {"indentation", "m", &Measured::indentation, [](const Event& e) { return e.largest; }},
    {"duration", "s", &Measured::duration, [](const Event& e) { return e.duration(); }},
}};

bool is_measured(const Measured& m, const FitColumn& c) { return c.of != nullptr && std::isfinite(m.*c.value); }
/// Forces, indentations or durations: they tell of the spring, restitution alone does not.
bool tells_of_the_spring(const std::vector<Measured>& data) {
  return std::any_of(data.begin(), data.end(), [](const Measured& m) {
    return std::isfinite(m.peak_force) || std::isfinite(m.indentation) || std::isfinite(m.duration);
  });
}

/// A parameter of a model that a fit may move.
struct Knob {
  std::string name, unit;
  double* value;
  bool positive = true;  ///< fitted by its logarithm
  bool usual = true;     ///< free when nothing is said
};

/// Knobs of each model, with a first guess where the study leaves one out.
std::vector<Knob> knobs(dem::impact::HuntCrossleyModel& m, const Pair& pair, const std::vector<Measured>& data) {
  const bool spring = tells_of_the_spring(data);
  m.b = std::isnan(m.b) && !std::isnan(m.restitution) ? m.completed().b : m.b;
  m.restitution = m.at_speed = not_measured;
  for (const Measured& d : data)
    if (std::isnan(m.b) && d.restitution > 0 && d.restitution < 1)
      m.b = dem::impact::hunt_crossley_nu(d.restitution) / d.speed;
  if (std::isnan(m.b)) m.b = 0.1 / data.front().speed;
  for (const Measured& d : data) {
    if (!std::isnan(m.c) || pair.E_eff > 0) break;
    // Elastic estimates from whatever is there: F x = (n+1) E, x = E (n+1)/F, and for n = 3/2 T = 2.94 x/V.
    const double energy = (m.n + 1) * 0.5 * pair.mass * d.speed * d.speed;
    const double x = std::isfinite(d.indentation)  ? d.indentation
                     : std::isfinite(d.peak_force) ? energy / d.peak_force
                                                   : d.duration * d.speed / 2.94;
    if (std::isfinite(x)) m.c = energy / std::pow(x, m.n + 1);
  }
  if (std::isnan(m.c)) m.c = pair.E_eff > 0 ? pair.hertz() : 1e6;  // restitution does not depend on it
  return {{"b", "s/m", &m.b}, {"c", "N/m^n", &m.c, true, spring}, {"n", "1", &m.n, false, spring}};
}
std::vector<Knob> knobs(dem::impact::Hertz&, const Pair&, const std::vector<Measured>&) { return {}; }
std::vector<Knob> knobs(dem::impact::EnergyEquivalent& m, const Pair& pair, const std::vector<Measured>&) {
  m.lambda_c = m.critical_lambda(pair);
  return {{"A", "1", &m.A}, {"B", "1", &m.B}, {"lambda_c", "1", &m.lambda_c, true, false}};
}
std::vector<Knob> knobs(GroundImpact&, const Pair&, const std::vector<Measured>&) { return {}; }
/// K1 and the restitution; forces, indentations and durations tell K1.
std::vector<Knob> knobs(dem::impact::Hysteretic& m, const Pair& pair, const std::vector<Measured>& data) {
  const bool spring = tells_of_the_spring(data);
  m.restitution = std::isnan(m.K2) ? m.restitution : m.restitution_at(pair, 1);
  if (std::isnan(m.K1) && std::isnan(m.S_y) && std::isnan(pair.yield) && spring)
    for (const Measured& d : data) {
      const double root = std::isfinite(d.indentation)  ? d.speed / d.indentation
                          : std::isfinite(d.peak_force) ? d.peak_force / (pair.mass * d.speed)
                                                        : 2.5 / d.duration;  // (pi/2) (1 + e), e about 0.6
      if (std::isfinite(root)) m.K1 = pair.mass * root * root;
    }
  m.K1 = m.loading(pair);
  m.S_y = m.K2 = not_measured;
  return {{"restitution", "1", &m.restitution}, {"K1", "N/m", &m.K1, true, spring}};
}
std::vector<Knob> knobs(dem::impact::Thornton& m, const Pair&, const std::vector<Measured>&) {
  return {{"p_y", "Pa", &m.p_y}};
}
std::vector<Knob> knobs(dem::impact::JacksonGreen& m, const Pair& pair, const std::vector<Measured>&) {
  m.S_y = m.strength(pair);
  return {{"S_y", "Pa", &m.S_y}};
}
std::vector<Knob> knobs(dem::impact::Jkr& m, const Pair&, const std::vector<Measured>&) {
  return {{"w", "J/m^2", &m.w}};
}

std::vector<Knob> chosen(const std::vector<Knob>& all, const std::vector<std::string>& free) {
  std::vector<Knob> out;
  std::vector<std::string> names;
  for (const Knob& k : all) names.push_back(k.name);
  for (const std::string& name : free)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw std::invalid_argument(
          fmt::format("`{}` is no parameter that a fit of this model can move{}", name, suggestion(name, names)));
  for (const Knob& k : all)
    if (free.empty() ? k.usual : std::find(free.begin(), free.end(), k.name) != free.end()) out.push_back(k);
  if (out.empty()) throw std::invalid_argument("this model has nothing to fit");
  return out;
}

/// Relative residuals of a model over the data, as Eigen's solver takes them.
struct Residuals {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  const ImpactModel& model;
  const Pair& pair;
  const std::vector<Measured>& data;
  const std::vector<Knob>& knobs_free;
  Eigen::Index count = 0;

  int inputs() const { return static_cast<int>(knobs_free.size()); }
  int values() const { return static_cast<int>(count); }

  void set(const Eigen::VectorXd& p) const {
    for (std::size_t k = 0; k < knobs_free.size(); ++k) {
      const double value = p[static_cast<Eigen::Index>(k)];
      *knobs_free[k].value = knobs_free[k].positive ? std::exp(value) : value;
    }
  }
  Eigen::VectorXd start() const {
    Eigen::VectorXd p(inputs());
    for (std::size_t k = 0; k < knobs_free.size(); ++k) {
      const double value = *knobs_free[k].value;
      p[static_cast<Eigen::Index>(k)] = knobs_free[k].positive ? std::log(value) : value;
    }
    return p;
  }

  int operator()(const Eigen::VectorXd& p, Eigen::VectorXd& r) const {
    set(p);
    Eigen::Index i = 0;
    for (const Measured& m : data) {
      const bool course =
          std::any_of(columns.begin() + 2, columns.end(), [&](const FitColumn& c) { return is_measured(m, c); });
      Event event;
      // The course itself costs a thousand times its restitution.
      if (course) event = std::visit([&](const auto& law) { return law.strike(pair, m.speed, 24); }, model);
      event.restitution = std::visit([&](const auto& law) { return law.restitution_at(pair, m.speed); }, model);
      for (const FitColumn& c : columns)
        if (is_measured(m, c)) r[i++] = c.of(event) / (m.*c.value) - 1;
    }
    return 0;
  }
  /// Central differences; parameters are logarithms or of the size of 1.
  int df(const Eigen::VectorXd& p, Eigen::MatrixXd& jacobian) const {
    Eigen::VectorXd above(count), below(count), at = p;
    for (Eigen::Index k = 0; k < p.size(); ++k) {
      constexpr double h = 1e-5;
      at[k] = p[k] + h, (*this)(at, above);
      at[k] = p[k] - h, (*this)(at, below);
      at[k] = p[k];
      jacobian.col(k) = (above - below) / (2 * h);
    }
    return 0;
  }
};

/// Refuses data in which a combination of parameters leaves no trace.
void refuse_unidentifiable(const Eigen::MatrixXd& jacobian, const std::vector<Knob>& knobs_free) {
  Eigen::MatrixXd scaled = jacobian;
  std::vector<std::string> dead;
  for (Eigen::Index k = 0; k < scaled.cols(); ++k) {
    const double size = scaled.col(k).norm();
    if (size < 1e-9) dead.push_back(knobs_free[static_cast<std::size_t>(k)].name);
    if (size > 0) scaled.col(k) /= size;
  }
  if (!dead.empty())
    throw std::invalid_argument(fmt::format(
        "the data do not depend on {}: measure what it changes, or leave it out of --free", fmt::join(dead, " and ")));
  const auto [sizes, left, right] = mbd::singular_values(scaled);
  if (jacobian.rows() >= jacobian.cols() && sizes[0] <= apart * sizes[sizes.size() - 1]) return;
  std::vector<std::string> mixed;
  for (Eigen::Index k = 0; k < scaled.cols(); ++k)
    if (jacobian.rows() < jacobian.cols() || std::abs(right(k, scaled.cols() - 1)) > 0.1)
      mixed.push_back(knobs_free[static_cast<std::size_t>(k)].name);
  throw std::invalid_argument(
      fmt::format("the data cannot tell {} apart: add speeds or measured columns, or free fewer "
                  "by --free",
                  fmt::join(mixed, " and ")));
}

}  // namespace

std::vector<Measured> read_measured(const std::filesystem::path& file) {
  std::vector<MeasuredColumn> wanted;
  for (const FitColumn& c : columns) wanted.push_back({c.name, c.unit});
  const MeasuredTable table = read_measured_table(file, wanted);
  std::vector<Measured> data;
  for (std::size_t row = 0; row < table.values.size(); ++row) {
    Measured m{not_measured, not_measured, not_measured, not_measured, not_measured};
    for (std::size_t k = 0; k < columns.size(); ++k) m.*columns[k].value = table.values[row][k];
    const auto refuse = [&](const char* rule) {
      throw ScenarioError(fmt::format("{}:{}: {}", file.string(), table.lines[row], rule));
    };
    if (std::isnan(m.speed)) refuse("the speed is missing");
    if (m.restitution > 1) refuse("restitution must not be above 1");
    if (std::none_of(columns.begin(), columns.end(), [&](const FitColumn& c) { return is_measured(m, c); }))
      refuse("holds nothing beside the speed: needs restitution, peak force, indentation or duration");
    data.push_back(m);
  }
  return data;
}

std::vector<Measured> measured_of(const LoadedStudy& loaded) {
  const ImpactStudy& s = loaded.study;
  if (s.speeds.empty()) throw ScenarioError(loaded.where("speeds") + ": is missing: speeds at which to take the law");
  std::vector<Measured> data;
  try {
    for (const double speed : s.speeds) {
      const double e = std::visit([&](const auto& m) { return m.restitution_at(pair_of(s), speed); }, s.fit_to->model);
      data.push_back({speed, e, not_measured, not_measured, not_measured});
    }
  } catch (const std::invalid_argument& error) {
    throw ScenarioError(loaded.where("fit to") + ": " + error.what());
  }
  return data;
}

ImpactFit fit_impact(const LoadedStudy& loaded, const std::vector<Measured>& data,
                     const std::vector<std::string>& free) {
  ImpactFit fit;
  fit.model = loaded.study.model;
  const Pair pair = pair_of(loaded.study);
  try {
    const std::vector<Knob> moved = chosen(std::visit([&](auto& m) { return knobs(m, pair, data); }, fit.model), free);
    Residuals residuals{fit.model, pair, data, moved};
    for (const Measured& m : data)
      residuals.count +=
          std::count_if(columns.begin(), columns.end(), [&](const FitColumn& c) { return is_measured(m, c); });
    Eigen::VectorXd p = residuals.start();
    Eigen::MatrixXd jacobian(residuals.count, p.size());
    residuals.df(p, jacobian);
    refuse_unidentifiable(jacobian, moved);
    Eigen::LevenbergMarquardt<Residuals> solver(residuals);
    solver.parameters.xtol = solver.parameters.ftol = 1e-14;
    solver.minimize(p);
    Eigen::VectorXd r(residuals.count);
    residuals(p, r);
    residuals.df(p, jacobian);
    refuse_unidentifiable(jacobian, moved);
    residuals.set(p);
    std::vector<FitName> names;
    for (const Knob& k : moved) names.push_back({k.name, k.unit, k.positive});
    add_intervals(fit, jacobian, p, r, names);
  } catch (const std::invalid_argument& error) {
    throw ScenarioError(loaded.where("model") + ": " + error.what());
  }
  return fit;
}

std::string fit_text(const ImpactFit& fit) {
  std::string text = fmt::format("fit to {} values: {:.3g} % spread of residuals, {:.3g} % at most\n", fit.points,
                                 100 * fit.spread, 100 * fit.worst);
  for (const FittedParameter& p : fit.parameters) {
    text += fmt::format("{:<10} {:>14.8g} {:<6}", p.name, p.value, p.unit == "1" ? "" : p.unit);
    text += std::isnan(p.low)
                ? "  no interval: as many parameters as values\n"
                : fmt::format("  {:.0f} % interval {:.6g} ... {:.6g}\n", 100 * fit.confidence, p.low, p.high);
  }
  return text;
}

}  // namespace subsoil::sim
