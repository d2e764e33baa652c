#include "libsim/studies/design/optimum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/studies/design/formulas.hpp"
#include "libsim/studies/sweep/tables.hpp"

namespace subsoil::sim {
namespace {

/// Turns places into points and results into what they are worth.
class Judge {
 public:
  explicit Judge(const OptimisePlan& plan) : plan_(plan), common_(split_at_semicolons(plan.set)) {
    for (const std::string& set : without_frames(plan.scenario, common_)) common_.push_back(set);
    const std::vector<std::string> names = formula_names(plan);
    objective_ = design_formula(plan.minimise.empty() ? plan.maximise : plan.minimise, names);
    for (const std::string& text : plan.constraints) constraints_.emplace_back(text, names);
  }

  SweepPoint point(const Design& u) const {
    SweepPoint point;
    point.sets = common_;
    for (std::size_t k = 0; k < u.size(); ++k) {
      const DesignParameter& p = plan_.parameters[k];
      const std::string text = p.text(p.value(u[k]));
      point.values.push_back(text);
      point.places.push_back(std::stod(text));
      for (const std::string& path : p.paths) point.sets.push_back(path + "=" + text);
    }
    return point;
  }

  DesignRow row(std::size_t search, std::size_t at, const SweepPoint& point, const PointResult& result) const {
    DesignRow row;
    row.search = search, row.parameters = point.places, row.worth.point = at;
    std::vector<double> values = point.places;
    values.insert(values.end(), result.value.begin(), result.value.end());
    Worth& w = row.worth;
    w.objective = objective_(values.data());
    w.whole = result.end == PointResult::End::reached && std::isfinite(w.objective);
    for (const DesignConstraint& c : constraints_) {
      w.excess.push_back(c.excess(values.data())), w.size.push_back(c.size(values.data()));
      w.whole = w.whole && std::isfinite(w.excess.back());
      const double over = c.is_equation() ? std::abs(w.excess.back()) : std::max(0.0, w.excess.back());
      row.missed_by.push_back(over > 0 ? over / w.size.back() : 0);
      row.missed = std::max(row.missed, row.missed_by.back());
    }
    row.feasible = w.whole && row.missed <= plan_.constraint_tolerance;
    return row;
  }

 private:
  const OptimisePlan& plan_;
  std::vector<std::string> common_;
  std::function<double(const double*)> objective_;
  std::vector<DesignConstraint> constraints_;
};

/// Whether a row is better than another: what is feasible before what is not, then what misses less.
bool better(const OptimisePlan& plan, const DesignRow& a, const DesignRow& b) {
  if (a.feasible != b.feasible) return a.feasible;
  if (!a.feasible && a.missed != b.missed) return a.missed < b.missed;
  return plan.minimise.empty() ? a.worth.objective > b.worth.objective : a.worth.objective < b.worth.objective;
}

std::vector<Design> starts_of(const OptimisePlan& plan) {
  Design first;
  for (const DesignParameter& p : plan.parameters) first.push_back(p.place(*p.start));
  std::vector<Design> starts{first};
  if (plan.starts > 1)
    for (Design& u : latin_hypercube(plan.starts - 1, plan.parameters.size(), plan.seed))
      starts.push_back(std::move(u));
  return starts;
}

std::string parameters_text(const OptimisePlan& plan, const DesignRow& row) {
  std::string text;
  for (std::size_t k = 0; k < plan.parameters.size(); ++k)
    text += fmt::format("{}{} = {:.6g}{}{}", text.empty() ? "" : ", ", plan.parameters[k].name, row.parameters[k],
                        plan.parameters[k].unit.empty() ? "" : " ", plan.parameters[k].unit);
  return text;
}

const std::string& objective_text(const OptimisePlan& plan) {
  return plan.minimise.empty() ? plan.maximise : plan.minimise;
}

std::string csv_text(const OptimisePlan& plan, const Optimum& found, const GrowingStudy& study) {
  std::string text = "point,search";
  for (const DesignParameter& p : plan.parameters)
    text += "," + csv::quoted(p.name + (p.unit.empty() ? "" : " [" + p.unit + "]"));
  for (std::size_t n = 0; n < plan.numbers.size(); ++n)
    text += "," + csv::quoted(with_unit(plan.numbers[n].name, unit_of(study.results(), n)));
  text += "," + csv::quoted(objective_text(plan));
  for (const std::string& c : plan.constraints) text += "," + csv::quoted("excess of " + c);
  text += ",feasible,end,wall time [s],cause\n";
  const auto add = [&](double v) {
    text += ',';
    if (std::isfinite(v)) csv::append_number(text, v, csv::exact_digits);
  };
  for (std::size_t k = 0; k < found.rows.size(); ++k) {
    const DesignRow& row = found.rows[k];
    const PointResult& r = study.results()[k];
    text += fmt::format("{},{}", k + 1, row.search + 1);
    for (const double v : row.parameters) add(v);
    for (const double v : r.value) add(v);
    add(row.worth.objective);
    for (const double v : row.worth.excess) add(v);
    text +=
        fmt::format(",{},{}", row.feasible ? "yes" : "no", r.end == PointResult::End::reached ? "reached" : "failed");
    add(r.wall_time);
    text += "," + csv::quoted(r.cause) + "\n";
  }
  return text;
}

}  // namespace

Study study_of(const OptimisePlan& plan) {
  Study study;
  study.title = plan.title, study.scenario = plan.scenario, study.numbers = plan.numbers;
  for (const DesignParameter& p : plan.parameters) study.parameters.push_back(p.name);
  return study;
}

Optimum find_optimum(const OptimisePlan& plan, GrowingStudy& study) {
  const Judge judge(plan);
  const std::vector<Design> starts = starts_of(plan);
  Optimum out;
  out.method = method_of(plan);
  out.ends.resize(starts.size()), out.best_of.resize(starts.size());
  const auto answer = [&](const std::vector<Question>& questions) {
    std::vector<SweepPoint> points;
    for (const Question& q : questions)
      for (const Design& u : q.places) points.push_back(judge.point(u));
    const std::vector<std::size_t> at = study.run(points);
    std::vector<std::vector<Worth>> worths(questions.size());
    for (std::size_t i = 0, k = 0; i < questions.size(); ++i)
      for (std::size_t j = 0; j < questions[i].places.size(); ++j, ++k) {
        if (at[k] == out.rows.size())
          out.rows.push_back(
              judge.row(questions[i].search, at[k], study.study().points[at[k]], study.results()[at[k]]));
        const DesignRow& row = out.rows[at[k]];
        worths[i].push_back(row.worth);
        std::optional<std::size_t>& best = out.best_of[questions[i].search];
        if (row.worth.whole && (!best || better(plan, row, out.rows[*best]))) best = at[k];
      }
    return worths;
  };
  const auto search = [&](std::size_t k, const Ask& ask) {
    out.ends[k] = search_optimum(plan, starts[k], static_cast<std::uint64_t>(plan.seed) + k, ask);
  };
  search_in_step(starts.size(), search, answer);
  for (const auto& row : out.best_of)
    if (row && (!out.best || better(plan, out.rows[*row], out.rows[*out.best]))) out.best = row;
  return out;
}

void write_optimum(const OptimisePlan& plan, const Optimum& found, const GrowingStudy& study,
                   const std::filesystem::path& folder) {
  write_atomically(folder / "optimise.csv", csv_text(plan, found, study));
  if (!found.best) return;
  const DesignRow& row = found.rows[*found.best];
  std::vector<std::string> sets = split_at_semicolons(plan.set);
  for (std::size_t k = 0; k < plan.parameters.size(); ++k)
    for (const std::string& path : plan.parameters[k].paths)
      sets.push_back(path + "=" + study.study().points[*found.best].values[k]);
  const std::string head = fmt::format("# {}: {} = {:.9g}\n# {}\n", plan.minimise.empty() ? "Largest" : "Least",
                                       objective_text(plan), row.worth.objective, parameters_text(plan, row));
  write_atomically(folder / "best.yaml", head + write_scenario(load_scenario(plan.scenario, sets).scenario));
}

std::string optimum_text(const OptimisePlan& plan, const Optimum& found, const GrowingStudy& study) {
  std::size_t failed = 0;
  std::string causes, text;
  for (std::size_t k = 0; k < found.rows.size(); ++k) {
    const PointResult& r = study.results()[k];
    if (found.rows[k].worth.whole) continue;
    constexpr std::size_t shown = 5;
    if (++failed <= shown)
      causes += fmt::format("no numbers at {:04} ({}): {}\n", k + 1, parameters_text(plan, found.rows[k]),
                            r.cause.empty() ? "the formulas have no value there" : r.cause);
  }
  text += fmt::format("{} designs by {}, {} without numbers{}\n", found.rows.size(), word_of(found.method), failed,
                      failed > 5 ? "; all of them in optimise.csv" : "");
  text += causes;
  for (std::size_t k = 0; k < found.ends.size(); ++k) {
    text += fmt::format("search {}: {} after {} designs", k + 1, found.ends[k].words, found.ends[k].evaluations);
    if (const auto row = found.best_of[k]) {
      text += fmt::format("; {:.9g} at {:04}", found.rows[*row].worth.objective, *row + 1);
      if (!found.rows[*row].feasible)
        text += fmt::format(" (a constraint is missed by {:.2g})", found.rows[*row].missed);
    }
    text += "\n";
  }
  if (!found.best) return text + "no design gives numbers\n";
  const DesignRow& best = found.rows[*found.best];
  text += fmt::format("{} {} = {:.9g} at point {:04}\n", plan.minimise.empty() ? "largest" : "least",
                      objective_text(plan), best.worth.objective, *found.best + 1);
  for (std::size_t k = 0; k < plan.parameters.size(); ++k) {
    const DesignParameter& p = plan.parameters[k];
    const double u = p.place(best.parameters[k]);
    text += fmt::format("  {:<20} {:.8g} {}{}\n", p.name, best.parameters[k], p.unit,
                        u < plan.tolerance       ? " (on its lower bound)"
                        : u > 1 - plan.tolerance ? " (on its upper bound)"
                                                 : "");
  }
  for (std::size_t k = 0; k < plan.numbers.size(); ++k)
    text += fmt::format("  {:<20} {:.8g} {}\n", plan.numbers[k].name, study.results()[*found.best].value[k],
                        unit_of(study.results(), k));
  for (std::size_t c = 0; c < plan.constraints.size(); ++c)
    text +=
        fmt::format("  {:<20} {}\n", plan.constraints[c],
                    best.missed_by[c] > plan.constraint_tolerance ? "IS MISSED"
                    : std::abs(best.worth.excess[c]) <= 10 * plan.constraint_tolerance * best.worth.size[c] ? "active"
                                                                                                            : "holds");
  if (!best.feasible) text += "no design meets all constraints: this is the one that comes closest\n";
  return text;
}

}  // namespace subsoil::sim
