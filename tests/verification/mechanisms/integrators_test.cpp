// Order of accuracy by error ratios, and the two integrators against each other on the rig.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/joints/revolute.hpp"
#include "tests/tools/reference_ode.hpp"
#include "tests/tools/rig.hpp"

namespace subsoil::mbd::integrators_test {
namespace {

/// A bar pendulum with a torsion damper, thrown hard: smooth, nonlinear, dissipative, constrained.
Model thrown_bar() {
  Model m;
  const int bar = m.add(
      {.name = "bar", .mass = 2, .inertia = 0.3, .pose = {0.8, 0, std::numbers::pi / 2}, .velocity = {0, 1.6, 2}});
  m.add("pin", Revolute{.body_a = ground, .body_b = bar, .p_b = {0, 0.8}});
  m.add("damper", RotationalSpringDamper{.body_a = ground, .body_b = bar, .stiffness = 0, .damping = 0.4});
  return m;
}

/// angle, spin, dissipated energy
test::OdeState thrown_bar_exact(double end) {
  return test::solve_ode(
      [](const auto& y, auto& d, double) {
        d = {y[1], (-2 * 9.81 * 0.8 * std::sin(y[0]) - 0.4 * y[1]) / (0.3 + 2 * 0.64), 0.4 * y[1] * y[1]};
      },
      {std::numbers::pi / 2, 2, 0}, 0, end, 1e-14);
}

struct Errors {
  double angle = 0, lost = 0;
};
/// Largest error at eight times: at a single one the error may just change its sign.
Errors error_at(int order, int steps) {
  constexpr int outputs = 8;
  constexpr double end = 2;
  static const auto exact = [] {
    std::vector<test::OdeState> at;
    for (int i = 1; i <= outputs; ++i) at.push_back(thrown_bar_exact(end * i / outputs));
    return at;
  }();
  Machine machine(thrown_bar(), {.adams_moulton = {.order = order}});
  machine.start_from_pose();
  Errors worst;
  for (const auto& y : exact) {
    for (int i = 0; i < steps / outputs; ++i) machine.advance(end / steps);
    worst.angle = std::max(worst.angle, std::abs(machine.body(1).angle - y[0]));
    worst.lost = std::max(worst.lost, std::abs(machine.energy().lost - y[2]));
  }
  return worst;
}

class Order : public testing::TestWithParam<int> {};

// Halving the step; the observed order must come within 0.3 of the formal one. Steps are short enough for the leading
// term of the error and long enough to keep the finer error above 1e-12, clear of rounding.
TEST_P(Order, ErrorRatioOfTheMotionAndOfTheEnergyFlows) {
  const int order = GetParam();
  const int coarse = order <= 2 ? 800 : order <= 4 ? 400 : 200;
  const Errors rough = error_at(order, coarse), fine = error_at(order, 2 * coarse);
  EXPECT_GT(fine.angle, 1e-12);
  EXPECT_NEAR(std::log2(rough.angle / fine.angle), order, 0.3) << rough.angle << " -> " << fine.angle;
  EXPECT_NEAR(std::log2(rough.lost / fine.lost), order, 0.3) << rough.lost << " -> " << fine.lost;
}
INSTANTIATE_TEST_SUITE_P(OneToSix, Order, testing::Range(1, 7));

// IDA chooses its own steps: what can be asserted is that the error stays within a few hundred tolerances (some hundred
// steps, each within one) and falls by two decades at least over four decades of tolerance.
TEST(Order, IdaErrorFollowsTheTolerance) {
  std::vector<double> errors;
  for (const double tolerance : {1e-5, 1e-7, 1e-9}) {
    Machine machine(thrown_bar(), {.integrator = IntegratorKind::ida, .ida = {.rtol = tolerance, .atol = tolerance}});
    machine.start_from_pose();
    double worst = 0;
    for (int i = 1; i <= 8; ++i) {
      machine.advance(0.25);
      worst = std::max(worst, std::abs(machine.body(1).angle - thrown_bar_exact(0.25 * i)[0]));
    }
    EXPECT_LT(worst, 300 * tolerance);
    errors.push_back(worst);
  }
  EXPECT_LT(errors[1], errors[0] / 3);
  EXPECT_LT(errors[2], errors[0] / 100);
}

/// Staircase of a smooth wrench, as a coupling hands it over: constant over each step, taken at the step's middle so
/// that the staircase itself is of second order.
double staircase_error(int steps, WrenchJump jump) {
  constexpr double end = 2, amplitude = 3, omega = 5;
  static const auto exact = test::solve_ode(
      [](const auto& y, auto& d, double t) {
        d = {y[1],
             (-2 * 9.81 * 0.8 * std::sin(y[0]) - 0.4 * y[1] + amplitude * std::sin(omega * t)) / (0.3 + 2 * 0.64)};
      },
      {std::numbers::pi / 2, 2}, 0, end, 1e-14);
  Machine machine(thrown_bar(), {.adams_moulton = {.order = 4, .wrench_jump = jump}});
  machine.start_from_pose();
  const double h = end / steps;
  for (int i = 0; i < steps; ++i) {
    machine.set_external_wrench(1, 0, 0, amplitude * std::sin(omega * (i + 0.5) * h));
    machine.advance(h);
  }
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-3);
  return std::abs(machine.body(1).angle - exact[0]);
}

// Both treatments of a jump keep order 2, the most that a midpoint staircase can give and above the order 1 of the
// explicit coupling that makes it.
TEST(Order, JumpsOfTheWrenchKeepOrderTwo) {
  for (const WrenchJump jump : {WrenchJump::shift, WrenchJump::restart}) {
    const double rough = staircase_error(400, jump), fine = staircase_error(800, jump);
    EXPECT_GT(std::log2(rough / fine), 1.8) << rough << " -> " << fine;
  }
}

// Machine-only rig, smooth prescribed wrench on the shovel, 1 s, rtol 1e-11: differences in q and q' scaled by the
// largest value that a coordinate of the kind (x, y, angle) takes: 1 m, 1 rad, and 1 m/s, 1 rad/s at least.
TEST(Integrators, PartitioningAgreesWithIdaOnTheRig) {
  auto rig = test::make_rig({.raise = 0.125});
  rig.model.add("wrench", AppliedForce{.body = rig.shovel,
                                       .fx = HarmonicFunction{.mean = -500, .amplitude = 200, .frequency = 2.3},
                                       .fy = HarmonicFunction{.mean = -150, .amplitude = 100, .frequency = 1.1},
                                       .moment = HarmonicFunction{.amplitude = 40, .frequency = 3.1}});
  Machine partitioned(rig.model, {.adams_moulton = {.order = 6}});
  Machine ida(rig.model, {.integrator = IntegratorKind::ida, .ida = {.rtol = 1e-11, .atol = 1e-11}});
  partitioned.start_from_towing_equilibrium(0.5);
  ida.start_from_towing_equilibrium(0.5);
  for (int i = 0; i < 5000; ++i) partitioned.advance(2e-4);
  for (int i = 0; i < 10; ++i) ida.advance(0.1);
  const auto &a = partitioned.integrator().state(), &b = ida.integrator().state();
  for (Eigen::Index i = 0; i < a.q.size(); ++i) {
    EXPECT_NEAR(a.q[i], b.q[i], 1e-8 * std::max(1.0, std::abs(a.q[i]))) << "coordinate " << i;
    EXPECT_NEAR(a.velocity[i], b.velocity[i], 1e-8 * std::max(1.0, std::abs(a.velocity[i]))) << "coordinate " << i;
  }
  EXPECT_GT(std::abs(partitioned.body(rig.shovel).angle - partitioned.body(rig.frame).angle), 0.01);
  EXPECT_NEAR(partitioned.energy().balance(), 0, 1e-6);
  EXPECT_NEAR(ida.energy().balance(), 0, 1e-6);
  EXPECT_NEAR(partitioned.driver_force("H10"), ida.driver_force("H10"), 1e-4);
}

}  // namespace
}  // namespace subsoil::mbd::integrators_test
