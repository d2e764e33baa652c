// Joints that open and close: release, shear pin, latch, against closed forms of flight and plastic impact.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/joint_friction.hpp"
#include "libmbd/joints/distance.hpp"
#include "libmbd/joints/fixed.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "libmbd/measures/angle.hpp"
#include "libmbd/measures/control_input.hpp"
#include "libmbd/measures/distance.hpp"
#include "libmbd/measures/position.hpp"
#include "libmbd/measures/reaction.hpp"
#include "libmbd/measures/soil_force.hpp"
#include "libmbd/measures/velocity.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::mbd::release_test {
namespace {

using Does = JointEvent::Does;

MachineOptions options(IntegratorKind kind) {
  return {.integrator = kind, .ida = {.rtol = 1e-10, .atol = 1e-11}, .cvode = {.rtol = 1e-11, .atol = 1e-12}};
}
double bound(IntegratorKind kind) { return kind == IntegratorKind::ida ? 1e-7 : 3e-9; }
void run(Machine& machine, double until, double h) {
  while (machine.time() < until - 0.5 * h) machine.advance(h);
}

class Release : public testing::TestWithParam<IntegratorKind> {};
INSTANTIATE_TEST_SUITE_P(All, Release,
                         testing::Values(IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida));

/// A rod of 1 m on a pin, let go level.
Model pendulum() {
  Model m;
  m.add({.name = "rod", .mass = 3, .inertia = 0.25, .pose = {0.5, 0, 0}});
  m.add("pin", Revolute{.body_a = 0, .body_b = 1, .p_b = {-0.5, 0}});
  return m;
}

// The rod flies on from where the pin let it go: a parabola, its spin constant.
TEST_P(Release, APendulumFliesOn) {
  const double at = 0.3137, later = 0.6;
  Machine held(pendulum(), options(GetParam()));
  held.start_from_pose();
  for (int i = 0; i < 100; ++i) held.advance(at / 100);
  const BodyState b = held.body(1);
  Model m = pendulum();
  m.add("drop", JointEvent{.joint = "pin", .does = Does::opens, .at = at});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, later, 2e-3);
  const double dt = later - at;
  EXPECT_NEAR(machine.body(1).r.x, b.r.x + b.v.x * dt, bound(GetParam()));
  EXPECT_NEAR(machine.body(1).r.y, b.r.y + b.v.y * dt - 9.81 * dt * dt / 2, bound(GetParam()));
  EXPECT_NEAR(machine.body(1).omega, b.omega, 10 * bound(GetParam()));
  EXPECT_EQ(machine.joint_reaction("pin").fx, 0);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-7) << "it loses nothing";
  ASSERT_EQ(machine.events().size(), 1U);
  EXPECT_NEAR(machine.events()[0].t, at, 1e-12);
  EXPECT_EQ(machine.events()[0].name, "pin");
  EXPECT_STREQ(machine.events()[0].word(), "opens");
}

// Welded to the ground under 1 kN/s t: at 250 N the pin shears, after 0.25 s; then v = 500 (t^2 - t_0^2)/m.
TEST_P(Release, AShearPinGivesWayAtItsLimit) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "tool", .mass = 20, .inertia = 1});
  m.add("pin", Fixed{.body_a = 0, .body_b = 1});
  m.add("load",
        AppliedForce{
            .body = 1, .fx = PolynomialFunction{{0, 800, 0, 0, 0, 0}}, .fy = PolynomialFunction{{0, 600, 0, 0, 0, 0}}});
  m.add("trip", JointEvent{.joint = "pin", .does = Does::opens, .reaction_above = 250});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 0.4, 7e-3);
  const double t = machine.time();
  ASSERT_EQ(machine.events().size(), 1U);
  EXPECT_NEAR(machine.events()[0].t, 0.25, 1e-9);
  EXPECT_NEAR(machine.body(1).v.x, 400 * (t * t - 0.0625) / 20, 10 * bound(GetParam()));
  EXPECT_NEAR(machine.body(1).v.y, 300 * (t * t - 0.0625) / 20, 10 * bound(GetParam()));
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
}

/// 2 kg at 3 m/s towards 4 kg on the same rail, whose weld closes when they are 0.2 m apart.
Model collision() {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "one", .mass = 2, .inertia = 1, .pose = {0, 0, 0}, .velocity = {3, 0, 0}});
  m.add({.name = "other", .mass = 4, .inertia = 1, .pose = {1, 0, 0}});
  m.add("rail", Translational{.body_a = 0, .body_b = 1});
  m.add("rail 2", Translational{.body_a = 0, .body_b = 2});
  m.add("hook", Fixed{.body_a = 1, .body_b = 2, .p_b = {-1, 0}});
  m.add("catch",
        JointEvent{
            .joint = "hook",
            .does = Does::closes,
            .input = input_of(DistanceMeasure{{Marker{.name = "one", .body = 1}, Marker{.name = "other", .body = 2}}}),
            .below = 0.2});
  return m;
}

// Plastic impact: v = m_1 v_1/(m_1 + m_2), lost m_1 m_2/(m_1 + m_2) v_1^2/2.
TEST_P(Release, ALatchIsAPlasticImpact) {
  Machine machine(collision(), options(GetParam()));
  machine.start_from_pose();
  std::vector<double> row(machine.column_names().size());
  const auto open =
      static_cast<std::size_t>(std::find(machine.column_names().begin(), machine.column_names().end(), "hook.open") -
                               machine.column_names().begin());
  ASSERT_LT(open, row.size());
  machine.columns(row);
  EXPECT_EQ(row[open], 1) << "a joint that is only closed starts open";
  run(machine, 0.5, 7e-3);
  machine.columns(row);
  EXPECT_EQ(row[open], 0);
  const double t = machine.time(), met = 0.8 / 3;
  ASSERT_EQ(machine.events().size(), 1U);
  EXPECT_STREQ(machine.events()[0].word(), "closes");
  EXPECT_NEAR(machine.events()[0].t, met, 1e-9);
  EXPECT_NEAR(machine.body(1).v.x, 1, 1e-9);
  EXPECT_NEAR(machine.body(2).v.x, 1, 1e-9);
  EXPECT_NEAR(machine.body(2).r.x, 1 + (t - met), bound(GetParam()));
  EXPECT_NEAR(machine.body(2).r.x - machine.body(1).r.x, 0.2, 1e-9) << "where they were";
  EXPECT_NEAR(machine.energy().lost, 0.5 * 8 / 6 * 9, 1e-8);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-8);
}

// A rod that flies across its length catches a pin at its end: w = m v (l/2)/(I + m l^2/4), and half as fast its
// middle.
TEST_P(Release, ARodCaughtAtItsEndTurns) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "rod", .mass = 3, .inertia = 0.25, .pose = {0, -1, 0}, .velocity = {0, 2, 0}});
  m.add("pin", Revolute{.body_a = 0, .body_b = 1, .p_a = {-0.5, 0}, .p_b = {-0.5, 0}});
  m.add("catch", JointEvent{.joint = "pin",
                            .does = Does::closes,
                            .input = input_of(PositionMeasure{.of = {.name = "rod", .body = 1}, .part = VectorPart::y}),
                            .above = 0});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 0.8, 1e-2);
  const double spin = 3 * 2 * 0.5 / (0.25 + 3 * 0.25);
  EXPECT_NEAR(machine.body(1).omega, spin, 1e-8);
  EXPECT_NEAR(machine.body(1).angle, spin * (machine.time() - 0.5), bound(GetParam()));
  EXPECT_NEAR(machine.energy().lost, 0.5 * 3 * 4 - 0.5 * spin * spin, 1e-8);
  EXPECT_NEAR(std::hypot(machine.body(1).r.x + 0.5, machine.body(1).r.y), 0.5, 1e-10);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-8);
}

// What it is caught by is driven at 1 m/s and stays so: the driver does P v = m_1 (1 - 3) 1 J on it.
TEST_P(Release, ADrivenCatcherDoesItsShareOfTheWork) {
  Model m = collision();
  m.bodies[1].velocity[0] = 1;
  m.add("tow", CoordinateDriver{.body = 2, .coordinate = Coordinate::x, .motion = {.velocity = 1.}});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 0.5, 7e-3);
  EXPECT_NEAR(machine.body(1).v.x, 1, 1e-9);
  EXPECT_NEAR(machine.energy().lost, 0.5 * 2 * 4, 1e-8);
  EXPECT_NEAR(machine.energy().driver_work, 2 * (1 - 3) * 1, 1e-8);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-8);
}

// Caught, let go where the measure is at its value still, drawn apart and pushed together: caught once more.
TEST_P(Release, AnEventWaitsUntilItsValueIsPassedAnew) {
  Model m = collision();
  m.events[0].element.starts = JointEvent::Starts::open;
  m.add("push", AppliedForce{.body = 2, .fx = TableFunction({0, 0.4, 0.5, 0.6, 0.7, 2}, {0, 0, 60, -90, 0, 0})});
  m.add("let go", JointEvent{.joint = "hook", .does = Does::opens, .at = 0.35});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 2, 5e-3);
  ASSERT_EQ(machine.events().size(), 3U);
  EXPECT_NEAR(machine.events()[1].t, 0.35, 1e-12);
  EXPECT_GT(machine.events()[2].t, 0.5);
  EXPECT_STREQ(machine.events()[2].word(), "closes");
  EXPECT_NEAR(machine.body(2).r.x - machine.body(1).r.x, 0.2, 1e-8);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-4) << "steps of 5 ms over the corners of the load";
}

// Below its value from the start on, it has to rise above and fall again: a pendulum let go level swings down through
// -0.3 rad, which is no passage upward, and up through it on its way back.
TEST_P(Release, AMeasureBeyondItsValueAtTheStartIsNoPassage) {
  Model m = pendulum();
  m.add("drop", JointEvent{.joint = "pin",
                           .does = Does::opens,
                           .input = input_of(AngleMeasure{.of = {.name = "rod", .body = 1}}),
                           .above = -0.3});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  EXPECT_EQ(machine.events().size(), 0U);
  run(machine, 1, 2e-3);
  EXPECT_EQ(machine.events().size(), 0U);
  run(machine, 2, 2e-3);
  ASSERT_EQ(machine.events().size(), 1U);
  EXPECT_GT(machine.events()[0].t, 1.4) << "most of a period of 1.93 s: 1.18 times that of small swings";
}

// At its value at the start: it passes it where it moves beyond, at once, and not where it moves away or rests. Within
// what counts as the value itself, 1e-9 at least, it moves for 1e-9/0.5 s.
TEST_P(Release, AMeasureAtItsValueAtTheStartPassesItByMovingOn) {
  for (const double spin : {0.5, -0.5, 0.0}) {
    SCOPED_TRACE(spin);
    Model m = pendulum();
    m.gravity = {0, 0};
    m.bodies[0].velocity = {0, 0.5 * spin, spin};
    m.add("drop", JointEvent{.joint = "pin",
                             .does = Does::opens,
                             .input = input_of(AngleMeasure{.of = {.name = "rod", .body = 1}}),
                             .above = 0});
    Machine machine(m, options(GetParam()));
    machine.start_from_pose();
    run(machine, 0.1, 2e-3);
    ASSERT_EQ(machine.events().size(), spin > 0 ? 1U : 0U);
    if (spin > 0) {
      EXPECT_LT(machine.events()[0].t, 3e-9);
    }
  }
}

// A rod turns freely at 6 rad/s, its centre 0.5 m from the pin, past a post that stands a little further out. The two
// are nearer than 1 mm for 0.6 ms, a thirtieth of the interval asked for; d^2 = R^2 + P^2 - 2 R P cos(phi) says from
// when. Bound: the motion's 1e-8 m at 3 m/s, twice as much along the chord.
TEST_P(Release, AMeasureThatPassesItsValueForAnInstantIsSeen) {
  const double spin = 6, radius = 0.5;
  for (const double post : {0.5005, 0.4995, 0.50099, 0.5012}) {
    SCOPED_TRACE(post);
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "rod", .mass = 3, .inertia = 0.25, .pose = {radius, 0, 0}, .velocity = {0, radius * spin, spin}});
    m.add("pin", Revolute{.body_a = 0, .body_b = 1, .p_b = {-radius, 0}});
    m.add("drop",
          JointEvent{.joint = "pin",
                     .does = Does::opens,
                     .input = input_of(DistanceMeasure{.between = {Marker{.name = "post", .body = 0, .p = {0, post}},
                                                                   Marker{.name = "rod", .body = 1}}}),
                     .below = 1e-3});
    Machine machine(m, {.integrator = GetParam()});
    machine.start_from_pose();
    run(machine, 0.4, 0.02);
    const double cosine = (radius * radius + post * post - 1e-6) / (2 * radius * post);
    ASSERT_EQ(machine.events().size(), cosine < 1 ? 1U : 0U);
    if (cosine < 1) {
      EXPECT_NEAR(machine.events()[0].t, (std::numbers::pi / 2 - std::acos(cosine)) / spin, 1e-8);
    }
  }
}

// A rim point passes two posts once a turn, below 1 cm from each for 0.1 ms: every passage of the first opens a joint,
// every one of the second closes it, though the rotor turns by radians from row to row.
TEST_P(Release, EventsComeOnceInEveryTurn) {
  if (GetParam() == IntegratorKind::adams_moulton) GTEST_SKIP() << "fixed steps that turn by radians resolve nothing";
  for (const double spin : {600.0, 1000.0, 2000.0, 5000.0}) {
    SCOPED_TRACE(spin);
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "rotor", .mass = 1, .inertia = 0.01, .velocity = {0, 0, spin}});
    m.add({.name = "held", .mass = 1, .inertia = 0.01, .pose = {0, 5, 0}});
    m.add("pin", Revolute{.body_a = 0, .body_b = 1});
    m.add("hold", Fixed{.body_a = 0, .body_b = 2});
    const auto near = [](double angle) {
      return input_of(DistanceMeasure{
          .between = {Marker{.name = "post", .body = 0, .p = {0.1001 * std::cos(angle), 0.1001 * std::sin(angle)}},
                      Marker{.name = "rim", .body = 1, .p = {0.1, 0}}}});
    };
    m.add("open", JointEvent{.joint = "hold", .does = Does::opens, .input = near(1.234), .below = 0.01});
    m.add("close", JointEvent{.joint = "hold", .does = Does::closes, .input = near(4), .below = 0.01});
    Machine machine(m, {.integrator = GetParam()});
    machine.start_from_pose();
    const double turns = 12.1;
    const double end = turns * 2 * std::numbers::pi / spin;
    for (int k = 0; k < 40; ++k) machine.advance(end / 40);
    ASSERT_EQ(machine.events().size(), 24U);
    for (std::size_t k = 1; k < 24; ++k) EXPECT_NE(machine.events()[k].word(), machine.events()[k - 1].word()) << k;
  }
}

// A block of 2 kg slides at 3 m/s, pressed on its rail by 20 N, and catches at 0.1 s what comes at -4 m/s: the friction
// of that instant is against the velocity behind the impact, (2 kg 2.7 m/s - 4 kg 4 m/s)/6 kg, and brakes both.
TEST_P(Release, FrictionIsAgainstTheVelocityBehindAnImpact) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "block", .mass = 2, .inertia = 1, .velocity = {3, 0, 0}});
  m.add({.name = "other", .mass = 4, .inertia = 1, .pose = {1, 0, 0}, .velocity = {-4, 0, 0}});
  m.add("rail", Translational{.body_a = 0, .body_b = 1});
  m.add("hook", Fixed{.body_a = 1, .body_b = 2});
  m.add("press", AppliedForce{.body = 1, .fy = -20.});
  m.add("rub", JointFriction{.joint = "rail", .guide = 0.5, .mu_s = 0.3, .mu_k = 0.3, .stick_stiffness = 1e5});
  m.add("catch", JointEvent{.joint = "hook", .does = Does::closes, .at = 0.1});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 0.098, 2e-3);
  EXPECT_NEAR(machine.force_value("rub", "force"), -6, 1e-6);
  run(machine, 0.1, 2e-3);
  EXPECT_NEAR(machine.body(1).v.x, (2 * 2.7 - 4 * 4) / 6, 1e-6);
  EXPECT_NEAR(machine.force_value("rub", "force"), 6, 1e-6);
  EXPECT_NEAR(machine.integrator().state().acceleration[0], 1, 1e-6);
  run(machine, 0.2, 2e-3);
  EXPECT_NEAR(machine.body(1).v.x, (2 * 2.7 - 4 * 4) / 6 + 0.1, 1e-6);
}

// 1 kg on a slide whose friction may stick, held by a rod beside; 2 N push it, and the rod opens at 0.1 s. With the rod
// nothing could move along the slide: from then on its damping is critical for the mass, w = (k/m)^1/2 = 100/s:
//   x = F/k (1 - (1 + w t) e^(-w t))
TEST_P(Release, FrictionThatSticksIsDampedForWhatMayMoveNow) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "sledge", .mass = 1, .inertia = 1});
  m.add("rail", Translational{.body_a = 0, .body_b = 1});
  m.add("rod", Distance{.body_a = 0, .body_b = 1, .p_a = {-0.2, 0}, .length = 0.2});
  m.add("press", AppliedForce{.body = 1, .fx = 2., .fy = -20.});
  m.add("rub", JointFriction{.joint = "rail", .guide = 0.5, .mu_s = 0.3, .mu_k = 0.3, .stick_stiffness = 1e4});
  m.add("go", JointEvent{.joint = "rod", .does = Does::opens, .at = 0.1});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 0.1, 1e-3);
  for (const double t : {0.01, 0.03, 0.05, 0.1, 0.3}) {
    run(machine, 0.1 + t, 1e-3);
    EXPECT_NEAR(machine.body(1).r.x, 2e-4 * (1 - (1 + 100 * t) * std::exp(-100 * t)), 2e-8) << t;
    EXPECT_EQ(machine.force_value("rub", "sticking"), 1) << t;
  }
}

// A soil's force, which jumps from step to step: 0 at the start, above -2 N already, then -5 N, then 0 again. The joint
// opens with the second passage, by each method.
TEST_P(Release, AForceThatJumpsBackAndPassesAgainOpens) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "one", .mass = 2, .inertia = 1});
  m.add("weld", Fixed{.body_a = 0, .body_b = 1});
  SoilForceMeasure felt{.body = 1};
  felt.part = WrenchPart::x;
  m.add("go", JointEvent{.joint = "weld", .does = Does::opens, .input = input_of(felt), .above = -2});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  const auto steps = [&](int count, double fx) {
    for (int i = 0; i < count; ++i) {
      machine.set_external_wrench(1, fx, 0, 0);
      machine.advance(1e-3);
    }
  };
  steps(10, 0);
  EXPECT_TRUE(machine.events().empty());
  steps(10, -5);
  EXPECT_TRUE(machine.events().empty());
  steps(10, 0);
  ASSERT_EQ(machine.events().size(), 1U);
  EXPECT_NEAR(machine.events()[0].t, 0.02, 1.0001e-3);
}

/// A parallelogram of two cranks of 0.3 m, turning at 15 rad/s from 1 rad; a brake closes on its coupler at `angle`.
Model braked_parallelogram(double angle) {
  const double r = 0.3, start = 1, spin = 15, s = std::sin(start), c = std::cos(start);
  Model m;
  m.add({.name = "one", .mass = 1, .inertia = 0.02, .pose = {0, 0, start}, .velocity = {0, 0, spin}});
  m.add({.name = "two", .mass = 1, .inertia = 0.02, .pose = {0.8, 0, start}, .velocity = {0, 0, spin}});
  m.add({.name = "coupler",
         .mass = 2,
         .inertia = 0.1,
         .pose = {r * c + 0.4, r * s, 0},
         .velocity = {-r * s * spin, r * c * spin, 0}});
  m.add("a", Revolute{.body_a = 0, .body_b = 1});
  m.add("b", Revolute{.body_a = 0, .body_b = 2, .p_a = {0.8, 0}});
  m.add("e", Revolute{.body_a = 1, .body_b = 3, .p_a = {r, 0}, .p_b = {-0.4, 0}});
  m.add("f", Revolute{.body_a = 2, .body_b = 3, .p_a = {r, 0}, .p_b = {0.4, 0}});
  m.add("brake", Fixed{.body_a = 0, .body_b = 3});
  m.add("stop", JointEvent{.joint = "brake",
                           .does = Does::closes,
                           .input = input_of(AngleMeasure{.of = {.name = "one", .body = 1}}),
                           .above = angle});
  return m;
}

// Beside its flat poses and away from them it stands where it was caught, with all of its kinetic energy lost: of the
// brake's three equations and the eight of the pins two are redundant, and near the flat pose not any two.
TEST_P(Release, ALinkageLockedBesideItsFlatPoseStands) {
  for (const double angle : {2.0, 3.1, 3.13, 3.162, 6.2, 6.25, 6.27, 6.3}) {
    SCOPED_TRACE(angle);
    Machine machine(braked_parallelogram(angle), options(GetParam()));
    machine.start_from_pose();
    run(machine, 0.7, 1e-3);
    ASSERT_EQ(machine.events().size(), 1U);
    const double start = 0.5 * (2 * 0.02 + 2 * 0.09) * 15 * 15;
    EXPECT_NEAR(machine.body(1).angle, angle, 1e-7);
    EXPECT_NEAR(machine.body(2).angle, angle, 1e-7);
    EXPECT_NEAR(machine.body(3).r.y, 0.3 * std::sin(angle), 1e-7);
    for (int i = 1; i <= 3; ++i) EXPECT_NEAR(machine.body(i).omega, 0, 1e-7) << i;
    EXPECT_NEAR(machine.energy().lost, start - 2 * 9.81 * 0.3 * (std::sin(angle) - std::sin(1.)), 1e-5);
    EXPECT_NEAR(machine.energy().balance(), 0, 1e-5);
  }
}

/// A ball on a rail meets the tip of a hanging rod at 8 m/s: when it is there, rail and rod change over.
Model ballistic_pendulum(bool catch_first) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "rod", .mass = 3, .inertia = 1, .pose = {0, -1, 0}});
  m.add({.name = "ball", .mass = 0.5, .inertia = 1e-3, .pose = {-1, -2, 0}, .velocity = {8, 0, 0}});
  m.add("pin", Revolute{.body_a = 0, .body_b = 1, .p_b = {0, 1}});
  m.add("hook", Revolute{.body_a = 1, .body_b = 2, .p_a = {0, -1}});
  m.add("rail", Translational{.body_a = 0, .body_b = 2, .p_a = {0, -2}});
  const auto there = [](const char* joint, Does does) {
    return JointEvent{.joint = joint,
                      .does = does,
                      .input = input_of(PositionMeasure{.of = {.name = "ball", .body = 2}, .part = VectorPart::x}),
                      .above = 0};
  };
  if (catch_first) m.add("catch", there("hook", Does::closes));
  m.add("free", there("rail", Does::opens));
  if (!catch_first) m.add("catch", there("hook", Does::closes));
  return m;
}

// Both happen at x = 0, in either order of the events: m v l = (I + M l^2/4 + m l^2) w with l = 2 m, so w = 8/6 1/s;
// of 16 J of the ball 6 w^2/2 = 5.333 J are left. The ball is a mass point to the rod. Bounds: those of the motion.
TEST_P(Release, TwoEventsOfOneInstantBothHappen) {
  for (const bool catch_first : {false, true}) {
    Machine machine(ballistic_pendulum(catch_first), options(GetParam()));
    machine.start_from_pose();
    run(machine, 0.5, 1e-2);
    EXPECT_EQ(machine.events().size(), 2U);
    for (const Event& e : machine.events()) EXPECT_NEAR(e.t, 0.125, 1e-9);
    EXPECT_NEAR(machine.body(1).omega, 8. / 6, 10 * bound(GetParam()));
    EXPECT_NEAR(machine.body(1).angle, 8. / 6 * (machine.time() - 0.125), 10 * bound(GetParam()));
    EXPECT_NEAR(machine.energy().lost, 16 - 3 * 64. / 36, 1e-7);
    EXPECT_NEAR(machine.energy().balance(), 0, 1e-7);
  }
}

/// 10 kg on a rail, pulled by `load` and held by links at both sides of the rail, which are redundant to one another.
Model between_links(Function load) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "carriage", .mass = 10, .inertia = 1});
  m.add("rail", Translational{.body_a = 0, .body_b = 1});
  m.add("a", Distance{.body_a = 0, .body_b = 1, .p_a = {-1, 0.1}, .p_b = {0, 0.1}});
  m.add("b", Distance{.body_a = 0, .body_b = 1, .p_a = {-1, -0.1}, .p_b = {0, -0.1}});
  m.add("load", AppliedForce{.body = 1, .fx = std::move(load)});
  return m;
}

// A link has 3 kN more to bear when another one, that pulls back by 2 kN, is let go at 1 s: it shears then and not only
// if its load should pass 2 kN by and by. From there v = F (t - 1)/m.
TEST_P(Release, AReactionThatJumpsAboveItsLimitShears) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "carriage", .mass = 10, .inertia = 1});
  m.add({.name = "counter", .mass = 1, .inertia = 1, .pose = {1, 0, 0}});
  m.add("rail", Translational{.body_a = 0, .body_b = 1});
  m.add("other rail", Translational{.body_a = 0, .body_b = 2});
  m.add("pin", Distance{.body_a = 0, .body_b = 1, .p_a = {-1, 0.1}, .p_b = {0, 0.1}});
  m.add("hook", Distance{.body_a = 1, .body_b = 2});
  m.add("load", AppliedForce{.body = 1, .fx = 3000.});
  m.add("back", AppliedForce{.body = 2, .fx = -2000.});
  m.add("drop", JointEvent{.joint = "hook", .does = Does::opens, .at = 1});
  m.add("shear", JointEvent{.joint = "pin", .does = Does::opens, .reaction_above = 2000});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 0.99, 1e-2);
  EXPECT_NEAR(std::abs(machine.joint_reaction("pin").fx), 1000, 1e-6);
  EXPECT_TRUE(machine.events().empty());
  run(machine, 1.5, 1e-2);
  ASSERT_EQ(machine.events().size(), 2U);
  EXPECT_EQ(machine.events()[1].name, "pin");
  EXPECT_NEAR(machine.events()[1].t, 1, 1e-9);
  EXPECT_NEAR(machine.body(1).v.x, 300 * (machine.time() - 1), 10 * bound(GetParam()) * 300);
}

// A sampled output that follows 1 kN/s t at multiples of 0.1 s jumps from 200 to 300 N at 0.3 s, inside a step of 0.25
// s: there a pin of 250 N shears.
TEST_P(Release, AReactionThatASampleTakesAboveItsLimitShears) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "tool", .mass = 20, .inertia = 1});
  m.add("pin", Fixed{.body_a = 0, .body_b = 1});
  AppliedForce load{.body = 1};
  load.controller = "ramp";
  m.add("load", load);
  PidController ramp;
  ramp.input = input_of(PositionMeasure{.of = {.name = "tool", .body = 1}, .part = VectorPart::x});
  ramp.bias = PolynomialFunction{{0, 1000, 0, 0, 0, 0}}, ramp.sample_time = 0.1;
  m.add("ramp", ramp);
  m.add("trip", JointEvent{.joint = "pin", .does = Does::opens, .reaction_above = 250});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 0.5, 0.25);
  ASSERT_EQ(machine.events().size(), 1U);
  EXPECT_NEAR(machine.events()[0].t, 0.3, 1e-9);
  EXPECT_NEAR(machine.body(1).v.x, (300 * 0.1 + 400 * 0.1) / 20, 1e-7);
}

// A sledge of 9 kg with 1 kg pinned on it slides with friction mu and a push of 3 N against it on the small one: a =
// -(mu g + 0.3), and the pin pushes by |a| - 3 = -0.24 N along x. As the sledge sticks, after 1/|a| s, its deceleration
// falls to 0.3 m/s^2 at once and the pin has 2.7 N along x, above its limit of 10 N with the 9.81 N of the weight.
TEST_P(Release, AReactionThatRisesAsFrictionSticksShears) {
  Model m;
  m.add({.name = "sledge", .mass = 9, .inertia = 1, .velocity = {1, 0, 0}});
  m.add({.name = "load", .mass = 1, .inertia = 1, .velocity = {1, 0, 0}});
  m.add("rail", Translational{.body_a = 0, .body_b = 1});
  m.add("pin", Fixed{.body_a = 1, .body_b = 2});
  m.add("rub", JointFriction{.joint = "rail", .guide = 10, .mu_s = 0.3, .mu_k = 0.3, .stick_stiffness = 1e4});
  m.add("push", AppliedForce{.body = 2, .fx = -3.});
  m.add("shear", JointEvent{.joint = "pin", .does = Does::opens, .reaction_above = 10});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 0.5, 1e-2);
  const double stops = 1 / (0.3 * 9.81 + 0.3);
  ASSERT_EQ(machine.events().size(), 2U);
  EXPECT_EQ(machine.events()[1].name, "pin");
  EXPECT_NEAR(machine.events()[1].t, stops, 1e-8);
  EXPECT_NEAR(machine.body(2).v.x, -3 * (machine.time() - stops), 1e-6);
}

// The impact of a latch takes a speed from 3 to 1 m/s, past the 2 m/s at which another joint opens: then, once.
TEST_P(Release, AnImpactTakesAMeasurePastItsValue) {
  Model m = collision();
  m.add("let go",
        JointEvent{.joint = "rail 2",
                   .does = Does::opens,
                   .input = input_of(VelocityMeasure{.of = {.name = "one", .body = 1}, .part = VectorPart::x}),
                   .below = 2});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 0.5, 7e-3);
  ASSERT_EQ(machine.events().size(), 2U);
  EXPECT_EQ(machine.events()[1].name, "rail 2");
  for (const Event& e : machine.events()) EXPECT_NEAR(e.t, 0.8 / 3, 1e-9);
  EXPECT_NEAR(machine.body(2).v.x, 1, 1e-9);
}

// Two links bear 500 t N each. At 1.8 s link a reaches its 900 N; then b has 1800 N, above its 1000 N, and gives way at
// that instant too. v = 1000 (t^2 - 1.8^2)/(2 m), to the share `bound` of 100 m/s.
TEST_P(Release, LinksThatShareTheirLoadShearByTheirShare) {
  Model m = between_links(PolynomialFunction{{0, 1000, 0, 0, 0, 0}});
  m.add("shear a", JointEvent{.joint = "a", .does = Does::opens, .reaction_above = 900});
  m.add("shear b", JointEvent{.joint = "b", .does = Does::opens, .reaction_above = 1000});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 1.7, 1e-2);
  EXPECT_TRUE(machine.events().empty());
  EXPECT_NEAR(std::abs(machine.joint_reaction("a").fx), 500 * machine.time(), 1e-6);
  run(machine, 2.3, 1e-2);
  ASSERT_EQ(machine.events().size(), 2U);
  for (const Event& e : machine.events()) EXPECT_NEAR(e.t, 1.8, 1e-9);
  EXPECT_NEAR(machine.body(1).v.x, 50 * (machine.time() * machine.time() - 3.24), 100 * bound(GetParam()));
}

// A controller that hands on the reaction of either link drives 1 kg by the 500 N that this link bears: v = 500 t.
TEST_P(Release, ControllersSeeTheShareOfALink) {
  for (const bool sampled : {false, true})
    for (const char* link : {"a", "b"}) {
      Model m = between_links(1000.);
      m.add({.name = "follower", .mass = 1, .inertia = 1, .pose = {0, 5, 0}});
      m.add("other rail", Translational{.body_a = 0, .body_b = 2, .p_a = {0, 5}});
      AppliedForce drive{.body = 2};
      drive.controller = "hand on";
      m.add("drive", drive);
      ReactionMeasure reaction;
      reaction.element = link, reaction.part = WrenchPart::size;
      PidController c;
      c.input = input_of(reaction), c.proportional = -1;
      (sampled ? c.sample_time : c.sensor_lag) = 1e-3;
      m.add("hand on", c);
      Machine machine(m, options(GetParam()));
      machine.start_from_pose();
      run(machine, 0.1, 1e-3);
      EXPECT_NEAR(machine.body(2).v.x, 500 * machine.time(), 1e-5) << link << (sampled ? " sampled" : "");
    }
}

TEST_P(Release, GoesOnFromASnapshotWithTheSameNumbers) {
  for (const double at : {0.1, 0.3}) {  // before and after the impact
    Machine one(collision(), options(GetParam())), other(collision(), options(GetParam()));
    one.start_from_pose();
    other.start_from_pose();
    run(one, at, 5e-3);
    one.restore(one.snapshot());
    other.restore(one.snapshot());
    for (int i = 0; i < 60; ++i) one.advance(5e-3), other.advance(5e-3);
    EXPECT_EQ(one.snapshot(), other.snapshot());
    EXPECT_EQ(other.events().size(), 1U);
    EXPECT_NEAR(other.energy().lost, 6, 1e-8);
  }
}

// Rows inside the step of an event: before it the joint is as it was before.
TEST(ReleaseLook, InsideTheStepSeesBothSides) {
  Machine machine(collision(), {});
  machine.start_from_pose();
  machine.keep_dense_output();
  run(machine, 0.27, 9e-3);  // the last step holds the impact
  ASSERT_EQ(machine.events().size(), 1U);
  Evaluation between = machine.evaluation();
  const Instant before = between.evaluate(machine.dense_output(), 0.264);
  EXPECT_NEAR(before.body(1).v.x, 3, 1e-9);
  EXPECT_NEAR(before.body(1).r.x, 0.264 * 3, 1e-9);
  const Instant behind = between.evaluate(machine.dense_output(), 0.269);
  EXPECT_NEAR(behind.body(1).v.x, 1, 1e-9);
  EXPECT_EQ(machine.system().open_joints()[2], 0);
}

TEST(ReleaseRefusal, SaysWhatIsWrong) {
  const auto refusal = [](const Model& m) { return test::message_of([&] { Machine machine(m, {}); }); };
  const auto says = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  Model m = pendulum();
  m.add("drop", JointEvent{.joint = "pim", .does = Does::opens, .at = 1});
  says(refusal(m), "event 'drop': no joint 'pim'; there are pin");
  m = pendulum();
  m.add("drop", JointEvent{.joint = "pin", .does = Does::opens});
  says(refusal(m), "needs one condition");
  m = collision();
  m.add("catch 2", JointEvent{.joint = "rail", .does = Does::closes, .at = 1});
  says(refusal(m), "joint 'rail' cannot close on the way");
  m = pendulum();
  m.add("drop", JointEvent{.joint = "pin", .does = Does::opens, .at = 1});
  m.add("rub", JointFriction{.joint = "pin", .radius = 0.02, .mu_s = 0.1, .mu_k = 0.1});
  says(refusal(m), "and friction would act in it still");
}

}  // namespace
}  // namespace subsoil::mbd::release_test
