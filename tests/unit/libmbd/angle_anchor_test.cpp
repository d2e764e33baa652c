// Sine and cosine by series from kept multiples, against the library's.

#include "libmbd/base/angle_anchor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace subsoil::mbd::angle_anchor_test {
namespace {

// 1.5 units in the last place of 1, wherever it was asked before; exact where angles mostly stand.
TEST(AngleAnchor, IsTheSineAndCosineOfTheAngleAlone) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> step(-0.03, 0.03), far(-1000, 1000);
  AngleAnchor moved;
  double c = 0, s = 0, angle = 0;
  for (int i = 0; i < 20000; ++i) {
    angle = i % 100 == 0 ? far(random) : angle + step(random);
    moved.of(angle, c, s);
    EXPECT_NEAR(c, std::cos(angle), 3.4e-16);
    EXPECT_NEAR(s, std::sin(angle), 3.4e-16);
    AngleAnchor fresh;
    double c_fresh = 0, s_fresh = 0;
    fresh.of(angle, c_fresh, s_fresh);
    EXPECT_EQ(c, c_fresh);
    EXPECT_EQ(s, s_fresh);
  }
  for (const double at : {0.0, 1. / 128, -1. / 128, 1. / 64, 3. / 128}) {
    AngleAnchor a;
    a.of(at, c, s);
    EXPECT_NEAR(c, std::cos(at), 2.3e-16);
    EXPECT_NEAR(s, std::sin(at), 2.3e-16);
  }
  AngleAnchor().of(0, c, s);
  EXPECT_EQ(c, 1);
  EXPECT_EQ(s, 0);
  AngleAnchor().of(std::numeric_limits<double>::quiet_NaN(), c, s);
  EXPECT_TRUE(std::isnan(c) && std::isnan(s));
}

}  // namespace
}  // namespace subsoil::mbd::angle_anchor_test
