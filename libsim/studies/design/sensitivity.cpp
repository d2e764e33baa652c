#include "libsim/studies/design/sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmbd/base/dense.hpp"
#include "libsim/base/replicates.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/keys/ranges.hpp"
#include "libsim/studies/sweep/tables.hpp"

namespace subsoil::sim {
namespace {

/// Points of the base and of all steps, in a fixed order.
class Steps {
 public:
  explicit Steps(const SensitivityPlan& plan) : plan_(plan), common_(split_at_semicolons(plan.set)) {
    for (const std::string& set : without_frames(plan.scenario, common_)) common_.push_back(set);
  }

  std::vector<SweepPoint> all() const {
    std::vector<double> at;
    for (const SensitivityParameter& p : plan_.parameters) at.push_back(*p.at);
    std::vector<SweepPoint> points{point(at)};
    for (std::size_t k = 0; k < at.size(); ++k)
      for (std::size_t i = 0; i < step_count; ++i)
        for (const double side : {-1.0, 1.0}) {
          std::vector<double> moved = at;
          moved[k] += side * length(k, i);
          points.push_back(point(moved));
        }
    return points;
  }

  double length(std::size_t parameter, std::size_t i) const {
    const SensitivityParameter& p = plan_.parameters[parameter];
    return p.step * (*p.at != 0 ? std::abs(*p.at) : 1) / std::pow(step_ratio, static_cast<double>(i));
  }

 private:
  SweepPoint point(const std::vector<double>& values) const {
    SweepPoint point;
    point.sets = common_, point.places = values;
    for (std::size_t k = 0; k < values.size(); ++k) {
      const SensitivityParameter& p = plan_.parameters[k];
      const std::string text = fmt::format("{}{}{}", values[k], p.unit.empty() ? "" : " ", p.unit);
      point.values.push_back(text);
      for (const std::string& path : p.paths) point.sets.push_back(path + "=" + text);
    }
    return point;
  }

  const SensitivityPlan& plan_;
  std::vector<std::string> common_;
};

void refuse_failed(const GrowingStudy& study, const std::vector<std::size_t>& places) {
  for (const std::size_t k : places) {
    const PointResult& r = study.results()[k];
    std::string values;
    for (const std::string& v : study.study().points[k].values) values += (values.empty() ? "" : ", ") + v;
    if (r.end != PointResult::End::reached)
      throw std::runtime_error(fmt::format("the run at {} fails, so that there is no derivative: {}{}", values, r.cause,
                                           k == places.front()
                                               ? ""
                                               : "; values on both sides of `at` are run: give one farther from this "
                                                 "limit, or a smaller `step`"));
    for (std::size_t n = 0; n < r.value.size(); ++n)
      if (!std::isfinite(r.value[n]))
        throw std::runtime_error(fmt::format(
            "the run at {} gives no number `{}`: {}", values, study.study().numbers[n].name,
            study.study().numbers[n].summary.empty() ? "is its column spelt as in series.csv?"
                                                     : "is its path, names with / between, that of summary.json?"));
  }
}

/// The limit of d(h) for step 0: least squares of h d over powers of h, of which the first is 1; that list whose limit
/// has the narrowest 95 % interval.
Slope narrowest(const std::vector<double>& d, const std::vector<std::vector<int>>& lists) {
  const auto n = static_cast<Eigen::Index>(d.size());
  Eigen::VectorXd h(n);  // over the first
  for (Eigen::Index i = 0; i < n; ++i) h[i] = std::pow(step_ratio, -static_cast<double>(i));
  const Eigen::VectorXd y = h.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(d.data(), n));
  Slope best{d.front(), std::numeric_limits<double>::infinity()};
  for (const std::vector<int>& powers : lists) {
    const auto terms = static_cast<Eigen::Index>(powers.size());
    Eigen::MatrixXd x(n, terms);
    for (Eigen::Index k = 0; k < terms; ++k) x.col(k) = h.array().pow(powers[static_cast<std::size_t>(k)]);
    const Eigen::VectorXd fit = mbd::least_squares(x, y).x;
    const auto freedom = static_cast<double>(n - terms);
    const double scatter = (y - x * fit).squaredNorm() / freedom;
    const double variance = mbd::inverse_of_square(x)(0, 0);
    const double error = student_t(freedom) * std::sqrt(scatter * variance);
    if (error < best.error) best = {fit[0], error};
  }
  return best;
}

std::string unit_text(const SensitivityParameter& p) { return p.unit.empty() ? "" : "/(" + p.unit + ")"; }

}  // namespace

Slope extrapolated_slope(const std::vector<double>& differences) {
  return narrowest(differences, {{1, 3}, {1, 3, 5}, {1, 3, 5, 7}});
}

double slope_jump(const std::vector<double>& second_differences) {
  const Slope jump = narrowest(second_differences, {{1, 0, 2}, {1, 0, 2, 4}, {1, 0, 2, 3, 4}});
  constexpr double beyond_chance = 5;
  return std::abs(jump.value) > beyond_chance * jump.error ? jump.value : 0;
}

Slope slope_with_kink(const std::vector<double>& differences, const std::vector<double>& second_differences) {
  Slope slope = extrapolated_slope(differences);
  const double jump = slope_jump(second_differences);
  if (0.5 * std::abs(jump) > slope.error) slope.jump = jump, slope.error += 0.5 * std::abs(jump);
  return slope;
}

Study study_of(const SensitivityPlan& plan) {
  Study study;
  study.title = plan.title, study.scenario = plan.scenario, study.numbers = plan.numbers;
  for (const SensitivityParameter& p : plan.parameters) study.parameters.push_back(p.name);
  return study;
}

Sensitivity find_sensitivity(const SensitivityPlan& plan, GrowingStudy& study) {
  const Steps steps(plan);
  const std::vector<std::size_t> places = study.run(steps.all());
  refuse_failed(study, places);
  Sensitivity out;
  out.values = study.results()[places.front()].value;
  for (std::size_t n = 0; n < plan.numbers.size(); ++n) {
    out.units.push_back(unit_of(study.results(), n));
    out.slopes.emplace_back();
    for (std::size_t k = 0; k < plan.parameters.size(); ++k) {
      std::vector<double> differences, second;
      for (std::size_t i = 0; i < step_count; ++i) {
        const std::size_t first = 1 + 2 * (k * step_count + i), low = places[first], high = places[first + 1];
        // What was put in is what the text says.
        const double width = study.study().points[high].places[k] - study.study().points[low].places[k];
        const double below = study.results()[low].value[n], above = study.results()[high].value[n];
        differences.push_back((above - below) / width);
        second.push_back((above + below - 2 * out.values[n]) / (0.5 * width));
      }
      out.slopes.back().push_back(slope_with_kink(differences, second));
    }
  }
  return out;
}

void write_sensitivity(const SensitivityPlan& plan, const Sensitivity& found, const std::filesystem::path& folder) {
  std::string text = "number,value,parameter,at,unit,derivative,error,below,above\n";
  const auto add = [&](double v) { text += ',', csv::append_number(text, v, csv::exact_digits); };
  for (std::size_t n = 0; n < plan.numbers.size(); ++n)
    for (std::size_t k = 0; k < plan.parameters.size(); ++k) {
      const SensitivityParameter& p = plan.parameters[k];
      text += csv::quoted(with_unit(plan.numbers[n].name, found.units[n]));
      add(found.values[n]);
      text += "," + csv::quoted(p.name);
      add(*p.at);
      text += "," + csv::quoted(p.unit.empty() ? "1" : p.unit);
      const Slope& slope = found.slopes[n][k];
      add(slope.value), add(slope.error), add(slope.below()), add(slope.above());
      text += '\n';
    }
  write_atomically(folder / "sensitivity.csv", text);
}

std::string sensitivity_text(const SensitivityPlan& plan, const Sensitivity& found) {
  std::string text;
  for (std::size_t n = 0; n < plan.numbers.size(); ++n) {
    const std::string unit = found.units[n] == "1" ? "" : found.units[n];
    text += fmt::format("{} = {:.12g}{}{}\n", plan.numbers[n].name, found.values[n], unit.empty() ? "" : " ", unit);
    for (std::size_t k = 0; k < plan.parameters.size(); ++k) {
      const SensitivityParameter& p = plan.parameters[k];
      const Slope& slope = found.slopes[n][k];
      text +=
          fmt::format("  d/d {:<16} {:>17.9e} +- {:.1e} {:<12}", p.name, slope.value, slope.error, unit + unit_text(p));
      if (found.values[n] != 0 && *p.at != 0)
        text += fmt::format("  {:+.4f} % per %", slope.value * *p.at / found.values[n]);
      if (!(std::abs(slope.value) > slope.error)) text += "  not distinguishable from zero";
      if (slope.jump != 0)
        text += fmt::format("\n    warning: a kink; {:.6e} below and {:.6e} above", slope.below(), slope.above());
      text += "\n";
    }
  }
  return text;
}

}  // namespace subsoil::sim
