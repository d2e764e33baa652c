#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "libsim/keys/ranges.hpp"
#include "libsim/studies/sweep/plan.hpp"

/// What `subsoil optimise` and `subsoil sensitivity` are asked.
namespace subsoil::sim {

/// A design parameter with its bounds.
struct DesignParameter {
  std::string name, keys, unit;
  double least = required, largest = required;
  std::optional<double> start;
  Scale scale = Scale::linear;
  std::vector<std::string> paths;  ///< of `keys`; none: it stands in formulas alone

  template <class V>
  void describe(V& v) {
    v.joined_text("keys", keys,
                  "path of the value in the scenario, several with ; between: parameters.a; left out: it stands in "
                  "formulas alone, as a bound on several numbers that is minimised");
    v.span("between", least, largest, "1", "(-inf, inf)", "bounds, in `unit`");
    v.text("unit", unit,
           "unit of the bounds, of the value that is put in, and of the parameter in formulas; left out: "
           "a number");
    v.quantity("start", start, "1", "(-inf, inf)",
               "where the first search begins; left out: what the scenario has, the same at all keys, else the middle "
               "of the bounds");
    v.choice("scale", scale, {{"linear", Scale::linear}, {"log", Scale::log}},
             "log: for values that may differ by powers of ten");
  }
  double value(double u) const { return value_in_range(scale, least, largest, u); }
  double place(double value) const;
  std::string text(double value) const;  ///< as a scenario writes it
};

enum class SearchMethod { automatic, bobyqa, cobyla, slsqp, isres, surrogate };

struct OptimisePlan {
  long version = 1;
  std::string title, scenario, set, minimise, maximise, constraints_text;
  std::vector<DesignParameter> parameters;
  std::vector<SweepNumber> numbers;
  std::vector<std::string> constraints;  ///< of `constraints_text`
  SearchMethod method = SearchMethod::automatic;
  long starts = 3, evaluations = 200, seed = 1, threads = 1;
  double tolerance = 1e-4, constraint_tolerance = 1e-5;
  std::optional<long> at_once;

  template <class V>
  void describe(V& v) {
    v.version("subsoil", version, "version of the format: 1");
    v.text("title", title, "one line about what this is");
    v.file("scenario", scenario, "scenario whose values are the design, beside the plan");
    v.joined_text("set", set, "path=value for all runs, several with ; between, or a list");
    v.named("parameters", parameters,
            "what may be changed, with bounds; names are words of formulas: letters, digits, _");
    v.named("numbers", numbers,
            "what is taken of every run, in the unit of its column or summary entry; names are words of formulas");
    v.text("minimise", minimise, "formula in numbers and parameters whose least value is sought");
    v.text("maximise", maximise, "in its place: formula whose largest value is sought");
    v.joined_text("constraints", constraints_text,
                  "what must hold, formulas with <=, >= or = between: [mass <= 3, a + b = 0.5]");
    v.choice("method", method,
             {{"auto", SearchMethod::automatic},
              {"bobyqa", SearchMethod::bobyqa},
              {"cobyla", SearchMethod::cobyla},
              {"slsqp", SearchMethod::slsqp},
              {"isres", SearchMethod::isres},
              {"surrogate", SearchMethod::surrogate}},
             "auto: bobyqa, with constraints or a single parameter cobyla; surrogate: for runs with soil, few runs "
             "(docs/reference/optimise.md)");
    v.count("starts", starts, "[1, 1000]", "searches: the first from `start`, the others from a Latin hypercube");
    v.count("evaluations", evaluations, "[3, 100000]", "runs of each search at most");
    v.count("seed", seed, "[1, inf)", "of the Latin hypercube and of isres");
    v.quantity("tolerance", tolerance, "1", "(0, 0.1]", "share of the bounds' distance to which the optimum is sought");
    v.quantity("constraint tolerance", constraint_tolerance, "1", "(0, 0.1]",
               "share of its larger side by which a constraint may be missed");
    v.count("threads", threads, "[1, 1024]", "cores of each run; no two runs share one");
    v.count("at once", at_once, "[1, 100000]", "runs side by side at most; left out: as many as the cores allow");
  }
};

/// A parameter that sensitivities are taken over.
struct SensitivityParameter {
  std::string name, keys, unit;
  std::optional<double> at;
  double step = 0.02;
  std::vector<std::string> paths;

  template <class V>
  void describe(V& v) {
    v.joined_text("keys", keys, "path of the value in the scenario, several with ; between: parameters.a");
    v.text("unit", unit, "of the value; derivatives are per this unit; left out: a number");
    v.quantity("at", at, "1", "(-inf, inf)",
               "value at which the derivative is taken; left out: what the scenario has, the same at all keys");
    v.quantity("step", step, "1", "(0, 1)", "largest step, as a share of the value (of one unit where it is 0)");
  }
};

struct SensitivityPlan {
  long version = 1;
  std::string title, scenario, set;
  std::vector<SensitivityParameter> parameters;
  std::vector<SweepNumber> numbers;
  long threads = 1;
  std::optional<long> at_once;

  template <class V>
  void describe(V& v) {
    v.version("subsoil", version, "version of the format: 1");
    v.text("title", title, "one line about what this is");
    v.file("scenario", scenario, "scenario of the machine, beside the plan");
    v.joined_text("set", set, "path=value for all runs, several with ; between, or a list");
    v.named("parameters", parameters, "what the numbers are differentiated with respect to");
    v.named("numbers", numbers, "what is differentiated, in the unit of its column or summary entry");
    v.count("threads", threads, "[1, 1024]", "cores of each run; no two runs share one");
    v.count("at once", at_once, "[1, 100000]", "runs side by side at most; left out: as many as the cores allow");
  }
};

/// Read and checked. Throw ScenarioError with all faults, also those of the scenario itself.
OptimisePlan load_optimise(const std::string& file, const std::vector<std::string>& sets = {});
SensitivityPlan load_sensitivity(const std::string& file, const std::vector<std::string>& sets = {});

}  // namespace subsoil::sim
