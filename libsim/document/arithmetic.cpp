#include "libsim/document/arithmetic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

#include "libsim/document/characters.hpp"
#include "libsim/document/document.hpp"

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

constexpr std::array<std::string_view, 15> functions{"sqrt", "abs",  "min",  "max",   "hypot", "sin", "cos", "tan",
                                                     "asin", "acos", "atan", "atan2", "exp",   "log", "pi"};
/// Units that scenarios are written in: a parameter of such a name would make them hard to read.
constexpr std::array<std::string_view, 44> common_units{
    "m",   "mm",  "cm",   "dm",  "km",  "um",  "nm", "in",  "ft", "kg", "g",  "mg",      "t",   "s",   "ms",
    "us",  "min", "h",    "N",   "mN",  "kN",  "MN", "J",   "kJ", "W",  "kW", "Pa",      "kPa", "MPa", "GPa",
    "bar", "rad", "mrad", "deg", "rev", "rpm", "Hz", "kHz", "K",  "L",  "l",  "percent", "n",   "e"};

/// The word at the front: a letter, then letters, digits and _.
std::string_view word_at(std::string_view text) {
  std::size_t size = 0;
  while (size < text.size() && (is_letter(text[size]) || (size > 0 && is_digit(text[size])))) ++size;
  return text.substr(0, size);
}

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

class Calculation {
 public:
  Calculation(std::string_view text, std::optional<double> n) : rest_(text), n_(n) {}

  Amount whole() {
    const Amount result = sum();
    if (!rest_.empty())
      fail(fmt::format("cannot be read on from `{}`; several values stand in a list, [2*a, 30 mm]", rest_));
    if (!std::isfinite(result.value)) fail("has no finite value");
    return result;
  }

 private:
  [[noreturn]] static void fail(const std::string& text) { throw UnitError(text); }
  void skip() {
    while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
  }
  bool accept(char c) {
    skip();
    if (rest_.empty() || rest_.front() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void expect(char c, const char* where) {
    if (!accept(c)) fail(fmt::format("lacks a `{}` {}", c, where));
  }

  Amount sum() {
    Amount value = term();
    for (;;) {
      const bool plus = accept('+');
      if (!plus && !accept('-')) return value;
      const Amount next = term();
      if (!same(value, next))
        fail(fmt::format("adds {} to {}; both must be of one dimension", dimension(next), dimension(value)));
      value.value += plus ? next.value : -next.value;
    }
  }
  Amount term() {
    Amount value = factor();
    for (;;) {
      if (accept('*')) {
        value = scaled(value, factor(), 1);
      } else if (accept('/')) {
        value = scaled(value, factor(), -1);
      } else {
        return value;
      }
    }
  }
  /// Each sign and each power calls for a factor within the factor.
  void deeper() {
    if (++depth_ > 100) fail("nests more than 100 brackets, signs and powers; leave out those that change nothing");
  }
  Amount factor() {
    deeper();
    const Amount value = signed_factor();
    --depth_;
    return value;
  }
  Amount signed_factor() {
    if (accept('-')) {
      Amount value = factor();
      value.value = -value.value;
      return value;
    }
    Amount value = primary();
    if (!accept('^')) return value;
    const Amount power = factor();
    if (!plain(power)) fail(fmt::format("has the power {}, which must be a plain number", dimension(power)));
    value.value = std::pow(value.value, power.value);
    for (auto& [name, p] : value.powers) p *= power.value;
    if (power.value == 0) value.powers.clear();
    return value;
  }
  Amount primary() {
    skip();
    if (rest_.empty()) fail("ends where a number or parameter should follow");
    Amount value;
    if (accept('(')) {
      value = sum();
      expect(')', "");
      value = with_unit(value);
    } else if (is_digit(rest_.front()) || rest_.front() == '.') {
      value = with_unit({number()});
    } else if (is_letter(rest_.front())) {
      value = named();
    } else {
      fail(fmt::format("cannot be read at `{}`", rest_));
    }
    return value;
  }
  double number() {
    double value = 0;
    const auto [end, code] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (code != std::errc{}) fail(fmt::format("holds no number at `{}`", rest_));
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }

  /// The unit behind a number or bracket, as far as it goes: up to an operator that a number, bracket or parameter
  /// follows.
  Amount with_unit(const Amount& value) {
    skip();
    if (rest_.empty() ||
        !(is_letter(rest_.front()) || rest_.front() == '%' || static_cast<unsigned char>(rest_.front()) >= 0x80))
      return value;
    const std::string_view text = rest_.substr(0, unit_length());
    rest_.remove_prefix(text.size());
    const Unit unit = parse_unit(text, n_);
    Amount out = scaled(value, {1, unit.powers}, 1);
    out.value = unit.to_si(value.value);  // 18 mm is 18/1000 m, which 18 times 0.001 is not
    return out;
  }
  std::size_t unit_length() const {
    std::size_t i = 0, end = 0;
    while (i < rest_.size()) {
      const std::string_view from = rest_.substr(i);
      const char c = from.front();
      if (is_letter(c) || c == '%' || static_cast<unsigned char>(c) >= 0x80) {
        const std::string_view word = word_at(from);
        i += std::max<std::size_t>(word.size(), 1);
        while (i < rest_.size() && is_digit(rest_[i])) ++i;  // m2
        end = i;
      } else if (c == '^' || (c == '-' && i == end && i + 1 < rest_.size() && is_digit(rest_[i + 1]))) {
        i = end = power_end(i + 1);
      } else if (c == '/' || c == '*' || c == '.' || is_blank(c)) {
        const std::size_t next = rest_.find_first_not_of(" \t/*.", i);
        if (next == std::string_view::npos || !is_letter(rest_[next])) break;
        if (parameters && parameters->contains(word_at(rest_.substr(next)))) break;
        if (is_function(word_at(rest_.substr(next)))) break;
        i = next;
      } else {
        break;
      }
    }
    return end;
  }
  std::size_t power_end(std::size_t i) const {
    if (i < rest_.size() && rest_[i] == '(') {
      const std::size_t close = rest_.find(')', i);
      return close == std::string_view::npos ? rest_.size() : close + 1;
    }
    if (i < rest_.size() && (rest_[i] == '-' || rest_[i] == '+')) ++i;
    while (i < rest_.size() && (is_digit(rest_[i]) || rest_[i] == '.')) ++i;
    return i;
  }

  static bool is_function(std::string_view word) {
    return std::find(functions.begin(), functions.end(), word) != functions.end();
  }
  Amount named() {
    const std::string word{word_at(rest_)};
    rest_.remove_prefix(word.size());
    if (parameters) {
      const auto found = parameters->find(word);
      if (found != parameters->end()) {
        found->second.used = true;
        return found->second.amount;
      }
    }
    if (word == "pi") return with_unit({std::numbers::pi});
    if (is_function(word)) return call(word);
    std::vector<std::string> known(functions.begin(), functions.end());
    if (parameters)
      for (const auto& [name, parameter] : *parameters) known.push_back(name);
    fail(fmt::format("`{}` is no parameter{}", word, suggestion(word, known)));
  }
  Amount call(const std::string& word) {
    expect('(', ("behind " + word).c_str());
    std::vector<Amount> of{sum()};
    while (accept(',')) of.push_back(sum());
    expect(')', ("at the end of " + word).c_str());
    const bool two = word == "min" || word == "max" || word == "hypot" || word == "atan2";
    if (of.size() != (two ? 2U : 1U)) fail(fmt::format("`{}` takes {}", word, two ? "two values" : "one value"));
    return two ? of_two(word, of[0], of[1]) : of_one(word, of[0]);
  }
  static Amount of_two(const std::string& word, const Amount& a, const Amount& b) {
    if (!same(a, b))
      fail(fmt::format("`{}` is given {} and {}; both must be of one dimension", word, dimension(a), dimension(b)));
    if (word == "atan2") return {std::atan2(a.value, b.value), {{"rad", 1}}};
    const double value = word == "min"   ? std::min(a.value, b.value)
                         : word == "max" ? std::max(a.value, b.value)
                                         : std::hypot(a.value, b.value);
    return {value, a.powers};
  }
  static Amount of_one(const std::string& word, const Amount& a) {
    if (word == "abs") return {std::abs(a.value), a.powers};
    if (word == "sqrt") {
      if (a.value < 0) fail("takes the root of a negative number");
      Amount out{std::sqrt(a.value), a.powers};
      for (auto& [name, p] : out.powers) p /= 2;
      return out;
    }
    const bool turns = word == "sin" || word == "cos" || word == "tan";
    if (!plain(a) && !(turns && angle(a)))
      fail(fmt::format("`{}` is given {}; it takes {}", word, dimension(a),
                       turns ? "an angle or a plain number" : "a plain number"));
    const double x = a.value;
    if (word == "sin") return {std::sin(x)};
    if (word == "cos") return {std::cos(x)};
    if (word == "tan") return {std::tan(x)};
    if (word == "exp") return {std::exp(x)};
    if (word == "log") return {std::log(x)};
    return {word == "asin" ? std::asin(x) : word == "acos" ? std::acos(x) : std::atan(x), {{"rad", 1}}};
  }

  std::string_view rest_;
  std::optional<double> n_;
  int depth_ = 0;
};

}  // namespace

ParametersInScope::ParametersInScope() { parameters = new Parameters; }
ParametersInScope::~ParametersInScope() {
  delete parameters;
  parameters = nullptr;
}

void add_parameter(const std::string& name, const Amount& amount) {
  if (word_at(name) != name)
    throw UnitError("a parameter's name is a letter followed by letters, digits and _: it stands in arithmetic");
  const auto holds = [&](const auto& list) { return std::find(list.begin(), list.end(), name) != list.end(); };
  if (holds(common_units)) throw UnitError(fmt::format("`{}` is a unit; take a longer name for the parameter", name));
  if (holds(functions)) throw UnitError(fmt::format("`{}` is a function or constant; take another name", name));
  if (parameters) (*parameters)[name] = {amount};
}

bool has_parameters() { return parameters && !parameters->empty(); }

bool names_parameter(std::string_view text) {
  if (!has_parameters()) return false;
  for (std::size_t i = 0; i < text.size();) {
    const std::string_view word = word_at(text.substr(i));
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
    const std::string_view word = word_at(text.substr(i));
    if (!word.empty() && i + word.size() < text.size() && text[i + word.size()] == '(' && word != "n" &&
        std::find(functions.begin(), functions.end(), word) != functions.end())
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
    const std::string word{word_at(std::string_view(formula).substr(i))};
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

Amount evaluate_arithmetic(std::string_view text, std::optional<double> n) { return Calculation(text, n).whole(); }

}  // namespace subsoil::sim
