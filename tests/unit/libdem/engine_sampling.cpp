#include <gtest/gtest.h>

#include <random>

#include "libdem/step/sampling.hpp"

namespace subsoil::dem::test::engine_sampling {
namespace {

/// Steps at random with new lists, now and then several in a row.
std::vector<bool> new_lists(int steps) {
  std::mt19937 dice(5);
  std::vector<bool> out(static_cast<std::size_t>(steps), false);
  for (int k = 0; k < steps / 20; ++k) {
    const std::size_t at = dice() % out.size();
    for (std::size_t n = at; n < std::min(at + 1 + dice() % 3, out.size()); ++n) out[n] = true;
  }
  return out;
}

/// Whatever the lists do, samples stand for all steps, and each follows a step that kept what it needs.
TEST(Sampling, StandsForEveryStep) {
  constexpr int steps = 4000;
  for (const int every : {1, 2, 5, 16, 32}) {
    const std::vector<bool> fresh = new_lists(steps);
    for (std::size_t block = 0; block < 200; ++block) {
      Sampling sampling;
      double stood_for = 0;
      bool kept = true;
      for (int n = 0; n < steps; ++n) {
        sampling.begin(every, n, fresh[static_cast<std::size_t>(n)]);
        const Sample s = sampling.of(block);
        ASSERT_TRUE(s.record || !s.accumulate);
        ASSERT_EQ(s.accumulate, s.weight > 0);
        if (every > 1 && s.accumulate) {
          ASSERT_TRUE(kept) << "block " << block << ", step " << n << ", every " << every;
          ASSERT_FALSE(fresh[static_cast<std::size_t>(n)]);
        }
        stood_for += s.weight;
        kept = s.record;
      }
      // At either end a sample may be missing; with every second step one that two new lists in a row put off.
      const double put_off = every == 2 ? 0.1 * steps : 0;
      ASSERT_NEAR(stood_for, steps, every + put_off) << "block " << block << ", every " << every;
    }
  }
}

/// In each step about as many particle blocks are sampled as in any other.
TEST(Sampling, IsSpreadOverTheSteps) {
  constexpr int every = 32, blocks = 510;
  Sampling sampling;
  for (int n = 1; n <= every; ++n) {
    sampling.begin(every, n, false);
    int sampled = 0;
    for (std::size_t k = 0; k < blocks; ++k) sampled += sampling.of(k).accumulate;
    EXPECT_NEAR(sampled, static_cast<double>(blocks) / every, 4) << "step " << n;
  }
}

}  // namespace
}  // namespace subsoil::dem::test::engine_sampling
