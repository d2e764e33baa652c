// Where a gap changes sign within a step, and which forces have gaps.

#include "libmbd/integrators/events.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"

namespace subsoil::mbd::events_test {
namespace {

/// Share at which locate_crossing finds the zero of a gap that starts on its positive side, and how often it asked.
double found(const std::function<double(double)>& gap, int* asked = nullptr) {
  int count = 0;
  const double at = locate_crossing([&](double s) { return ++count, gap(s); }, gap(0) < 0 ? -1 : 1, gap(0), gap(1));
  if (asked) *asked = count;
  return at;
}

TEST(LocateCrossing, FindsTheZeroToTheWidthItPromises) {
  EXPECT_NEAR(found([](double s) { return 0.3 - s; }), 0.3, 1e-12);
  EXPECT_NEAR(found([](double s) { return s - 1e-5; }), 1e-5, 1e-12);
  EXPECT_NEAR(found([](double s) { return std::cos(2 * s); }), M_PI / 4, 1e-12);
  EXPECT_NEAR(found([](double s) { return 1e-9 * (std::exp(-8 * s) - 0.5); }), std::log(2) / 8, 1e-12);
  EXPECT_NEAR(found([](double s) { return std::pow(0.9 - s, 3); }), 0.9, 1e-4);  // flat: 1e-12 of the value
}

TEST(LocateCrossing, EndsOnTheOtherSide) {
  const auto gap = [](double s) { return 0.7 - s * s; };
  EXPECT_LE(gap(found(gap)), 0);
}

// Bisection would ask 40 times; every question costs a dozen evaluations of the machine.
TEST(LocateCrossing, AsksSeldom) {
  int asked = 0;
  found([](double s) { return 0.3 - 0.5 * s - 0.2 * s * s; }, &asked);
  EXPECT_LT(asked, 16);
}

// A ball that has just touched: its gap is rounding of either sign, then negative, and positive again after it leaves.
TEST(LocateCrossing, DoesNotFindTheEventBeforeAgain) {
  for (const double rounding : {-1e-18, 0.0, 1e-18}) {
    const auto gap = [&](double s) { return s * (s - 0.4) + rounding; };
    EXPECT_NEAR(locate_crossing(gap, -1, gap(0), gap(1)), 0.4, 1e-12) << rounding;
  }
}

Model ball_over_ground() {
  Model m;
  m.add({.name = "ball", .mass = 1, .inertia = 1, .pose = {0, 1, 0}});
  m.add("floor", LineContact{.body_a = ground, .body_b = 1, .law = {.normal = {.stiffness = 1e4}}});
  m.add("load", AppliedForce{.body = 1});
  return m;
}

TEST(Switches, AreTheForcesWithAGap) {
  System system(ball_over_ground());
  Switches switches(system);
  ASSERT_EQ(switches.count(), 1U);
  EXPECT_EQ(switches.name(0), "floor");
  switches.take_sides();
  EXPECT_EQ(switches.side(0), 1);
  Eigen::VectorXd q = system.start_position();
  q[1] = -0.25;
  system.set_position(0, q);
  double gap = 0;
  switches.gaps({&gap, 1});
  EXPECT_NEAR(gap, -0.25, 1e-14);
  EXPECT_GT(gap, -0.25) << "open surfaces close by more than the rounding of their gap";
  switches.take_sides();
  EXPECT_EQ(switches.side(0), -1);
  switches.gaps({&gap, 1});
  EXPECT_LT(gap, -0.25) << "and open by more";
  q[1] = -1e-17;  // below the rounding of the machine's length
  system.set_position(0, q);
  switches.take_sides();
  EXPECT_EQ(switches.side(0), 1);
}

TEST(Switches, OnlyRutsRememberAcceptedSteps) {
  Model m = ball_over_ground();
  EXPECT_FALSE(remembers(m));
  m.add("wheel", WheelOnSoil{.body = 1, .radius = 0.2, .width = 0.1, .n = 1, .k_c = 0, .k_phi = 1e6});
  EXPECT_TRUE(remembers(m));
}

}  // namespace
}  // namespace subsoil::mbd::events_test
