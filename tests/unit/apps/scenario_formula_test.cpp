// The one grammar of formulas: values and derivatives of random formulas against an evaluator that shares nothing with
// the program, closed forms, kinks and poles, bounds, and that values with units speak the same language.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "libsim/document/arithmetic.hpp"
#include "libsim/document/expression.hpp"
#include "libsim/document/formula.hpp"
#include "libsim/document/quantity.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::sim::scenario_formula_test {
namespace {

const std::vector<std::string> of_t{"t"};

double value(const std::string& text, double t) { return Formula(text, of_t)(&t); }
std::array<double, 3> derivatives(const std::string& text, double t) {
  const Jet<1> once{{t, 1}, true};
  const Jet<2> twice{{t, 1, 0}, true};
  const Formula formula(text, of_t);
  const Jet<1> first = formula(&once);
  const Jet<2> second = formula(&twice);
  // Each order does the same operations for the lower ones.
  for (const int k : {0, 1})
    EXPECT_TRUE(first.c[k] == second.c[k] || (std::isnan(first.c[k]) && std::isnan(second.c[k]))) << text;
  return {second.c[0], second.c[1], second.c[2]};
}
std::string refusal(const std::string& text) {
  return test::message_of<UnitError>([&] { Formula(text, of_t); });
}

// ---- random formulas -----------------------------------------------------------------------------------------------

using Real = long double;
using OneNumber = std::function<Real(Real)>;
using TwoNumbers = std::function<Real(Real, Real)>;

/// A formula as a tree with its own text and its own value.
struct Tree {
  std::string text;
  OneNumber value;
  bool moves = false;   ///< with t
  bool broken = false;  ///< a constant in it has no finite value, or something is divided by a constant 0
};

/// The functions by their names, in long double: the oracle. Arguments of those with a bounded range are brought there.
using Ones = std::map<std::string_view, OneNumber>;
using Twos = std::map<std::string_view, TwoNumbers>;
const Ones of_one{{"sin", [](Real x) { return std::sin(x); }},
                  {"cos", [](Real x) { return std::cos(x); }},
                  {"tan", [](Real x) { return std::tan(x); }},
                  {"asin", [](Real x) { return std::asin(x); }},
                  {"acos", [](Real x) { return std::acos(x); }},
                  {"atan", [](Real x) { return std::atan(x); }},
                  {"sinh", [](Real x) { return std::sinh(x); }},
                  {"cosh", [](Real x) { return std::cosh(x); }},
                  {"tanh", [](Real x) { return std::tanh(x); }},
                  {"exp", [](Real x) { return std::exp(x); }},
                  {"log", [](Real x) { return std::log(x); }},
                  {"sqrt", [](Real x) { return std::sqrt(x); }},
                  {"abs", [](Real x) { return std::fabs(x); }},
                  {"sign", [](Real x) { return std::isnan(x) ? x : static_cast<Real>((x > 0) - (x < 0)); }}};
const Twos of_two{{"atan2", [](Real x, Real y) { return std::atan2(x, y); }},
                  {"hypot", [](Real x, Real y) { return std::sqrt(x * x + y * y); }},
                  {"min", [](Real x, Real y) { return std::isnan(x + y) ? x + y : std::fmin(x, y); }},
                  {"max", [](Real x, Real y) { return std::isnan(x + y) ? x + y : std::fmax(x, y); }},
                  {"pow", [](Real x, Real y) { return std::pow(x, y); }}};

class RandomFormulas {
 public:
  explicit RandomFormulas(unsigned seed) : random_(seed) {}

  Tree any(int depth) {
    const int kind = depth == 0 ? pick(2) : 2 + pick(10);
    switch (kind) {
      case 0:
        return {.text = "t", .value = [](Real t) { return t; }, .moves = true};
      case 1:
        return number();
      case 2:
        return sign_between(depth, '+', [](Real a, Real b) { return a + b; });
      case 3:
        return sign_between(depth, '-', [](Real a, Real b) { return a - b; });
      case 4:
        return sign_between(depth, '*', [](Real a, Real b) { return a * b; });
      case 5:
        return sign_between(depth, '/', [](Real a, Real b) { return a / b; });
      case 6: {  // a power by a whole number
        const Real p = pick(5) - 1;
        return one(any(depth - 1), "({})^" + fmt::format("{}", static_cast<double>(p)),
                   [p](Real x) { return std::pow(x, p); });
      }
      case 7:
        return one(any(depth - 1), "-({})", [](Real x) { return -x; });
      case 8: {
        const std::string_view name = function(2);
        return two(any(depth - 1), any(depth - 1), std::string(name) + "({}, {})", of_two.find(name)->second);
      }
      default: {
        const std::string_view name = function(1);
        return one(any(depth - 1), std::string(name) + "({})", of_one.find(name)->second);
      }
    }
  }
  /// A constant formula.
  std::string constant(int depth) {
    std::string text = any(depth).text;
    for (std::size_t at = 0; (at = text.find('t', at)) != std::string::npos; ++at) {
      const bool alone = (at == 0 || !std::isalpha(static_cast<unsigned char>(text[at - 1]))) &&
                         (at + 1 == text.size() || !std::isalnum(static_cast<unsigned char>(text[at + 1])));
      if (alone) text.replace(at, 1, "0.7");
    }
    return text;
  }

 private:
  int pick(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
  Tree number() {
    const Real x = (1 + pick(400)) * 0.0078125L;  // exact in double and in decimals
    return {.text = fmt::format("{}", static_cast<double>(x)), .value = [x](Real) { return x; }};
  }
  static Tree judged(Tree tree) {
    tree.broken = tree.broken || (!tree.moves && !std::isfinite(static_cast<double>(tree.value(0))));
    return tree;
  }
  static Tree one(const Tree& a, const std::string& form, const OneNumber& f) {
    return judged({fmt::format(fmt::runtime(form), a.text), [=](Real t) { return f(a.value(t)); }, a.moves, a.broken});
  }
  static Tree two(const Tree& a, const Tree& b, const std::string& form, const TwoNumbers& f) {
    return judged({fmt::format(fmt::runtime(form), a.text, b.text), [=](Real t) { return f(a.value(t), b.value(t)); },
                   a.moves || b.moves, a.broken || b.broken});
  }
  Tree sign_between(int depth, char sign, const TwoNumbers& f) {
    const Tree a = any(depth - 1), b = any(depth - 1);
    Tree both = two(a, b, std::string("({})") + sign + "({})", f);
    both.broken = both.broken || (sign == '/' && !b.moves && static_cast<double>(b.value(0)) == 0);
    return both;
  }
  std::string_view function(int arguments) {
    for (;;)
      if (const FormulaFunction& f = formula_functions[static_cast<std::size_t>(pick(formula_functions.size()))];
          f.arguments == arguments)
        return f.name;
  }
  std::mt19937 random_;
};

// A function that is added to the grammar needs an oracle here, or the random formulas would end in a null function.
TEST(Formula, EveryFunctionHasAnOracle) {
  for (const FormulaFunction& f : formula_functions)
    EXPECT_TRUE(f.arguments == 1 ? of_one.contains(f.name) : of_two.contains(f.name)) << f.name;
}

/// Central differences of sixth order of the oracle, in long double, with the change from twice the step as their
/// error.
struct Difference {
  Real value, error;
};
Difference difference(const OneNumber& f, Real t, int order) {
  const auto with = [&](Real h) {
    const Real a1 = f(t - h), a2 = f(t - 2 * h), a3 = f(t - 3 * h), b1 = f(t + h), b2 = f(t + 2 * h), b3 = f(t + 3 * h);
    return order == 1 ? (45 * (b1 - a1) - 9 * (b2 - a2) + (b3 - a3)) / (60 * h)
                      : (270 * (b1 + a1) - 27 * (b2 + a2) + 2 * (b3 + a3) - 490 * f(t)) / (180 * h * h);
  };
  const Real h = 5e-4L, fine = with(h), coarse = with(2 * h);
  return {fine, std::fabs(fine - coarse)};
}

// 20,000 formulas of up to four levels. The difference from twice the step is 64 times the error of a smooth formula,
// so it bounds that and the rounding of both: no tolerance is chosen but for the rounding of doubles, 1e-9 of the sizes
// that take part, which a value keeps unless its parts cancel; where they do, the oracle in double differs as much.
// Formulas near a kink or pole, where the differences fail, are left out; the counts show that most remain.
TEST(Formula, DerivativesOfRandomFormulasAgreeWithDifferences) {
  RandomFormulas random(17);
  int values = 0, undefined = 0, compared[3] = {0, 0, 0};
  for (int i = 0; i < 20000; ++i) {
    const Tree tree = random.any(1 + i % 4);
    const double t = 0.37 + 0.001 * (i % 997);
    const Real exact = tree.value(t);
    std::array<double, 3> got{};
    try {
      got = derivatives(tree.text, t);
    } catch (const UnitError& error) {
      ASSERT_TRUE(tree.broken) << tree.text << ": " << error.what();
      continue;
    }
    ASSERT_FALSE(tree.broken) << tree.text << ": not refused";
    if (!std::isfinite(static_cast<double>(exact)) || std::fabs(exact) > 1e6L) continue;
    // How much the value moves by rounding alone: the oracle at a point one part in 1e13 beside.
    const Real shaken = std::fabs(tree.value(t * (1 + 1e-13L)) - exact) * 1e3L;
    if (!(shaken <= 1e-6L)) continue;
    ++values;
    ASSERT_NEAR(got[0], static_cast<double>(exact), static_cast<double>(shaken + 1e-9L * (1 + std::fabs(exact))))
        << tree.text << " at " << t;
    for (const int order : {1, 2}) {
      const Difference d = difference(tree.value, t, order);
      if (!(d.error < 1e-6L * (1 + std::fabs(d.value))) || std::fabs(d.value) > 1e6L) continue;
      // asin(t/t) and sqrt(t - t) stand where the slope is infinite: no derivative, though the formula is constant.
      if (std::isnan(got[static_cast<std::size_t>(order)]) && ++undefined) continue;
      ++compared[order];
      ASSERT_NEAR(got[static_cast<std::size_t>(order)], static_cast<double>(d.value),
                  static_cast<double>(d.error + 2e-8L * (1 + std::fabs(d.value))))
          << tree.text << " at " << t << ", derivative " << order;
    }
  }
  RecordProperty("values", values), RecordProperty("undefined", undefined);
  RecordProperty("first", compared[1]), RecordProperty("second", compared[2]);
  EXPECT_LT(undefined, (compared[1] + compared[2]) / 100);
  EXPECT_GT(values, 9000);
  EXPECT_GT(compared[1], 8000);
  EXPECT_GT(compared[2], 8000);
}

// The oracle must be able to fail: it sees a slope that is wrong by 1e-6.
TEST(Formula, TheDifferencesSeeAWrongSlope) {
  const Difference d = difference([](Real t) { return std::sin(3 * t) * std::exp(-t); }, 0.8L, 1);
  const double right = derivatives("sin(3*t)*exp(-t)", 0.8)[1];
  EXPECT_LT(std::abs(static_cast<double>(d.value) - right), static_cast<double>(d.error) + 2e-8);
  EXPECT_GT(std::abs(static_cast<double>(d.value) - right * (1 + 1e-6)), static_cast<double>(d.error) + 2e-8);
}

// ---- kinks and poles -----------------------------------------------------------------------------------------------

TEST(Formula, DerivativesAtKinks) {
  EXPECT_EQ(derivatives("abs(t)", 0), (std::array<double, 3>{0, 0, 0}));
  EXPECT_EQ(derivatives("sign(t)", 0), (std::array<double, 3>{0, 0, 0}));
  EXPECT_EQ(derivatives("max(4*t, 2*t^2)", 0), (std::array<double, 3>{0, 2, 2})) << "half of each where both are equal";
  EXPECT_EQ(derivatives("min(4*t, 2*t^2)", 0), (std::array<double, 3>{0, 2, 2}));
  EXPECT_EQ(derivatives("max(4*t, 2*t^2)", 3), (std::array<double, 3>{18, 12, 4}));
  EXPECT_EQ(derivatives("t^2", 0), (std::array<double, 3>{0, 0, 2}));
  EXPECT_EQ(derivatives("t^3", 0), (std::array<double, 3>{0, 0, 0}));
  EXPECT_EQ(derivatives("(t + 2)^1", -2), (std::array<double, 3>{0, 1, 0}));
  EXPECT_EQ(derivatives("t^0", 0), (std::array<double, 3>{1, 0, 0}));
  EXPECT_EQ(derivatives("sqrt(1 - t^0)", 0.5), (std::array<double, 3>{0, 0, 0}));
}

// Before a drive begins its root, power or quotient has an argument at rest: its derivatives are 0, not 0 times
// infinity.
TEST(Formula, DerivativesBeforeADriveBegins) {
  for (const char* text : {"sqrt(max(0, t - 1))", "max(0, t - 1)^1.5", "max(0, t - 1)^0.3", "hypot(max(0, t - 1), 0)",
                           "pow(max(0, t - 1), 1.2)", "asin(min(1, t + 1))*0", "0^t", "exp(log(max(1, t))^0.5) - 1"})
    EXPECT_EQ(derivatives(text, 0.5), (std::array<double, 3>{0, 0, 0})) << text;
  // A point of infinite or undefined slope is no number, whatever the true limit is: nothing is guessed.
  EXPECT_TRUE(std::isinf(derivatives("sqrt(t)", 0)[1]));
  for (const char* text : {"(t^3)^(1/3)", "sqrt(t^2)", "atan2(t, t)", "hypot(t, t)"})
    EXPECT_TRUE(std::isnan(derivatives(text, 0)[1])) << text;
}

// What does not exist does not vanish in a function of two: max(0, 0/0) is no number, in either order.
TEST(Formula, NoValueStaysNoValue) {
  for (const char* text : {"max(0, t/t)", "max(t/t, 0)", "min(0, t/t)", "min(t/t, 0)", "sign(t/t)",
                           "max(0, log(t - 1))", "hypot(1, t/t)", "t/t", "0*log(-1 - t)"})
    EXPECT_TRUE(std::isnan(value(text, 0))) << text;
  EXPECT_TRUE(std::isnan(derivatives("max(0, sqrt(t))", -1)[1]));
  EXPECT_EQ(value("sqrt(max(0, t))", -1), 0) << "the cure";
}

// Nothing is cancelled or rearranged: the value is that of the operations in their order, to the last bit.
TEST(Formula, DoesWhatIsWritten) {
  for (const double t : {0.1, 0.3, 1.7, 1e9}) {
    EXPECT_EQ(value("t + 0.1 + 0.2", t), (t + 0.1) + 0.2);
    EXPECT_EQ(value("0.1 + 0.2 + t", t), (0.1 + 0.2) + t);
    EXPECT_EQ(value("t*3/7", t), t * 3 / 7);
    EXPECT_EQ(value("(t + 1e17) - 1e17", t), (t + 1e17) - 1e17);
    EXPECT_EQ(value("2 - t/3 - 5", t), 2 - t / 3 - 5);
    EXPECT_EQ(value("3/(1 - t)", t), 3 / (1 - t));
    EXPECT_EQ(value("t^-2", t), std::pow(t, -2));
    EXPECT_EQ(value("2^t", t), std::pow(2, t));
    EXPECT_EQ(value("max(2, t) - min(t, 2)", t), std::max(2., t) - std::min(t, 2.));
  }
}

// ---- bounds --------------------------------------------------------------------------------------------------------

// prod (1 + t/i) for i up to 600: f'/f = sum 1/(i + t), f''/f = (f'/f)^2 - sum 1/(i + t)^2. Its second derivative
// written out would have 360,000 terms; 600 roundings of 1e-16 make 1e-13.
TEST(Formula, LongProductsAreDifferentiatedInOnePass) {
  std::string product = "1";
  for (int i = 1; i <= 600; ++i) product += fmt::format("*(1 + t/{})", i);
  const double t = 0.6;
  double f = 1, once = 0, twice = 0;
  for (int i = 1; i <= 600; ++i) f *= 1 + t / i, once += 1 / (i + t), twice += 1 / ((i + t) * (i + t));
  const std::array<double, 3> got = derivatives(product, t);
  EXPECT_NEAR(got[0], f, 1e-12 * f);
  EXPECT_NEAR(got[1], f * once, 1e-12 * f * once);
  EXPECT_NEAR(got[2], f * (once * once - twice), 1e-12 * f * once * once);
}

// The most values on the stack that 100 levels can ask for.
TEST(Formula, EveryPermittedDepthHasAValue) {
  const auto nested = [](int levels) {
    std::string text;
    for (int i = 0; i < levels; ++i) text += "t+t*t^max(t,";
    return text + "t" + std::string(static_cast<std::size_t>(levels), ')');
  };
  double expected = 0.5;
  for (int i = 0; i < 100; ++i) expected = 0.5 + 0.5 * std::pow(0.5, std::max(0.5, expected));
  EXPECT_EQ(value(nested(100), 0.5), expected);
  EXPECT_TRUE(std::isfinite(derivatives(nested(100), 0.5)[2]));
  EXPECT_EQ(refusal(nested(101)), "nests more than 100 brackets; leave out those that change nothing");
}

// 10,000 characters of any kind are read and differentiated within a second, here in some ms.
TEST(Formula, TheLongestFormulasAreRead) {
  const auto begin = std::chrono::steady_clock::now();
  for (const std::string part : {"+t", "*2", "^2)*(t", "/(t+2)", "--t", "+sin(t)", "+max(t,2)"}) {
    std::string text = "(t";
    while (text.size() + part.size() < 9990) text += part;
    EXPECT_TRUE(std::isfinite(derivatives(text + ")", 1e-3)[0]) || part == "*2") << part;
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
}

// ---- one language --------------------------------------------------------------------------------------------------

// Values with units and formulas are read by one grammar: a constant is the same in both, to the last bit.
TEST(Formula, ValuesOfAScenarioSpeakTheSameLanguage) {
  RandomFormulas random(5);
  int same = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::string text = random.constant(1 + i % 3);
    double formula = 0;
    std::string fault;
    try {
      formula = Formula(text, {})(&formula);
    } catch (const UnitError& error) {
      fault = error.what();
    }
    if (!fault.empty() || text.find("asin") != std::string::npos || text.find("acos") != std::string::npos ||
        text.find("atan") != std::string::npos)
      continue;  // in a scenario their values are angles, which may not be added to numbers
    ASSERT_EQ(evaluate_arithmetic(text).value, formula) << text;
    ++same;
  }
  EXPECT_GT(same, 1000);
}

TEST(Formula, FunctionsOfValuesWithUnits) {
  EXPECT_DOUBLE_EQ(parse_quantity("pow(2 m, 3)", "m^3"), 8);
  EXPECT_DOUBLE_EQ(parse_quantity("sign(-3 m)*2 s", "s"), -2);
  EXPECT_DOUBLE_EQ(parse_quantity("2*tanh(0.5) m", "m"), 2 * std::tanh(0.5)) << "behind the bracket of a function too";
  EXPECT_DOUBLE_EQ(parse_quantity("+3 m/min + 2*min(1, 2) m/min", "m/s"), 5. / 60) << "min without a bracket is a unit";
  EXPECT_DOUBLE_EQ(parse_quantity("2 m*e + (1/2) m*pi", "m"), 2 * std::numbers::e + std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(parse_quantity("3 N/m^(2*(n+1)/2)", "N/m^(n+1)", 1.5), 3);
  EXPECT_EQ(test::message_of<UnitError>([] { parse_quantity("3 N/m^(2^)", "N/m"); }),
            "the unit `N/m^(2^)` has a power that is no formula: expected a number, a name or a bracket, got its end");
  EXPECT_EQ(test::message_of<UnitError>([] { parse_quantity("5 − 3 mm", "mm"); }),
            "unknown unit `−`; for the sign − write -");
}

TEST(Formula, SuperscriptsArePowers) {
  EXPECT_EQ(value("2*t² + 10⁻³", 3), 18 + 1e-3);
  EXPECT_DOUBLE_EQ(parse_quantity("(2 m)² + 1 m²", "m^2"), 5);
  EXPECT_EQ(refusal("t⁻"), "has a power in superscripts that is no number");
  EXPECT_EQ(refusal("t²^2"),
            "is no formula: of powers in a row it must say which comes first; write a^(b^c) or (a^b)^c");
}

TEST(Formula, RefusalsNameTheCure) {
  EXPECT_EQ(refusal("1 − t"), "`−` has no place in a formula; write -");
  EXPECT_EQ(refusal("2×t"), "`×` has no place in a formula; write *");
  EXPECT_EQ(refusal("t**2"), "is no formula: expected its end, got `*`; a power is written ^");
  EXPECT_EQ(refusal("2 t"), "is no formula: expected its end, got `t`; a product is written *");
  EXPECT_EQ(refusal("0,5*t"), "is no formula: expected its end, got `,`; a number has a point: 1.5");
  EXPECT_EQ(refusal("sin(0,5)"), "is no formula: `sin` takes one value; a number has a point: 1.5");
  EXPECT_EQ(refusal("min(t)"), "is no formula: `min` takes two values, got one");
  EXPECT_EQ(refusal("sin*t"), "`sin` is a function; write what it is the function of: sin(t)");
  EXPECT_EQ(refusal("t(2)"), "`t` is no function; a product is t*(...)");
  EXPECT_EQ(refusal("1/0 + t"), "divides by 0");
  EXPECT_EQ(refusal("t/0"), "divides by 0");
  EXPECT_EQ(refusal("log(0)*t"), "holds the logarithm of 0");
  EXPECT_EQ(refusal("10^400*t"), "holds a number too large for double precision");
}

// {moment: {expression: max(0, t), unit: N m}}: YAML ends the value at the comma.
TEST(Formula, AFormulaThatYamlCutIsNamed) {
  const std::string hint =
      "; between { } or [ ] YAML ends a value at a comma; put the formula in quotes: \"max(0, 1)\"";
  EXPECT_EQ(refusal("5*max(0"), "is no formula: expected `,`, got its end" + hint);
  EXPECT_EQ(refusal("2*(1 + min(sin(t)"), "is no formula: expected `,`, got its end" + hint);
  EXPECT_EQ(refusal("sin(t"), "is no formula: expected `)`, got its end") << "no comma is missing";
  EXPECT_EQ(test::message_of<UnitError>([] { parse_quantity("hypot(3 mm", "m"); }),
            "is no formula: expected `,`, got its end" + hint);
}

}  // namespace
}  // namespace subsoil::sim::scenario_formula_test
