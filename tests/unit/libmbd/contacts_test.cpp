// Contacts and stops in given states: thresholds, the clip of Hunt-Crossley, friction and its moment arm, gaps.

#include <gtest/gtest.h>

#include <cmath>

#include "force_support.hpp"
#include "libmbd/forces/disk_contact.hpp"
#include "libmbd/forces/distance_stop.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/rotational_stop.hpp"
#include "libmbd/forces/slide_stop.hpp"

namespace subsoil::mbd::contacts_test {
namespace {

constexpr double k = 1e4, b = 0.5, mu = 0.3;
const ContactLaw law{.normal = {.n = 1.5, .stiffness = k, .damping = b}, .friction = mu, .slip_speed = 1e-3};

template <class Force>
double gap_of(const Force& force, const BodyState& first, const BodyState& second = {}) {
  const std::array<BodyState, 3> bodies{BodyState{}, first, second};
  return force.gap({bodies, 0, {}});
}

TEST(HuntCrossleyForce, PushesFromTheFirstOverlapOnAndNeverPulls) {
  const HuntCrossleyForce h{.n = 1.5, .stiffness = k, .damping = b};
  EXPECT_EQ(h.at(0, 1).force, 0);
  EXPECT_EQ(h.at(-1e-300, 1).force, 0);
  EXPECT_GT(h.at(1e-12, 0).force, 0);
  EXPECT_DOUBLE_EQ(h.at(0.01, 0).force, k * 1e-3);  // 0.01^1.5
  EXPECT_DOUBLE_EQ(h.at(0.01, 2).force, k * 1e-3 * 2);
  EXPECT_DOUBLE_EQ(h.at(0.01, -1).force, k * 1e-3 * 0.5);
  EXPECT_EQ(h.at(0.01, -2).force, 0);                     // 1 + b d' = 0
  EXPECT_EQ(h.at(0.01, -50).force, 0);                    // clipped
  EXPECT_DOUBLE_EQ(h.at(0.01, -50).lost, k * 1e-3 * 50);  // what it stored and did not give back
  EXPECT_DOUBLE_EQ(h.at(0.01, 2).lost, k * 1e-3 * b * 2 * 2);
  EXPECT_DOUBLE_EQ(h.at(0.01, 2).stored, k * 1e-5 / 2.5);
}

TEST(LineContact, PointOverGround) {
  const LineContact c{.body_a = ground, .body_b = 1, .p_a = {5, 0.2}, .p_b = {0, -1}, .law = law};
  EXPECT_DOUBLE_EQ(gap_of(c, {{3, 1.25}, 0, {}, 0}), 0.05);
  EXPECT_EQ(feel(c, {{3, 1.25}, 0, {0, -9}, 0}).wrench[1][1], 0);
  const Felt f = feel(c, {{3, 1.19}, 0, {0.5, 0}, 0});
  EXPECT_NEAR(f.wrench[1][1], k * 1e-3, 1e-9);
  EXPECT_NEAR(f.wrench[1][0], -mu * k * 1e-3, 1e-9);        // 500 slip speeds: all of mu F
  EXPECT_NEAR(f.wrench[1][2], -mu * k * 1e-3 * 1.0, 1e-9);  // lever 1 m below the centre of gravity
  EXPECT_NEAR(f.power.lost, mu * k * 1e-3 * 0.5, 1e-9);
  EXPECT_NEAR(f.values[2], -0.01, 1e-15);
  EXPECT_NEAR(f.values[3], 0.5, 1e-15);
  // Half of tanh's corner.
  EXPECT_NEAR(feel(c, {{3, 1.19}, 0, {0.5e-3, 0}, 0}).wrench[1][0], -mu * k * 1e-3 * std::tanh(0.5), 1e-9);
}

// A wall on a body at a quarter turn and moving: only what the wall's own axes see counts.
TEST(LineContact, DiskAgainstAMovingWall) {
  const double quarter = std::acos(0.0);
  const LineContact c{.body_a = 1, .body_b = 2, .radius = 0.3, .law = law};
  // The line's direction is body a's x, now the world's y; its left is the world's -x.
  const BodyState wall{{2, 0}, quarter, {1.5, 0.7}, 0};
  const BodyState disk{{2 - 0.29, 4}, 0, {1.5, 0.7}, 0};
  EXPECT_NEAR(gap_of(c, wall, disk), -0.01, 1e-15);
  const Felt f = feel(c, wall, disk);
  EXPECT_NEAR(f.wrench[2][0], -k * 1e-3, 1e-9);  // no relative velocity: the spring alone
  EXPECT_NEAR(f.wrench[2][1], 0, 1e-9);
  EXPECT_NEAR(f.wrench[2][2], 0, 1e-9);
  // Rolling: the disk's rim goes down at R w = 0.6 while its centre rises at 0.6 against the wall.
  const BodyState rolling{{2 - 0.29, 4}, 0, {1.5, 0.7 + 0.6}, -2};
  EXPECT_NEAR(feel(c, wall, rolling).values[3], 0, 1e-14);
  // Spinning on the spot: friction at the lever R brakes the spin.
  const BodyState spinning{{2 - 0.29, 4}, 0, {1.5, 0.7}, 2};
  const Felt s = feel(c, wall, spinning);
  EXPECT_NEAR(s.wrench[2][2], -mu * k * 1e-3 * 0.3, 1e-9);
  EXPECT_NEAR(s.power.lost, mu * k * 1e-3 * 0.6, 1e-9);
}

TEST(DiskContact, OutsideAndInside) {
  DiskContact c{.body_a = 1, .body_b = 2, .radius_a = 1, .radius_b = 0.5, .law = law};
  const BodyState a{{0, 0}, 0, {}, 0};
  EXPECT_DOUBLE_EQ(gap_of(c, a, {{0, 1.7}, 0, {}, 0}), 1.7 - 1.5);
  const Felt f = feel(c, a, {{0, 1.49}, 0, {0.2, 0}, 0});
  EXPECT_NEAR(f.wrench[2][1], k * 1e-3, 1e-9);
  EXPECT_NEAR(f.wrench[2][0], -mu * k * 1e-3, 1e-9);
  // In the middle of the overlap of 0.01, so that neither disk is the first.
  EXPECT_NEAR(f.wrench[2][2], -mu * k * 1e-3 * 0.495, 1e-9);
  EXPECT_NEAR(f.wrench[1][2], -mu * k * 1e-3 * 0.995, 1e-9);
  c.side = DiskSide::inside;
  EXPECT_DOUBLE_EQ(gap_of(c, a, {{0, -0.3}, 0, {}, 0}), 0.2);
  EXPECT_DOUBLE_EQ(gap_of(c, a, {{0, 0}, 0, {}, 0}), 0.5);
  EXPECT_EQ(feel(c, a, {{0, 0}, 0, {1, 1}, 3}).wrench[2][2], 0);  // concentric in the bore is no contact
  const Felt in = feel(c, a, {{0, -0.51}, 0, {0.2, 0}, 0});
  EXPECT_NEAR(in.wrench[2][1], k * 1e-3, 1e-9);  // up, off the bore's bottom
  EXPECT_NEAR(in.wrench[2][0], -mu * k * 1e-3, 1e-9);
}

TEST(DiskContact, RunsAgainstConcentricDisks) {
  const DiskContact c{.body_a = 1, .body_b = 2, .radius_a = 1, .radius_b = 0.5, .law = law};
  EXPECT_THROW(feel(c, {}, {}), std::runtime_error);
}

TEST(Stops, PushBackFromEitherEnd) {
  const Limits limits{.least = -0.2, .largest = 0.6, .law = law.normal};
  const RotationalStop turn{.body_a = 1, .body_b = 2, .limits = limits};
  const BodyState a{{}, 0.1, {}, 0.4};
  const auto at = [](double angle, double spin) { return BodyState{{}, angle, {}, spin}; };
  EXPECT_NEAR(gap_of(turn, a, at(0.5, 0)), 0.2, 1e-15);
  EXPECT_NEAR(gap_of(turn, a, at(0.0, 0)), 0.1, 1e-15);
  EXPECT_EQ(feel(turn, a, at(0.5, 9)).wrench[2][2], 0);
  EXPECT_NEAR(feel(turn, a, at(0.71, 0.4)).wrench[2][2], -k * 1e-3, 1e-9);
  EXPECT_NEAR(feel(turn, a, at(-0.11, 0.4)).wrench[2][2], k * 1e-3, 1e-9);
  EXPECT_NEAR(feel(turn, a, at(0.71, 2.4)).wrench[2][2], -k * 1e-3 * 2, 1e-9);  // closing at 2 rad/s
  EXPECT_NEAR(feel(turn, a, at(-0.11, -1.6)).wrench[2][2], k * 1e-3 * 2, 1e-9);

  const SlideStop slide{.body_a = ground, .body_b = 1, .angle_a = std::acos(0.0), .limits = limits};
  EXPECT_NEAR(feel(slide, {{7, 0.61}, 0, {3, 0}, 0}).wrench[1][1], -k * 1e-3, 1e-9);
  EXPECT_NEAR(feel(slide, {{7, 0.61}, 0, {3, 0}, 0}).wrench[1][0], 0, 1e-9);
  EXPECT_NEAR(gap_of(slide, {{7, 0.61}, 0, {}, 0}), -0.01, 1e-15);
}

TEST(Stops, RopeOnlyPulls) {
  const DistanceStop rope{.body_a = ground, .body_b = 1, .limits = {.largest = 2, .law = law.normal}};
  EXPECT_EQ(feel(rope, {{1, 0}, 0, {9, 0}, 0}).wrench[1][0], 0);
  EXPECT_EQ(feel(rope, {{0, 0}, 0, {9, 0}, 0}).wrench[1][0], 0);  // slack through its own anchor
  EXPECT_NEAR(gap_of(rope, {{0, 1.5}, 0, {}, 0}), 0.5, 1e-15);
  EXPECT_NEAR(feel(rope, {{0, 2.01}, 0, {}, 0}).wrench[1][1], -k * 1e-3, 1e-9);
  EXPECT_NEAR(feel(rope, {{0, 2.01}, 0, {}, 0}).values[0], -k * 1e-3, 1e-9);
}

TEST(Contacts, RefuseWithRuleAndCure) {
  EXPECT_EQ(refusal([] { LineContact{}.check(); }),
            "stiffness must be given and above 0, n at least 1, damping not negative; damping 0 is elastic");
  EXPECT_EQ(refusal([] { LineContact{.radius = -1, .law = law}.check(); }),
            "radius must not be negative; 0 is a point");
  EXPECT_EQ(refusal([] { LineContact{.law = {.normal = law.normal, .slip_speed = 0}}.check(); }),
            "friction must not be negative and the slip speed above 0; friction 0 is smooth");
  EXPECT_EQ(refusal([] { DiskContact{.law = law}.check(); }),
            "both radii must be given, the first above 0 and the second not negative");
  EXPECT_EQ(refusal([] { DiskContact{.radius_a = 1, .radius_b = 1, .side = DiskSide::inside, .law = law}.check(); }),
            "the second radius must be less than the first for a disk inside a bore");
  EXPECT_EQ(refusal([] { RotationalStop{.limits = {.law = law.normal}}.check(); }),
            "needs a stop: give minimum, maximum or both");
  EXPECT_EQ(refusal([] { SlideStop{.limits = {.least = 1, .largest = 1, .law = law.normal}}.check(); }),
            "minimum must be below maximum; for a fixed value use a joint or a driver");
  EXPECT_EQ(refusal([] { DistanceStop{.limits = {.largest = 0, .law = law.normal}}.check(); }),
            "maximum must be above 0; for a common point use a joint");
}

}  // namespace
}  // namespace subsoil::mbd::contacts_test
