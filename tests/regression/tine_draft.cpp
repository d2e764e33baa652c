#include <gtest/gtest.h>

#include "tests/tools/tine_pass.hpp"

/// Regression of a reduced bed, with physics beside it.
///
/// The band: mean draft of TinePass (tests/tools/tine_pass.hpp; 780 spheres of the wet law, tine 80 mm wide and 40 mm
/// deep, 0.5 m/s) over 40 to 100 mm of travel in soil. Measured with
///     regression --gtest_also_run_disabled_tests --gtest_filter='*MeasuresTheBand*'
/// which runs the eighteen beds below and prints what stands here. A change of the laws, the sweep or the coupling that
/// moves the draft by more than the scatter of packings shows; one within it cannot be told from another bed.
namespace subsoil::coupling::test::tine_draft {
namespace {

constexpr double from = 0.04, until = 0.10;  // m
// Seeds 1 to 12, N: 247.5 241.1 248.8 258.7 243.9 254.8 275.2 257.5 296.3 265.2 249.4 296.9; seeds 101 to 106: 273.4
// 210.8 288.4 216.3 290.8 166.7. Eighteen and not the least of five: the first six alone scatter by 6.6 N, by luck.
// For comparison: seed 1 with mu = 0: 91 N; seed 2 with K_B = 0: 13 N.
constexpr double mean = 254.5, deviation = 32.9;  // N
constexpr double low = mean - 4 * deviation, high = mean + 4 * deviation;

TEST(TineDraft, LiesInTheBandAndObeysMechanics) {
  TinePass pass({.seed = 201});  // none of the beds that the band was measured with
  pass.run(from, until);
  EXPECT_GT(pass.draft(), low);
  EXPECT_LT(pass.draft(), high);

  // Newton's law for the whole bed: change of momentum = impulse of tine, walls and gravity. Sums of 1e4 steps.
  EXPECT_LT(norm(pass.impulse_gap()), 1e-10);
  // At constant speed the trolley's driver pulls with what the soil holds back with.
  EXPECT_NEAR(pass.driver_pull(), pass.draft(), 1e-6 * pass.draft());
  const TineEnergy e = pass.energy();
  EXPECT_LT(std::abs(e.closure()), 0.01 * e.put_in);
  // The work of towing is the mean draft times the path, within the run-in from the first contact on.
  EXPECT_GT(e.driver_work, pass.draft() * (until - from));
  EXPECT_LT(e.driver_work, pass.draft() * until);
}

TEST(TineDraft, WithoutFrictionFallsOutOfTheBand) {
  TinePass pass({.seed = 201, .mu = 0});
  pass.run(from, until);
  EXPECT_LT(pass.draft(), low);
}

TEST(TineDraft, WithoutAttractionFallsOutOfTheBand) {
  TinePass pass({.seed = 201, .attraction = 0});
  pass.run(from, until);
  EXPECT_LT(pass.draft(), low);
}

TEST(TineDraft, DISABLED_MeasuresTheBand) {
  std::vector<std::uint64_t> seeds{101, 102, 103, 104, 105, 106};
  for (std::uint64_t seed = 1; seed <= 12; ++seed) seeds.push_back(seed);
  double sum = 0, squares = 0;
  const double count = static_cast<double>(seeds.size());
  for (const std::uint64_t seed : seeds) {
    TinePass pass({.seed = seed});
    pass.run(from, until);
    std::printf("seed %d: %.1f N\n", static_cast<int>(seed), pass.draft());
    sum += pass.draft(), squares += pass.draft() * pass.draft();
  }
  std::printf("mean %.1f N, deviation %.1f N\n", sum / count, std::sqrt((squares - sum * sum / count) / (count - 1)));
}

}  // namespace
}  // namespace subsoil::coupling::test::tine_draft
