#include "libsim/document/arithmetic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libsim/document/characters.hpp"
#include "libsim/document/grammar.hpp"

namespace subsoil::sim {
namespace {

struct Parameter {
  Amount amount;
  bool used = false;
};
using Parameters = std::map<std::string, Parameter, std::less<>>;
// Values are read deep inside declarations that know nothing of parameters, most of them in the libraries; to hand the
// parameters through all of them would make each depend on what only this file uses.
// Initial-exec: the library may be linked into a module that a program loads.
[[gnu::tls_model("initial-exec")]] thread_local Parameters* parameters = nullptr;

/// Units that scenarios are written in: a parameter of such a name would make them hard to read.
constexpr std::array<std::string_view, 44> common_units{
    "m",   "mm",  "cm",   "dm",  "km",  "um",  "nm", "in",  "ft", "kg", "g",  "mg",      "t",   "s",   "ms",
    "us",  "min", "h",    "N",   "mN",  "kN",  "MN", "J",   "kJ", "W",  "kW", "Pa",      "kPa", "MPa", "GPa",
    "bar", "rad", "mrad", "deg", "rev", "rpm", "Hz", "kHz", "K",  "L",  "l",  "percent", "n",   "e"};

bool same(const Amount& a, const Amount& b) { return a.powers == b.powers; }
bool plain(const Amount& a) { return a.powers.empty(); }
bool angle(const Amount& a) { return a.powers.size() == 1 && a.powers.contains("rad") && a.powers.at("rad") == 1; }

std::string dimension(const Amount& a) { return dimension_text(Unit{1, 1, a.powers}); }

Amount scaled(const Amount& a, const Amount& by, double sign) {
  Amount out{sign > 0 ? a.value * by.value : a.value / by.value, a.powers};
  for (const auto& [name, p] : by.powers) {
    double& sum = out.powers[name];
    sum += sign * p;
    if (std::abs(sum) < 1e-9) out.powers.erase(name);
  }
  return out;
}

/// A formula over a stack of amounts.
class Calculation {
 public:
  explicit Calculation(std::optional<double> n) : n_(n) {}

  void take(const Operation& o, const std::vector<Parameters::iterator>& named) {
    switch (o.kind) {
      case Operation::Kind::number:
        stack_.push_back({o.number});
        break;
      case Operation::Kind::name:
        named[o.name]->second.used = true;
        stack_.push_back(named[o.name]->second.amount);
        break;
      case Operation::Kind::unit:
        give_unit(parse_unit(o.unit, n_));
        break;
      case Operation::Kind::negate:
        stack_.back().value = -stack_.back().value;
        break;
      case Operation::Kind::call:
        call(o.call);
        break;
      default:
        two(o.kind);
    }
  }
  Amount result() const {
    if (!std::isfinite(stack_.back().value)) throw UnitError("has no finite value");
    return stack_.back();
  }

 private:
  [[noreturn]] static void fail(const std::string& text) { throw UnitError(text); }

  void give_unit(const Unit& unit) {
    Amount& a = stack_.back();
    const double value = unit.to_si(a.value);  // 18 mm is 18/1000 m, which 18 times 0.001 is not
    a = scaled(a, {1, unit.powers}, 1);
    a.value = value;
  }
  void two(Operation::Kind kind) {
    const Amount b = stack_.back();
    stack_.pop_back();
    Amount& a = stack_.back();
    switch (kind) {
      case Operation::Kind::multiply:
        a = scaled(a, b, 1);
        break;
      case Operation::Kind::divide:
        a = scaled(a, b, -1);
        break;
      case Operation::Kind::power:
        raise(a, b);
        break;
      default:
        if (!same(a, b)) fail(fmt::format("adds {} to {}; both must be of one dimension", dimension(b), dimension(a)));
        a.value += kind == Operation::Kind::add ? b.value : -b.value;
    }
  }
  static void raise(Amount& base, const Amount& power) {
    if (!plain(power)) fail(fmt::format("has the power {}, which must be a plain number", dimension(power)));
    base.value = std::pow(base.value, power.value);
    for (auto& [name, p] : base.powers) p *= power.value;
    if (power.value == 0) base.powers.clear();
  }

  void call(Call call) {
    const auto* const f = std::find_if(formula_functions.begin(), formula_functions.end(),
                                       [&](const FormulaFunction& known) { return known.call == call; });
    if (f->arguments == 1) return of_one(*f, stack_.back());
    const Amount b = stack_.back();
    stack_.pop_back();
    of_two(*f, stack_.back(), b);
  }
  static void of_two(const FormulaFunction& f, Amount& a, const Amount& b) {
    if (f.call == Call::pow) return raise(a, b);
    if (!same(a, b))
      fail(fmt::format("`{}` is given {} and {}; both must be of one dimension", f.name, dimension(a), dimension(b)));
    a.value = value_of(f.call, a.value, b.value);
    if (f.call == Call::atan2) a.powers = {{"rad", 1}};
  }
  static void of_one(const FormulaFunction& f, Amount& a) {
    if (f.call == Call::sqrt && a.value < 0) fail("takes the root of a negative number");
    const double value = value_of(f.call, a.value);
    if (f.call == Call::sqrt) {
      for (auto& [name, p] : a.powers) p /= 2;
    } else if (f.call == Call::sign) {
      a.powers.clear();
    } else if (f.call != Call::abs) {
      const bool turns = f.call == Call::sin || f.call == Call::cos || f.call == Call::tan;
      if (!plain(a) && !(turns && angle(a)))
        fail(fmt::format("`{}` is given {}; it takes {}", f.name, dimension(a),
                         turns ? "an angle or a plain number" : "a plain number"));
      a.powers.clear();
      if (f.call == Call::asin || f.call == Call::acos || f.call == Call::atan) a.powers = {{"rad", 1}};
    }
    a.value = value;
  }

  std::vector<Amount> stack_;
  std::optional<double> n_;
};

}  // namespace

ParametersInScope::ParametersInScope() { parameters = new Parameters; }
ParametersInScope::~ParametersInScope() {
  delete parameters;
  parameters = nullptr;
}

void add_parameter(const std::string& name, const Amount& amount) {
  if (name_at(name) != name)
    throw UnitError("a parameter's name is a letter followed by letters, digits and _: it stands in arithmetic");
  if (is_common_unit(name)) throw UnitError(fmt::format("`{}` is a unit; take a longer name for the parameter", name));
  if (is_formula_function(name) || is_formula_constant(name))
    throw UnitError(fmt::format("`{}` is a function or constant; take another name", name));
  if (parameters) (*parameters)[name] = {amount};
}

bool is_common_unit(std::string_view name) {
  return std::find(common_units.begin(), common_units.end(), name) != common_units.end();
}

bool has_parameters() { return parameters && !parameters->empty(); }

bool names_parameter(std::string_view text) {
  if (!has_parameters()) return false;
  for (std::size_t i = 0; i < text.size();) {
    const std::string_view word = name_at(text.substr(i));
    const bool behind_number = i > 0 && (is_digit(text[i - 1]) || text[i - 1] == '.');
    if (!word.empty() && !behind_number && parameters->contains(word)) return true;
    i += std::max<std::size_t>(word.size(), 1);
  }
  return false;
}

bool is_arithmetic(std::string_view text) {
  if (names_parameter(text)) return true;
  char before = ' ';  // the last that is no blank
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '^' && i + 1 < text.size() && text[i + 1] == '(') {  // the power of a unit: m^(n+1)
      i = std::min(text.find(')', i), text.size() - 1);
      before = text[i];
      continue;
    }
    const bool sign = i > 0 && is_blank(text[i - 1]) && i + 1 < text.size() && is_digit(text[i + 1]);  // 1 +2 mm
    const bool exponent = i > 1 && (text[i - 1] == 'e' || text[i - 1] == 'E') && is_digit(text[i - 2]);
    if (c == '+' && before != ' ' && before != '^' && before != '(' && !exponent && !sign) return true;
    if (c == '*') {
      const std::size_t next = text.find_first_not_of(" \t", i + 1);
      if (next != std::string_view::npos && (is_digit(text[next]) || text[next] == '(') && before != '*' &&
          text[next - 1] != '*')
        return true;
    }
    if (c == '(' && (before == ' ' || before == '-')) return true;
    const std::string_view word = name_at(text.substr(i));
    if (!word.empty() && i + word.size() < text.size() && text[i + word.size()] == '(' && word != "n" &&
        is_formula_function(word))
      return true;
    if (!word.empty()) i += word.size() - 1;
    if (!is_blank(c)) before = text[i];
  }
  return false;
}

bool parameter_is_used(const std::string& name) {
  if (!parameters) return false;
  const auto found = parameters->find(name);
  return found != parameters->end() && found->second.used;
}

std::string with_numbers(const std::string& formula, const std::vector<std::string>& variables, bool si) {
  std::string out;
  for (std::size_t i = 0; i < formula.size();) {
    const std::string word{name_at(std::string_view(formula).substr(i))};
    const bool behind_number = i > 0 && (is_digit(formula[i - 1]) || formula[i - 1] == '.');
    const bool variable = std::find(variables.begin(), variables.end(), word) != variables.end();
    const auto found =
        parameters && !word.empty() && !behind_number && !variable ? parameters->find(word) : Parameters::iterator{};
    if (!parameters || word.empty() || behind_number || variable || found == parameters->end()) {
      const std::size_t size = std::max<std::size_t>(word.size(), 1);
      out += formula.substr(i, size), i += size;
      continue;
    }
    if (!si && !plain(found->second.amount))
      throw UnitError(
          fmt::format("`{}` has a unit, and parameters with units stand in a formula for their numbers in "
                      "base units; give the formula's value in base units too",
                      word));
    found->second.used = true;
    out += fmt::format("({})", found->second.amount.value), i += word.size();
  }
  return out;
}

std::string in_base_units(const Amount& amount) {
  std::string out = fmt::format("{}", amount.value);
  for (const auto& [name, power] : amount.powers) out += fmt::format(" {}^{}", name, power);
  return out;
}

Amount evaluate_arithmetic(std::string_view text, std::optional<double> n) {
  std::vector<std::string> names;
  std::vector<Parameters::iterator> named;
  if (parameters)
    for (auto p = parameters->begin(); p != parameters->end(); ++p) names.push_back(p->first), named.push_back(p);
  Calculation calculation(n);
  for (const Operation& o : read_formula(text, {.names = names, .units = true})) calculation.take(o, named);
  return calculation.result();
}

}  // namespace subsoil::sim
