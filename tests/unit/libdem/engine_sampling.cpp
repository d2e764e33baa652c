#include <gtest/gtest.h>

#include <random>

#include "libdem/step/sampling.hpp"

namespace subsoil::dem::test {
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
    for (std::size_t tile = 0; tile < 200; ++tile) {
      Sampling sampling;
      double stood_for = 0;
      bool kept = true;
      for (int n = 0; n < steps; ++n) {
        sampling.begin(every, n, fresh[static_cast<std::size_t>(n)]);
        const Booking b = sampling.of(tile);
        ASSERT_TRUE(b.book || !b.sum);
        ASSERT_EQ(b.sum, b.weight > 0);
        if (every > 1 && b.sum) {
          ASSERT_TRUE(kept) << "tile " << tile << ", step " << n << ", every " << every;
          ASSERT_FALSE(fresh[static_cast<std::size_t>(n)]);
        }
        stood_for += b.weight;
        kept = b.book;
      }
      // At either end a sample may be missing; with every second step one that two new lists in a row put off.
      const double put_off = every == 2 ? 0.1 * steps : 0;
      ASSERT_NEAR(stood_for, steps, every + put_off) << "tile " << tile << ", every " << every;
    }
  }
}

/// In each step about as many tiles are sampled as in any other.
TEST(Sampling, IsSpreadOverTheSteps) {
  constexpr int every = 32, tiles = 510;
  Sampling sampling;
  for (int n = 1; n <= every; ++n) {
    sampling.begin(every, n, false);
    int sampled = 0;
    for (std::size_t k = 0; k < tiles; ++k) sampled += sampling.of(k).sum;
    EXPECT_NEAR(sampled, static_cast<double>(tiles) / every, 4) << "step " << n;
  }
}

}  // namespace
}  // namespace subsoil::dem::test
