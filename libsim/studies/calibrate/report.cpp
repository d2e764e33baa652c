#include "libsim/studies/laboratory/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/io/atomic_file.hpp"
#include "libsim/plot/plot.hpp"
#include "libsim/studies/calibrate/calibration.hpp"

namespace subsoil::sim {
namespace {

std::string set_table(const Plan& plan, const Calibrated& c) {
  bool truths = false;
  for (const PlanParameter& p : plan.parameters) truths = truths || p.truth.has_value();
  std::string text = "| parameter | found | 95 % interval | range |" + std::string(truths ? " truth |" : "") +
                     "\n|---|---|---|---|" + (truths ? "---|" : "") + "\n";
  for (std::size_t k = 0; k < plan.parameters.size(); ++k) {
    const PlanParameter& p = plan.parameters[k];
    text += fmt::format("| {} | {:.4g}{} | {:.4g} ... {:.4g} | {:g} ... {:g} |", p.name, c.values[k],
                        p.unit.empty() ? "" : " " + p.unit, c.low[k], c.high[k], p.least, p.largest);
    if (truths) text += p.truth ? fmt::format(" {:g} |", *p.truth) : " - |";
    text += '\n';
  }
  return text;
}

std::string target_table(const Calibrated& c) {
  std::string text =
      "| target | wanted | tolerance | surrogate at the set | simulated nearest | standard error | off, deviations |\n"
      "|---|---|---|---|---|---|---|\n";
  const Evaluation& e = c.evaluations[c.nearest];
  for (std::size_t k = 0; k < c.targets.size(); ++k) {
    const PlanTarget& t = c.targets[k];
    const HandyUnit handy = handy_unit(t.unit, t.value);
    text += fmt::format("| {} [{}] | {:.4g} | {:.2g} | {:.4g} | {:.4g} | {:.2g} | {:+.2f} |\n", t.name(), handy.unit,
                        t.value * handy.factor, t.tolerance * handy.factor, c.predicted[k] * handy.factor,
                        e.found[k] * handy.factor, e.error[k] * handy.factor,
                        (e.found[k] - t.value) / std::hypot(t.tolerance, e.error[k]));
  }
  return text;
}

/// Targets that the set misses, and parameters at an end of their range: then the intervals are not valid.
std::string missed_text(const Plan& plan, const Calibrated& c) {
  constexpr double missed = 3;  // deviations
  std::string text;
  const Evaluation& e = c.evaluations[c.nearest];
  for (std::size_t k = 0; k < c.targets.size(); ++k) {
    const PlanTarget& t = c.targets[k];
    const double off = (e.found[k] - t.value) / std::hypot(t.tolerance, e.error[k]);
    if (!(std::abs(off) > missed)) continue;
    double least = e.found[k], largest = e.found[k];
    for (const Evaluation& other : c.evaluations)
      if (other.complete()) least = std::min(least, other.found[k]), largest = std::max(largest, other.found[k]);
    const HandyUnit handy = handy_unit(t.unit, t.value);
    text += fmt::format(
        "\n**{} is missed by {:.1f} deviations.** Evaluations gave {:.4g} to {:.4g} {}, wanted is {:.4g}.\n", t.name(),
        std::abs(off), least * handy.factor, largest * handy.factor, handy.unit, t.value * handy.factor);
  }
  if (text.empty()) return text;
  text += "The 95 % intervals hold for a set that meets its targets; here they are not valid.";
  std::string ends;
  for (std::size_t k = 0; k < plan.parameters.size(); ++k)
    if (const double u = c.u[static_cast<Eigen::Index>(k)]; u < 0.01 || u > 0.99)
      ends += (ends.empty() ? "" : ", ") + plan.parameters[k].name;
  if (!ends.empty()) text += fmt::format(" At an end of its range: {}; widen it.", ends);
  return text + "\n";
}

std::string slope_table(const Plan& plan, const Calibrated& c) {
  std::string head = "| target |", rule = "|---|", text;
  for (const PlanParameter& p : plan.parameters) head += " " + p.name + " |", rule += "---|";
  for (std::size_t k = 0; k < c.targets.size(); ++k) {
    text += "| " + c.targets[k].name() + " |";
    for (Eigen::Index j = 0; j < c.slopes.cols(); ++j)
      text += fmt::format(" {:+.2f} |", 0.1 * c.slopes(static_cast<Eigen::Index>(k), j));
    text += '\n';
  }
  return head + "\n" + rule + "\n" + text;
}

/// "0.71 mu - 0.70 mu_r" of a direction, parts of less than a tenth left out.
std::string direction_text(const Plan& plan, Eigen::VectorXd v) {
  Eigen::Index largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  if (v[largest] < 0) v = -v;  // a direction has no sign
  std::string text;
  for (std::size_t k = 0; k < plan.parameters.size(); ++k) {
    const double part = v[static_cast<Eigen::Index>(k)];
    if (std::abs(part) < 0.1) continue;
    text += text.empty() ? fmt::format("{:.2f} {}", part, plan.parameters[k].name)
                         : fmt::format(" {} {:.2f} {}", part < 0 ? "-" : "+", std::abs(part), plan.parameters[k].name);
  }
  return text;
}

std::string blind_text(const Plan& plan, const Calibrated& c) {
  std::string text = "| combination of ranges | strength | told |\n|---|---|---|\n";
  bool blind = false;
  for (Eigen::Index k = 0; k < c.strengths.size(); ++k) {
    const bool told = c.strengths[k] >= Calibrated::blind;
    blind = blind || !told;
    text += fmt::format("| {} | {:.2f} | {} |\n", direction_text(plan, c.directions.col(k)), c.strengths[k],
                        told ? "yes" : "**no**");
  }
  if (c.strengths.size() > 1)
    text += c.strengths[c.strengths.size() - 1] > 0
                ? fmt::format("\nCondition of the scaled slopes: {:.1f}.\n",
                              c.strengths[0] / c.strengths[c.strengths.size() - 1])
                : "\nFewer targets than parameters: the scaled slopes are singular.\n";
  if (blind)
    text +=
        "\nA combination that is not determined moves the targets by less than their deviations over its whole range: "
        "along "
        "it "
        "the set is one of many. Add a target that depends on it, lower the tolerances, or fix one of its "
        "parameters.\n";
  return text;
}

}  // namespace

std::string calibration_text(const Plan& plan, const Calibrated& c) {
  std::size_t failed = 0;
  for (const Evaluation& e : c.evaluations) failed += e.complete() ? 0 : 1;
  std::string text = "# Calibration" + (plan.title.empty() ? "" : ": " + plan.title) + "\n\n";
  text += fmt::format("{} evaluations{}; {}.\n\n", c.evaluations.size(),
                      failed > 0 ? fmt::format(", {} of them without result", failed) : "",
                      c.converged ? "the search led to a set that had been evaluated"
                                  : "the search had not ended when they were used up");
  text += "## The set\n\n" + set_table(plan, c) + "\n    ";
  for (const std::string& set : plan.sets([&] {
         std::vector<double> digits;
         for (const double v : c.values) digits.push_back(std::stod(fmt::format("{:.4g}", v)));
         return digits;
       }()))
    text += "--set \"" + set + "\" ";
  text += "\n\n## What was to be met\n\n" + target_table(c) + missed_text(plan, c);
  text += fmt::format("\nThe nearest evaluation is {:.1f} % of a range away.\n", 100 * c.distance);
  text += "\n## Sensitivities\n\nChange of each target, in its deviations, for a tenth of each range, at the set.\n\n" +
          slope_table(plan, c);
  text += "\n## What the targets tell\n\n" + blind_text(plan, c);
  return text;
}

void write_calibration(const Plan& plan, const Calibrated& c, const std::filesystem::path& folder,
                       const std::string& pictures) {
  write_atomically(folder / "report.md", calibration_text(plan, c));
  if (!gnuplot_found()) return;
  Chart course{.title = "targets over the evaluations",
               .x_label = "evaluation",
               .y_label = "off the value [tolerances]",
               .curves = {}};
  for (std::size_t k = 0; k < c.targets.size(); ++k) {
    ChartCurve curve{c.targets[k].name(), {}, {}, ChartCurve::Style::dots, static_cast<int>(k)};
    for (std::size_t i = 0; i < c.evaluations.size(); ++i) {
      if (!c.evaluations[i].complete()) continue;
      curve.x.push_back(static_cast<double>(i + 1));
      curve.y.push_back((c.evaluations[i].found[k] - c.targets[k].value) / c.targets[k].tolerance);
    }
    course.curves.push_back(std::move(curve));
  }
  draw_chart(course, folder / ("evaluations." + pictures));
  for (std::size_t j = 0; j < plan.parameters.size(); ++j) {
    const PlanParameter& p = plan.parameters[j];
    Chart scatter = course;
    scatter.title = "targets over " + p.name;
    scatter.x_label = p.name + (p.unit.empty() ? "" : " [" + p.unit + "]");
    for (std::size_t k = 0; k < c.targets.size(); ++k) {
      scatter.curves[k].x.clear();
      for (const Evaluation& e : c.evaluations)
        if (e.complete()) scatter.curves[k].x.push_back(e.parameters[j]);
    }
    scatter.curves.push_back({"found", {c.values[j], c.values[j]}, {-3, 3}, ChartCurve::Style::line, 6});
    draw_chart(scatter, folder / ("over-" + p.name + "." + pictures));
  }
}

}  // namespace subsoil::sim
