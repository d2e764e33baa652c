// Events located in time: a ball on an elastic floor, whose touches are known in closed form.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/rotational_stop.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::events_test {
namespace {

constexpr double g = 9.81, mass = 1, stiffness = 1e4, height = 0.2;

Model bouncing_ball(double floor_stiffness = stiffness) {
  Model m;
  m.add({.name = "ball", .mass = mass, .inertia = 1, .pose = {0, height, 0}});
  m.add("floor",
        LineContact{
            .body_a = ground, .body_b = 1, .law = {.normal = {.n = 1, .stiffness = floor_stiffness, .damping = 0}}});
  return m;
}

/// Times at which the ball touches and leaves: falls of sqrt(2 h/g); y = -(g/w^2)(1 - cos wt) - (v/w) sin wt on the
/// floor comes back to 0 at tan(wt/2) = -v w/g; flights of 2 v/g between.
std::vector<double> exact_events(int count) {
  const double w = std::sqrt(stiffness / mass), v = std::sqrt(2 * g * height);
  const double on_floor = 2 / w * (std::numbers::pi - std::atan(v * w / g)), flight = 2 * v / g;
  std::vector<double> times{v / g};
  while (static_cast<int>(times.size()) < count)
    times.push_back(times.back() + (times.size() % 2 == 1 ? on_floor : flight));
  return times;
}

MachineOptions method(int which, bool locate = true) {
  MachineOptions o;
  o.locate_events = locate;
  o.cvode = {.rtol = 1e-11, .atol = 1e-12};
  o.ida = {.rtol = 1e-10, .atol = 1e-11};
  o.integrator = std::array{IntegratorKind::adams_moulton, IntegratorKind::cvode,
                            IntegratorKind::ida}[static_cast<std::size_t>(which)];
  return o;
}

class Events : public testing::TestWithParam<int> {};

// A pendulum let go level meets a stop of 1e7 N m/rad at its lowest point, with w = (2 g)^1/2 of a mass on a massless
// rod: trial steps that reach 1e-2 rad into it see 1e5 N m, and must not keep the method from finding the touch.
// Elastic: it comes back after 2 T + pi (m/k)^1/2, T = K(1/2^1/2)/(g/l)^1/2 from level to the lowest point, each time.
TEST(Events, AStiffStopIsMetFromLongSteps) {
  Model m;
  m.add({.name = "bob", .mass = 1, .inertia = 1e-12, .pose = {1, 0, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-1, 0}});
  m.add("stop",
        RotationalStop{.body_a = ground, .body_b = 1, .limits = {.least = -std::numbers::pi / 2, .law = {1, 1e7, 0}}});
  for (const IntegratorKind kind : {IntegratorKind::cvode, IntegratorKind::ida}) {
    Machine machine(m, {.integrator = kind});
    machine.start_from_pose();
    while (machine.time() < 3) machine.advance(1e-2);
    const double down = std::comp_ellint_1(std::sqrt(0.5)) / std::sqrt(g);
    ASSERT_EQ(machine.events().size(), 6U);
    for (const std::size_t i : {0, 2, 4})
      EXPECT_NEAR(machine.events()[i].t,
                  static_cast<double>(i + 1) * down + std::numbers::pi / std::sqrt(1e7) * static_cast<double>(i) / 2,
                  1e-5)
          << i;
    EXPECT_LT(machine.energy().closure(), 1e-6);
  }
}

// Steps of 0.1 ms at order 4 err by (w h)^5 = 1e-10 of a contact each, 300 of them; tolerances 1e-10 or tighter and
// some hundred steps: 1e-7 s for each. The order of the ends is that of the field: closes, opens, closes ...
TEST_P(Events, TouchesOfABallAreWhereTheClosedFormHasThem) {
  Machine machine(bouncing_ball(), method(GetParam()));
  machine.start_from_pose();
  const std::vector<double> exact = exact_events(7);
  const double h = 1e-4;
  while (machine.time() < exact.back() + 0.01) machine.advance(h);
  const std::vector<Event>& events = machine.events();
  ASSERT_EQ(events.size(), exact.size());
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_NEAR(events[i].t, exact[i], 1e-7) << i;
    EXPECT_EQ(events[i].name, "floor");
    EXPECT_EQ(events[i].direction, i % 2 == 0 ? -1 : 1) << i;
  }
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-7 * mass * g * height);
}
INSTANTIATE_TEST_SUITE_P(Methods, Events, testing::Range(0, 3));

// Outputs far apart: several touches between two of them are all found, by the methods with steps of their own.
TEST(Events, AreFoundBetweenOutputs) {
  const std::vector<double> exact = exact_events(7);
  for (const int which : {1, 2}) {
    Machine machine(bouncing_ball(), method(which));
    machine.start_from_pose();
    machine.advance(exact.back() + 0.01);
    ASSERT_EQ(machine.events().size(), exact.size());
    EXPECT_NEAR(machine.events().back().t, exact.back(), 1e-7);
  }
}

/// Error of the height after the second flight.
double height_error(double h, bool locate) {
  const std::vector<double> exact = exact_events(4);
  const double v = std::sqrt(2 * g * height), after = 0.07;
  const double end = exact[3] + after, wanted = v * after - 0.5 * g * after * after;
  MachineOptions options = method(0, locate);
  Machine machine(bouncing_ball(), options);
  machine.start_from_pose();
  const long steps = std::lround(end / h);
  for (long i = 0; i < steps; ++i) machine.advance(end / static_cast<double>(steps));
  EXPECT_EQ(machine.events().size(), locate ? 4U : 0U);
  return std::abs(machine.body(1).r.y - wanted);
}

// The order of the fixed step survives touches only where they are located. Stepped over, each costs an error of second
// order in the step: with (w h)^2 = 1e-2 in place of 1e-4 to 1e-5.
TEST(Events, LocatingKeepsTheOrderOfTheFixedStep) {
  const double rough = height_error(1e-3, true), fine = height_error(5e-4, true), over = height_error(5e-4, false);
  EXPECT_GT(std::log2(rough / fine), 3) << rough << " -> " << fine;
  EXPECT_LT(fine, 0.1 * over);
}

// A stop that is touched, left and touched again within one step of 20 ms, and the step's end is still exact.
TEST(Events, SeveralInOneStep) {
  Machine machine(bouncing_ball(4e6), method(0));  // on the floor for 1.6 ms
  machine.start_from_pose();
  for (int i = 0; i < 60; ++i) machine.advance(0.02);
  EXPECT_NEAR(machine.time(), 1.2, 1e-12);
  // 0.202 s of fall, flights of 0.404 s: touches at 0.202, 0.607, 1.012 s, each in and out.
  EXPECT_EQ(machine.events().size(), 6U);
}

}  // namespace
}  // namespace subsoil::mbd::events_test
