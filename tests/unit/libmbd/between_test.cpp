// What is read between fixed steps: as good as the steps, on the constraints, and without a trace in the motion.

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <utility>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/mechanisms.hpp"

namespace subsoil::mbd::between_test {
namespace {

MachineOptions order(int k) { return {.adams_moulton = {.order = k}}; }

/// Largest difference of angle and spin, looked at in the thirds of steps of `h`, from steps twelve times as short.
double error_between(double h) {
  Machine coarse(test::make_chain(2), order(6)), fine(test::make_chain(2), order(6));
  coarse.start_from_pose(), fine.start_from_pose();
  coarse.keep_dense_output();
  Evaluation between = coarse.evaluation();
  double worst = 0;
  for (int i = 0; i < std::lround(0.5 / h); ++i) {
    const double begin = coarse.time();
    coarse.advance(h);
    for (int part = 1; part < 3; ++part) {
      for (int k = 0; k < 4; ++k) fine.advance(h / 12);
      const Instant at = between.evaluate(coarse.dense_output().state(begin + part * h / 3));
      worst = std::max(worst, std::abs(at.body(2).angle - fine.body(2).angle));
      worst = std::max(worst, std::abs(at.body(2).omega - fine.body(2).omega));
      EXPECT_LT(at.partition.residual(), 1e-12);
      EXPECT_NEAR(coarse.energy(at).balance(), 0, 1e-3 * h);
    }
    for (int k = 0; k < 4; ++k) fine.advance(h / 12);
  }
  return worst;
}

// The spin is the derivative of a quintic: order 5 in the step, beside order 6 of the method. Half the step, a
// twentieth of the error at least.
TEST(BetweenSteps, IsReadToTheOrderOfTheSteps) {
  const double coarse = error_between(4e-3), fine = error_between(2e-3);
  EXPECT_LT(coarse, 1e-5);
  EXPECT_LT(fine, coarse / 20);
}

// Steps that are halved to their error are read in these parts. A spring of 3 rad in a step would be off by 3^6/46080,
// 1.6 % of its amplitude, by the quintic between the ends alone; the parts err by 1e-6 in a step.
TEST(BetweenSteps, IsReadInThePartsOfAStep) {
  constexpr double amplitude = 0.1, frequency = 3000, h = 1e-3;
  Model m;
  m.gravity = {0, 0};
  const int mass = m.add({.name = "mass", .mass = 1, .inertia = 0.1, .pose = {amplitude, 0, 0}});
  m.add("spring", SpringDamper{.body_a = ground,
                               .body_b = mass,
                               .p_a = {-1, 0},
                               .p_b = {0, 0},
                               .stiffness = frequency * frequency,
                               .free_length = 1});
  Machine machine(m, {.adams_moulton = {.error_per_second = 1e-3}});
  machine.start_from_pose();
  machine.keep_dense_output();
  Evaluation between = machine.evaluation();
  for (int i = 0; i < 5; ++i) {
    machine.advance(h);
    for (int k = 1; k < 8; ++k) {
      const double t = h * (i + 0.125 * k);
      const Instant at = between.evaluate(machine.dense_output(), t);
      EXPECT_NEAR(at.body(mass).r.x, amplitude * std::cos(frequency * t), 1e-5) << t;
    }
  }
}

// An instant that is asked for is reached to the last bit, and the machine there does not depend on those before it.
// Without freedom a method's steps are long, and its time alone tells where the driver stands.
TEST(AdvanceTo, IsOfThatInstantWhateverLedThere) {
  for (const bool driven : {true, false})
    for (const IntegratorKind kind : {IntegratorKind::cvode, IntegratorKind::ida, IntegratorKind::kinematic}) {
      if (kind == IntegratorKind::kinematic && !driven) continue;
      Model m;
      const int rod = m.add({.name = "rod", .mass = 2, .inertia = 0.2, .pose = {0.5, 0, 0}});
      m.add("pin", Revolute{.body_a = ground, .body_b = rod, .p_a = {0, 0}, .p_b = {-0.5, 0}});
      if (driven) m.add("turn", AngleDriver{.first = ground, .second = rod, .motion = {.velocity = 0.7}});
      Machine once(m, {.integrator = kind}), often(m, {.integrator = kind});
      once.start_from_pose(), often.start_from_pose();
      for (int i = 1; i <= 20; ++i) {
        const double end = 0.015 * i;
        once.advance_to(end);
        for (int part = 1; part < 11; ++part) often.advance_to(end - 0.015 + 0.0014 * part);
        often.advance_to(end);
        ASSERT_EQ(once.time(), end);
        ASSERT_EQ(often.time(), end);
        if (kind == IntegratorKind::kinematic) continue;  // its steps end where they are asked for
        ASSERT_EQ(once.body(rod).angle, often.body(rod).angle) << end;
        ASSERT_EQ(once.body(rod).r.x, often.body(rod).r.x) << end;
      }
    }
}

TEST(BetweenSteps, LookingLeavesTheMotionAsItIs) {
  Machine looked(test::make_slider_crank(), order(4)), alone(test::make_slider_crank(), order(4));
  looked.start_from_pose(), alone.start_from_pose();
  looked.keep_dense_output();
  Evaluation between = looked.evaluation();
  for (int i = 0; i < 200; ++i) {
    looked.advance(1e-3), alone.advance(1e-3);
    between.evaluate(looked.dense_output(), looked.time() - 3e-4);
    ASSERT_EQ(looked.body(1).angle, alone.body(1).angle);
    ASSERT_EQ(looked.body(2).omega, alone.body(2).omega);
    ASSERT_EQ(looked.energy().balance(), alone.energy().balance());
  }
}

// A step in which a ball touches is read in two pieces: before the touch the ball flies on its parabola.
TEST(BetweenSteps, DoesNotSmoothOverAnEvent) {
  Model m;
  m.add({.name = "ball", .mass = 1, .inertia = 0.1, .pose = {0, 0.2, 0}});
  m.add("floor", LineContact{.body_a = ground, .body_b = 1, .law = {.normal = {.stiffness = 1e6}}});
  Machine machine(m, order(4));
  machine.start_from_pose();
  machine.keep_dense_output();
  const double touch = std::sqrt(2 * 0.2 / 9.81), h = 0.01;
  while (machine.time() + h < touch) machine.advance(h);
  machine.advance(h);
  const double before = touch - 1e-3;
  Evaluation between = machine.evaluation();
  const Instant at = between.evaluate(machine.dense_output(), before);
  EXPECT_NEAR(at.body(1).r.y, 0.2 - 0.5 * 9.81 * before * before, 1e-9);
  EXPECT_NEAR(at.body(1).v.y, -9.81 * before, 1e-7);
}

TEST(BetweenSteps, RefusesATimeThatIsNotKept) {
  Machine machine(test::make_chain(1), order(4));
  machine.start_from_pose();
  machine.advance(1e-3);
  EXPECT_THROW(machine.dense_output().state(5e-4), std::logic_error);
}

// A state is a value: kept over later steps, and over events that change the machine, it evaluates to the same numbers.
TEST(BetweenSteps, AStateOutlivesItsStep) {
  for (const IntegratorKind kind : {IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida}) {
    Machine machine(test::make_slider_crank(), {.integrator = kind});
    machine.start_from_pose();
    machine.keep_dense_output();
    for (int i = 0; i < 20; ++i) machine.advance(1e-3);
    const State kept = machine.dense_output().state(machine.time() - 3e-4);
    std::vector<double> then(machine.column_names().size()), later = then;
    Evaluation one = machine.evaluation();
    machine.columns(one.evaluate(kept), then);
    machine.set_external_wrench(1, 50, 0, 3);
    for (int i = 0; i < 100; ++i) machine.advance(1e-3);
    machine.columns(one.evaluate(machine.dense_output(), machine.time() - 7e-4), later);
    EXPECT_NE(then, later);
    machine.columns(one.evaluate(kept), later);
    EXPECT_EQ(then, later);
    Evaluation other = machine.evaluation();
    machine.columns(other.evaluate(kept), later);
    EXPECT_EQ(then, later);
  }
}

}  // namespace
}  // namespace subsoil::mbd::between_test
