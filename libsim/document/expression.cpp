#include "libsim/document/expression.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ginac/ginac.h>

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "libsim/document/characters.hpp"
#include "libsim/document/document.hpp"
#include "libsim/document/formula_bounds.hpp"
#include "libsim/document/formula_signs.hpp"
#include "libsim/document/units.hpp"

namespace subsoil::sim {

// ---- functions that GiNaC does not have, or has for complex numbers ------------------------------------------------

namespace formula {
using GiNaC::ex;

DECLARE_FUNCTION_1P(sign)
DECLARE_FUNCTION_1P(magnitude)
DECLARE_FUNCTION_2P(min)
DECLARE_FUNCTION_2P(max)

ex sign_slope(const ex&, unsigned) { return 0; }
ex magnitude_slope(const ex& x, unsigned) { return sign(x); }
/// Of the one that counts, and half of each where they are equal.
ex min_slope(const ex& a, const ex& b, unsigned of) { return (1 + sign(of == 0 ? b - a : a - b)) / 2; }
ex max_slope(const ex& a, const ex& b, unsigned of) { return (1 + sign(of == 0 ? a - b : b - a)) / 2; }

REGISTER_FUNCTION(sign, derivative_func(sign_slope))
REGISTER_FUNCTION(magnitude, derivative_func(magnitude_slope))
REGISTER_FUNCTION(min, derivative_func(min_slope))
REGISTER_FUNCTION(max, derivative_func(max_slope))
}  // namespace formula

namespace {

using GiNaC::ex;

/// A function of formulas: the name under which GiNaC reads it and holds it in its trees, and how it is evaluated; sqrt
/// and pow become powers.
struct Known {
  const char* word;
  const char* in_tree;
  double (*one)(double);
  double (*two)(double, double);
};
const std::array<Known, 18> known_functions{{
    {"sin", "sin", [](double x) { return std::sin(x); }, nullptr},
    {"cos", "cos", [](double x) { return std::cos(x); }, nullptr},
    {"tan", "tan", [](double x) { return std::tan(x); }, nullptr},
    {"asin", "asin", [](double x) { return std::asin(x); }, nullptr},
    {"acos", "acos", [](double x) { return std::acos(x); }, nullptr},
    {"atan", "atan", [](double x) { return std::atan(x); }, nullptr},
    {"sinh", "sinh", [](double x) { return std::sinh(x); }, nullptr},
    {"cosh", "cosh", [](double x) { return std::cosh(x); }, nullptr},
    {"tanh", "tanh", [](double x) { return std::tanh(x); }, nullptr},
    {"exp", "exp", [](double x) { return std::exp(x); }, nullptr},
    {"log", "log", [](double x) { return std::log(x); }, nullptr},
    {"sqrt", "sqrt", nullptr, nullptr},
    {"pow", "pow", nullptr, nullptr},
    {"atan2", "atan2", nullptr, [](double y, double x) { return std::atan2(y, x); }},
    {"abs", "magnitude", [](double x) { return std::abs(x); }, nullptr},
    {"sign", "sign", [](double x) { return static_cast<double>((x > 0) - (x < 0)); }, nullptr},
    {"min", "min", nullptr, [](double x, double y) { return std::min(x, y); }},
    {"max", "max", nullptr, [](double x, double y) { return std::max(x, y); }},
}};

// ---- reading -------------------------------------------------------------------------------------------------------

bool is_digit_or_point(char c) { return is_digit(c) || c == '.'; }

/// Length of the number that `text` begins with: digits and an exponent.
std::size_t number_length(std::string_view text) {
  const auto digits_from = [&](std::size_t i) {
    while (i < text.size() && is_digit_or_point(text[i])) ++i;
    return i;
  };
  const std::size_t mantissa = digits_from(0);
  if (mantissa == text.size() || (text[mantissa] != 'e' && text[mantissa] != 'E')) return mantissa;
  std::size_t exponent = mantissa + 1;
  if (exponent < text.size() && (text[exponent] == '+' || text[exponent] == '-')) ++exponent;
  const std::size_t end = digits_from(exponent);
  return end > exponent ? end : mantissa;
}

/// The variables of a formula.
using Symbols = std::vector<GiNaC::realsymbol>;

bool is_variable(const std::string& name, const Symbols& variables) {
  return std::any_of(variables.begin(), variables.end(), [&](const auto& v) { return v.get_name() == name; });
}

/// What GiNaC's parser knows a variable by: its name, but where that is one of its own constants' or of ours, which the
/// variable hides.
std::string variable_in_tree(std::string name, const Symbols& variables) {
  static constexpr std::array constants{"pi", "e", "Pi", "Euler", "Catalan", "I", "Digits"};
  if (std::find(constants.begin(), constants.end(), name) == constants.end()) return name;
  do name += '_';
  while (is_variable(name, variables));
  return name;
}

std::string name_in_tree(const std::string& name, const Symbols& variables) {
  if (is_variable(name, variables)) return variable_in_tree(name, variables);
  std::vector<std::string> known;
  for (const GiNaC::realsymbol& v : variables) known.push_back(v.get_name());
  const std::string arguments = fmt::format("{}", fmt::join(known, ", "));
  known.insert(known.end(), {"pi", "e"});
  if (std::find(known.begin(), known.end(), name) != known.end()) return name;
  for (const Known& f : known_functions)
    if (name == f.word) return f.in_tree;
  for (const Known& f : known_functions) known.emplace_back(f.word);
  throw UnitError(fmt::format("`{}` is no name of a formula in {}{}", name, arguments, suggestion(name, known)));
}

/// The words of a formula, with GiNaC's names. GiNaC knows more words and signs than ours and does not say where it
/// stumbles over one, so they are looked at here.
std::vector<std::string> words_of(const std::string& text, const Symbols& variables) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i + 1;
    if (is_digit_or_point(text[i])) {
      end = i + number_length(std::string_view(text).substr(i));
      words.push_back(text.substr(i, end - i));
    } else if (is_letter(text[i])) {
      while (end < text.size() && (is_letter(text[end]) || is_digit_or_point(text[end]))) ++end;
      words.push_back(name_in_tree(text.substr(i, end - i), variables));
    } else if (std::string_view("+-*/^(),").find(text[i]) != std::string_view::npos) {
      words.emplace_back(1, text[i]);
    } else if (text[i] != ' ' && text[i] != '\t') {
      throw UnitError(fmt::format("`{}` has no place in a formula; there are + - * / ^ ( ) and functions", text[i]));
    }
    i = end;
  }
  return words;
}

/// "expected ')' ..., got: EOF" out of GiNaC's message, which also names its own source.
std::string fault_of(const std::string& message) {
  const std::size_t from = message.find("column 0: ");
  std::string fault = from == std::string::npos ? message : message.substr(from + 10);
  fault = fault.substr(0, fault.find('\n'));
  for (const auto& [theirs, ours] : {std::pair("EOF", "its end"), std::pair("magnitude", "abs")})
    if (const std::size_t at = fault.find(theirs); at != std::string::npos)
      fault.replace(at, std::string_view(theirs).size(), ours);
  return fault;
}

ex read_formula(const std::string& text, const Symbols& variables) {
  const std::vector<std::string> words = words_of(text, variables);
  std::vector<std::string> hidden;
  for (const GiNaC::realsymbol& v : variables) hidden.push_back(v.get_name());
  check_formula_bounds(text, hidden);
  const std::string formula = with_signs_in_brackets(words);
  GiNaC::symtab names;
  names["pi"] = GiNaC::Pi, names["e"] = GiNaC::exp(ex(1));
  for (const GiNaC::realsymbol& v : variables) names[variable_in_tree(v.get_name(), variables)] = v;
  try {
    return GiNaC::parser(names, true)(formula);
  } catch (const GiNaC::parse_error& error) {
    throw UnitError(fmt::format("is no formula: {}", fault_of(error.what())));
  } catch (const std::exception& error) {
    const std::string fault = error.what();
    if (fault.find("make_binop_expr") != std::string::npos)
      throw UnitError("is no formula: of powers in a row it must say which comes first; write a^(b^c) or (a^b)^c");
    throw UnitError(fmt::format("is no formula: {}", fault));
  }
}

// ---- evaluating ----------------------------------------------------------------------------------------------------

enum class Do { number, variable, add, multiply, power, square, root, reciprocal, one, two };
struct Step {
  Do what = Do::number;
  double number = 0;
  std::size_t function = 0;  // which function, or which variable
  auto operator<=>(const Step&) const = default;
};
using Steps = std::vector<Step>;

/// A formula as steps on a stack. GiNaC keeps sums and products in an order of its own that differs from run to run;
/// here their parts are sorted, so that rounding is the same in every run.
class Program {
 public:
  static constexpr std::size_t deepest = 64;

  Program(const ex& e, const Symbols& variables) {
    try {
      steps_ = flatten(e, variables);
    } catch (const std::domain_error& error) {  // 0^-e, which is evaluated here only
      throw UnitError(fmt::format("is no formula: {}", error.what()));
    }
    std::size_t depth = 0, most = 0;
    for (const Step& s : steps_) {
      if (s.what <= Do::variable) most = std::max(most, ++depth);
      if (takes_two(s)) --depth;
    }
    if (most > deepest) throw UnitError("is too deeply nested a formula; write it with fewer brackets");
  }

  /// `at`: values of the variables, in their order.
  double operator()(const double* at) const {
    std::array<double, deepest> stack;
    std::size_t top = 0;  // one above the last value
    for (const Step& s : steps_) {
      if (takes_two(s)) --top;
      switch (s.what) {
        case Do::number:
          stack[top++] = s.number;
          break;
        case Do::variable:
          stack[top++] = at[s.function];
          break;
        case Do::add:
          stack[top - 1] += stack[top];
          break;
        case Do::multiply:
          stack[top - 1] *= stack[top];
          break;
        case Do::power:
          stack[top - 1] = std::pow(stack[top - 1], stack[top]);
          break;
        case Do::square:
          stack[top - 1] *= stack[top - 1];
          break;
        case Do::root:
          stack[top - 1] = std::sqrt(stack[top - 1]);
          break;
        case Do::reciprocal:
          stack[top - 1] = 1 / stack[top - 1];
          break;
        case Do::one:
          stack[top - 1] = known_functions[s.function].one(stack[top - 1]);
          break;
        case Do::two:
          stack[top - 1] = known_functions[s.function].two(stack[top - 1], stack[top]);
          break;
      }
    }
    return stack[0];
  }

 private:
  static bool takes_two(const Step& s) {
    return s.what == Do::add || s.what == Do::multiply || s.what == Do::power || s.what == Do::two;
  }
  static void append(Steps& to, const Steps& from) { to.insert(to.end(), from.begin(), from.end()); }

  static Steps flatten(const ex& e, const Symbols& variables) {
    bool constant = true;
    for (std::size_t i = 0; i < variables.size(); ++i) {
      if (e.is_equal(variables[i])) return {{.what = Do::variable, .function = i}};
      constant = constant && !e.has(variables[i]);
    }
    if (constant)  // constants fold, unless GiNaC does not know their value, such as that of sign(2)
      if (const ex value = e.evalf(); GiNaC::is_a<GiNaC::numeric>(value)) return {number(value)};
    if (GiNaC::is_a<GiNaC::add>(e)) return chain(e, Do::add, variables);
    if (GiNaC::is_a<GiNaC::mul>(e)) return chain(e, Do::multiply, variables);
    if (GiNaC::is_a<GiNaC::power>(e)) return power(e, variables);
    if (GiNaC::is_a<GiNaC::function>(e)) return call(GiNaC::ex_to<GiNaC::function>(e), variables);
    throw UnitError("is no formula for one number");
  }
  static Step number(const ex& value) {
    if (!GiNaC::ex_to<GiNaC::numeric>(value).is_real())
      throw UnitError("holds a number that is not real, such as a root or logarithm of a negative one");
    const double real = GiNaC::ex_to<GiNaC::numeric>(value).to_double();
    if (!std::isfinite(real)) throw UnitError("holds a number too large for double precision");
    return {.what = Do::number, .number = real};
  }
  static Steps chain(const ex& e, Do what, const Symbols& variables) {
    std::vector<Steps> parts;
    for (std::size_t i = 0; i < e.nops(); ++i) parts.push_back(flatten(e.op(i), variables));
    std::sort(parts.begin(), parts.end());
    Steps steps = parts.front();
    for (std::size_t i = 1; i < parts.size(); ++i) append(steps, parts[i]), steps.push_back({.what = what});
    return steps;
  }
  static Steps power(const ex& e, const Symbols& variables) {
    Steps steps = flatten(e.op(0), variables);
    const Steps exponent = flatten(e.op(1), variables);
    const double p = exponent.size() == 1 && exponent[0].what == Do::number ? exponent[0].number : 0;
    const Do special = p == 2 ? Do::square : p == 0.5 ? Do::root : p == -1 ? Do::reciprocal : Do::power;
    if (special == Do::power) append(steps, exponent);
    steps.push_back({.what = special});
    return steps;
  }
  static Steps call(const GiNaC::function& f, const Symbols& variables) {
    Steps steps;
    for (std::size_t i = 0; i < f.nops(); ++i) append(steps, flatten(f.op(i), variables));
    for (std::size_t i = 0; i < known_functions.size(); ++i)
      if (f.get_name() == known_functions[i].in_tree) {
        steps.push_back({.what = f.nops() == 1 ? Do::one : Do::two, .function = i});
        return steps;
      }
    throw UnitError(fmt::format("needs the function `{}`, which has no value here", f.get_name()));
  }

  Steps steps_;
};

// ---- integrals -----------------------------------------------------------------------------------------------------

using Evaluate = std::function<double(double)>;

/// Integral of f over [a, b], and that of (b - s) f(s).
struct Area {
  double once = 0, twice = 0;
};

/// Both over [a, b] by 15-point Gauss-Kronrod sums of the same values of f, halving until that and the 7-point Gauss
/// sum agree to 4e-15 of the integral of |f|, or to what rounding of s itself leaves of f: its variation times b times
/// the precision, which is also all that is known of where a jump lies. The number of sums ends what no halving helps.
class Quadrature {
 public:
  explicit Quadrature(const Evaluate& f) : f_(f) {}
  Area operator()(double a, double b) {
    if (!(b > a)) return {};
    const Piece all = sum(a, b);
    allowed_ = 4e-15 * all.absolute, whole_ = all.absolute, mean_ = all.absolute / (b - a);
    return refine(all, a, b, 40);
  }

 private:
  struct Piece {
    Area area;
    double error, absolute, rounding;
  };
  Piece sum(double a, double b) {
    using Kronrod = boost::math::quadrature::gauss_kronrod<double, 15>;
    using Gauss = boost::math::quadrature::gauss<double, 7>;
    static const auto& x = Kronrod::abscissa();
    static const auto& w = Kronrod::weights();
    static const auto& w_gauss = Gauss::weights();  // its nodes are every other one, from the middle on
    --sums_left_;
    const double middle = 0.5 * (a + b), half = 0.5 * (b - a), f_middle = f_(middle);
    double once = w[0] * f_middle, lever = 0, gauss = w_gauss[0] * f_middle, absolute = w[0] * std::abs(f_middle);
    double least = f_middle, most = f_middle;
    for (std::size_t i = 1; i < x.size(); ++i) {
      const double below = f_(middle - half * x[i]), above = f_(middle + half * x[i]);
      once += w[i] * (below + above), lever += w[i] * x[i] * (below - above);
      absolute += w[i] * (std::abs(below) + std::abs(above));
      if (i % 2 == 0) gauss += w_gauss[i / 2] * (below + above);
      least = std::min({least, below, above}), most = std::max({most, below, above});
    }
    constexpr double precision = std::numeric_limits<double>::epsilon();
    return {{half * once, half * half * (once + lever)},
            half * std::abs(once - gauss),
            half * absolute,
            2 * precision * b * (most - least)};
  }
  Area refine(const Piece& piece, double a, double b, int halvings) {
    if (piece.error <= std::max(allowed_, piece.rounding)) return piece.area;
    if (halvings == 0 || sums_left_ <= 0) {
      // A jump has left 1e-12 of its error here, a root's pole 1e-6, and 1/t all of it.
      if (piece.error > 1e-3 * whole_ && piece.absolute > 1e3 * mean_ * (b - a))
        throw std::runtime_error(
            fmt::format("a formula has no integral over t = {:.6g} s: it grows without bound there", a));
      return piece.area;
    }
    const double middle = 0.5 * (a + b);
    const Piece first = sum(a, middle), second = sum(middle, b);
    const Area left = refine(first, a, middle, halvings - 1), right = refine(second, middle, b, halvings - 1);
    return {left.once + right.once, left.twice + left.once * (b - middle) + right.twice};
  }
  const Evaluate& f_;
  double allowed_ = 0, whole_ = 0, mean_ = 0;  // of |f| over all: its integral and its mean
  int sums_left_ = 300;
};

/// Integral and double integral of f from 0 to t >= 0. They are sums over panels whose ends are the same whatever t
/// is, kept and in the order of the panels, so that a value does not depend on what was asked before. The nodes of a
/// panel lie 0.21 ms apart at most: a pulse that is longer is met by one of them, and halving does the rest.
class Sums {
 public:
  explicit Sums(Evaluate f) : f_(std::move(f)) {}
  double once(double t) { return to(t).once; }
  double twice(double t) { return to(t).twice; }

 private:
  static constexpr double panel = 2e-3;         // s
  static constexpr std::size_t in_block = 256;  // panels

  struct Block {
    std::size_t index = 0;
    std::vector<Area> sums{};  ///< up to the begin of each of its panels, as far as they were asked for
  };
  Area to(double t) {
    const double count = std::floor(t / panel), begin = count * panel;
    if (count > 1e9) throw std::runtime_error("a formula is integrated up to 2e6 s from t = 0 and no farther");
    return joined(before(static_cast<std::size_t>(count)), Quadrature(f_)(begin, t), t - begin);
  }
  static Area joined(const Area& before, const Area& next, double length) {
    return {before.once + next.once, before.twice + before.once * length + next.twice};
  }
  /// Up to the begin of a panel. Of all blocks the sums before them are kept, of the last two all.
  Area before(std::size_t index) {
    const std::size_t block = index / in_block;
    while (starts_.size() <= block) starts_.push_back(up_to(kept(starts_.size() - 1), in_block));
    return up_to(kept(block), index % in_block);
  }
  Block& kept(std::size_t block) {
    for (Block& b : kept_)
      if (b.index == block && !b.sums.empty()) return b;
    std::swap(kept_[0], kept_[1]);
    return kept_[1] = {block, {starts_[block]}};
  }
  const Area& up_to(Block& block, std::size_t count) const {
    while (block.sums.size() <= count) {
      const auto index = static_cast<double>(block.index * in_block + block.sums.size() - 1);
      const double begin = index * panel, end = (index + 1) * panel;
      block.sums.push_back(joined(block.sums.back(), Quadrature(f_)(begin, end), end - begin));
    }
    return block.sums[count];
  }

  Evaluate f_;
  std::array<Block, 2> kept_;
  std::vector<Area> starts_{Area{}};
};

}  // namespace

mbd::ExpressionFunction make_expression(const std::string& text, const std::string& unit, double size) {
  const GiNaC::realsymbol t("t");
  const ex value = read_formula(text, {t});
  const auto evaluator = [&](const ex& e, const char* what) -> Evaluate {
    return [program = Program(e, {t}), text, what, size](double at) {
      const double result = size * program(&at);
      if (!std::isfinite(result))
        throw std::runtime_error(fmt::format("the formula `{}` has no finite {} at t = {} s", text, what, at));
      return result;
    };
  };
  mbd::ExpressionFunction f;
  f.text = text, f.unit = unit;
  f.value_ = evaluator(value, "value");
  try {
    f.first_ = evaluator(value.diff(t), "first derivative");
    f.second_ = evaluator(value.diff(t, 2), "second derivative");
  } catch (const std::exception& error) {  // 0^t
    throw UnitError(fmt::format("has no derivative in t: {}", error.what()));
  }
  const auto after = std::make_shared<Sums>(f.value_);
  const auto before = std::make_shared<Sums>([forward = f.value_](double s) { return forward(-s); });
  f.integral_ = [after, before](double at) { return at >= 0 ? after->once(at) : -before->once(-at); };
  f.double_integral_ = [after, before](double at) { return at >= 0 ? after->twice(at) : before->twice(-at); };
  return f;
}

std::function<double(double, double, double)> make_formula(const std::string& text,
                                                           const std::array<const char*, 3>& names) {
  return [formula = make_formula_of(text, {names.begin(), names.end()}), text, names](double a, double b, double c) {
    const double at[] = {a, b, c};
    const double result = formula(at);
    if (!std::isfinite(result))
      throw std::runtime_error(fmt::format("the formula `{}` has no finite value at {} = {}, {} = {}, {} = {}", text,
                                           names[0], a, names[1], b, names[2], c));
    return result;
  };
}

std::function<double(const double*)> make_formula_of(const std::string& text, const std::vector<std::string>& names) {
  Symbols variables;
  for (const std::string& name : names) variables.emplace_back(name);
  return Program(read_formula(text, variables), variables);
}

}  // namespace subsoil::sim
