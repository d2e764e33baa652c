#include "libmbd/base/jumps.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

namespace subsoil::mbd::jumps_test {
namespace {

using Call = std::function<double(double)>;

Function of(
    const Call& value, const Call& first, const Call& second = [](double) { return 0.0; }) {
  ExpressionFunction f;
  f.value_ = value, f.first_ = first, f.second_ = second;
  f.integral_ = f.double_integral_ = [](double) { return 0.0; };
  return f;
}

double sign(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

/// What jumps at `at`, wherever it lies between samples.
Function step(double at, double size) {
  return of([=](double t) { return 3 + std::sin(t) + size * sign(t - at); }, [](double t) { return std::cos(t); },
            [](double t) { return -std::sin(t); });
}
Function corner(double at, double size) {
  return of([=](double t) { return std::sin(t) + size * std::abs(t - at); },
            [=](double t) { return std::cos(t) + size * sign(t - at); }, [](double t) { return -std::sin(t); });
}

/// The same wave in seconds and in microseconds, without a jump and with one.
TEST(Jumps, HaveNoTimeOfTheirOwn) {
  for (const double unit : {1.0, 1e-3, 1e-6}) {
    const auto wave = [=](double size) {
      return of([=](double t) { return std::sin(t / unit) + size * sign(t / unit - 1.2); },
                [=](double t) { return std::cos(t / unit) / unit; },
                [=](double t) { return -std::sin(t / unit) / (unit * unit); });
    };
    EXPECT_FALSE(first_jump(wave(0), Smooth::value_and_rate, 0, 4 * unit)) << unit;
    const auto found = first_jump(wave(0.25), Smooth::value_and_rate, 0, 4 * unit);
    ASSERT_TRUE(found) << unit;
    EXPECT_NEAR(found->time, 1.2 * unit, 1e-8 * unit);
    EXPECT_NEAR(found->after - found->before, 0.5, 1e-6) << unit;
  }
}

TEST(Jumps, AreFoundWithPlaceAndSize) {
  for (const double at : {0.123, 0.5, 1.0 / 3, 1.7}) {
    const auto value = first_jump(step(at, 0.25), Smooth::value, 0, 2);
    ASSERT_TRUE(value) << at;
    EXPECT_NEAR(value->time, at, 3e-9);
    EXPECT_NEAR(value->after - value->before, 0.5, 1e-8);
    EXPECT_FALSE(value->of_rate);
    const auto rate = first_jump(corner(at, -0.25), Smooth::value_and_rate, 0, 2);
    ASSERT_TRUE(rate) << at;
    EXPECT_NEAR(rate->time, at, 3e-9);
    EXPECT_NEAR(rate->after - rate->before, -0.5, 1e-8);
    EXPECT_TRUE(rate->of_rate);
    EXPECT_FALSE(first_jump(corner(at, -0.25), Smooth::value, 0, 2)) << "a velocity may have corners";
  }
}

/// Lines and ramps over a tenth of a millisecond, between two samples or on one, are steep and do not jump.
TEST(Jumps, SteepIsNoJump) {
  for (const double begin : {0.2003, 0.5, 0.19, 1. / 3})
    for (const double rise : {1e-4, 1e-5, 2e-4}) {
      const Function lines =
          TableFunction({begin, begin + rise, begin + 2 * rise}, {0, 0.01, 0}, false, PiecewiseCubic::Between::linear);
      EXPECT_FALSE(first_jump(lines, Smooth::value, 0, 1)) << begin << " s, " << rise << " s";
      const Function ramp = RampFunction{.from = 0, .to = 1e-4, .begin = begin, .end = begin + rise};
      EXPECT_FALSE(first_jump(ramp, Smooth::value_and_rate, 0, 1)) << begin << " s, " << rise << " s";
    }
}

TEST(Jumps, TheFirstOfSeveralIsReported) {
  const Function two = SumFunction{{step(0.8, 0.1), step(0.3, 0.1)}};
  EXPECT_NEAR(first_jump(two, Smooth::value, 0, 2)->time, 0.3, 3e-9);
  EXPECT_NEAR(first_jump(two, Smooth::value, 0.5, 2)->time, 0.8, 3e-9);
}

/// A body starts with the value at the start itself, and then that of all later times.
TEST(Jumps, AtTheStartCountsTheValueThere) {
  const auto jump = first_jump(step(0.5, 0.25), Smooth::value, 0.5, 2);
  ASSERT_TRUE(jump);
  EXPECT_NEAR(jump->after - jump->before, 0.25, 1e-8);
  EXPECT_FALSE(first_jump(step(0.5, 0.25), Smooth::value, 0.51, 2));
}

/// At its end a body is not moved any more.
TEST(Jumps, BeyondTheEndDoNotCount) { EXPECT_FALSE(first_jump(step(2.001, 0.25), Smooth::value, 0, 2)); }

TEST(Jumps, ATableHasThemAtItsEnds) {
  const Function table = TableFunction{{0.4, 0.7, 1}, {0, 1, 1.5}, false, Between::monotone};
  const auto begin = first_jump(table, Smooth::value_and_rate, 0, 2),
             end = first_jump(table, Smooth::value_and_rate, 0.5, 2);
  ASSERT_TRUE(begin && end);
  EXPECT_NEAR(begin->time, 0.4, 3e-9);
  EXPECT_NEAR(begin->after, table.first(0.4 + 1e-9), 1e-6);
  EXPECT_NEAR(end->time, 1, 3e-9);
  EXPECT_NEAR(end->before, table.first(1 - 1e-9), 1e-6);
  EXPECT_EQ(end->after, 0);
  EXPECT_FALSE(first_jump(table, Smooth::value_and_rate, 0.5, 0.9));
  EXPECT_FALSE(first_jump(table, Smooth::value, 0, 2));
  EXPECT_FALSE(first_jump(TableFunction{{0.4, 0.7, 1}, {0, 1, 0}, true}, Smooth::value_and_rate, 0, 2));
}

TEST(Jumps, AreARampWithoutLength) {
  EXPECT_TRUE(first_jump(RampFunction{.to = 1, .begin = 0.5, .end = 0.5 + 1e-9}, Smooth::value, 0, 1));
  EXPECT_TRUE(
      first_jump(TableFunction{{0, 0.5, 0.5 + 1e-10, 1}, {0, 0, 1, 1}, false, Between::linear}, Smooth::value, 0, 1));
  EXPECT_FALSE(first_jump(RampFunction{.to = 1, .begin = 0.5, .end = 0.501}, Smooth::value_and_rate, 0, 1));
  EXPECT_FALSE(
      first_jump(TableFunction{{0, 0.5, 0.501, 1}, {0, 0, 1, 1}, false, Between::linear}, Smooth::value, 0, 1));
}

/// A root has an infinite slope where it begins, t^1.5 a slope that is continuous and an infinite curvature.
TEST(Jumps, RootsAreToldApart) {
  const auto power = [](double p, int derivative) {
    return [=](double t) {
      if (t <= 0.3) return 0.0;
      const double factor = derivative == 0 ? 1 : derivative == 1 ? p : p * (p - 1);
      return factor * std::pow(t - 0.3, p - derivative);
    };
  };
  const Function root = of(power(0.5, 0), power(0.5, 1), power(0.5, 2));
  const auto jump = first_jump(root, Smooth::value_and_rate, 0, 1);
  ASSERT_TRUE(jump);
  EXPECT_TRUE(jump->of_rate);
  EXPECT_FALSE(first_jump(of(power(1.5, 0), power(1.5, 1), power(1.5, 2)), Smooth::value_and_rate, 0, 1));
  EXPECT_FALSE(first_jump(of(power(2, 0), power(2, 1), power(2, 2)), Smooth::value_and_rate, 0, 1));
}

/// Fast, slow, large, with an offset, of rounding alone, of constants with six digits.
TEST(Jumps, WhatIsSmoothHasNone) {
  const std::vector<Function> smooth = {
      Function(2.5),
      PolynomialFunction{{1e3, -2, 0.5, 0.3, -0.1, 0.02}},
      HarmonicFunction{.mean = 1e4, .amplitude = 1e-3, .frequency = 50},
      HarmonicFunction{.amplitude = 1e-6, .frequency = 1000},
      RampFunction{.from = 1, .to = -2, .begin = 0.4, .end = 1.9},
      TableFunction{{-1, 0.5, 1.2, 3}, {0, 2, -1, 1}},
      TableFunction{{-1, 0.5, 1.2, 3}, {0, 2, -1, 1}, false, Between::monotone},
      of([](double t) { return std::sin(t) * std::sin(t) + std::cos(t) * std::cos(t); },
         [](double t) { return std::sin(1e9 * t) * 1e-16; }),
      of([](double t) { return std::tanh(1e4 * (t - 1)); },
         [](double t) { return 1e4 / std::pow(std::cosh(1e4 * (t - 1)), 2); },
         [](double t) { return -2e8 * std::tanh(1e4 * (t - 1)) / std::pow(std::cosh(1e4 * (t - 1)), 2); }),
      of([](double t) { return t < 1 ? t : 1.0000001 + (t - 1); }, [](double) { return 1.0; })};
  for (std::size_t i = 0; i < smooth.size(); ++i)
    EXPECT_FALSE(first_jump(smooth[i], Smooth::value_and_rate, 0, 2)) << "function " << i;
}

/// It has none at 0.5 s, and the run ends there.
TEST(Jumps, AFormulaWithoutAValueIsNoJump) {
  const auto ends = [](double t) -> double {
    if (t > 0.5) throw std::runtime_error("no finite value");
    return t;
  };
  EXPECT_FALSE(first_jump(of(ends, [](double) { return 1.0; }), Smooth::value_and_rate, 0, 1));
}

}  // namespace
}  // namespace subsoil::mbd::jumps_test
