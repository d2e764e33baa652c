// Friction in joints from their reaction: closed forms in full sliding, minimal coordinates in a pin, self-locking.

#include "libmbd/forces/joint_friction.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/fixed.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/reference_ode.hpp"
#include "tests/verification/mechanisms/sledge.hpp"

namespace subsoil::mbd::joint_friction_test {
namespace {

class JointFrictionBy : public testing::TestWithParam<IntegratorKind> {
 protected:
  MachineOptions options() const { return {.integrator = GetParam(), .ida = {.rtol = 1e-10, .atol = 1e-11}}; }
};
INSTANTIATE_TEST_SUITE_P(Both, JointFrictionBy, testing::Values(IntegratorKind::adams_moulton, IntegratorKind::ida));

constexpr double mass = 4, g = 9.81;

/// A block on a level slide whose line runs `below` under its centre of gravity, moving at 2 m/s.
Model sledge(double below, double mu, double guide, double fx, double moment) {
  Model m;
  const int block = m.add({.name = "block", .mass = mass, .inertia = 0.3, .velocity = {2, 0, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = block, .p_a = {0, -below}, .p_b = {0, -below}});
  m.add("friction", JointFriction{.joint = "slide", .guide = guide, .mu_s = mu, .mu_k = mu});
  m.add("load", AppliedForce{.body = block, .fx = fx, .moment = moment});
  return m;
}

// Above 2 m/s tanh(v/1 mm/s) is 1 to the last digit, so the acceleration is constant: the method adds rounding only.
TEST_P(JointFrictionBy, WeightOnASlide) {
  Machine machine(sledge(0, 0.25, 0.4, 30, 0), options());
  machine.start_from_pose();
  for (int i = 0; i < 200; ++i) machine.advance(0.005);
  const double force = 0.25 * mass * g, a = (30 - force) / mass;
  EXPECT_NEAR(machine.body(1).v.x, 2 + a, 1e-8);
  EXPECT_NEAR(machine.body(1).r.x, 2 + a / 2, 1e-8);
  EXPECT_NEAR(machine.force_value("friction", "force"), -force, 1e-9);
  EXPECT_NEAR(machine.energy().lost, force * machine.body(1).r.x, 1e-6);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
}

// The guide carries M = moment - below F, since friction at the line below the centre of gravity turns against the
// load; N = 2 |M|/guide exceeds the weight, so F = mu N = 2 mu moment/(guide + 2 mu below).
TEST_P(JointFrictionBy, MomentInTheGuideIncludesItsOwn) {
  constexpr double below = 0.1, mu = 0.3, guide = 0.2, moment = 20;
  Machine machine(sledge(below, mu, guide, 150, moment), options());
  machine.start_from_pose();
  for (int i = 0; i < 100; ++i) machine.advance(0.005);
  const double force = 2 * mu * moment / (guide + 2 * mu * below);
  ASSERT_GT(force / mu, mass * g);
  EXPECT_NEAR(machine.force_value("friction", "force"), -force, 1e-7);
  EXPECT_NEAR(machine.force_value("friction", "normal force"), force / mu, 1e-7);
  EXPECT_NEAR(machine.body(1).v.x, 2 + 0.5 * (150 - force) / mass, 1e-7);
}

// Without other moments F below = M alone loads the guide: F = (2 mu below/guide) F has no solution but growth where
// the bracket exceeds 1.
TEST_P(JointFrictionBy, SelfLockingIsNamed) {
  Machine machine(sledge(0.5, 0.5, 0.2, 0, 0), options());
  try {
    machine.start_from_pose();
    FAIL() << "a locking slide was started";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("joint 'slide' locks itself"), std::string::npos) << error.what();
  }
}

constexpr double arm = 0.6, inertia = 0.2, radius = 0.05, mu_s = 0.4, mu_k = 0.25, v_s = 0.1, v_reg = 0.02;

/// theta'' of a pendulum (theta from the hanging position) whose pin has friction; the reaction holds theta'' itself:
/// m (l theta'' + g sin) across, m (l theta'^2 + g cos) along the arm.
double pendulum_acceleration(double theta, double rate) {
  const double v = radius * rate, x = v / v_s, mu = mu_k + (mu_s - mu_k) * std::exp(-x * x);
  double result = 0;
  for (int i = 0; i < 60; ++i) {  // contracts by mu radius m l/(I + m l^2) = 0.005
    const double normal =
        std::hypot(mass * (arm * result + g * std::sin(theta)), mass * (arm * rate * rate + g * std::cos(theta)));
    result = (-mass * g * arm * std::sin(theta) - radius * mu * normal * std::tanh(v / v_reg)) /
             (inertia + mass * arm * arm);
  }
  return result;
}

// 3 s of swinging. The speed passes v_reg in 30 ms at each turn, which order 6 at 0.2 ms resolves to 1e-10; IDA's bound
// is a thousand tolerances.
TEST_P(JointFrictionBy, PinOfAPendulum) {
  Model m;
  const int bar = m.add({.name = "bar", .mass = mass, .inertia = inertia, .pose = {arm, 0, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = bar, .p_b = {-arm, 0}});
  m.add("friction", JointFriction{.joint = "pin",
                                  .radius = radius,
                                  .mu_s = mu_s,
                                  .mu_k = mu_k,
                                  .stribeck_speed = v_s,
                                  .regularisation_speed = v_reg});
  auto with = options();
  with.adams_moulton.order = 6;
  Machine machine(m, with);
  machine.start_from_pose();
  for (int i = 0; i < 15000; ++i) machine.advance(2e-4);
  const double half_pi = std::acos(0.0);
  const auto y = test::solve_ode(
      [](const auto& s, auto& d, double) {
        d = {s[1], pendulum_acceleration(s[0], s[1])};
      },
      {half_pi, 0}, 0, 3, 1e-13);
  EXPECT_NEAR(machine.body(bar).angle + half_pi, y[0], 1e-7);
  EXPECT_NEAR(machine.body(bar).omega, y[1], 1e-6);
  EXPECT_GT(machine.energy().lost, 1);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
}

using test::Sledge;

/// A block on a level slide between a spring and dry friction that can stick; let go at 0.3 m.
Model sprung_sledge(std::array<double, 2> gravity) {
  Model m;
  m.gravity = gravity;
  const int block = m.add({.name = "block", .mass = mass, .inertia = 0.3, .pose = {0.3, 0, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = block, .p_a = {0.3, 0}});
  m.add("friction", JointFriction{.joint = "slide",
                                  .guide = 0.4,
                                  .mu_s = Sledge::mu,
                                  .mu_k = Sledge::mu,
                                  .stick_stiffness = Sledge::stick_stiffness,
                                  .stick_damping = Sledge::stick_damping});
  return m;
}

class Stick : public testing::TestWithParam<IntegratorKind> {
 protected:
  MachineOptions options() const {
    return {.integrator = GetParam(),
            .adams_moulton = {.order = 6},
            .ida = {.rtol = 1e-10, .atol = 1e-11},
            .cvode = {.rtol = 1e-11, .atol = 1e-12}};
  }
};
INSTANTIATE_TEST_SUITE_P(All, Stick,
                         testing::Values(IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida));

// Amplitudes fall by 2 mu m g/k each half swing until the spring no longer moves the block. Order 6 at 0.2 ms resolves
// the sticking spring's 70 rad/s to (w h)^6 = 1e-11; the tolerances are of that size and gather over twelve changes.
TEST_P(Stick, SledgeSticksWhereItTurnsAndSlidesWhereTheGripEnds) {
  Model m = sprung_sledge({0, -g});
  SpringDamper pull{.body_a = ground, .body_b = 1, .p_a = {-10, 0}};
  pull.free_length = 10, pull.stiffness = Sledge::spring;
  m.add("spring", pull);
  Machine machine(m, options());
  machine.start_from_pose();
  for (int i = 0; i < 15000; ++i) machine.advance(2e-4);
  Sledge exact;
  exact.run(3);
  ASSERT_GE(exact.changes.size(), 9U);
  const std::vector<Event>& events = machine.events();
  ASSERT_EQ(events.size(), exact.changes.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_NEAR(events[i].t, exact.changes[i], 1e-8) << i;
    EXPECT_STREQ(events[i].word(), i % 2 == 0 ? "slides" : "sticks") << i;
  }
  EXPECT_NEAR(machine.body(1).r.x, exact.x, 1e-9);
  EXPECT_NEAR(machine.body(1).v.x, exact.v, 1e-8);
  EXPECT_EQ(machine.force_value("friction", "sticking"), 1);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-8);
}

// On a slope below the angle of friction it does not creep: at rest where the sticking spring carries the weight's
// share.
TEST_P(Stick, StaysOnASlope) {
  Model m = sprung_sledge({1, -g});
  Machine machine(m, options());
  machine.start_from_pose();
  for (int i = 0; i < 5000; ++i) machine.advance(2e-3);
  EXPECT_NEAR(machine.body(1).r.x, 0.3 + Sledge::mass / Sledge::stick_stiffness, 1e-12);
  EXPECT_TRUE(machine.events().empty());
}

// What it remembers goes through a restart: the same numbers afterwards.
TEST_P(Stick, GoesOnFromASnapshot) {
  if (GetParam() != IntegratorKind::adams_moulton) GTEST_SKIP() << "begins anew from a snapshot, by design";
  Machine machine(sprung_sledge({1, -g}), options()), other(sprung_sledge({1, -g}), options());
  machine.start_from_pose();
  for (int i = 0; i < 20; ++i) machine.advance(2e-3);
  other.restore(machine.snapshot());
  for (int i = 0; i < 20; ++i) machine.advance(2e-3), other.advance(2e-3);
  EXPECT_EQ(machine.body(1).r.x, other.body(1).r.x);
}

TEST(JointFriction, RefusesWhatItCannotActIn) {
  const auto refusal = [](auto change) {
    Model m;
    const int bar = m.add({.name = "bar", .mass = 1, .inertia = 1});
    m.add("pin", Revolute{.body_a = ground, .body_b = bar});
    m.add("friction", JointFriction{.joint = "pin", .radius = 0.01, .mu_s = 0.2, .mu_k = 0.1});
    change(m, *m.forces[0].element.get_if<JointFriction>());
    return test::message_of<std::invalid_argument>([&] { Machine(m).start_from_pose(); });
  };
  EXPECT_EQ(refusal([](Model&, JointFriction& f) { f.joint = "pn"; }),
            "force 'friction': no joint 'pn'; there are pin");
  EXPECT_EQ(refusal([](Model&, JointFriction& f) { f.radius = NAN; }),
            "force 'friction': joint 'pin' is a pin: give its radius");
  EXPECT_EQ(refusal([](Model&, JointFriction& f) { f.mu_k = 0.3; }),
            "force 'friction': mu_s and mu_k must be given, mu_k not negative and at most mu_s; equal values are "
            "Coulomb's friction");
  EXPECT_EQ(refusal([](Model& m, JointFriction& f) {
              m.add("weld", Fixed{.body_a = ground, .body_b = 1});
              f.joint = "weld";
            }),
            "force 'friction': joint 'weld' is neither revolute nor translational; name one that is");
  EXPECT_EQ(refusal([](Model& m, JointFriction&) {
              m.add("second pin", Revolute{.body_a = ground, .body_b = 1, .p_a = {1, 0}, .p_b = {1, 0}});
            }),
            "friction in joint 'pin' needs its reaction, which is not determined: joint 'second pin' depends on other "
            "constraints; free the constraint that is too many");
}

}  // namespace
}  // namespace subsoil::mbd::joint_friction_test
