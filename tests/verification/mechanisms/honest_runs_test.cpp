// A run that is wrong says so: by its estimate of the error, by its energy balance, or by stopping.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/fixed.hpp"
#include "libmbd/joints/point_on_line.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/mechanisms.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::mbd::honest_runs_test {
namespace {

constexpr double pi = std::numbers::pi;

/// A mass on a spring along x, released a millimetre from rest.
Model oscillator(double mass, double stiffness) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "mass", .mass = mass, .inertia = 1, .pose = {0.501, 0, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = 1});
  m.add("spring", SpringDamper{.body_a = ground, .body_b = 1, .stiffness = stiffness, .free_length = 0.5});
  return m;
}

std::string outcome(Machine& machine, double h, double end) {
  try {
    machine.start_from_pose();
    while (machine.time() < end - h / 2) machine.advance(h);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

// 0.2 kg on 2e6 N/m swing at 3162 rad/s: w h = 3.2 is far outside what Adams-Moulton of order 4 bears (1.3).
TEST(HonestRuns, AFixedStepThatIsTooLongStops) {
  Machine machine(oscillator(0.2, 2e6), {});
  const std::string text = outcome(machine, 1e-3, 0.1);
  EXPECT_EQ(text.find("t = 0.0"), 0U) << text;
  EXPECT_NE(text.find("step"), std::string::npos) << text;
  EXPECT_EQ(text.find("singular"), std::string::npos) << text;
}

TEST(HonestRuns, StepsOfTheirOwnFollowTheSameSpring) {
  Machine machine(oscillator(0.2, 2e6), {.integrator = IntegratorKind::cvode});
  EXPECT_EQ(outcome(machine, 1e-3, 0.1), "");
  // 316 rad of phase, each erring by the tolerance of 1e-8 at most tenfold: 3e-6 of a millimetre.
  EXPECT_NEAR(machine.body(1).r.x, 0.5 + 1e-3 * std::cos(std::sqrt(2e6 / 0.2) * 0.1), 1e-3 * 1e-5);
  EXPECT_LT(machine.energy().closure(), 1e-6);
}

// The balance is judged against the energy that is there: nothing is put in here, and the amplitude grows or decays by
// the error of the step. (w h)^6 at w h = 0.9 is 0.5, so that some per cent are lost within a hundred swings.
TEST(HonestRuns, ClosureRelatesToTheEnergyThatIsThere) {
  Machine machine(oscillator(1, 810e3), {});
  outcome(machine, 1e-3, 0.2);
  const MachineEnergy e = machine.energy();
  const double at_start = 0.5 * 810e3 * 1e-6;
  EXPECT_NEAR(e.at_start, at_start, 1e-9 * at_start);
  EXPECT_GT(std::abs(e.balance()), 1e-3 * at_start);
  EXPECT_GE(e.moved, at_start * (1 - 1e-12));
  EXPECT_NEAR(e.closure(), std::abs(e.balance()) / e.moved, 1e-6 * e.closure());
  EXPECT_GT(e.closure(), 1e-3);
}

// Milne's estimate against the true error of an oscillator: the sum of local errors bounds the phase error within a
// factor of a few (both are known: the global error after n radian is n times the local one per radian).
TEST(HonestRuns, TheEstimateOfTheStepTellsTheError) {
  for (const double h : {2e-3, 1e-3, 5e-4}) {
    Machine machine(oscillator(1, 1e4), {});  // w = 100/s
    machine.start_from_pose();
    double worst = 0;
    for (int i = 1; i <= std::lround(1 / h); ++i) {
      machine.advance(h);
      worst = std::max(worst, std::abs(machine.body(1).r.x - 0.5 - 1e-3 * std::cos(100 * machine.time())));
    }
    const StepError& e = machine.integrator().step_error();
    const double true_share = worst / 1e-3, estimate = e.velocities / e.fastest;
    EXPECT_GT(estimate, 0.3 * true_share) << h;
    EXPECT_LT(estimate, 30 * true_share) << h;
  }
}

// A driver's angle that jumps by 2 rad has no motion between: no method may call that done.
TEST(HonestRuns, AMotionThatJumpsIsNamed) {
  Model m;
  m.add({.name = "rod", .mass = 3, .inertia = 0.25, .pose = {0.5, 0, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.5, 0}});
  m.add("motor",
        AngleDriver{.first = ground,
                    .second = 1,
                    .motion = {.position = RampFunction{.from = 0, .to = 2, .begin = 0.5, .end = 0.5 + 1e-9}}});
  for (const IntegratorKind kind : {IntegratorKind::adams_moulton, IntegratorKind::cvode}) {
    Machine machine(m, {.integrator = kind});
    const std::string text = outcome(machine, 1e-2, 1);
    if (text.empty()) {
      EXPECT_GT(machine.energy().closure(), 0.1);
    } else {
      EXPECT_NE(text.find("t = 0.5"), std::string::npos) << text;
      EXPECT_NE(text.find("jump"), std::string::npos) << text;
    }
  }
}

// Two drivers of one coordinate that part on the way: both are named, and no step or tolerance is blamed.
TEST(HonestRuns, DriversThatPartOnTheWayAreNamed) {
  Model m;
  m.add({.name = "rod", .mass = 1, .inertia = 0.1, .pose = {0.5, 0, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.5, 0}});
  m.add("a", AngleDriver{.first = ground,
                         .second = 1,
                         .motion = {.position = RampFunction{.from = 0, .to = 1, .begin = 0.2, .end = 0.5}}});
  m.add("b", AngleDriver{.first = ground,
                         .second = 1,
                         .motion = {.position = RampFunction{.from = 0, .to = 1, .begin = 0.3, .end = 0.6}}});
  Machine machine(m, {.integrator = IntegratorKind::cvode});
  const std::string text = outcome(machine, 1e-2, 1);
  EXPECT_NE(text.find("t = 0.2"), std::string::npos) << text;
  EXPECT_NE(text.find("driver 'b' and driver 'a' depend on each other and ask for different motions"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("tolerance"), std::string::npos) << text;
}

// A first step that fails on the way: what it has made before is read.
TEST(HonestRuns, WhatAFailedStepHasMadeIsRead) {
  Model m;
  m.add({.name = "rod", .mass = 1, .inertia = 0.1, .pose = {0.5, 0, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.5, 0}});
  for (const double end : {0.5, 0.6})
    m.add("turn until " + std::to_string(end),
          AngleDriver{.first = ground,
                      .second = 1,
                      .motion = {.position = RampFunction{.from = 0, .to = 1, .begin = end - 0.3, .end = end}}});
  Machine machine(m, {.integrator = IntegratorKind::ida});
  machine.keep_dense_output();
  machine.start_from_pose();
  EXPECT_NE(test::message_of<std::runtime_error>([&] { machine.advance(1); }), "accepted");
  ASSERT_FALSE(machine.dense_output().empty());
  Evaluation evaluation = machine.evaluation();
  EXPECT_EQ(evaluation.evaluate(machine.dense_output(), 1e-6).body(1).angle, 0);
}

// A crank of 0.2 m and a rod of 0.13^1/2 m, whose slider is driven from 0.3 to 0.6 m: they are in line at 0.5606 m.
TEST(HonestRuns, ADriverBeyondADeadCentreIsNamed) {
  Model m;
  m.gravity = {0, 0};
  const int crank = m.add({.name = "crank", .mass = 1, .inertia = 0.01, .pose = {0, 0.1, pi / 2}});
  const int rod = m.add({.name = "rod", .mass = 1, .inertia = 0.01, .pose = {0.15, 0.1, -std::atan2(2, 3)}});
  const int slider = m.add({.name = "slider", .mass = 1, .inertia = 0.01, .pose = {0.3, 0, 0}});
  m.add("o", test::pin_at(m, ground, crank, {0, 0}));
  m.add("a", test::pin_at(m, crank, rod, {0, 0.2}));
  m.add("b", test::pin_at(m, rod, slider, {0.3, 0}));
  m.add("g", Translational{.body_a = ground, .body_b = slider});
  m.add("d", CoordinateDriver{.body = slider,
                              .coordinate = Coordinate::x,
                              .motion = {.position = RampFunction{.from = 0.3, .to = 0.6, .begin = 0, .end = 1}}});
  Machine machine(m, {.integrator = IntegratorKind::cvode});
  const std::string text = outcome(machine, 1e-2, 1);
  EXPECT_NE(text.find("t = 0.725"), std::string::npos) << text;
  EXPECT_NE(text.find("dead centre"), std::string::npos) << text;
  EXPECT_NE(text.find("beyond which driver 'd' leads"), std::string::npos) << text;
}

// A force of F sin(w t) over whole periods leaves a mass at rest at every row, where its work is 0 to rounding. What
// moved between them counts: v = 2 F/(m w) in the middle of each.
TEST(HonestRuns, EnergyThatMovesBetweenRowsIsThere) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "mass", .mass = 1, .inertia = 0.01});
  m.add("slide", Translational{.body_a = ground, .body_b = 1});
  m.add("shaker", AppliedForce{.body = 1, .fx = HarmonicFunction{.amplitude = 1000, .frequency = 1000}});
  const double v = 2 * 1000 / (2 * pi * 1000);
  for (const IntegratorKind kind : {IntegratorKind::cvode, IntegratorKind::ida}) {
    Machine machine(m, {.integrator = kind});
    EXPECT_EQ(outcome(machine, 1e-3, 0.1), "");
    EXPECT_NEAR(machine.energy().moved, v * v / 2, 0.1 * v * v / 2);
    EXPECT_LT(machine.energy().closure(), 1e-6);
  }
}

// A beam at rest on a pin and two rollers, one too many: what rounding does to its height is no energy that was lost.
TEST(HonestRuns, RoundingOfAMachineAtRestIsNoShareOfAnything) {
  Model m;
  m.add({.name = "beam", .mass = 3, .inertia = 1, .pose = {0.2, 0, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_a = {-1, 0}, .p_b = {-1.2, 0}});
  m.add("middle", PointOnLine{.body_a = ground, .body_b = 1, .p_b = {-0.2, 0}});
  m.add("end", PointOnLine{.body_a = ground, .body_b = 1, .p_a = {1, 0}, .p_b = {0.8, 0}});
  Machine machine(m, {.integrator = IntegratorKind::cvode});
  EXPECT_EQ(outcome(machine, 1e-3, 0.1), "");
  EXPECT_LT(machine.energy().closure(), 1e-3);
}

// Freedom 0 and nothing driven: nothing is to be integrated, by whichever method.
TEST(HonestRuns, AMachineThatNothingMovesStands) {
  Model m;
  m.add({.name = "block", .mass = 2, .inertia = 1, .pose = {1, 2, 0.3}});
  m.add("weld", Fixed{.body_a = ground, .body_b = 1, .p_a = {1, 2}});
  for (const IntegratorKind kind : {IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida}) {
    Machine machine(m, {.integrator = kind});
    EXPECT_EQ(outcome(machine, 1e-2, 0.1), "");
    EXPECT_EQ(machine.assembly().freedom, 0);
    EXPECT_NEAR(machine.body(1).r.y, 2, 1e-12);
    EXPECT_NEAR(machine.joint_reaction("weld").fy, -2 * 9.81, 1e-9);
  }
}

// A machine that a driver holds at rest moves no energy, and what rounding leaves of its balance is no share of it.
TEST(HonestRuns, AMachineHeldAtRestKeepsItsBalance) {
  Model m;
  m.add({.name = "rod", .mass = 3, .inertia = 0.25, .pose = {0.5, 0, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.5, 0}});
  m.add("brake", AngleDriver{.first = ground, .second = 1, .motion = {.position = 0.0}});
  for (const IntegratorKind kind : {IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida}) {
    Machine machine(m, {.integrator = kind});
    machine.start_from_pose();
    for (int i = 0; i < 500; ++i) {
      machine.advance(1e-3);
      ASSERT_LT(machine.energy().closure(), 1e-3) << machine.time() << " s by " << static_cast<int>(kind);
    }
    const StepError& e = machine.integrator().step_error();
    EXPECT_LT(e.sum(), 1e-6) << "of steps that move nothing";
  }
}

// Where a method gives up it says which body and which constraint stand out: here the cart, which is all but without
// mass, as the point mass on its pole swings through its lowest place and turns it round within nanoseconds.
TEST(HonestRuns, AMethodThatGivesUpNamesWhatStandsOut) {
  Model m;
  const double angle = 0.7;
  m.add({.name = "cart", .mass = 1e-9, .inertia = 0.1});
  m.add({.name = "pole", .mass = 1, .inertia = 1e-12, .pose = {0.5 * std::cos(angle), 0.5 * std::sin(angle), angle}});
  m.add("rail", Translational{.body_a = ground, .body_b = 1});
  m.add("pin", Revolute{.body_a = 1, .body_b = 2, .p_b = {-0.5, 0}});
  Machine machine(m, {.integrator = IntegratorKind::ida});
  const std::string text = outcome(machine, 1e-2, 1);
  if (text.empty()) {
    EXPECT_LT(machine.energy().closure(), 1e-3);
  } else {
    EXPECT_NE(text.find("body 'cart' is the most accelerated"), std::string::npos) << text;
  }
}

/// Two bars of 1 m from the ground to a common pin `height` above the line of their feet: a frame that stands, singular
/// where the bars lie flat.
Model braced_frame(double height) {
  Model m;
  const double angle = std::asin(height), c = std::cos(angle);
  m.add({.name = "left", .mass = 1, .inertia = 0.1, .pose = {c / 2, height / 2, angle}});
  m.add({.name = "right", .mass = 1, .inertia = 0.1, .pose = {1.5 * c, height / 2, -angle}});
  m.add("left foot", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.5, 0}});
  m.add("top", Revolute{.body_a = 1, .body_b = 2, .p_a = {0.5, 0}, .p_b = {-0.5, 0}});
  m.add("right foot", Revolute{.body_a = ground, .body_b = 2, .p_a = {2 * c, 0}, .p_b = {0.5, 0}});
  return m;
}

TEST(HonestRuns, AFrameNearASingularPoseStands) {
  for (const double height : {0.3, 0.05, 0.02, 0.005})
    for (const IntegratorKind kind : {IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida}) {
      Machine machine(braced_frame(height), {.integrator = kind});
      EXPECT_EQ(outcome(machine, 1e-3, 0.1), "") << height << " by " << static_cast<int>(kind);
      EXPECT_NEAR(machine.body(1).r.y, height / 2, 1e-10);
    }
}

}  // namespace
}  // namespace subsoil::mbd::honest_runs_test
