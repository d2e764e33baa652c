#include "libmbd/function.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace subsoil::mbd {
namespace {

std::vector<Function> every_kind() {
  return {Function(2.5),
          PolynomialFunction{{1, -2, 0.5, 0.3, -0.1, 0.02}},
          HarmonicFunction{.mean = 0.4, .amplitude = 1.5, .frequency = 0.7, .phase = 0.3},
          RampFunction{.from = 1, .to = -2, .begin = 0.4, .end = 1.9},
          TableFunction{{-1, 0.5, 1.2, 3}, {0, 2, -1, 1}},
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
    }
}

TEST(Function, IntegralStartsAtZero) {
  for (const auto& f : every_kind()) EXPECT_EQ(f.integral(0), 0);
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

std::string refusal(auto make) {
  try {
    const Function f = make();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
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
  EXPECT_EQ(refusal([] {
              return Function(TableFunction{{0, 1}, {0}});
            }),
            "table function: needs as many values as times, and at least one point");
}

}  // namespace
}  // namespace subsoil::mbd
