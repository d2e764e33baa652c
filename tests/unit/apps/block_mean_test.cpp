#include "libsim/io/block_mean.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "libsim/io/summary.hpp"

namespace subsoil::sim::block_mean_test {
namespace {

/// x_{k+1} = phi x_k + noise of variance 1: the mean of n values has the standard error sqrt(1/n)/(1 - phi) for n >> 1.
BlockMean autoregressive(double phi, double drift, unsigned seed, int count) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise;
  BlockMean mean;
  double x = noise(random) / std::sqrt(1 - phi * phi);
  for (int k = 0; k < count; ++k) {
    mean.add(1e-3, 5 + drift * k / count + x);
    x = phi * x + noise(random);
  }
  return mean;
}

/// Of fewer than six blocks nothing is known, and nothing is said.
TEST(BlockMean, ShortSignalsAreNeitherSteadyNorNot) {
  BlockMean mean;
  for (const double value : {1.0, 2.0, 3.0, 4.0, 5.0}) mean.add(1, value);
  EXPECT_TRUE(steady_json(mean).is_null());
  mean.add(1, 6);
  EXPECT_EQ(steady_json(mean), false) << "a straight line";
}

/// What is left over behind whole blocks counts with its duration: of 13 values six blocks of two, and half a block.
TEST(BlockMean, TheLineKnowsWhatIsLeftOver) {
  BlockMean ramp, rise;
  for (int k = 1; k <= 13; ++k) ramp.add(1, k), rise.add(1, k == 13 ? 13 : 0);
  EXPECT_NEAR(ramp.trend(), 13, 1e-12);
  // Middle 6.5; sum of w (t - 6.5)^2 = 71.5 + 6^2/2; sum of w (t - 6.5) v = 6 x 13/2.
  EXPECT_NEAR(rise.trend(), 13 * 39 / 89.5, 1e-12);
}

/// Six periods are six blocks, whatever the step: none is lost because each ended within a step.
TEST(BlockMean, WholePeriodsAreAsManyBlocks) {
  constexpr double period = 0.05;
  for (const int steps_of_a_period : {7, 50, 1234}) {
    BlockMean mean;
    mean.take_blocks_of(period);
    const double dt = period / (steps_of_a_period + 0.37), end = 6 * period;
    for (double t = 0; t < end * (1 - 1e-12); t += dt) {
      const double length = std::min(dt, end - t);
      mean.add(length, 3 + std::sin(2 * M_PI * (t + 0.5 * length) / period));
    }
    EXPECT_FALSE(std::isnan(mean.interval())) << steps_of_a_period;
    EXPECT_NEAR(mean.mean(), 3, 0.02) << steps_of_a_period;
    EXPECT_LT(mean.interval(), 0.03) << "each block is a whole period";
  }
}

TEST(BlockMean, TheIntervalHoldsTheTrueMeanOfACorrelatedSignal) {
  // 20,000 steps that remember 20: blocks of 1/16 remember nothing. 95 % of 400 is 380 with a deviation of 4.4; the
  // largest of the levels is never too narrow by chance of one level alone, so more may hold it, but a few must not.
  int held = 0, steady = 0;
  double width = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    const BlockMean m = autoregressive(0.95, 0, seed, 20000);
    held += std::abs(m.mean() - 5) < m.interval();
    steady += m.steady();
    width += m.interval() / 400;
  }
  EXPECT_GT(held, 367) << "three deviations below 95 %";
  EXPECT_LT(held, 400) << "an interval that is never missed says nothing";
  const double true_width = 1.96 * std::sqrt(1.0 / 20000) / (1 - 0.95);
  EXPECT_GT(width, 0.95 * true_width);
  EXPECT_LT(width, 2.0 * true_width)
      << "Student's t at 8 blocks is 1.2 times the normal's, the largest level adds to it";
  EXPECT_GT(steady, 360) << "a trend in one of twenty by chance";
}

TEST(BlockMean, ADriftIsNotSteady) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const BlockMean m = autoregressive(0.9, 3, seed, 20000);  // the noise of its mean is 0.07
    EXPECT_FALSE(m.steady());
    EXPECT_NEAR(m.trend(), 3, 1.0) << "4 deviations of a slope: sqrt(12) times that of the mean";
  }
}

TEST(BlockMean, IsWeightedWithTimeAndKnowsNothingOfAFewSteps) {
  BlockMean m;
  m.add(1, 2), m.add(3, 6);
  EXPECT_DOUBLE_EQ(m.mean(), 5);
  EXPECT_TRUE(std::isnan(m.interval()));
  EXPECT_TRUE(m.steady());
}

}  // namespace
}  // namespace subsoil::sim::block_mean_test
