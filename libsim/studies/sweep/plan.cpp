#include "libsim/studies/sweep/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <random>

#include "libsim/document/shared_keys.hpp"
#include "libsim/document/units.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/keys/reading.hpp"
#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/studies/sweep/study.hpp"

namespace subsoil::sim {
namespace {

struct PlanChecker {
  SweepPlan& plan;
  const Places& places;
  Problems& problems;

  void refuse(const std::string& path, const std::string& rule) { problems.add(place_of(places, path), path, rule); }

  void parameter(SweepParameter& p) {
    const std::string path = "parameters." + p.name;
    p.paths = split_at_semicolons(p.keys);
    if (p.paths.empty())
      refuse(path + ".keys", "is missing: path of the value in the scenario, such as soil.bed.radius");
    const int kinds =
        (p.values_text.empty() ? 0 : 1) + (p.factors.empty() ? 0 : 1) + (p.between.empty() ? 0 : 1) + (p.seeds ? 1 : 0);
    if (kinds != 1) return refuse(path, "needs one of `values`, `factors`, `between` and `seeds`");
    if (!p.between.empty() && (p.between.size() != 2 || !(p.between[0] < p.between[1])))
      return refuse(path + ".between", "must be two numbers, the least first");
    if (!p.between.empty() && p.scale == Scale::log && !(p.between[0] > 0))
      refuse(path + ".between", "must be above zero for `scale: log`");
    if (p.levels && p.between.empty()) refuse(path + ".levels", "divide `between`, which is missing");
    p.values = split_at_semicolons(p.values_text);
    for (const double f : p.factors) p.values.push_back(fmt::format("{}", f));
    for (long k = 1; p.seeds && k <= *p.seeds; ++k) p.values.push_back(std::to_string(k));
    for (long k = 0; p.levels && p.between.size() == 2 && k < *p.levels; ++k)
      p.values.push_back(fmt::format("{:.6g}{}{}", p.at(static_cast<double>(k) / static_cast<double>(*p.levels - 1)),
                                     p.unit.empty() ? "" : " ", p.unit));
  }

  /// Those that are left out are the scenario's own; its faults are named where it is read for a run.
  std::vector<SweepNumber> numbers() const {
    if (!plan.numbers.empty()) return plan.numbers;
    try {
      return usual_numbers(load_scenario(plan.scenario, split_at_semicolons(plan.set)).scenario);
    } catch (const ScenarioError&) {
      return {};
    }
  }

  void best() {
    if (plan.best.empty()) return;
    std::vector<std::string> names;
    for (const SweepNumber& n : numbers()) names.push_back(n.name);
    const std::size_t blank = plan.best.find(' ');
    const std::string end = plan.best.substr(0, blank),
                      name = blank == std::string::npos ? "" : plan.best.substr(blank + 1);
    if (end != "least" && end != "largest") return refuse("best", "must be `least NUMBER` or `largest NUMBER`");
    if (std::find(names.begin(), names.end(), name) == names.end())
      refuse("best", fmt::format("`{}` is no number of this plan{}", name, suggestion(name, names)));
  }

  void all() {
    if (plan.parameters.empty()) refuse("parameters", "is missing: nothing changes");
    for (SweepParameter& p : plan.parameters) parameter(p);
    const Node scenario = written_scenario(plan.scenario, split_at_semicolons(plan.set));
    refuse_shared_keys(plan.parameters, scenario,
                       [&](const std::string& path, const std::string& rule) { refuse(path, rule); });
    std::vector<std::string> varied;
    for (const SweepParameter& p : plan.parameters) varied.insert(varied.end(), p.paths.begin(), p.paths.end());
    for (const auto& [path, rule] : faults_of(plan.numbers, scenario, varied)) refuse(path, rule);
    best();
  }
};

/// The single value at a path; nullptr where there is none.
const Node* value_at(const Node& scenario, const std::string& path) {
  const Node* const node = find_path(scenario, path);
  return node != nullptr && node->kind == Node::Kind::scalar ? node : nullptr;
}

[[noreturn]] void refuse_no_value(const std::string& path) {
  throw std::invalid_argument(fmt::format("the scenario has no single value at {}; `factors` need one", path));
}

/// The first number in a text, NaN without, and what stands behind the last: `1 2 3 mm` -> 1, mm.
struct WrittenNumber {
  double number = std::numeric_limits<double>::quiet_NaN();
  std::string unit{};

  explicit WrittenNumber(const std::string& text) : unit(text) {
    for (double value = 0;;) {
      const auto [end, code] = std::from_chars(unit.data(), unit.data() + unit.size(), value);
      if (code != std::errc{}) return;
      if (std::isnan(number)) number = value;
      unit.erase(0, std::min(unit.find_first_not_of(' ', static_cast<std::size_t>(end - unit.data())), unit.size()));
    }
  }
};

/// NaN where the unit is another's.
double in_unit(const WrittenNumber& n, const std::string& unit) {
  if (n.unit == unit) return n.number;
  try {
    const Unit own = n.unit.empty() ? Unit{} : parse_unit(n.unit), wanted = unit.empty() ? Unit{} : parse_unit(unit);
    if (own.powers == wanted.powers) return wanted.from_si(own.to_si(n.number));
  } catch (const UnitError&) {  // no unit, as behind `2*a`
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// The numbers in values, all in the unit of the first of them; NaN of a word.
std::vector<double> in_one_unit(const std::vector<std::string>& values) {
  std::vector<double> out;
  for (const std::string& v : values) out.push_back(in_unit(WrittenNumber(v), WrittenNumber(values.front()).unit));
  return out;
}

}  // namespace

double SweepParameter::at(double u) const { return value_in_range(scale, between[0], between[1], u); }

SweepPlan load_sweep(const std::string& file, const std::vector<std::string>& sets) {
  Problems problems;
  const Node document = read_document(file, sets, problems);
  SweepPlan plan;
  Reading reading(problems);
  read_all(document, reading, [&](Fields& fields) { declare(fields, plan); });
  if (problems.empty()) PlanChecker{plan, reading.places, problems}.all();
  if (!problems.empty()) throw ScenarioError(problems);
  return plan;
}

std::vector<std::vector<double>> latin_hypercube(long points, std::size_t dimensions, long seed) {
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  const auto n = static_cast<std::size_t>(points);
  // Own shuffle and own reals: the standard's distributions differ between libraries.
  const auto real = [&] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
  std::vector<std::vector<double>> u(n, std::vector<double>(dimensions));
  std::vector<std::size_t> order(n);
  for (std::size_t d = 0; d < dimensions; ++d) {
    for (std::size_t i = 0; i < n; ++i) order[i] = i;
    for (std::size_t i = n; i > 1; --i)
      std::swap(order[i - 1], order[static_cast<std::size_t>(real() * static_cast<double>(i))]);
    for (std::size_t i = 0; i < n; ++i) u[i][d] = (static_cast<double>(order[i]) + real()) / static_cast<double>(n);
  }
  return u;
}

Node explicit_tree(const Scenario& scenario) {
  Problems problems;
  return parse_document(write_scenario(scenario), "scenario.yaml", {}, problems);
}

std::string scaled_value(const Node& scenario, const std::string& path, double factor) {
  const Node* const node = value_at(scenario, path);
  if (node == nullptr) refuse_no_value(path);
  std::string out;
  const std::string& text = node->scalar;
  bool any = false;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t end = std::min(text.find(' ', i), text.size());
    const std::string word = text.substr(i, end - i);
    double value = 0;
    const auto [stop, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    const bool number = code == std::errc{} && stop == word.data() + word.size();
    any = any || number;
    out += fmt::format("{}{}", out.empty() ? "" : " ", number ? fmt::format("{}", value * factor) : word);
    i = end + 1;
  }
  if (!any) throw std::invalid_argument(fmt::format("{} = {}: is no number, which `factors` need", path, text));
  return out;
}

namespace {

/// Builds the list of points.
class Points {
 public:
  Points(const std::string& file, const SweepPlan& plan)
      : file_(file), plan_(plan), common_(split_at_semicolons(plan.set)) {
    const bool scaled = std::any_of(plan.parameters.begin(), plan.parameters.end(),
                                    [](const SweepParameter& p) { return !p.factors.empty(); });
    for (const SweepParameter& p : plan.parameters) numbers_.push_back(in_one_unit(p.values));
    try {
      const Loaded loaded = load_scenario(plan.scenario, common_);
      Problems unheard;
      if (scaled) tree_ = explicit_tree(loaded.scenario), document_ = read_document(plan.scenario, common_, unheard);
    } catch (const ScenarioError& error) {
      throw ScenarioError(fmt::format("{}: the scenario itself is refused:\n{}", file, error.what()));
    }
  }

  std::vector<SweepPoint> all() {
    std::vector<std::size_t> ranges;
    std::size_t combinations = 1;
    for (std::size_t k = 0; k < plan_.parameters.size(); ++k)
      plan_.parameters[k].is_range() ? ranges.push_back(k) : void(combinations *= plan_.parameters[k].values.size());
    const auto cube = latin_hypercube(ranges.empty() ? 1 : plan_.points, ranges.size(), plan_.seed);
    if (combinations * cube.size() > 100000)
      throw ScenarioError(fmt::format("{}: asks for {} runs; 100000 at most", file_, combinations * cube.size()));
    std::vector<SweepPoint> points;
    for (const std::vector<double>& u : cube)
      for (std::size_t c = 0; c < combinations; ++c) points.push_back(point(u, c, combinations));
    for (const SweepPoint& p : points) refuse_bad(p);
    return points;
  }

 private:
  SweepPoint point(const std::vector<double>& u, std::size_t combination, std::size_t combinations) const {
    SweepPoint p;
    p.sets = common_;
    std::size_t range = 0;
    for (std::size_t k = 0; k < plan_.parameters.size(); ++k) {
      const SweepParameter& parameter = plan_.parameters[k];
      std::string value;
      if (parameter.is_range()) {
        // Six digits: a value that can be typed again.
        value = fmt::format("{:.6g}{}{}", parameter.at(u[range++]), parameter.unit.empty() ? "" : " ", parameter.unit);
        p.places.push_back(WrittenNumber(value).number);
      } else {
        combinations /= parameter.values.size();
        const std::size_t i = combination / combinations % parameter.values.size();
        value = parameter.values[i];
        p.places.push_back(numbers_[k][i]);
      }
      p.values.push_back(value);
      for (const std::string& path : parameter.paths)
        p.sets.push_back(path + "=" + (parameter.factors.empty() ? value : scaled(path, p.places.back())));
    }
    return p;
  }

  std::string scaled(const std::string& path, double factor) const {
    try {
      return path.starts_with("parameters.") ? scaled_parameter(path, factor) : scaled_value(tree_, path, factor);
    } catch (const std::invalid_argument& error) {
      throw ScenarioError(fmt::format("{}: {}", file_, error.what()));
    }
  }

  /// The explicit scenario has the parameters' amounts in place of their names: they stand in the document alone.
  std::string scaled_parameter(const std::string& path, double factor) const {
    const Node* const node = value_at(document_, path);
    if (node == nullptr) refuse_no_value(path);
    return fmt::format("{}*({})", factor, node->scalar);
  }

  void refuse_bad(const SweepPoint& p) const {
    try {
      static_cast<void>(load_scenario(plan_.scenario, p.sets));
    } catch (const ScenarioError& error) {
      std::string words;
      for (std::size_t k = 0; k < p.values.size(); ++k)
        words += fmt::format("{}{} = {}", words.empty() ? "" : ", ", plan_.parameters[k].name, p.values[k]);
      throw ScenarioError(fmt::format("{}: the scenario refuses the point {}:\n{}", file_, words, error.what()));
    }
  }

  const std::string& file_;
  const SweepPlan& plan_;
  std::vector<std::string> common_;
  Node tree_, document_;
  std::vector<std::vector<double>> numbers_;  ///< of each parameter's list, in one unit
};

}  // namespace

std::vector<SweepPoint> sweep_points(const std::string& file, const SweepPlan& plan) {
  return Points(file, plan).all();
}

}  // namespace subsoil::sim
