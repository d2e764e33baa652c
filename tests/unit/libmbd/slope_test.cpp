// Derivatives of laws that change beside the point at which they are taken.

#include "libmbd/base/slope.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace subsoil::mbd::slope_test {
namespace {

Slope slope_of(double (*f)(double), double far = 1e-4) {
  return slope_at_zero([f](double x) { return Eigen::VectorXd::Constant(1, f(x)); }, far, 0);
}

// Analytic functions: rounding over the first step, 2e-16/1e-4, with what the extrapolation adds to it.
TEST(Slope, OfSmoothFunctions) {
  EXPECT_NEAR(slope_of([](double x) { return std::exp(x); }).value[0], 1, 2e-11);
  EXPECT_NEAR(slope_of([](double x) { return std::sin(3 * x + 1); }).value[0], 3 * std::cos(1.0), 6e-11);
  EXPECT_EQ(slope_of([](double) { return 5.0; }).value[0], 0);
  EXPECT_EQ(slope_of([](double) { return 5.0; }).error[0], 0);
}

// A contact k (d + x)^n that ends at x = -d: n k d^(n - 1) at 0. Its digits are those of x + d: 1e-16 over a step that
// is some hundredth of d for n = 1.5, whose further derivatives grow as d^-1.
TEST(Slope, OfAContactOfAnyDepth) {
  for (const double n : {1.0, 1.5, 3.0})
    for (double depth = 1e-9; depth < 1; depth *= 7) {
      const auto force = [&](double x) {
        return Eigen::VectorXd::Constant(1, depth + x > 0 ? 1e8 * std::pow(depth + x, n) : 0.0);
      };
      const Slope s = slope_at_zero(force, 1e-4, 0);
      const double exact = 1e8 * n * std::pow(depth, n - 1);
      EXPECT_NEAR(s.value[0], exact, 1e-9 * exact) << "n = " << n << ", depth " << depth;
      EXPECT_NEAR(s.value[0], exact, 10 * s.error[0] + 1e-11 * exact) << "n = " << n << ", depth " << depth;
    }
}

// At the corner itself there are two derivatives: their mean, and an error that says so.
TEST(Slope, SaysWhereThereIsNone) {
  const Slope s = slope_of([](double x) { return x > 0 ? 4 * x : 0.0; });
  EXPECT_NEAR(s.value[0], 2, 1e-12);
  EXPECT_GT(s.error[0], 0.5);
}

// tanh of friction: 1/v over any regularisation speed v.
TEST(Slope, OfSteepFriction) {
  for (const double v : {1e-2, 1e-5, 1e-9}) {
    const Slope s = slope_at_zero([v](double x) { return Eigen::VectorXd::Constant(1, -std::tanh(x / v)); }, 1e-4, 0);
    EXPECT_NEAR(s.value[0] * v, -1, 1e-9) << v;
  }
}

// Of |x| x nothing is left at 0; the differences fall with the step only.
TEST(Slope, OfQuadraticDragAtRest) {
  EXPECT_NEAR(slope_of([](double x) { return std::abs(x) * x; }).value[0], 0, 1e-12);
}

// Every component for itself: a deep contact beside a shallow one and a noise of rounding.
TEST(Slope, ComponentsStandForThemselves) {
  const auto f = [](double x) {
    Eigen::VectorXd out(3);
    out << 1e8 * std::max(0.0, 1e-7 + x), std::sin(x), 1e8 + 1e-3 * x - 1e8;
    return out;
  };
  const Slope s = slope_at_zero(f, 1e-4, 0);
  EXPECT_NEAR(s.value[0], 1e8, 1e-1);
  EXPECT_NEAR(s.value[1], 1, 1e-10);
  EXPECT_NEAR(s.value[2], 1e-3, 1e-3);
}

// An argument beside 1, whose rounding a step of 1e-16 does not change: differences of nought agree, and are no slope.
TEST(Slope, StepsBelowTheRoundingOfTheArgumentDoNotCount) {
  constexpr double eps = 0x1p-52;
  const auto f = [](double x) {
    const double moved = 1 + x;
    Eigen::VectorXd out(3);
    // The third never settles, so that steps shrink as far as they may.
    out << 1e3 * (moved - 1), std::cbrt(moved), std::sqrt(std::abs(moved - 1)) * (moved > 1 ? 1 : -1);
    return out;
  };
  const Slope s = slope_at_zero(f, 1e-4, eps);
  EXPECT_NEAR(s.value[0], 1e3, 1e-7);
  EXPECT_NEAR(s.value[1], 1.0 / 3, 1e-10);
  EXPECT_LT(std::abs(s.value[1] - 1.0 / 3), 10 * s.error[1]);
  EXPECT_GT(s.error[0], 0);
}

TEST(RoughSlope, ShortensItsStepBesideACorner) {
  const Curve1 f = [](double x) { return Eigen::VectorXd::Constant(1, 1e8 * std::max(0.0, 1e-9 + x)); };
  EXPECT_NEAR(rough_slope(f, f(0), 1e-7)[0], 1e8, 1);
  const Curve1 at_corner = [](double x) { return Eigen::VectorXd::Constant(1, std::max(0.0, x)); };
  EXPECT_NEAR(rough_slope(at_corner, at_corner(0), 1e-7)[0], 0.5, 1e-9);
}

}  // namespace
}  // namespace subsoil::mbd::slope_test
