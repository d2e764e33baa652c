#include "libsim/document/formula_bounds.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "libsim/document/units.hpp"

namespace subsoil::sim {
namespace {

constexpr int deepest_nesting = 100;
constexpr std::size_t longest = 10000;  // characters
constexpr std::size_t longest_quoted = 60;
constexpr double most_bits = 1e5;   // of a whole number, worked out exactly
constexpr double most_terms = 2e5;  // of the second derivative

/// What a part of a formula costs.
struct Cost {
  std::optional<double> value{};            // of a constant, as far as double precision goes
  double bits = 0;                          // upper bound of the digits of any number in it
  double terms = 1, first = 1, second = 1;  // of the part, its first and second derivative
  double most = 1;                          // what it may be where its variables cancel, as t - t or t/t
};

/// f'' = (a b)'' = a'' b + 2 a' b' + a b''
Cost product(const Cost& a, const Cost& b) {
  Cost c;
  c.bits = a.bits + b.bits;
  c.terms = a.terms + b.terms + 1;
  c.first = a.first + b.terms + a.terms + b.first + 3;
  c.second = a.second + b.terms + 2 * (a.first + b.first) + a.terms + b.second + 8;
  c.most = a.most * b.most;
  return c;
}
/// Of a function of a part: g'(a) a' and g''(a) a'^2 + g'(a) a''.
Cost composed(const Cost& a) {
  Cost c = a;
  c.value.reset(), c.most = std::max(1.0, a.most);
  c.terms = a.terms + 1;
  c.first = a.terms + a.first + 4;
  c.second = 2 * a.terms + 2 * a.first + a.second + 10;
  return c;
}

class Bounds {
 public:
  Bounds(std::string_view text, std::span<const std::string> variables) : text_(text), variables_(variables) {}
  void all() {
    const Cost cost = sum();
    if (next() != '\0') refuse("its end");
    bound(cost);
  }

 private:
  char next() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  /// At what comes next.
  [[noreturn]] void refuse(const char* expected) {
    const char c = next();
    std::size_t end = at_ + 1;
    if (is_word(c))
      while (end < text_.size() && is_word(text_[end])) ++end;
    const std::string got =
        c == '\0' ? "its end" : "`" + std::string(text_.substr(at_, std::min(end - at_, longest_quoted))) + "`";
    throw UnitError("is no formula: expected " + std::string(expected) + ", got " + got);
  }
  static bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.'; }
  bool take(char c) {
    if (next() != c) return false;
    ++at_;
    return true;
  }
  static const Cost& bound(const Cost& cost) {
    if (cost.bits > most_bits)
      throw UnitError("holds powers that make numbers of more than 30,000 digits",
                      "write such a number with an exponent: 1e10");
    if (cost.second > most_terms)
      throw UnitError("has a second derivative of more than 200,000 terms",
                      "write it with fewer factors, or as a table");
    return cost;
  }

  Cost sum() {
    Cost left = term();
    for (char sign; (sign = next()) == '+' || sign == '-';) {
      ++at_;
      const Cost right = term();
      std::optional<double> value;
      if (left.value && right.value) value = sign == '+' ? *left.value + *right.value : *left.value - *right.value;
      left = bound({value, left.bits + right.bits + 1, left.terms + right.terms + 1, left.first + right.first + 1,
                    left.second + right.second + 1, left.most + right.most});
    }
    return left;
  }
  Cost term() {
    Cost left = signed_power();
    for (char sign; (sign = next()) == '*' || sign == '/';) {
      ++at_;
      const Cost right = signed_power();
      Cost both = product(left, right);
      if (left.value && right.value) both.value = sign == '*' ? *left.value * *right.value : *left.value / *right.value;
      if (sign == '/' && right.value) both.most = left.most / std::abs(*right.value);
      left = bound(both);
    }
    return left;
  }
  Cost signed_power() {
    bool negative = false;
    for (char sign; (sign = next()) == '+' || sign == '-'; ++at_) {
      negative = negative != (sign == '-');
      if (++signs_ > deepest_nesting)
        throw UnitError("holds too many signs", "one in front of a number or bracket is enough");
    }
    signs_ = 0;
    Cost cost = power();
    if (negative && cost.value) cost.value = -*cost.value;
    return cost;
  }
  Cost power() {
    Cost base = part();
    while (take('^')) base = raised(base, exponent());
    return base;
  }
  Cost exponent() {
    if (next() != '-' && next() != '+') return part();
    return signed_power();
  }
  static Cost raised(const Cost& base, const Cost& exponent) {
    Cost cost = composed(product(base, exponent));
    if (base.value && exponent.value) cost.value = std::pow(*base.value, *exponent.value);
    const double times = std::max(1.0, exponent.value ? std::abs(*exponent.value) : exponent.most);
    cost.most = cost.value ? std::abs(*cost.value) : std::pow(std::max(1.0, base.most), times);
    cost.bits = base.bits * times + exponent.bits;
    if (std::isnan(cost.bits)) cost.bits = 0;  // no number at all; GiNaC says so
    return bound(cost);
  }
  Cost part() {
    const char c = next();
    if (c == '(') return bracket();
    if (std::isdigit(static_cast<unsigned char>(c)) || c == '.') return number();
    if (std::isalpha(static_cast<unsigned char>(c)) || c == '_') return name();
    refuse("a number, a name or a bracket");
  }
  Cost bracket() {
    if (++depth_ > deepest_nesting)
      throw UnitError("nests more than 100 brackets", "leave out those that change nothing");
    take('(');
    if (next() == ')') throw UnitError("holds empty brackets", "write what belongs between them");
    const Cost inside = sum();
    if (!take(')')) refuse("`)`");
    --depth_;
    return inside;
  }
  Cost number() {
    char* end = nullptr;
    const std::string rest(text_.substr(at_, 400));
    const double value = std::strtod(rest.c_str(), &end);
    const auto length = static_cast<std::size_t>(end - rest.c_str());
    if (length == 0) refuse("a number");
    const std::string_view digits = std::string_view(rest).substr(0, length);
    if (!std::isfinite(value) || length >= 399) throw UnitError("holds a number too large for double precision");
    const std::string_view mantissa = digits.substr(0, digits.find_first_of("eE"));
    if (value == 0 && mantissa.find_first_of("123456789") != std::string_view::npos)
      throw UnitError("holds a number too small for double precision", "write 0");
    if (digits.size() - mantissa.size() > 8) throw UnitError("holds a number too large for double precision");
    at_ += length;
    Cost cost;
    cost.value = value, cost.most = value;
    cost.bits = std::abs(std::log2(std::max(std::abs(value), 1e-308))) + 4 * static_cast<double>(mantissa.size());
    if (value == 0) cost.bits = 1;
    return cost;
  }
  Cost name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) || text_[at_] == '_')) ++at_;
    const std::string word(text_.substr(begin, at_ - begin));
    if (next() != '(') {
      Cost cost;
      if (std::find(variables_.begin(), variables_.end(), word) != variables_.end()) return cost;
      if (word == "pi") cost.value = 3.141592653589793;
      if (word == "e") cost.value = 2.718281828459045;
      return cost;
    }
    return call(word);
  }
  Cost call(const std::string& word) {
    if (++depth_ > deepest_nesting)
      throw UnitError("nests more than 100 brackets", "leave out those that change nothing");
    take('(');
    if (next() == ')')
      throw UnitError(word + "() has empty brackets", "write what it is the function of: " + word + "(t)");
    const Cost first = sum();
    Cost cost = composed(first);
    const bool two = take(',');
    if (two) {
      const Cost second = sum();
      cost = word == "pow" ? raised(first, second) : composed(product(first, second));
    } else if (first.value) {
      cost.value = word == "sqrt" ? std::sqrt(*first.value) : word == "exp" ? std::exp(*first.value) : *first.value;
    }
    if (!take(')')) refuse(two ? "`)`" : "`)` or `,`");
    --depth_;
    return bound(cost);
  }

  std::string_view text_;
  std::span<const std::string> variables_;
  std::size_t at_ = 0;
  int depth_ = 0, signs_ = 0;
};

}  // namespace

void check_formula_bounds(const std::string& formula, std::span<const std::string> variables) {
  if (formula.size() > longest)
    throw UnitError("is a formula of more than 10,000 characters", "write it shorter, or as a table");
  Bounds(formula, variables).all();
}

}  // namespace subsoil::sim
