#include "libsim/studies/credibility/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/base/replicates.hpp"

namespace subsoil::sim {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Of a number over the packings.
struct PackingScatter {
  double deviation = none;  // standard deviation
  double half_width = 0;    // of the 95 % interval of the difference of two runs
};

PackingScatter scatter_of(const Axes& axes, const std::vector<PointResult>& results, std::size_t number) {
  std::vector<double> values;
  for (std::size_t k = 0; k < axes.axes.size(); ++k)
    if ((axes.axes[k].packing || (k == 0 && axes.base_is_packing)) && std::isfinite(results[k].value[number]))
      values.push_back(results[k].value[number]);
  if (values.size() < 2) return {};
  const Replicates over(values);
  const double s = over.deviation();
  return {s, student_t(static_cast<double>(over.count - 1)) * std::sqrt(2.0) * s};
}

double or_zero(double v) { return std::isfinite(v) ? v : 0; }

Verdict verdict(const std::vector<PointResult>& results, std::size_t axis, std::size_t number,
                const PackingScatter& scatter, double tolerance) {
  const PointResult &base = results[0], &other = results[axis];
  Verdict v{axis, number, base.value[number], other.value[number], none, none, Verdict::Kind::failed, {}};
  if (!std::isfinite(v.base) || !std::isfinite(v.changed) || v.base == 0) {
    v.cause = !other.cause.empty()  ? other.cause
              : !base.cause.empty() ? "the run as given failed: " + base.cause
                                    : "the number could not be taken";
    return v;
  }
  v.change = (v.changed - v.base) / std::abs(v.base);
  // Packings scatter by what their records fluctuate, too; without them the record's own interval must do.
  const double scattered = std::isfinite(scatter.deviation)
                               ? scatter.half_width
                               : std::hypot(or_zero(base.half_width[number]), or_zero(other.half_width[number]));
  v.uncertainty = scattered / std::abs(v.base);
  v.kind = std::abs(v.change) + v.uncertainty <= tolerance  ? Verdict::Kind::converged
           : std::abs(v.change) - v.uncertainty > tolerance ? Verdict::Kind::not_converged
                                                            : Verdict::Kind::not_told;
  return v;
}

std::string words_of(const Verdict& v, const Axes& axes) {
  switch (v.kind) {
    case Verdict::Kind::converged:
      return "converged";
    case Verdict::Kind::not_converged:
      return "not converged in " + axes.axes[v.axis].name;
    case Verdict::Kind::not_told:
      return "inconclusive: the uncertainty is as large as the tolerance; longer steady work or more packings";
    case Verdict::Kind::scatter:
      return "scatter of the packings";
    case Verdict::Kind::failed:
      return "failed: " + v.cause;
  }
  return {};
}

/// "warning of bin below, packing 2: blade touched no soil ..."
std::vector<std::string> warnings_of(const Axes& axes, const std::vector<PointResult>& results) {
  std::vector<std::pair<std::string, std::string>> found;  // warning, its runs
  for (std::size_t k = 0; k < results.size(); ++k)
    for (const std::string& text : results[k].warnings) {
      const auto known = std::find_if(found.begin(), found.end(), [&](const auto& one) { return one.first == text; });
      if (known == found.end())
        found.emplace_back(text, axes.axes[k].name);
      else
        known->second += ", " + axes.axes[k].name;
    }
  std::vector<std::string> lines;
  for (const auto& [text, runs] : found) lines.push_back(fmt::format("warning of {}: {}", runs, text));
  return lines;
}

std::string percent(double share) { return std::isfinite(share) ? fmt::format("{:+.1f} %", 100 * share) : "-"; }
std::string figure(double v) { return std::isfinite(v) ? fmt::format("{:.5g}", v) : "-"; }

}  // namespace

Credibility judge(const Axes& axes, const Study& study, const std::vector<PointResult>& results, double tolerance) {
  Credibility c;
  c.warnings = warnings_of(axes, results);
  for (std::size_t n = 0; n < study.numbers.size(); ++n) {
    const PackingScatter scatter = scatter_of(axes, results, n);
    c.packing_scatter.push_back(scatter.deviation);
    c.tolerance.push_back(tolerance);
    for (std::size_t k = 1; k < axes.axes.size(); ++k)
      if (!axes.axes[k].packing) c.verdicts.push_back(verdict(results, k, n, scatter, tolerance));
  }
  return c;
}

std::vector<std::string> credibility_lines(const Axes& axes, const Study& study, const Credibility& c) {
  std::vector<std::string> lines;
  for (std::size_t n = 0; n < study.numbers.size(); ++n) {
    std::string text = study.numbers[n].name, bad, open, index;
    bool first = true, any = false;
    for (const Verdict& v : c.verdicts) {
      if (v.number != n) continue;
      if (std::exchange(first, false)) {
        text += fmt::format(" {}", figure(v.base));
        if (std::isfinite(c.packing_scatter[n])) text += fmt::format(", +- {:.3g} packing", c.packing_scatter[n]);
      }
      const std::string& name = axes.axes[v.axis].name;
      any = any || v.kind != Verdict::Kind::failed;
      text += fmt::format(", {} {}", v.kind == Verdict::Kind::failed ? "failed" : percent(v.change), name);
      if (v.kind == Verdict::Kind::not_converged) bad += fmt::format("{}{}", bad.empty() ? "" : " and ", name);
      if (v.kind == Verdict::Kind::not_told) open += fmt::format("{}{}", open.empty() ? "" : " and ", name);
      if (axes.axes[v.axis].refinement && std::isfinite(v.change))
        index += fmt::format("{}{} {:.1f} %", index.empty() ? "" : ", ", name, 300 * std::abs(v.change));
    }
    if (!any)
      text += ": not judged: no axis beside the packings gave a value";
    else if (bad.empty() && open.empty())
      text += ": converged in every axis that ran";
    if (!bad.empty()) text += ": not converged in " + bad;
    if (!open.empty()) text += (bad.empty() ? ": inconclusive in " : ", inconclusive in ") + open;
    if (!index.empty()) text += "; grid convergence index: " + index;
    lines.push_back(text);
  }
  for (const AbsentAxis& a : axes.absent) lines.push_back(fmt::format("{}: not tried, {}", a.name, a.why));
  lines.insert(lines.end(), c.warnings.begin(), c.warnings.end());
  return lines;
}

Json credibility_json(const Axes& axes, const Study& study, const Credibility& c) {
  Json out;
  out["note"] = fmt::format(
      "Each axis changes one thing that is not physics. Uncertainty of a change: the 95 % interval by Student's t "
      "from the standard deviation over the packings, of both runs (without packings the 95 % intervals of both "
      "means). Converged: change and uncertainty "
      "together within {:.1f} %.",
      c.tolerance.empty() ? 0.0 : 100 * c.tolerance.front());
  out["rows"] = Json::array();
  for (const Verdict& v : c.verdicts)
    out["rows"].push_back(
        {{"axis", axes.axes[v.axis].name + ": " + axes.axes[v.axis].change},
         {"number", study.numbers[v.number].name},
         {"base", figure(v.base)},
         {"changed", figure(v.changed)},
         {"change", percent(v.change)},
         {"uncertainty", std::isfinite(v.uncertainty) ? fmt::format("{:.1f} %", 100 * v.uncertainty) : "-"},
         {"verdict", words_of(v, axes)}});
  out["lines"] = credibility_lines(axes, study, c);
  return out;
}

}  // namespace subsoil::sim
