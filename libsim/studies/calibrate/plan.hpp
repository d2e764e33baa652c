#pragma once
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libsim/document/document.hpp"
#include "libsim/keys/ranges.hpp"
#include "libsim/scenario/sections/defaults.hpp"

/// What `subsoil calibrate` is asked: parameters with ranges, targets with tolerances.
namespace subsoil::sim {

struct PlanParameter {
  std::string name, keys, unit;
  double least = required, largest = required;
  Scale scale = Scale::linear;
  std::optional<double> truth;
  std::vector<std::string> paths;  ///< of `keys`

  template <class V>
  void describe(V& v) {
    v.text("keys", keys, "path of the value in the scenario, several with ; between: contacts[0].mu; contacts[1].mu");
    v.span("between", least, largest, "1", "(-inf, inf)", "range that is searched, in `unit`");
    v.text("unit", unit, "unit of the range and of the value that is put in; left out: a number");
    v.choice("scale", scale, {{"linear", Scale::linear}, {"log", Scale::log}},
             "log: for values that may differ by powers of ten");
    v.quantity(
        "truth", truth, "1", "(-inf, inf)",
        "in place of measurements: targets without value are what the program finds with this, for other packings");
  }

  /// Of u in [0, 1] and back.
  double value(double u) const;
  double place(double value) const;
};

struct PlanTarget {
  std::string test, number, value_text, tolerance_text;
  std::string unit;  ///< of the number, SI
  double value = std::numeric_limits<double>::quiet_NaN();
  double tolerance = std::numeric_limits<double>::quiet_NaN();

  template <class V>
  void describe(V& v) {
    v.text("test", test, "a laboratory test: repose, shear, ...");
    v.text("number", number, "of the test: angle, modulus, ... (docs/reference/laboratory-tests.md)");
    v.text("value", value_text, "measured, with its unit; left out: from the parameters' truth");
    v.text("tolerance", tolerance_text, "standard deviation of the measured value, with its unit; also its weight");
  }
  std::string name() const { return test + "." + number; }
};

struct Plan {
  long version = 1;
  std::string title, scenario;
  std::vector<PlanParameter> parameters;
  std::vector<PlanTarget> targets;
  std::optional<long> design;
  long evaluations = 30, seed = 1;

  template <class V>
  void describe(V& v) {
    v.version("subsoil", version, "version of the format: 1");
    v.text("title", title, "one line about what this is");
    v.file("scenario", scenario, "scenario with materials, contacts and the section `test`, beside the plan");
    v.named("parameters", parameters, "what may be changed");
    v.list("targets", targets, "what is to be met");
    v.count("design", design, "[3, 10000]", "points of the first design; left out: 5 per parameter, and 3");
    v.count("evaluations", evaluations, "[3, 100000]", "points at most, design included");
  }

  std::vector<std::string> tests() const;  ///< words, each once
  /// `path=value` overrides that put parameters at u, in [0, 1] each.
  std::vector<std::string> sets(const std::vector<double>& values) const;
};

/// Reads and checks a plan. Throws ScenarioError with all faults.
Plan load_plan(const std::string& file, const std::vector<std::string>& sets);

}  // namespace subsoil::sim
