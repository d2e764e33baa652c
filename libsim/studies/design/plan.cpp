#include "libsim/studies/design/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "libsim/document/quantity.hpp"
#include "libsim/document/shared_keys.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/keys/reading.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/studies/design/formulas.hpp"

namespace subsoil::sim {
namespace {

template <class Plan>
Plan read_plan(const std::string& file, const std::vector<std::string>& sets, Reading& reading) {
  const Node document = read_document(file, sets, reading.problems);
  Plan plan;
  read_all(document, reading, [&](Fields& fields) { declare(fields, plan); });
  return plan;
}

bool is_word(const std::string& name) {
  return !name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) != 0 &&
         std::all_of(name.begin(), name.end(),
                     [](char c) { return c == '_' || std::isalnum(static_cast<unsigned char>(c)) != 0; });
}

struct DesignChecker {
  const std::string& file;
  const Reading& reading;
  Problems& problems;

  void refuse(const std::string& path, const std::string& rule) {
    problems.add(place_of(reading.places, path), path, rule);
  }

  template <class Plan>
  void numbers(const Plan& plan) {
    if (plan.numbers.empty()) refuse("numbers", "is missing: nothing is taken of the runs");
    std::vector<std::string> varied;
    for (const auto& p : plan.parameters) varied.insert(varied.end(), p.paths.begin(), p.paths.end());
    const Node scenario = written_scenario(plan.scenario, split_at_semicolons(plan.set));
    for (const auto& [path, rule] : faults_of(plan.numbers, scenario, varied)) refuse(path, rule);
  }

  template <class Parameter>
  void parameters(std::vector<Parameter>& list, const std::string& scenario, const std::string& sets) {
    if (list.empty()) refuse("parameters", "is missing: nothing changes");
    for (Parameter& p : list) {
      p.paths = split_at_semicolons(p.keys);
      if (p.unit == "1") p.unit.clear();  // a pure number
      try {
        if (!p.unit.empty()) static_cast<void>(parse_unit(p.unit));
      } catch (const std::exception& error) {
        refuse("parameters." + p.name + ".unit", error.what());
      }
    }
    refuse_shared_keys(list, written_scenario(scenario, split_at_semicolons(sets)),
                       [&](const std::string& path, const std::string& rule) { refuse(path, rule); });
  }

  void words(const OptimisePlan& plan) {
    std::vector<std::string> seen;
    const auto look = [&](const std::string& section, const std::string& name) {
      if (!is_word(name))
        refuse(section + "." + name, "stands in formulas: a word of letters, digits and _, a letter first");
      if (holds(seen, name)) refuse(section + "." + name, "is also the name of a parameter; rename one");
      seen.push_back(name);
    };
    for (const DesignParameter& p : plan.parameters) look("parameters", p.name);
    for (const SweepNumber& n : plan.numbers) look("numbers", n.name);
  }

  void bounds(const DesignParameter& p) {
    const std::string path = "parameters." + p.name;
    if (p.scale == Scale::log && !(p.least > 0)) refuse(path + ".between", "must be above zero for `scale: log`");
    if (p.start && !(*p.start >= p.least && *p.start <= p.largest)) refuse(path + ".start", "must lie in the bounds");
  }

  void formulas(OptimisePlan& plan) {
    if (plan.minimise.empty() == plan.maximise.empty())
      return refuse(plan.minimise.empty() ? "minimise" : "maximise", "needs one of `minimise` and `maximise`");
    const auto attempt = [&](const std::string& key, auto make) {
      try {
        make();
      } catch (const std::exception& error) {
        refuse(key, error.what());
      }
    };
    const std::vector<std::string> names = formula_names(plan);
    const bool least = !plan.minimise.empty();
    attempt(least ? "minimise" : "maximise", [&] { design_formula(least ? plan.minimise : plan.maximise, names); });
    plan.constraints = split_at_semicolons(plan.constraints_text);
    for (const std::string& c : plan.constraints) attempt("constraints", [&] { DesignConstraint(c, names); });
  }

  /// At the values that the scenario has, so that a key that it does not know is refused before anything runs.
  void scenario(const std::string& name, const std::vector<std::string>& sets, const std::vector<std::string>& more) {
    for (const bool whole : {false, true}) {
      std::vector<std::string> all = sets;
      if (whole) all.insert(all.end(), more.begin(), more.end());
      try {
        static_cast<void>(load_scenario(name, all));
      } catch (const ScenarioError& error) {
        throw ScenarioError(fmt::format("{}: the scenario {}:\n{}", file,
                                        whole ? "refuses the first design" : "itself is refused", error.what()));
      }
    }
  }
};

std::optional<double> number_in(const Node& tree, const std::string& path, const std::string& unit) {
  try {
    const std::string text = scaled_value(tree, path, 1);
    if (unit.empty()) return parse_quantity(text, "1");
    return parse_quantity_in(text, unit);
  } catch (const std::exception&) {
    return {};
  }
}

/// What a scenario has at the keys of a parameter.
struct ValueThere {
  std::optional<double> value;
  std::string others;  ///< in words, where the keys have several
};
ValueThere value_there(const std::string& scenario, const std::vector<std::string>& sets,
                       const std::vector<std::string>& paths, const std::string& unit) {
  Problems unheard;
  const Node written = read_document(scenario, sets, unheard);
  std::optional<Node> all;
  ValueThere out;
  for (const std::string& path : paths) {
    std::optional<double> here = number_in(written, path, unit);
    if (!here) {
      if (!all) all = explicit_tree(load_scenario(scenario, sets).scenario);
      here = number_in(*all, path, unit);
    }
    if (!here) return {};
    if (!out.value) out.value = here;
    if (*here != *out.value) {
      const std::string of = unit.empty() ? "" : " " + unit;
      out.others = fmt::format("the scenario has {:.6g}{} at {} and {:.6g}{} at {}", *out.value, of, paths.front(),
                               *here, of, path);
      return out;
    }
  }
  return out;
}

/// The value at which derivatives are taken.
void take_place(SensitivityParameter& p, const SensitivityPlan& plan, DesignChecker& checker) {
  const std::string path = "parameters." + p.name;
  if (p.paths.empty()) return checker.refuse(path + ".keys", "is missing: path of the value in the scenario");
  if (!p.at) {
    const ValueThere there = value_there(plan.scenario, split_at_semicolons(plan.set), p.paths, p.unit);
    if (!there.others.empty()) return checker.refuse(path + ".at", "is missing: " + there.others);
    p.at = there.value;
  }
  if (!p.at)
    checker.refuse(path + ".at", fmt::format("is missing: the scenario has no single number{} at {}",
                                             p.unit.empty() ? "" : " in " + p.unit, p.paths.front()));
}

}  // namespace

double DesignParameter::place(double value) const {
  const double u =
      scale == Scale::log ? std::log(value / least) / std::log(largest / least) : (value - least) / (largest - least);
  return std::clamp(u, 0.0, 1.0);
}

std::string DesignParameter::text(double value) const {
  return fmt::format("{:.12g}{}{}", value, unit.empty() ? "" : " ", unit);
}

OptimisePlan load_optimise(const std::string& file, const std::vector<std::string>& sets) {
  Problems problems;
  Reading reading(problems);
  OptimisePlan plan = read_plan<OptimisePlan>(file, sets, reading);
  DesignChecker checker{file, reading, problems};
  if (problems.empty()) {
    checker.parameters(plan.parameters, plan.scenario, plan.set), checker.numbers(plan), checker.words(plan);
    for (const DesignParameter& p : plan.parameters) checker.bounds(p);
    checker.formulas(plan);
  }
  if (!problems.empty()) throw ScenarioError(problems);
  const std::vector<std::string> common = split_at_semicolons(plan.set);
  checker.scenario(plan.scenario, common, {});
  std::vector<std::string> first;
  for (DesignParameter& p : plan.parameters) {
    if (!p.start && !p.paths.empty()) {
      const ValueThere there = value_there(plan.scenario, common, p.paths, p.unit);
      if (!there.others.empty()) checker.refuse("parameters." + p.name + ".start", "is missing: " + there.others);
      if (there.value) p.start = std::clamp(*there.value, p.least, p.largest);
    }
    if (!p.start) p.start = p.value(0.5);
    for (const std::string& path : p.paths) first.push_back(path + "=" + p.text(*p.start));
  }
  if (!problems.empty()) throw ScenarioError(problems);
  checker.scenario(plan.scenario, common, first);
  return plan;
}

SensitivityPlan load_sensitivity(const std::string& file, const std::vector<std::string>& sets) {
  Problems problems;
  Reading reading(problems);
  SensitivityPlan plan = read_plan<SensitivityPlan>(file, sets, reading);
  DesignChecker checker{file, reading, problems};
  if (problems.empty()) checker.parameters(plan.parameters, plan.scenario, plan.set), checker.numbers(plan);
  if (!problems.empty()) throw ScenarioError(problems);
  checker.scenario(plan.scenario, split_at_semicolons(plan.set), {});
  std::vector<std::string> first;
  for (SensitivityParameter& p : plan.parameters) {
    take_place(p, plan, checker);
    for (const std::string& path : p.paths)
      if (p.at) first.push_back(fmt::format("{}={:.15g}{}{}", path, *p.at, p.unit.empty() ? "" : " ", p.unit));
  }
  if (!problems.empty()) throw ScenarioError(problems);
  checker.scenario(plan.scenario, split_at_semicolons(plan.set), first);
  return plan;
}

}  // namespace subsoil::sim
