#include "libsim/studies/calibrate/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libsim/document/quantity.hpp"
#include "libsim/document/shared_keys.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/studies/laboratory/tests.hpp"

namespace subsoil::sim {
namespace {

struct PlanChecker {
  Plan& plan;
  const Places& places;
  Problems& problems;

  void refuse(const std::string& path, const std::string& rule) { problems.add(place_of(places, path), path, rule); }

  void parameter(PlanParameter& p) {
    const std::string path = "parameters." + p.name;
    p.paths = split_at_semicolons(p.keys);
    if (p.paths.empty())
      refuse(path + ".keys", "is missing: path of the value in the scenario, such as contacts[0].mu");
    if (p.scale == Scale::log && !(p.least > 0)) refuse(path + ".between", "must be above zero for `scale: log`");
    if (p.truth && !(*p.truth >= p.least && *p.truth <= p.largest)) refuse(path + ".truth", "must lie in the range");
  }

  void target(std::size_t index) {
    PlanTarget& t = plan.targets[index];
    const std::string path = fmt::format("targets[{}]", index);
    std::string at = path + ".test";
    try {
      const std::vector<Number> numbers = test_numbers(t.test);
      at = path + ".number";
      std::vector<std::string> names;
      for (const Number& n : numbers) {
        names.push_back(n.name);
        if (n.name == t.number) t.unit = n.unit;
      }
      if (t.unit.empty())
        throw std::invalid_argument(
            fmt::format("`{}` is no number of {}{}", t.number, t.test, suggestion(t.number, names)));
      at = path + ".tolerance";
      t.tolerance = parse_quantity(t.tolerance_text, t.unit);
      if (!(t.tolerance > 0)) throw std::invalid_argument("must be above zero");
      at = path + ".value";
      if (!t.value_text.empty()) t.value = parse_quantity(t.value_text, t.unit);
    } catch (const std::invalid_argument& error) {
      refuse(at, error.what());
    }
    const bool twin =
        std::all_of(plan.parameters.begin(), plan.parameters.end(), [](const auto& p) { return p.truth; });
    if (t.value_text.empty() && !twin)
      refuse(path + ".value", "is missing; give it, or a `truth` for every parameter to take it from");
  }

  void all() {
    if (plan.parameters.empty()) refuse("parameters", "is missing: nothing may be changed");
    if (plan.targets.empty()) refuse("targets", "is missing: there is nothing to meet");
    for (PlanParameter& p : plan.parameters) parameter(p);
    refuse_shared_keys(plan.parameters, written_scenario(plan.scenario, {}),
                       [&](const std::string& path, const std::string& rule) { refuse(path, rule); });
    for (std::size_t i = 0; i < plan.targets.size(); ++i) target(i);
    if (!plan.design) plan.design = 3 + 5 * static_cast<long>(plan.parameters.size());
    if (*plan.design < static_cast<long>(plan.parameters.size()) + 2)
      refuse("design", "must be two points more than there are parameters");
    if (*plan.design > plan.evaluations) refuse("evaluations", "must be no fewer than the points of the design");
  }
};

}  // namespace

double PlanParameter::value(double u) const { return value_in_range(scale, least, largest, u); }

double PlanParameter::place(double value) const {
  return scale == Scale::log ? std::log(value / least) / std::log(largest / least)
                             : (value - least) / (largest - least);
}

std::vector<std::string> Plan::tests() const {
  std::vector<std::string> words;
  for (const PlanTarget& t : targets)
    if (std::find(words.begin(), words.end(), t.test) == words.end()) words.push_back(t.test);
  return words;
}

std::vector<std::string> Plan::sets(const std::vector<double>& values) const {
  std::vector<std::string> sets;
  for (std::size_t k = 0; k < parameters.size(); ++k)
    for (const std::string& path : parameters[k].paths)
      sets.push_back(
          fmt::format("{}={}{}{}", path, values[k], parameters[k].unit.empty() ? "" : " ", parameters[k].unit));
  return sets;
}

Plan load_plan(const std::string& file, const std::vector<std::string>& sets) {
  Problems problems;
  const Node document = read_document(file, sets, problems);
  Plan plan;
  Reading reading(problems);
  read_all(document, reading, [&](Fields& fields) { declare(fields, plan); });
  if (problems.empty()) PlanChecker{plan, reading.places, problems}.all();
  if (!problems.empty()) throw ScenarioError(problems);
  return plan;
}

}  // namespace subsoil::sim
