// Disks on lines and on disks, rolling and slipping, against closed forms and minimal coordinates.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libmbd/joints/disk_on_disk.hpp"
#include "libmbd/joints/disk_on_line.hpp"
#include "libmbd/joints/rolling_on_disk.hpp"
#include "libmbd/joints/rolling_on_line.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/reference_ode.hpp"

namespace subsoil::mbd::rolling_test {
namespace {

constexpr double g = 9.81, mass = 3, inertia = 0.02, slope = 0.35;

void run(Machine& machine, double end, double h) {
  for (long i = 0; i < std::lround(end / h); ++i) machine.advance(h);
}

/// A disk of 0.1 m at rest on a slope that falls towards +x.
Model on_slope(AnyJoint joint, double spin) {
  Model m;
  m.add({.name = "disk",
         .mass = mass,
         .inertia = inertia,
         .pose = {0.1 * std::sin(slope), 0.1 * std::cos(slope), 0.4},
         .velocity = {0, 0, spin}});
  m.add("contact", std::move(joint));
  return m;
}
const DiskAndLine contact{.body_a = ground, .body_b = 1, .angle_a = -slope, .radius = 0.1};

// Constant acceleration is exact for the integrator: rounding over 1000 steps remains. On the ground the disk leaves
// its weight's normal share and the friction_force that turns it.
TEST(Rolling, DownASlope) {
  Machine machine(on_slope(RollingOnLine{contact}, 0));
  machine.start_from_pose();
  run(machine, 1, 1e-3);
  const double k = inertia / (mass * 0.1 * 0.1), acceleration = g * std::sin(slope) / (1 + k), s = acceleration / 2;
  const double friction_force = mass * g * std::sin(slope) - mass * acceleration, normal = mass * g * std::cos(slope);
  EXPECT_NEAR(machine.body(1).r.x, 0.1 * std::sin(slope) + s * std::cos(slope), 1e-11);
  EXPECT_NEAR(machine.body(1).r.y, 0.1 * std::cos(slope) - s * std::sin(slope), 1e-11);
  EXPECT_NEAR(machine.body(1).angle, 0.4 - s / 0.1, 1e-10);
  const Reaction on_ground = machine.joint_reaction("contact");
  EXPECT_NEAR(on_ground.fx, -normal * std::sin(slope) + friction_force * std::cos(slope), 1e-9);
  EXPECT_NEAR(on_ground.fy, -normal * std::cos(slope) - friction_force * std::sin(slope), 1e-9);
  EXPECT_NEAR(on_ground.moment, 0, 1e-10);  // at the contact point
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-10);
}

TEST(Rolling, SlippingDownASlope) {
  Machine machine(on_slope(DiskOnLine{contact}, 5));
  machine.start_from_pose();
  run(machine, 1, 1e-3);
  const double s = g * std::sin(slope) / 2, normal = mass * g * std::cos(slope);
  EXPECT_NEAR(machine.body(1).r.x, 0.1 * std::sin(slope) + s * std::cos(slope), 1e-11);
  EXPECT_NEAR(machine.body(1).angle, 5.4, 1e-11);
  const Reaction on_ground = machine.joint_reaction("contact");
  EXPECT_NEAR(on_ground.fx, -normal * std::sin(slope), 1e-9);
  EXPECT_NEAR(on_ground.fy, -normal * std::cos(slope), 1e-9);
  EXPECT_NEAR(on_ground.moment, 0, 1e-10);
}

// A line is the same line from its other side, and drawn the other way.
TEST(Rolling, SideAndDirectionOfTheLineAreFree) {
  DiskAndLine reversed = contact;
  reversed.angle_a = std::numbers::pi - slope;
  Machine machine(on_slope(RollingOnLine{contact}, 0)), other(on_slope(RollingOnLine{reversed}, 0));
  machine.start_from_pose(), other.start_from_pose();
  run(machine, 0.5, 1e-3), run(other, 0.5, 1e-3);
  EXPECT_NEAR(machine.body(1).r.x, other.body(1).r.x, 1e-13);
  EXPECT_NEAR(machine.body(1).angle, other.body(1).angle, 1e-12);
  EXPECT_NEAR(machine.joint_reaction("contact").fx, other.joint_reaction("contact").fx, 1e-11);
}

struct Circles {
  bool inside;
  double radius, start, end;
};
class RollingOnCircle : public testing::TestWithParam<Circles> {};

// A disk of 0.2 m on or in a fixed circle, its centre at D (sin q, -+cos q): q'' = -+g sin q / (D (1 + k)) when it
// rolls, k = 0 when it slips; rolling turns it by -D q / 0.2. Order 5 at 1 ms errs by some 1e-11 over these times, and
// off the top grows with the motion itself by e^4; 1e-8 rules out any wrong term.
TEST_P(RollingOnCircle, FollowsMinimalCoordinate) {
  const Circles c = GetParam();
  const double r = 0.2, d = c.inside ? c.radius - r : c.radius + r, up = c.inside ? -1 : 1;
  for (const bool rolls : {true, false}) {
    Model m;
    m.add({.name = "disk",
           .mass = mass,
           .inertia = inertia,
           .pose = {d * std::sin(c.start), up * d * std::cos(c.start), 0.3}});
    const TwoDisks disks{.body_a = ground, .body_b = 1, .radius_a = c.radius, .radius_b = r, .inside = c.inside};
    if (rolls) m.add("contact", RollingOnDisk{disks});
    if (!rolls) m.add("contact", DiskOnDisk{disks});
    Machine machine(m, {.adams_moulton = {.order = 5}});
    machine.start_from_pose();
    run(machine, c.end, 1e-3);
    const double k = rolls ? inertia / (mass * r * r) : 0;
    const auto y = test::solve_ode(
        [&](const auto& s, auto& rate, double) {
          rate = {s[1], up * g * std::sin(s[0]) / (d * (1 + k))};
        },
        {c.start, 0}, 0, c.end);
    EXPECT_NEAR(machine.body(1).r.x, d * std::sin(y[0]), 1e-8) << rolls;
    EXPECT_NEAR(machine.body(1).r.y, up * d * std::cos(y[0]), 1e-8) << rolls;
    EXPECT_NEAR(machine.body(1).angle, 0.3 + (rolls ? -up * (c.inside ? -1 : 1) * d / r * (y[0] - c.start) : 0), 1e-7);
    // The line of centres carries the weight's share less what the centre's turn needs.
    const double normal = mass * (g * std::cos(y[0]) - up * d * y[1] * y[1]);
    const Reaction on_ground = machine.joint_reaction("contact");
    const double along = on_ground.fx * std::sin(y[0]) + on_ground.fy * up * std::cos(y[0]);
    EXPECT_NEAR(along, -up * normal, 1e-6) << rolls;
    EXPECT_NEAR(on_ground.moment, 0, 1e-9) << rolls;
  }
}
INSTANTIATE_TEST_SUITE_P(InAndOn, RollingOnCircle,
                         testing::Values(Circles{true, 1.0, 1.0, 4.0}, Circles{false, 0.5, 0.1, 1.2}));

}  // namespace
}  // namespace subsoil::mbd::rolling_test
