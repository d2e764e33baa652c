#include "libmbd/base/function.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "tests/tools/message_of.hpp"

namespace subsoil::mbd::function_test {
namespace {

std::vector<Function> every_kind() {
  return {Function(2.5),
          PolynomialFunction{{1, -2, 0.5, 0.3, -0.1, 0.02}},
          HarmonicFunction{.mean = 0.4, .amplitude = 1.5, .frequency = 0.7, .phase = 0.3},
          RampFunction{.from = 1, .to = -2, .begin = 0.4, .end = 1.9},
          TableFunction{{-1, 0.5, 1.2, 3}, {0, 2, -1, 1}},
          TableFunction{{0.2, 0.5, 0.7, 1.3}, {1, 2, -1, 1}, true},
          TableFunction{{-1, 0.5, 1.2, 3}, {0, 2, -1, 1}, false, Between::monotone},
          TableFunction{{0.2, 0.5, 0.7, 1.3}, {1, 2, -1, 1}, true, Between::monotone},
          TableFunction{{-1, 0.5, 1.2, 3}, {0, 2, -1, 1}, false, Between::linear},
          TableFunction{{0.2, 0.5, 0.7, 1.3}, {1, 2, -1, 1}, true, Between::linear},
          SumFunction{{Function(1.0), HarmonicFunction{.amplitude = 2, .frequency = 0.3}}}};
}

// Central differences of step h err by h^2 f'''/6: 1e-10 times derivatives up to some 100 here, plus rounding 1e-11.
TEST(Function, DerivativesAndIntegralBelongToTheValue) {
  constexpr double h = 1e-5;
  for (const auto& f : every_kind())
    for (double t = -0.93; t < 3.5; t += 0.171) {
      EXPECT_NEAR(f.first(t), (f.value(t + h) - f.value(t - h)) / (2 * h), 1e-7) << "t = " << t;
      EXPECT_NEAR(f.second(t), (f.first(t + h) - f.first(t - h)) / (2 * h), 1e-6) << "t = " << t;
      EXPECT_NEAR(f.value(t), (f.integral(t + h) - f.integral(t - h)) / (2 * h), 1e-8) << "t = " << t;
      EXPECT_NEAR(f.integral(t), (f.double_integral(t + h) - f.double_integral(t - h)) / (2 * h), 1e-8) << "t = " << t;
    }
}

TEST(Function, IntegralStartsAtZero) {
  for (const auto& f : every_kind()) {
    EXPECT_EQ(f.integral(0), 0);
    EXPECT_EQ(f.double_integral(0), 0);
  }
}

// Double integrals of the closed kinds by hand: from 0 to 2 of an integral from 0.
TEST(Function, DoubleIntegralsInClosedForm) {
  EXPECT_DOUBLE_EQ(Function(3.0).double_integral(2), 6);
  EXPECT_DOUBLE_EQ(Function(PolynomialFunction{{1, 6, 12, 0, 0, 0}}).double_integral(2), 2 + 8 + 16);
  const double omega = 2 * std::numbers::pi * 0.7;
  const Function sine = HarmonicFunction{.mean = 0, .amplitude = 1.5, .frequency = 0.7, .phase = 0};
  EXPECT_NEAR(sine.double_integral(2), 1.5 * (2 * omega - std::sin(2 * omega)) / (omega * omega), 1e-15);
  // A ramp is point-symmetric about its middle: with its integral D h/2, its double integral is D h^2/7 (from x^7/7).
  const Function ramp = RampFunction{.from = 0, .to = 2, .begin = 0, .end = 1};
  EXPECT_NEAR(ramp.double_integral(1), 2.0 / 7, 1e-15);
  EXPECT_NEAR(ramp.double_integral(3), 2.0 / 7 + 1 * 2 + 2 * 2 * 2 / 2.0, 1e-14);
}

// A periodic spline through one period of a sine at 64 points: its error is h^4/384 of the fourth derivative.
TEST(Function, PeriodicTableRepeatsItself) {
  TableFunction table;
  table.periodic = true;
  for (int i = 0; i <= 64; ++i) {
    table.times.push_back(1 + i * 0.03125);
    table.values.push_back(i == 64 ? 0.0 : std::sin(std::numbers::pi * i / 32));
  }
  const Function f = table;
  for (double t = -9.3; t < 12; t += 0.71) {
    EXPECT_NEAR(f.value(t), std::sin(std::numbers::pi * (t - 1)), 4e-7) << t;
    EXPECT_NEAR(f.value(t), f.value(t + 6), 1e-14) << t;
    EXPECT_NEAR(f.first(t), f.first(t + 6), 1e-13) << t;
    // From 0 the integral of sin(pi (t - 1)) is (-1 - cos(pi (t - 1))) / pi.
    EXPECT_NEAR(f.integral(t), (-1 - std::cos(std::numbers::pi * (t - 1))) / std::numbers::pi, 1e-7) << t;
    EXPECT_NEAR(f.double_integral(t), (-t - std::sin(std::numbers::pi * (t - 1)) / std::numbers::pi) / std::numbers::pi,
                1e-6)
        << t;
  }
}

// Natural cubic splines reproduce no cubic, periodic ones no polynomial; but interpolation at the points is exact and
// the second derivative at both ends of a natural one vanishes.
TEST(Function, SplineEndsAndPoints) {
  const PiecewiseCubic natural({0, 1, 1.5, 4}, {1, -2, 0.5, 3}, PiecewiseCubic::Ends::natural);
  EXPECT_EQ(natural.at(0).second, 0);
  EXPECT_EQ(natural.at(4).second, 0);
  EXPECT_EQ(natural.at(1.5).value, 0.5);
  EXPECT_DOUBLE_EQ(natural.at(6).value, 3 + 2 * natural.at(4).first);  // straight on
  EXPECT_DOUBLE_EQ(natural.at(-1).value, 1 - natural.at(0).first);
  const PiecewiseCubic periodic({0, 1, 1.5, 4}, {1, -2, 0.5, 1}, PiecewiseCubic::Ends::periodic);
  EXPECT_NEAR(periodic.at(0).first, periodic.at(4 - 1e-13).first, 1e-10);
  EXPECT_NEAR(periodic.at(0).second, periodic.at(4 - 1e-13).second, 1e-10);
}

TEST(Function, RampIsConstantOutsideAndSmoothAtItsEnds) {
  const RampFunction ramp{.from = 1, .to = 3, .begin = 1, .end = 2};
  EXPECT_EQ(ramp.value(0.5), 1);
  EXPECT_EQ(ramp.value(1.5), 2);
  EXPECT_EQ(ramp.value(9), 3);
  EXPECT_EQ(ramp.first(1), 0);
  EXPECT_EQ(ramp.second(2), 0);
  EXPECT_DOUBLE_EQ(ramp.integral(3), 1 + 2 + 3);  // 1 before, mean 2 within, 3 after
}

TEST(Function, TablePassesThroughItsPointsAndHoldsItsEnds) {
  const Function table = TableFunction{{0, 1, 3}, {2, 4, 8}};
  EXPECT_DOUBLE_EQ(table.value(1), 4);
  EXPECT_DOUBLE_EQ(table.value(2), 6);  // a straight line is its own spline
  EXPECT_DOUBLE_EQ(table.value(-5), 2);
  EXPECT_DOUBLE_EQ(table.value(7), 8);
  EXPECT_DOUBLE_EQ(table.integral(4), 3 + 12 + 8);
}

// By hand: slopes 3/2, 0, 0, -3/2 at the points (0, 0), (1, 1), (2, 1), (3, 0), so 1/2 + 3/2/8 at 1/2 and no more than
// 1 between the upper ones, where a spline rises by an eighth.
TEST(Function, MonotoneTableOvershootsNoPoint) {
  const std::vector<double> x{0, 1, 2, 3}, y{0, 1, 1, 0};
  const Function monotone = TableFunction{x, y, false, Between::monotone}, spline = TableFunction{x, y};
  EXPECT_DOUBLE_EQ(monotone.value(0.5), 0.6875);
  EXPECT_DOUBLE_EQ(monotone.value(1.5), 1);
  EXPECT_GT(spline.value(1.5), 1.1);
  EXPECT_DOUBLE_EQ(monotone.first(0), 1.5);
  EXPECT_DOUBLE_EQ(monotone.first(1), 0);
}

TEST(Function, MonotoneTableIsMonotoneWhereItsPointsAre) {
  const Function steps = TableFunction{{0, 1, 1.1, 4, 4.05, 9}, {0, 0.01, 5, 5.1, 40, 40}, false, Between::monotone};
  for (double t = 0; t < 9; t += 1e-3) ASSERT_GE(steps.value(t + 1e-3), steps.value(t) - 1e-13) << t;
}

TEST(Function, LinearTableIsOfStraightLines) {
  const Function f = TableFunction{{0, 1, 3}, {2, 4, -2}, false, Between::linear};
  EXPECT_DOUBLE_EQ(f.value(0.25), 2.5);
  EXPECT_DOUBLE_EQ(f.value(2), 1);
  EXPECT_DOUBLE_EQ(f.first(2), -3);
  EXPECT_EQ(f.second(2), 0);
  EXPECT_DOUBLE_EQ(f.integral(3), 3 + 2);
  EXPECT_TRUE(f.has_corners());
  EXPECT_TRUE(Function(SumFunction{{Function(1.0), f}}).has_corners());
  EXPECT_FALSE(Function(TableFunction{{0, 1, 3}, {2, 4, -2}, false, Between::monotone}).has_corners());
}

std::string refusal(auto make) {
  return test::message_of<std::invalid_argument>([&] { const Function f = make(); });
}

TEST(Function, RefusesWithRuleAndCure) {
  EXPECT_EQ(refusal([] { return Function(HarmonicFunction{.frequency = 0}); }),
            "harmonic function: frequency must be above 0 Hz; for a constant use the value alone");
  EXPECT_EQ(refusal([] { return Function(RampFunction{.begin = 2, .end = 1}); }),
            "ramp function: its end must come after its begin; for a jump use a short ramp");
  EXPECT_EQ(refusal([] {
              return Function(TableFunction{{0, 1, 1}, {0, 1, 2}});
            }),
            "table function: times must increase; point 3 does not come after the one before");
  EXPECT_EQ(
      refusal([] {
        return Function(TableFunction{{0, 1, 2}, {0, 1, 0.5}, true});
      }),
      "table function: what repeats itself must end with the value it begins with; add a last point with the first "
      "one's value");
  EXPECT_EQ(
      refusal([] { return Function(ExpressionFunction{}); }),
      "expression function: needs its value, two derivatives and two integrals as callables; a scenario's formula "
      "brings them all");
  EXPECT_EQ(refusal([] {
              return Function(TableFunction{{0, 1}, {0}});
            }),
            "table function: needs as many values as times, and at least one point");
}

}  // namespace
}  // namespace subsoil::mbd::function_test
