// Formulas in t: values and derivatives against the same formulas written out by hand in C++, integrals against closed
// forms.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "libsim/document/expression.hpp"
#include "libsim/document/unit_database.hpp"
#include "libsim/document/units.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::sim::scenario_expression_test {
namespace {

using std::numbers::pi;

struct ByHand {
  const char* text;
  double (*value)(double);
  double (*first)(double);
  double (*second)(double);
};

// Each value is a few operations, so some ulps of its largest part; 1e-13 of 1 + |value| allows for the sizes below.
TEST(Expression, ValueAndDerivativesByHand) {
  const std::vector<ByHand> cases{
      {"0.1*sin(20*t)", [](double t) { return 0.1 * std::sin(20 * t); }, [](double t) { return 2 * std::cos(20 * t); },
       [](double t) { return -40 * std::sin(20 * t); }},
      {"3 - 2*t + t^3/6", [](double t) { return 3 - 2 * t + t * t * t / 6; }, [](double t) { return -2 + t * t / 2; },
       [](double t) { return t; }},
      {"-t^2", [](double t) { return -t * t; }, [](double t) { return -2 * t; }, [](double) { return -2.0; }},
      {"8/4/2 - 3 - 1", [](double) { return -3.0; }, [](double) { return 0.0; }, [](double) { return 0.0; }},
      {"e^(-t)", [](double t) { return std::exp(-t); }, [](double t) { return -std::exp(-t); },
       [](double t) { return std::exp(-t); }},
      {"sqrt(1 + t)", [](double t) { return std::sqrt(1 + t); }, [](double t) { return 0.5 / std::sqrt(1 + t); },
       [](double t) { return -0.25 * std::pow(1 + t, -1.5); }},
      {"atan2(t, 2)", [](double t) { return std::atan2(t, 2); }, [](double t) { return 2 / (4 + t * t); },
       [](double t) { return -4 * t / ((4 + t * t) * (4 + t * t)); }},
      {"abs(t - 1)", [](double t) { return std::abs(t - 1); }, [](double t) { return t > 1 ? 1.0 : -1.0; },
       [](double) { return 0.0; }},
      {"max(t, 1)*min(t^2, 4)", [](double t) { return std::max(t, 1.0) * std::min(t * t, 4.0); },
       [](double t) { return t < 1   ? 2 * t
                             : t < 2 ? 3 * t * t
                                     : 4.0; },
       [](double t) { return t < 1   ? 2.0
                             : t < 2 ? 6 * t
                                     : 0.0; }},
      {"sign(t - 1)*pow(t, 2)", [](double t) { return (t > 1 ? 1 : -1) * t * t; },
       [](double t) { return (t > 1 ? 2 : -2) * t; }, [](double t) { return t > 1 ? 2.0 : -2.0; }},
      {"log(t + 1) + tan(t/4)", [](double t) { return std::log(t + 1) + std::tan(t / 4); },
       [](double t) { return 1 / (t + 1) + 0.25 / std::pow(std::cos(t / 4), 2); },
       [](double t) { return -1 / ((t + 1) * (t + 1)) + std::tan(t / 4) / (8 * std::pow(std::cos(t / 4), 2)); }},
      {"asin(t/4) + acos(t/4) + atan(t) - pi/2", [](double t) { return std::atan(t); },
       [](double t) { return 1 / (1 + t * t); }, [](double t) { return -2 * t / ((1 + t * t) * (1 + t * t)); }},
      {"cosh(t)^2 - sinh(t)^2 + tanh(t)", [](double t) { return 1 + std::tanh(t); },
       [](double t) { return 1 / (std::cosh(t) * std::cosh(t)); },
       [](double t) { return -2 * std::tanh(t) / (std::cosh(t) * std::cosh(t)); }}};
  for (const ByHand& c : cases) {
    const mbd::Function f = make_expression(c.text, "m", 1);
    for (const double t : {0.13, 0.77, 1.41, 2.9}) {
      EXPECT_NEAR(f.value(t), c.value(t), 1e-13 * (1 + std::abs(c.value(t)))) << c.text << " at " << t;
      EXPECT_NEAR(f.first(t), c.first(t), 1e-12 * (1 + std::abs(c.first(t)))) << c.text << " at " << t;
      EXPECT_NEAR(f.second(t), c.second(t), 1e-12 * (1 + std::abs(c.second(t)))) << c.text << " at " << t;
    }
  }
}

// The integral over many periods, where it is near 0 beside that of |f|, and beyond kinks and jumps.
/// A sign binds closer than what follows its term, and less than a power: as in C++ and on paper.
TEST(Expression, SignsBehindOperatorsBelongToTheirTerm) {
  struct Case {
    const char* text;
    double (*value)(double);
  };
  for (const Case& c : std::vector<Case>{
           {"3*-t + 1", [](double t) { return 3 * -t + 1; }},
           {"3/-t + 1", [](double t) { return 3 / -t + 1; }},
           {"8/-t/2", [](double t) { return 8 / -t / 2; }},
           {"1 - -t + 1", [](double t) { return 1 + t + 1; }},
           {"1 + -t*2 + 5", [](double t) { return 1 - 2 * t + 5; }},
           {"1 - +t - 1", [](double t) { return 1 - t - 1; }},
           {"2^-t + 1", [](double t) { return std::pow(2, -t) + 1; }},
           {"2^-t*3 + 1", [](double t) { return std::pow(2, -t) * 3 + 1; }},
           {"t^+2 + 1", [](double t) { return t * t + 1; }},
           {"3*-t^2 + 1", [](double t) { return -3 * t * t + 1; }},
           {"3*-t^-2 + 1", [](double t) { return -3 / (t * t) + 1; }},
           {"2*--t + 1", [](double t) { return 2 * t + 1; }},
           {"2*-+-t + 1", [](double t) { return 2 * t + 1; }},
           {"-t + 1", [](double t) { return -t + 1; }},
           {"-t^2*3 + 1", [](double t) { return -t * t * 3 + 1; }},
           {"(-t + 1)*-(t - 3) + 7", [](double t) { return (-t + 1) * -(t - 3) + 7; }},
           {"5*-sin(-t + 1) + 2", [](double t) { return 5 * -std::sin(-t + 1) + 2; }},
           {"5*-max(-t + 1, 1 - -t)^2 + 2", [](double t) { return -5 * std::pow(std::max(-t + 1, 1 + t), 2) + 2; }},
       }) {
    const mbd::Function f = make_expression(c.text, "1", 1);
    for (const double t : {0.3, 1.7, 4.2})
      EXPECT_NEAR(f.value(t), c.value(t), 1e-13 * (1 + std::abs(c.value(t)))) << c.text << " at " << t;
  }
}

TEST(Expression, IntegralsInClosedForm) {
  const mbd::Function sine = make_expression("sin(20*t)", "1", 1);
  const mbd::Function kink = make_expression("abs(t - 1.3)", "1", 1);
  const mbd::Function jump = make_expression("sign(t - 0.7)", "1", 1);
  for (const double t : {7.3, -2.1, 0.0, 31.4, 0.4, 20 * pi}) {
    EXPECT_NEAR(sine.integral(t), (1 - std::cos(20 * t)) / 20, 1e-13) << t;
    EXPECT_NEAR(sine.double_integral(t), (t - std::sin(20 * t) / 20) / 20, 1e-12) << t;
    const auto primitive = [](double x) { return std::abs(x) * x / 2; };
    EXPECT_NEAR(kink.integral(t), primitive(t - 1.3) + primitive(1.3), 1e-12 * (1 + t * t)) << t;
    EXPECT_NEAR(jump.integral(t), std::abs(t - 0.7) - 0.7, 1e-12 * (1 + std::abs(t))) << t;
  }
}

// A root's pole has an area, 2 sqrt(|t - p|) on either side; 1/t has none.
TEST(Expression, IntegralsOverPoles) {
  for (const double pole : {0.01, 0.0101, 0.0123456}) {
    const mbd::Function root = make_expression(fmt::format("1/sqrt(abs(t - {}))", pole), "1", 1);
    EXPECT_NEAR(root.integral(0.02), 2 * (std::sqrt(pole) + std::sqrt(0.02 - pole)), 1e-5) << pole;
    const mbd::Function simple = make_expression(fmt::format("1/(t - {})", pole), "1", 1);
    EXPECT_NEAR(simple.integral(0.9 * pole), std::log(0.1), 1e-12) << pole;
    EXPECT_NE(test::message_of<std::runtime_error>([&] { simple.integral(0.02); }).find("grows without bound"),
              std::string::npos)
        << pole;
  }
}

// A half-sine of 5 ms at 5.2 s, with kinks at its ends: 2 T/pi by then, after that a straight line from its middle on.
// A smooth one: sqrt(pi) 2 ms of area about 5.31 s. Sums of some 3000 panels round by 1e-16 each of at most 5e-3.
TEST(Expression, IntegralsMeetAShortPulseFromAnyTime) {
  const mbd::Function half_sine =
      make_expression("sin(pi*(t-5.2)/0.005)*max(0,sign(t-5.2))*max(0,sign(5.205-t))", "1", 1);
  const mbd::Function smooth = make_expression("exp(-((t-5.31)/0.002)^2)", "1", 1);
  const double area = 2 * 5e-3 / pi, smooth_area = std::sqrt(pi) * 2e-3;
  for (double t = 5.33; t < 6.5; t += 0.0137) {
    EXPECT_NEAR(half_sine.integral(t), area, 1e-14) << t;
    EXPECT_NEAR(half_sine.double_integral(t), area * (t - 5.2025), 1e-14) << t;
    EXPECT_NEAR(smooth.integral(t), smooth_area, 1e-14) << t;
    EXPECT_NEAR(smooth.double_integral(t), smooth_area * (t - 5.31), 1e-14) << t;
  }
  // Inside: (1 - cos(pi s/T)) T/pi, s from its begin on.
  for (double s = 1e-4; s < 5e-3; s += 1e-4)
    EXPECT_NEAR(half_sine.integral(5.2 + s), (1 - std::cos(pi * s / 5e-3)) * 5e-3 / pi, 1e-14) << s;
}

// Just behind a jump or a kink, and wherever these lie beside the ends of the panels of 2 ms, no node of the sum is
// between them and the end: |t - c| and its integral, to rounding.
TEST(Expression, IntegralsSeeAJumpThatLiesAtTheirEnd) {
  for (const double c : {0.2315, 0.2319995, 0.2320004, 0.31}) {
    const auto jump = make_expression(fmt::format("sign(t - {})", c), "m/s^2", 1);
    const auto kink = make_expression(fmt::format("max(0, t - {})", c), "m/s^2", 1);
    for (const double beyond : {-1e-6, 1e-12, 1e-9, 1e-7, 1e-6, 5e-6, 1e-5, 1e-4, 3e-3}) {
      const double t = c + beyond, gone = std::max(beyond, 0.0);
      EXPECT_NEAR(jump.integral(t), std::abs(beyond) - c, 2e-15) << c << " s, " << beyond;
      EXPECT_NEAR(jump.double_integral(t), beyond * std::abs(beyond) / 2 + c * c / 2 - c * t, 2e-15) << beyond;
      EXPECT_NEAR(kink.integral(t), gone * gone / 2, 1e-15) << c << " s, " << beyond;
    }
  }
}

// A shock of 50 g as shakers give it: where sine and step are 0 together, halving finds but rounding. Its integrals are
// asked for at every evaluation of a driven machine, so each is of a bounded number of sums.
TEST(Expression, IntegralsOfAShockAreContinuous) {
  const mbd::Function shock = make_expression("490.5*sin(pi*(t-0.1)/0.011)*(sign(t-0.1)-sign(t-0.1-0.011))/2", "1", 1);
  const double area = 490.5 * 2 * 0.011 / pi;
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.1 + 1e-4 * i, s = std::min(t - 0.1, 0.011);
    EXPECT_NEAR(shock.integral(t), area / 2 * (1 - std::cos(pi * s / 0.011)), 1e-12) << t;
    EXPECT_NEAR(shock.integral(t + 1e-9), shock.integral(t), 490.5e-9 * (1 + 1e-6)) << t;
  }
}

// A formula that is nothing but rounding must not be refined for ever.
TEST(Expression, IntegralOfRoundingEnds) {
  const mbd::Function f = make_expression("cos(t + 0.5)^2 + sin(t + 0.5)^2 - 1", "1", 1);
  EXPECT_NEAR(f.integral(3), 0, 1e-15);
}

// The order of asking leaves no trace, not in one bit.
TEST(Expression, IntegralsDoNotDependOnWhatWasAskedBefore) {
  const mbd::Function forward = make_expression("exp(sin(3*t))", "1", 1);
  const mbd::Function backward = make_expression("exp(sin(3*t))", "1", 1);
  std::vector<double> up, down;
  for (int i = 0; i <= 40; ++i) up.push_back(forward.integral(0.21 * i) + forward.double_integral(0.21 * i));
  for (int i = 40; i >= 0; --i) down.push_back(backward.integral(0.21 * i) + backward.double_integral(0.21 * i));
  for (std::size_t i = 0; i <= 40; ++i) EXPECT_EQ(up[i], down[40 - i]) << i;
}

TEST(Expression, SizeIsThatOfItsUnit) {
  const mbd::Function f = make_expression("20*t^2", "mm", 0.001);
  EXPECT_DOUBLE_EQ(f.value(2), 0.08);
  EXPECT_DOUBLE_EQ(f.first(2), 0.08);
  EXPECT_DOUBLE_EQ(f.second(2), 0.04);
}

std::string refusal(const std::string& text) {
  return test::message_of<UnitError>([&] { make_expression(text, "1", 1); });
}

// A name that the scenario gives hides a constant.
/// Those that no program reads the database for are what it says, to the last bit.
TEST(Units, CommonOnesAreThoseOfTheDatabase) {
  const std::vector<std::string> names = units_without_database();
  EXPECT_GT(names.size(), 30u);
  for (const std::string& name : names) {
    const Unit known = parse_unit(name), there = unit_by_database(name);
    EXPECT_EQ(known.times, there.times) << name;
    EXPECT_EQ(known.over, there.over) << name;
    EXPECT_EQ(known.powers, there.powers) << name;
  }
  EXPECT_EQ(parse_unit("inch").powers, parse_unit("m").powers) << "any other name is read there";
}

TEST(Expression, NamesThatAreGivenHideConstants) {
  for (const char* name : {"e", "pi", "Pi", "Euler", "Catalan", "I", "Digits", "E"}) {
    const double values[] = {5, 7};
    const std::string n = name;
    EXPECT_EQ(make_formula_of("2*" + n + " + b^2", {n, "b"})(values), 59) << name;
    EXPECT_EQ(make_formula_of(n + "_*" + n, {n, n + "_"})(values), 35) << name;
    EXPECT_EQ(make_formula_of(n + "^9999999", {n, "b"})(std::array{1.0, 0.0}.data()), 1) << name;
  }
  EXPECT_NEAR(make_formula_of("pi + e*b", {"b"})(std::array{2.0}.data()), M_PI + 2 * M_E, 1e-15);
}

TEST(Expression, RefusesWithRuleAndCure) {
  EXPECT_EQ(refusal("sine(t)"), "`sine` is no name of a formula in t; did you mean `sin`?");
  EXPECT_EQ(refusal("2*frequency"),
            "`frequency` is no name of a formula in t; known here: t, pi, e, sin, cos, tan, asin, acos, atan, sinh, "
            "cosh, tanh, "
            "exp, log, sqrt, pow, atan2, abs, sign, hypot, min, max");
  EXPECT_EQ(refusal("sin(t"), "is no formula: expected `)`, got its end");
  EXPECT_EQ(refusal("sin(t, t)"), "is no formula: `sin` takes one value; a number has a point: 1.5");
  EXPECT_EQ(refusal("-+exp("), "is no formula: expected a number, a name or a bracket, got its end");  // was a crash
  EXPECT_EQ(refusal("2*-(t + 1"), "is no formula: expected `)`, got its end");
  EXPECT_EQ(refusal(""), "is no formula: expected a number, a name or a bracket, got its end");
  EXPECT_EQ(refusal("t = 1"), "`=` has no place in a formula; there are + - * / ^ ( ) and functions");
  EXPECT_EQ(refusal("2^t^2"),
            "is no formula: of powers in a row it must say which comes first; write a^(b^c) or (a^b)^c");
  EXPECT_EQ(refusal("sqrt(-2)*t"), "holds a number that is not real, such as a root or logarithm of a negative one");
  EXPECT_EQ(refusal("1e-3*t + 2E+1"), "accepted");
}

TEST(Expression, StopsWhereItHasNoValue) {
  const mbd::Function f = make_expression("log(t)", "1", 1);
  EXPECT_DOUBLE_EQ(f.value(1), 0);
  try {
    f.value(0);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "the formula `log(t)` has no finite value at t = 0 s");
  }
}

}  // namespace
}  // namespace subsoil::sim::scenario_expression_test
