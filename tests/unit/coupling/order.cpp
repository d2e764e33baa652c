#include <gtest/gtest.h>

#include "tests/unit/coupling/contact_stack.hpp"

/// Order of the explicit staggered scheme: one, neither less (a mistake in the order of a step, a velocity left out)
/// nor more (then the test would not see the coupling). The forces of t_n act over the step to t_{n+1}: a delay of half
/// a step in the mean, so errors are of first order in the machine step.
namespace subsoil::coupling::test::order {
namespace {

/// Distance from the exact end state of the body, in m; velocity over the slow mode's frequency.
double error(const Stack& s, const StackRun& run) {
  const auto end = exact(s);
  const double omega = std::sqrt(0.5 * s.stiffness / (s.body_mass + s.sphere_mass));
  return std::hypot(run.height - end[0], (run.velocity - end[1]) / omega);
}

class Order : public testing::TestWithParam<std::tuple<double, int, mbd::IntegratorKind>> {};

TEST_P(Order, IsOneOnAContactSpring) {
  const auto [restitution, soil_steps, integrator] = GetParam();
  const Stack s{.restitution = restitution};
  // Fast mode 0.04 rad per machine step at the coarsest: second-order terms stay below some percent of the error.
  const double coarse = 4e-5 / soil_steps;
  double before = 0;
  for (const double step : {coarse, coarse / 2, coarse / 4}) {
    const StackRun r = run(s, step, soil_steps, integrator);
    EXPECT_GT(r.least_force, 0.1) << "the problem must stay smooth";
    const double now = error(s, r);
    if (before > 0) {
      const double order = std::log2(before / now);
      EXPECT_GT(order, 0.9) << step;
      EXPECT_LT(order, 1.1) << step;
    }
    before = now;
  }
  // 2 mm amplitude at most; an error of 1e-6 m says that the limit is the exact solution and not merely some limit.
  EXPECT_LT(before, 1e-6);
}
INSTANTIATE_TEST_SUITE_P(Staggered, Order,
                         testing::Combine(testing::Values(1.0, 0.7), testing::Values(1, 4),
                                          testing::Values(mbd::IntegratorKind::adams_moulton,
                                                          mbd::IntegratorKind::ida)));

TEST(InterfaceWork, ErrorVanishesInFirstOrderAtTheRateOfTheDelay) {
  const Stack s;
  const auto end = exact(s);
  // Sum of F_{n-1} d_n - (F_n + F_{n-1})/2 d_n: h times the integral of -F'/2 v.
  const double rate = end[4];
  double before = 0;
  for (const double step : {2e-5, 1e-5, 5e-6}) {
    const StackRun r = run(s, step);
    EXPECT_NEAR(r.work.error() / step, rate, 2e3 * step * std::abs(rate)) << step;
    if (before != 0) {
      EXPECT_NEAR(std::log2(before / r.work.error()), 1, 0.1);
    }
    before = r.work.error();
  }
}

TEST(InterfaceWork, IsAllThatTheExchangeAddsToTheEnergy) {
  for (const double restitution : {1.0, 0.7}) {
    const Stack s{.restitution = restitution};
    for (const double step : {2e-5, 1e-5}) {
      const StackRun r = run(s, step);
      // Each side's own balance closes in order 2, so that the energy which both made together is the interface error.
      EXPECT_LT(std::abs(r.closure - r.work.error()), 2e3 * step * step * std::abs(r.work.on_machine)) << restitution;
      EXPECT_GT(std::abs(r.work.error()), 1e-4 * std::abs(r.work.on_machine)) << "too small to say anything";
    }
  }
}

TEST(Window, MachineTakesTheMeanOfItsSoilSteps) {
  const Stack s;
  for (const int n : {1, 5, 20}) {
    const StackRun r = run(s, 1e-5, n);
    // Momentum of the body is the impulse of all soil steps: no soil step is lost or weighed twice.
    EXPECT_NEAR(s.body_mass * r.velocity, r.impulse - s.body_mass * s.gravity * s.end, 1e-12) << n;
  }
}

TEST(Window, ResultAndEnergyConvergeToOneSoilStepPerMachineStep) {
  const Stack s;
  const double step = 2.5e-6;
  const StackRun one = run(s, step);
  double height = 0, work = 0;
  for (const int n : {32, 16, 8}) {
    const StackRun r = run(s, step, n);
    const double d_height = std::abs(r.height - one.height), d_work = std::abs(r.to_the_end - one.to_the_end);
    // The machine moves under the mean of the window that it is about to pass, so a longer window adds no delay; what
    // it adds is the surfaces' extrapolation, of order 2 or better in the window.
    if (height > 0) {
      EXPECT_GT(height / d_height, 3.5) << n;
      EXPECT_GT(work / d_work, 3.5) << n;
    }
    height = d_height, work = d_work;
    EXPECT_LT(std::abs(r.closure), 1e-2 * std::abs(r.work.on_machine));
    // In the last soil step the machine's work is a share of its window's, to the change of its speed over the window.
    EXPECT_LT(std::abs(r.work.error() - one.work.error()), 2e-6 * std::abs(r.work.on_machine)) << n;
  }
}

TEST(Window, SurfacesRunAheadAsTheMachineWill) {
  // A body in free flight above the bed: the surface's pose inside a window is the parabola itself.
  dem::Bed bed(dem::test::table(dem::test::grains()), dem::test::quiet());
  const int face = dem::test::add_plane(bed, {0, -1, 0}, {0, -1, 0});
  mbd::Model model;
  const int body = model.add({.name = "b", .mass = 1, .inertia = 1, .pose = {0, 5, 0.2}, .velocity = {0.5, 1, 3}});
  mbd::Machine machine(model);
  machine.start_from_pose();
  Simulation simulation(&bed, &machine, {{body, face}}, {}, {.soil_step = 1e-3, .soil_steps = 10});
  for (int n = 0; n < 35; ++n) {
    simulation.step();
    const double t = simulation.time();
    const dem::Pose now = simulation.surface_pose(face);
    EXPECT_NEAR(now.position.x, 0.5 * t, 1e-12);
    EXPECT_NEAR(now.position.y, 5 + t - 0.5 * 9.81 * t * t, 1e-10);
    EXPECT_NEAR(2 * std::atan2(now.attitude.z, now.attitude.w), 0.2 + 3 * t, 1e-12);
  }
}

}  // namespace
}  // namespace subsoil::coupling::test::order
