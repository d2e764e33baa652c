#include "libsim/document/grammar.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

#include "libsim/base/problems.hpp"
#include "libsim/document/arithmetic.hpp"
#include "libsim/document/characters.hpp"

namespace subsoil::sim {
namespace {

constexpr int deepest_level = 100;
constexpr std::size_t longest_formula = 10000;  // characters
constexpr std::size_t longest_quote = 60;

const FormulaFunction* function_named(std::string_view word) {
  const auto* const found = std::find_if(formula_functions.begin(), formula_functions.end(),
                                         [&](const FormulaFunction& f) { return f.name == word; });
  return found == formula_functions.end() ? nullptr : found;
}

class FormulaReader {
 public:
  FormulaReader(std::string_view text, const FormulaLanguage& language) : rest_(text), language_(language) {}

  std::vector<Operation> whole() {
    if (rest_.size() > longest_formula)
      throw UnitError("is a formula of more than 10,000 characters", "write it shorter, or as a table");
    sum();
    if (next() != '\0') refuse("its end", language_.units ? "several values stand in a list, [2*a, 30 mm]" : "");
    return std::move(operations_);
  }

 private:
  using Kind = Operation::Kind;

  // ---- characters ----

  char next() {
    while (!rest_.empty() && (is_blank(rest_.front()) || rest_.front() == '\n' || rest_.front() == '\r'))
      rest_.remove_prefix(1);
    return rest_.empty() ? '\0' : rest_.front();
  }
  bool take(char c) {
    if (next() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void add(Kind kind) { operations_.push_back({.kind = kind}); }
  void add(double number) { operations_.push_back({.kind = Kind::number, .number = number}); }

  /// At what comes next.
  [[noreturn]] void refuse(const char* expected, std::string cure = "") {
    const char c = next();
    const std::string_view character = character_at(rest_);
    if (const char plain = typeset_operator_at(rest_))
      throw UnitError(fmt::format("`{}` has no place in a formula", character), fmt::format("write {}", plain));
    if (c != '\0' && !is_letter(c) && !is_digit(c) && std::string_view("+-*/^(),.").find(c) == std::string_view::npos &&
        superscript_at(rest_).plain == 0)
      throw UnitError(fmt::format("`{}` has no place in a formula", character),
                      "there are + - * / ^ ( ) and functions");
    std::size_t size = character.size();
    if (is_letter(c) || is_digit(c) || c == '.')
      while (size < rest_.size() && (is_letter(rest_[size]) || is_digit(rest_[size]) || rest_[size] == '.')) ++size;
    if (cure.empty() && c == ',') cure = "a number has a point: 1.5";
    if (cure.empty() && c == '*') cure = "a power is written ^";
    if (cure.empty() && (is_letter(c) || c == '(') && std::string_view(expected) == "its end")
      cure = "a product is written *";
    throw UnitError(
        fmt::format("is no formula: expected {}, got {}", expected,
                    c == '\0' ? "its end" : fmt::format("`{}`", rest_.substr(0, std::min(size, longest_quote)))),
        cure);
  }

  // ---- grammar ----

  void deeper() {
    if (++level_ > deepest_level)
      throw UnitError("nests more than 100 brackets", "leave out those that change nothing");
  }

  void sum() {
    term();
    for (;;) {
      const char sign = next();
      if (sign != '+' && sign != '-') return;
      rest_.remove_prefix(1);
      term();
      add(sign == '+' ? Kind::add : Kind::subtract);
    }
  }
  void term() {
    with_signs(&FormulaReader::power);
    for (;;) {
      const char sign = next();
      if ((sign != '*' && sign != '/') || rest_.starts_with("**")) return;
      rest_.remove_prefix(1);
      with_signs(&FormulaReader::power);
      add(sign == '*' ? Kind::multiply : Kind::divide);
    }
  }
  void with_signs(void (FormulaReader::*read)()) {
    bool negative = false;
    for (char sign; (sign = next()) == '+' || sign == '-'; rest_.remove_prefix(1)) negative = negative != (sign == '-');
    (this->*read)();
    if (negative) add(Kind::negate);
  }
  void power() {
    operand();
    if (!exponent()) return;
    add(Kind::power);
    if (next() == '^' || superscript_at(rest_).plain != 0)
      throw UnitError("is no formula: of powers in a row it must say which comes first", "write a^(b^c) or (a^b)^c");
  }
  bool exponent() {
    next();
    if (superscript_at(rest_).plain != 0) {
      const double value = take_superscripts(rest_);
      if (std::isnan(value)) throw UnitError("has a power in superscripts that is no number");
      add(value);
      return true;
    }
    if (!take('^')) return false;
    with_signs(&FormulaReader::operand);
    return true;
  }

  void operand() {
    const char c = next();
    if (c == '(') {
      deeper();
      rest_.remove_prefix(1);
      if (next() == ')') throw UnitError("holds empty brackets", "write what belongs between them");
      sum();
      if (!take(')')) refuse("`)`", cut_by_yaml());
      --level_;
      unit();
    } else if (is_digit(c) || c == '.') {
      number();
      unit();
    } else if (is_letter(c)) {
      named();
    } else {
      refuse("a number, a name or a bracket", c == '\0' ? cut_by_yaml() : "");
    }
  }
  void number() {
    double value = 0;
    const char* const begin = rest_.data();
    const auto [end, code] = std::from_chars(begin, begin + rest_.size(), value);
    if (code == std::errc::result_out_of_range) {
      if (std::abs(std::strtod(std::string(begin, end).c_str(), nullptr)) < 1)
        throw UnitError("holds a number too small for double precision", "write 0");
      throw UnitError("holds a number too large for double precision");
    }
    if (code != std::errc{}) refuse("a number");
    rest_.remove_prefix(static_cast<std::size_t>(end - begin));
    add(value);
  }
  void named() {
    const std::string_view word = name_at(rest_);
    const FormulaFunction* const function = function_named(word);
    const auto found = std::find(language_.names.begin(), language_.names.end(), word);
    const bool called = rest_.substr(word.size()).find_first_not_of(" \t") != std::string_view::npos &&
                        rest_[word.size() + rest_.substr(word.size()).find_first_not_of(" \t")] == '(';
    if (function != nullptr && (called || found == language_.names.end())) {
      rest_.remove_prefix(word.size());
      return call(*function);
    }
    if (found == language_.names.end() && !is_formula_constant(word)) unknown(word);
    rest_.remove_prefix(word.size());
    if (found != language_.names.end()) {
      operations_.push_back({.kind = Kind::name, .name = static_cast<std::size_t>(found - language_.names.begin())});
    } else {
      add(word == "pi" ? std::numbers::pi : std::numbers::e);
      unit();
    }
    if (called) throw UnitError(fmt::format("`{}` is no function", word), fmt::format("a product is {}*(...)", word));
  }
  void call(const FormulaFunction& f) {
    deeper();
    if (!take('('))
      throw UnitError(fmt::format("`{}` is a function", f.name),
                      fmt::format("write what it is the function of: {}({})", f.name, example_argument()));
    if (next() == ')')
      throw UnitError(fmt::format("{}() has empty brackets", f.name),
                      fmt::format("write what it is the function of: {}({})", f.name, example_argument()));
    open_pairs_ += f.arguments - 1;
    sum();
    const std::string takes =
        fmt::format("is no formula: `{}` takes {}", f.name, f.arguments == 1 ? "one value" : "two values");
    if (f.arguments == 2) {
      if (next() == ')') throw UnitError(takes + ", got one");
      if (!take(',')) refuse("`,`", cut_by_yaml());
      --open_pairs_;
      sum();
    }
    if (next() == ',') throw UnitError(takes, "a number has a point: 1.5");
    if (!take(')')) refuse("`)`", cut_by_yaml());
    --level_;
    operations_.push_back({.kind = Kind::call, .call = f.call});
    unit();
  }

  // ---- words ----

  std::string example_argument() const {
    return language_.units || language_.names.empty() ? "1" : language_.names.front();
  }
  /// A formula that ends before the second argument of a function: YAML ends a plain value at a comma in { } and [ ].
  std::string cut_by_yaml() {
    if (next() != '\0' || open_pairs_ == 0) return "";
    return "between { } or [ ] YAML ends a value at a comma; put the formula in quotes: \"max(0, 1)\"";
  }
  [[noreturn]] void unknown(std::string_view word) const {
    std::vector<std::string> known;
    if (!language_.units)
      known.assign(language_.names.begin(), language_.names.end()), known.insert(known.end(), {"pi", "e"});
    for (const FormulaFunction& f : formula_functions) known.emplace_back(f.name);
    if (language_.units) {
      known.insert(known.end(), {"pi", "e"});
      known.insert(known.end(), language_.names.begin(), language_.names.end());
      if (is_common_unit(word))
        throw UnknownName(word,
                          fmt::format("`{}` is a unit, and stands behind a number; no parameter has its name", word));
      throw UnknownName(word, fmt::format("`{}` is no parameter{}", word, suggestion(std::string(word), known)));
    }
    throw UnknownName(word, fmt::format("`{}` is no name of a formula in {}{}", word, fmt::join(language_.names, ", "),
                                        suggestion(std::string(word), known)));
  }

  // ---- units ----

  /// The unit behind the value just read.
  void unit() {
    if (!language_.units) return;
    const char c = next();
    if (!begins_unit(c) || superscript_at(rest_).plain != 0 || typeset_operator_at(rest_) != 0) return;
    const std::string_view text = rest_.substr(0, unit_length());
    rest_.remove_prefix(text.size());
    operations_.push_back({.kind = Kind::unit, .unit = text});
  }
  static bool begins_unit(char c) { return is_letter(c) || c == '%' || static_cast<unsigned char>(c) >= 0x80; }
  /// Up to an operator that a number, bracket, parameter, constant or function follows.
  std::size_t unit_length() const {
    std::size_t i = 0, end = 0;
    while (i < rest_.size()) {
      const std::string_view from = rest_.substr(i);
      const char c = from.front();
      if (begins_unit(c)) {
        if (const char plain = typeset_operator_at(from); plain != 0 && !from.starts_with("·")) break;
        i += std::max<std::size_t>(name_at(from).size(), 1);
        while (i < rest_.size() && is_digit(rest_[i])) ++i;  // m2
        end = i;
      } else if (c == '^' || (c == '-' && i == end && i + 1 < rest_.size() && is_digit(rest_[i + 1]))) {
        i = end = power_end(i + 1);
      } else if (c == '/' || c == '*' || c == '.' || is_blank(c)) {
        const std::size_t word = rest_.find_first_not_of(" \t/*.", i);
        if (word == std::string_view::npos || !is_letter(rest_[word]) || is_value(rest_.substr(word))) break;
        i = word;
      } else {
        break;
      }
    }
    return end;
  }
  /// Whether a parameter, a constant or the call of a function begins here: `min` alone is a unit.
  bool is_value(std::string_view text) const {
    const std::string_view word = name_at(text);
    if (std::find(language_.names.begin(), language_.names.end(), word) != language_.names.end()) return true;
    return is_formula_constant(word) || (is_formula_function(word) && text.substr(word.size()).starts_with('('));
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

  std::string_view rest_;
  const FormulaLanguage& language_;
  std::vector<Operation> operations_;
  int level_ = 0;
  int open_pairs_ = 0;  ///< functions of two values whose second is still to come
};

}  // namespace

bool is_formula_function(std::string_view word) { return function_named(word) != nullptr; }
bool is_formula_constant(std::string_view word) { return word == "pi" || word == "e"; }

std::vector<Operation> read_formula(std::string_view text, const FormulaLanguage& language) {
  return FormulaReader(text, language).whole();
}

double take_superscripts(std::string_view& text) {
  std::string digits;
  for (Typeset s; (s = superscript_at(text)).plain != 0; text.remove_prefix(s.character.size())) digits += s.plain;
  double value = 0;
  const char* const begin = digits.data() + (digits.starts_with('+') ? 1 : 0);
  const char* const behind = digits.data() + digits.size();
  const auto [end, code] = std::from_chars(begin, behind, value);
  return code == std::errc{} && end == behind ? value : std::numeric_limits<double>::quiet_NaN();
}

double value_of(Call call, double x, double y) {
  switch (call) {
    case Call::sin:
      return std::sin(x);
    case Call::cos:
      return std::cos(x);
    case Call::tan:
      return std::tan(x);
    case Call::asin:
      return std::asin(x);
    case Call::acos:
      return std::acos(x);
    case Call::atan:
      return std::atan(x);
    case Call::sinh:
      return std::sinh(x);
    case Call::cosh:
      return std::cosh(x);
    case Call::tanh:
      return std::tanh(x);
    case Call::exp:
      return std::exp(x);
    case Call::log:
      return std::log(x);
    case Call::sqrt:
      return std::sqrt(x);
    case Call::abs:
      return std::abs(x);
    case Call::sign:
      return x > 0 ? 1 : x < 0 ? -1 : x;  // NaN stays NaN
    case Call::atan2:
      return std::atan2(x, y);
    case Call::hypot:
      return std::hypot(x, y);
    case Call::min:
      return std::isnan(x) || y > x ? x : y;
    case Call::max:
      return std::isnan(x) || y < x ? x : y;
    case Call::pow:
      break;
  }
  return std::pow(x, y);
}

}  // namespace subsoil::sim
