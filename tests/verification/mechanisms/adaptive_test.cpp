// The integrators against independent solutions: tolerances mean what they say, outputs lie on the constraints, dense
// output costs no steps.

#include "libmbd/integrators/adaptive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "libmbd/assembly/assembly.hpp"
#include "tests/tools/mechanisms.hpp"
#include "tests/tools/reference_ode.hpp"

namespace subsoil::mbd::adaptive_test {
namespace {

using test::OdeState;

struct Method {
  std::string name;
  std::function<MachineOptions(double tolerance)> options;
};
MachineOptions cvode(double tolerance) {
  return {.integrator = IntegratorKind::cvode, .cvode = {.rtol = tolerance, .atol = tolerance}};
}
MachineOptions ida(double tolerance) {
  return {.integrator = IntegratorKind::ida, .ida = {.rtol = tolerance, .atol = tolerance}};
}
MachineOptions index_1(double tolerance) {
  return {.integrator = IntegratorKind::ida,
          .ida = {.rtol = tolerance, .atol = tolerance, .formulation = IdaFormulation::index_1}};
}
MachineOptions adams(double) { return {.adams_moulton = {.order = 4}}; }

/// Rods of mass 1 and length 1 hung on each other, absolute angles from the horizontal: the double pendulum in minimal
/// coordinates, by Lagrange's equations.
void double_pendulum(const OdeState& y, OdeState& d, double) {
  const double a = y[0], b = y[1], wa = y[2], wb = y[3], g = 9.81, c = 0.5 * std::cos(a - b), s = 0.5 * std::sin(a - b);
  // (4/3) a'' + c b'' = -s wb^2 - (3/2) g cos a,   c a'' + (1/3) b'' = s wa^2 - (1/2) g cos b
  const double ra = -s * wb * wb - 1.5 * g * std::cos(a), rb = s * wa * wa - 0.5 * g * std::cos(b);
  const double det = 4. / 9 - c * c;
  d = {wa, wb, (ra / 3 - c * rb) / det, (4. / 3 * rb - c * ra) / det};
}

/// A rod let go from the horizontal.
void pendulum(const OdeState& y, OdeState& d, double) { d = {y[1], -1.5 * 9.81 * std::cos(y[0])}; }

void slider_crank(const OdeState& y, OdeState& d, double) {
  const test::SliderCrankTerms terms = test::slider_crank_terms(y[0]);
  d = {y[1], -(terms.weight + 0.5 * terms.mass_slope * y[1] * y[1]) / terms.mass};
}

struct Problem {
  std::string name;
  Model model;
  std::function<void(const OdeState&, OdeState&, double)> right;
  OdeState start;
  std::size_t angles;  // the first states are the angles of bodies 1, 2, ...
};
std::vector<Problem> problems() {
  return {{"pendulum", test::make_chain(1), pendulum, {0, 0}, 1},
          {"double pendulum", test::make_chain(2), double_pendulum, {0, 0, 0, 0}, 2},
          {"slider-crank", test::make_slider_crank(), slider_crank, {0.7, 12}, 1}};
}

/// Largest error of the angles at ten times up to 1 s: before the double pendulum's errors grow by more than 30.
double global_error(const Problem& p, const MachineOptions& options) {
  Machine machine(p.model, options);
  machine.start_from_pose();
  double worst = 0;
  OdeState y = p.start;
  for (int i = 0; i < 10; ++i) {
    y = test::solve_ode(p.right, y, 0.1 * i, 0.1 * (i + 1), 1e-14);
    machine.advance(0.1);
    for (std::size_t k = 0; k < p.angles; ++k)
      worst = std::max(worst, std::abs(machine.body(static_cast<int>(k) + 1).angle - y[k]));
  }
  return worst;
}

class Tolerance : public testing::TestWithParam<int> {
 protected:
  static Method method() {
    return std::vector<Method>{
        {"cvode", cvode}, {"ida", ida}, {"ida index 1", index_1}}[static_cast<std::size_t>(GetParam())];
  }
};

// A tolerance means what it says up to how errors grow with the motion, thirtyfold for the double pendulum, and to what
// its error control does not see: the global error stays within a hundred tolerances, and falls with them: by two and a
// half decades at least over four, though it may happen to be small at one of them.
TEST_P(Tolerance, BoundsTheGlobalErrorAndOrdersIt) {
  for (const Problem& p : problems()) {
    SCOPED_TRACE(method().name + ", " + p.name);
    double before = 1, first = 0;
    for (const double tolerance : {1e-5, 1e-7, 1e-9}) {
      const double error = global_error(p, method().options(tolerance));
      EXPECT_LT(error, 100 * tolerance);
      EXPECT_LT(error, 0.3 * before);
      before = error;
      if (first == 0) first = error;
    }
    EXPECT_LT(before, 3e-3 * first);
  }
}
INSTANTIATE_TEST_SUITE_P(Methods, Tolerance, testing::Range(0, 3));

TEST(Tolerances, AreSharedOutOverTheStepsButNeverLoosened) {
  EXPECT_DOUBLE_EQ(local_tolerance(1e-6, 1e-14), 1e-8);
  EXPECT_DOUBLE_EQ(local_tolerance(1e-13, 1e-14), 1e-14) << "rounding";
  EXPECT_DOUBLE_EQ(local_tolerance(1e-15, 1e-14), 1e-15) << "as asked for";
}

TEST(Tolerances, MustBeAboveZero) {
  for (const auto& options : {cvode(0), ida(0), cvode(-1e-6)})
    EXPECT_THROW(Machine(test::make_chain(1), options), std::invalid_argument);
}

// Published to 16 digits. Errors of the squeezer grow by some 1e3 over its run, so at 1e-10 a relative 1e-6 is asked
// for; the fixed step of order 4 is a hundredth of a millisecond.
TEST(Squeezer, AnglesOfTheIvpTestSet) {
  for (const Method& method : {Method{"cvode", cvode}, Method{"ida", ida}, Method{"adams-moulton", adams}}) {
    SCOPED_TRACE(method.name);
    Machine machine(test::make_squeezer(), method.options(1e-10));
    machine.start_from_pose();
    const int steps = method.name == "adams-moulton" ? 3000 : 1;
    for (int i = 0; i < steps; ++i) machine.advance(0.03 / steps);
    const auto angles = test::squeezer_angles(machine);
    for (std::size_t i = 0; i < angles.size(); ++i)
      EXPECT_NEAR(angles[i], test::squeezer_reference[i], 1e-6 * std::max(1.0, std::abs(test::squeezer_reference[i])));
  }
}

/// |Phi| and |Phi_q q' + Phi_t| of a machine as it stands, angles times the machine's length.
std::pair<double, double> residuals(const Machine& machine) {
  System system(machine.system().model());
  Constraints c;
  const MotionState& now = machine.integrator().state();
  system.set_state(now.t, now.q, now.velocity);
  system.constraints(c);
  const Eigen::VectorXd scale = row_scale(system), rate = c.jacobian * now.velocity + c.phi_t;
  return {scale.cwiseProduct(c.phi).cwiseAbs().maxCoeff(), scale.cwiseProduct(rate).cwiseAbs().maxCoeff()};
}

double largest_rate(const Machine& machine) {
  const MotionState& now = machine.integrator().state();
  const Eigen::VectorXd scale = coordinate_scale(machine.system());
  return std::max(1.0, scale.cwiseProduct(now.velocity).cwiseAbs().maxCoeff() / machine.system().length_scale());
}

// At every output, whatever the tolerance: outputs are put on the constraints, they do not only come near.
TEST(Outputs, LieOnTheConstraints) {
  const std::vector<std::pair<Model, double>> machines{{test::make_chain(1), 0.1},        {test::make_chain(2), 0.1},
                                                       {test::make_slider_crank(), 0.02}, {test::make_four_bar(), 0.02},
                                                       {test::make_squeezer(), 5e-4},     {test::make_chain(5), 0.05}};
  for (const auto& options : {adams(0), cvode(1e-5), ida(1e-5), index_1(1e-5)})
    for (std::size_t k = 0; k < machines.size(); ++k) {
      SCOPED_TRACE(testing::Message() << "machine " << k << ", integrator " << static_cast<int>(options.integrator));
      Machine machine(machines[k].first, options);
      machine.start_from_pose();
      const bool fixed_step = options.integrator == IntegratorKind::adams_moulton;
      const double length = machine.system().length_scale();
      for (int i = 0; i < 20; ++i) {
        for (int part = 0; part < (fixed_step ? 50 : 1); ++part)
          machine.advance(machines[k].second / (fixed_step ? 50 : 1));
        const auto [position, velocity] = residuals(machine);
        ASSERT_LT(position, 1e-12 * length);
        ASSERT_LT(velocity, 1e-12 * length * largest_rate(machine));
      }
    }
}

long steps_with(MachineOptions options, int outputs) {
  Machine machine(test::make_chain(2), options);
  machine.start_from_pose();
  for (int i = 0; i < outputs; ++i) machine.advance(1.0 / outputs);
  EXPECT_DOUBLE_EQ(machine.time(), 1.0);
  return dynamic_cast<const Adaptive&>(machine.integrator()).steps();
}

// Outputs are read from the dense solution. A new choice of coordinates happens at other times, so a few steps differ.
TEST(Outputs, CostNoSteps) {
  for (const auto& options : {cvode(1e-8), ida(1e-8)}) {
    const long few = steps_with(options, 5), many = steps_with(options, 2000);
    EXPECT_LT(many, 1.15 * static_cast<double>(few));
    EXPECT_LT(many, 2000);
  }
}

// The wrench of a coupled run is constant between outputs and jumps at them: every jump begins anew and nothing of the
// next wrench leaks into the step before. Oracle: the pendulum under the same staircase, piece by piece.
TEST(Outputs, JumpsOfTheWrenchAreFollowedExactly) {
  for (const auto& options : {cvode(1e-9), ida(1e-9)}) {
    Machine machine(test::make_chain(1), options);
    machine.start_from_pose();
    OdeState y{0, 0};
    for (int i = 0; i < 20; ++i) {
      const double torque = i % 3 == 0 ? 6 : -4;
      y = test::solve_ode(
          [&](const OdeState& s, OdeState& d, double) {
            d = {s[1], -1.5 * 9.81 * std::cos(s[0]) + 3 * torque};
          },
          y, 0, 0.05, 1e-14);
      machine.set_external_wrench(1, 0, 0, torque);
      machine.advance(0.05);
      ASSERT_NEAR(machine.body(1).angle, y[0], 3e-7);
      ASSERT_NEAR(machine.body(1).omega, y[1], 3e-6);
    }
  }
}

// A parallelogram of five bars has one redundant pin pair; its reactions are shared, its motion is a pendulum's.
TEST(Adaptive, TakesRedundantConstraints) {
  for (const auto& options : {cvode(1e-9), ida(1e-9), index_1(1e-9)}) {
    Model m;
    for (int i = 0; i < 3; ++i) {
      const double x = 0.5 * i;
      const int rod = test::add_rod(m, "rod " + std::to_string(i), {x, 0}, {x, -1}, 1);
      m.add("top " + std::to_string(i), test::pin_at(m, ground, rod, {x, 0}));
    }
    const int bar = test::add_rod(m, "bar", {0, -1}, {1, -1}, 2);
    for (int i = 0; i < 3; ++i) m.add("low " + std::to_string(i), test::pin_at(m, i + 1, bar, {0.5 * i, -1}));
    for (int i = 0; i < 3; ++i) m.bodies[static_cast<std::size_t>(i)].velocity = {0.75, 0, 1.5};
    m.bodies[3].velocity = {1.5, 0, 0};
    Machine machine(m, options);
    machine.start_from_pose();
    EXPECT_EQ(machine.assembly().freedom, 1);
    for (int i = 0; i < 10; ++i) machine.advance(0.1);
    // Inertia 3 (1/3) + 2, moment of weight 3 (1/2) + 2.
    const OdeState y = test::solve_ode(
        [](const OdeState& s, OdeState& d, double) {
          d = {s[1], -3.5 * 9.81 / 3 * std::sin(s[0])};
        },
        {0, 1.5}, 0, 1, 1e-14);
    EXPECT_NEAR(machine.body(1).angle + std::numbers::pi / 2, y[0], 1e-6);
    EXPECT_NEAR(machine.energy().balance(), 0, 1e-5);
  }
}

// A rod turns freely about its end at 200 rad/s, 160 turns: x' and y' of its centre pass zero twice in each, where
// rounding of an angle of 1000 rad, over a step, is far more than 1e-12 m/s. Its speed errs by no more than a hundred
// times the tolerance, its angle by that times the way, growing as the time squared: half of it.
TEST(Adaptive, AFastRotorGoesOn) {
  for (const auto& options : {cvode(1e-8), ida(1e-8)}) {
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "rod", .mass = 1, .inertia = 1. / 12, .pose = {0.5, 0, 0}, .velocity = {0, 100, 200}});
    m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.5, 0}});
    Machine machine(m, options);
    machine.start_from_pose();
    for (int i = 0; i < 1000; ++i) machine.advance(5e-3);
    EXPECT_NEAR(machine.body(1).omega, 200, 200 * 1e-6);
    EXPECT_NEAR(machine.body(1).angle, 1000, 1000 * 0.5e-6);
  }
}

}  // namespace
}  // namespace subsoil::mbd::adaptive_test
