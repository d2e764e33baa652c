// PID controllers: closed loops on linear systems against the matrix exponential of their equations, which the tests
// write down on their own; order of convergence; sampled loops against their recursion; restart.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "libmbd/measures/control_input.hpp"
#include "libmbd/measures/force.hpp"
#include "libmbd/measures/position.hpp"
#include "libmbd/measures/soil_force.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::mbd::control_test {
namespace {

constexpr double mass = 2;

/// A mass on a rail that a controller pushes along x.
Model on_rail(PidController pid) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "mass", .mass = mass, .inertia = 1, .pose = {0.5, 0, 0}});
  m.add("rail", Translational{.body_a = 0, .body_b = 1});
  m.add("push", AppliedForce{.body = 1, .controller = "pid", .controls = Controls::x});
  if (!pid.input) pid.input = input_of(PositionMeasure{.of = {.name = "mass", .body = 1}, .part = VectorPart::x});
  m.add("pid", pid);
  return m;
}

MachineOptions options(IntegratorKind kind) {
  return {.integrator = kind, .ida = {.rtol = 1e-10, .atol = 1e-11}, .cvode = {.rtol = 1e-11, .atol = 1e-12}};
}
/// What a method may miss over a second or two: see docs/verification/integrators.md.
double bound(IntegratorKind kind) { return kind == IntegratorKind::ida ? 2e-8 : 2e-9; }

void run(Machine& machine, double until, double h) {
  while (machine.time() < until - 0.5 * h) machine.advance(h);
}

class Pid : public testing::TestWithParam<IntegratorKind> {};
INSTANTIATE_TEST_SUITE_P(All, Pid,
                         testing::Values(IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida));

const PidController gains{
    .set_point = 0.7, .proportional = 200, .integral = 300, .derivative = 30, .filter_time = 0.02};

/// z = (x - r, x', I, x_d) of the mass under `gains`: m x'' = K_p e + I + K_d (e - x_d)/T_f, e = r - x.
Eigen::Vector4d exact(double t) {
  const auto& g = gains;
  Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
  const double d = g.derivative / g.filter_time;
  a.row(0) << 0, 1, 0, 0;
  a.row(1) << (-g.proportional - d) / mass, 0, 1 / mass, -d / mass;
  a.row(2) << -g.integral, 0, 0, 0;
  a.row(3) << -1 / g.filter_time, 0, 0, -1 / g.filter_time;
  return (a * t).exp() * Eigen::Vector4d(-0.2, 0, 0, 0.2);
}

TEST_P(Pid, MovesAMassAsTheLinearSystemSays) {
  Machine machine(on_rail(gains), options(GetParam()));
  machine.start_from_pose();
  for (int k = 1; k <= 8; ++k) {
    run(machine, 0.25 * k, 1e-3);
    const Eigen::Vector4d z = exact(0.25 * k);
    EXPECT_NEAR(machine.body(1).r.x, 0.7 + z[0], bound(GetParam())) << k;
    EXPECT_NEAR(machine.body(1).v.x, z[1], 20 * bound(GetParam())) << k;
    EXPECT_NEAR(machine.system().element_states()[0], z[2], 300 * bound(GetParam()));
    EXPECT_NEAR(machine.system().controller_error(0), -z[0], bound(GetParam()));
    // What the controller puts in is work: some J go in and out again.
    EXPECT_NEAR(machine.energy().force_work, machine.energy().kinetic, 1e-6 * machine.energy().moved);
    EXPECT_NEAR(machine.energy().balance(), 0, 1e-6 * machine.energy().moved);
  }
  EXPECT_GT(machine.energy().moved, 0.5);
}

// Order k of Adams-Moulton: halving the step divides the error by 2^k, to a third where the next term counts.
TEST(PidOrder, OfTheMethodIsKept) {
  for (const int order : {2, 3, 4}) {
    const auto error = [&](double h) {
      MachineOptions o;
      o.adams_moulton.order = order;
      Machine machine(on_rail(gains), o);
      machine.start_from_pose();
      run(machine, 0.5, h);
      return std::abs(machine.body(1).r.x - 0.7 - exact(0.5)[0]);
    };
    const double coarse = error(2e-3), fine = error(1e-3);
    EXPECT_GT(coarse / fine, std::pow(2, order) / 1.4) << order;
    EXPECT_LT(coarse / fine, std::pow(2, order) * 1.8) << order;
  }
}

// Saturated from the start the mass goes as under a constant force until K_p e + I + D falls to the bound; with
// back-calculation I does not wind up, so that it overshoots less than with an I that follows the bound in 10 s only.
TEST_P(Pid, SaturatesAndDoesNotWindUp) {
  PidController pid = gains;
  pid.set_point = 2.5, pid.least = -5, pid.largest = 5;
  pid.derivative_of_measurement = true;
  const auto highest = [&](double tracking) {
    pid.tracking_time = tracking;
    Machine machine(on_rail(pid), options(GetParam()));
    machine.start_from_pose();
    run(machine, 0.5, 1e-3);
    EXPECT_NEAR(machine.body(1).r.x, 0.5 + 0.5 * 5 / mass * 0.25, 1e-9);
    double most = 0;
    while (machine.time() < 6) {
      machine.advance(1e-3);
      most = std::max(most, machine.body(1).r.x);
      EXPECT_LE(std::abs(machine.system().signals()[0]), 5);
    }
    EXPECT_NEAR(machine.energy().balance(), 0, 1e-5);
    return most;
  };
  EXPECT_LT(highest(0.2), highest(10) - 0.1);
}

/// The sampled loop by hand: constant force between changes at t_k + delay.
double sampled(const PidController& c, double until) {
  double x = 0.5, v = 0, u = 0, integral = 0, d = 0, w_before = 0, next_u = 0;
  const double filter = c.filter_time > 0 ? c.filter_time : 0, r = 0.7;
  const auto fly = [&](double dt) { x += v * dt + u / mass * dt * dt / 2, v += u / mass * dt; };
  for (int k = 0;; ++k) {
    const double t = k * c.sample_time, e = r - x, w = e;
    if (k > 0) {
      d = (filter * d + c.derivative * (w - w_before)) / (filter + c.sample_time);
      integral += c.sample_time * c.integral * e;
    }
    w_before = w;
    const double raw = c.proportional * e + integral + d;
    next_u = std::min(std::max(raw, c.least), c.largest);
    integral += c.sample_time / (c.proportional / c.integral) * (next_u - raw);
    if (t + c.delay >= until) return fly(until - t), x;
    fly(c.delay), u = next_u;
    if (t + c.sample_time >= until) return fly(until - t - c.delay), x;
    fly(c.sample_time - c.delay);
  }
}

// Steps that do not fit the sample time, those that do, and those that fit the delay as well.
TEST_P(Pid, SampledIsItsRecursion) {
  PidController pid = gains;
  pid.sample_time = 0.01, pid.delay = 0.004, pid.least = -25, pid.largest = 25;
  pid.proportional = 60, pid.integral = 50, pid.derivative = 20;
  for (const double h : {0.003, 0.01, 0.05, 0.001, 0.00025}) {
    Machine machine(on_rail(pid), options(GetParam()));
    machine.start_from_pose();
    run(machine, 0.9, h);
    EXPECT_NEAR(machine.body(1).r.x, sampled(pid, 0.9), GetParam() == IntegratorKind::ida ? 1e-7 : 1e-9) << h;
    EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
  }
}

/// The mass pushes a spring and damper whose force the controller holds through a sensor.
PidController of_force(double lag) {
  return {.input = input_of(ForceMeasure{{.element = "spring", .part = WrenchPart::x}}),
          .set_point = 40.,
          .proportional = 0.5,
          .integral = 20,
          .sensor_lag = lag};
}
Model against_spring(const PidController& pid) {
  Model m = on_rail(pid);
  m.add("spring",
        SpringDamper{.body_a = 1, .body_b = 0, .p_b = {2, 0}, .stiffness = 800, .free_length = 1.5, .damping = 30});
  return m;
}

// z = (x - 0.5, x', I, y): the spring is at rest at 0.5; y' = (k x + c x' - y)/T_s. The ForceMeasure looks at what the
// ground gets, along +x.
TEST_P(Pid, HoldsAForceThroughASensor) {
  const double lag = 0.02, k = 800, c = 30;
  Machine machine(against_spring(of_force(lag)), options(GetParam()));
  machine.start_from_pose();
  Eigen::Matrix<double, 5, 5> a = Eigen::Matrix<double, 5, 5>::Zero();  // the last is 1
  a.row(0) << 0, 1, 0, 0, 0;
  a.row(1) << -k / mass, -c / mass, 1 / mass, -0.5 / mass, 0.5 * 40 / mass;
  a.row(2) << 0, 0, 0, -20, 20 * 40;
  a.row(3) << k / lag, c / lag, 0, -1 / lag, 0;
  Eigen::Matrix<double, 5, 1> z;
  z << 0, 0, 0, 0, 1;
  run(machine, 0.3, 1e-3);
  const Eigen::Matrix<double, 5, 1> at = (a * 0.3).exp() * z;
  EXPECT_NEAR(machine.body(1).r.x - 0.5, at[0], bound(GetParam()));
  EXPECT_NEAR(machine.system().element_states()[2], at[3], 1e3 * bound(GetParam()));
  run(machine, 8, 1e-3);
  EXPECT_NEAR(machine.force_value("spring", "force"), 40, 1e-3) << "I leaves no offset";
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-7);
}

// The soil's force is held over a step, so that it needs no sensor lag: u = -(K_p)(f - 10) pushes back.
TEST(PidSoil, MeasuresWhatComesFromOutside) {
  PidController pid{
      .input = input_of(SoilForceMeasure{.body = 1, .part = WrenchPart::x}), .set_point = 10., .proportional = 2};
  Machine machine(on_rail(pid), {});
  machine.start_from_pose();
  machine.set_external_wrench(1, -30, 0, 0);
  run(machine, 0.1, 1e-3);
  EXPECT_NEAR(machine.system().signals()[0], 2 * (10 + 30), 1e-12);
  EXPECT_NEAR(machine.body(1).r.x, 0.5 + 0.5 * (80 - 30) / mass * 0.01, 1e-12);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-11);
}

TEST_P(Pid, GoesOnFromASnapshotWithTheSameNumbers) {
  PidController pid = gains;
  for (const bool sampled : {false, true}) {
    if (sampled) pid.sample_time = 0.02, pid.delay = 0.013;
    Machine one(on_rail(pid), options(GetParam())), other(on_rail(pid), options(GetParam()));
    one.start_from_pose();
    other.start_from_pose();
    run(one, 0.3, 7e-3);
    one.restore(one.snapshot());
    other.restore(one.snapshot());
    for (int i = 0; i < 50; ++i) one.advance(7e-3), other.advance(7e-3);
    EXPECT_EQ(one.snapshot(), other.snapshot()) << sampled;
    EXPECT_EQ(one.body(1).r.x, other.body(1).r.x);
  }
}

// Outputs change at 20 k + 47 ms, which is an end of advance() to rounding only: 0.227 s here and an ulp beside it
// there. Behind a change of what acts from outside each end is a stop of the method, which restarts at the output.
TEST_P(Pid, OutputsAndEndsThatDifferByRoundingAreOneInstant) {
  PidController pid = gains;
  pid.sample_time = 0.02, pid.delay = 0.047;
  Machine at_once(on_rail(pid), options(GetParam()));
  at_once.start_from_pose();
  at_once.advance_to(0.2);
  at_once.set_external_wrench(1, 1, 0, 0);
  at_once.advance_to(0.5);
  for (const double h : {1e-3, 4e-3, 0.01}) {
    Machine in_parts(on_rail(pid), options(GetParam()));
    in_parts.start_from_pose();
    in_parts.advance_to(0.2);
    in_parts.set_external_wrench(1, 1, 0, 0);
    for (int k = 1; 0.2 + k * h < 0.5 + 0.5 * h; ++k) in_parts.advance_to(0.2 + k * h);
    EXPECT_NEAR(in_parts.body(1).r.x, at_once.body(1).r.x, GetParam() == IntegratorKind::adams_moulton ? 1e-6 : 1e-8)
        << h;
  }
}

// A set point that jumps at a sample has its own value there, by every method, and not one a rounding of time beside:
// sign(0) = 0. A force that jumps with it ends a step there.
TEST_P(Pid, SamplesASetPointThatJumpsAtTheInstant) {
  for (const int with_force : {0, 1})
    for (const double instant : {0.1, 0.3, 0.5}) {  // which are 0.01 k to the last bit
      const auto jump = [instant](double t) { return t > instant ? 1.0 : t < instant ? -1.0 : 0.0; };
      const auto nothing = [](double) { return 0.0; };
      const ExpressionFunction f{.text = "sign",
                                 .unit = "1",
                                 .value_ = jump,
                                 .first_ = nothing,
                                 .second_ = nothing,
                                 .integral_ = nothing,
                                 .double_integral_ = nothing};
      PidController pid;
      pid.proportional = 10, pid.sample_time = 0.01, pid.set_point = f;
      Model m = on_rail(pid);
      if (with_force) m.add("beside", AppliedForce{.body = 1, .fx = f});
      MachineOptions by = options(GetParam());
      by.adams_moulton.longest_step = 1e-3, by.adams_moulton.error_per_second = 1e-6;
      Machine machine(std::move(m), by);
      machine.start_from_pose();
      run(machine, instant + 2.5e-3, 1e-3);
      const double fx = machine.force_value("push", "fx");
      // Of a set point of -1 or 1 m it would be 10 N apart.
      EXPECT_NEAR(fx, -10 * machine.body(1).r.x, 0.5) << instant << ", " << with_force;
    }
}

// Fixed steps go on from a snapshot with the bits of the whole run, taken at the very instant too at which an output
// changes: 20 k + 13 ms, the end of a step.
TEST(PidRestart, WhereAnOutputChangesIsTheWholeRun) {
  PidController pid = gains;
  pid.sample_time = 0.02, pid.delay = 0.013;
  for (const double until : {0.113, 0.114, 0.12, 0.125}) {
    Machine whole(on_rail(pid), {}), restarted(on_rail(pid), {});
    whole.start_from_pose();
    run(whole, until, 1e-3);
    restarted.restore(whole.snapshot());
    run(whole, 0.3, 1e-3);
    run(restarted, 0.3, 1e-3);
    EXPECT_EQ(whole.snapshot(), restarted.snapshot()) << until;
  }
}

// Between the ends of a step: states by cubics, so that the error falls with h^4.
TEST(PidLook, BetweenStepsStatesAreOfThatTime) {
  Machine machine(on_rail(gains), {});
  machine.start_from_pose();
  machine.keep_dense_output();
  run(machine, 0.2, 2e-3);
  Evaluation between = machine.evaluation();
  const Instant at = between.evaluate(machine.dense_output(), 0.1993);
  const Eigen::Vector4d z = exact(0.1993);
  EXPECT_NEAR(at.system.element_states()[0], z[2], 1e-6);
  EXPECT_NEAR(at.system.signals()[0], -200 * z[0] + z[2] + 30 / 0.02 * (-z[0] - z[3]), 1e-3);
  EXPECT_NEAR(machine.system().element_states()[0], exact(0.2)[2], 1e-6);
}

// An evaluation inside the step leaves what is seen at its end as it was: output, what the controller misses, forces.
TEST(PidLook, LeavesASampledControllerAsItWas) {
  for (const IntegratorKind kind : {IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida}) {
    PidController pid = gains;
    pid.sample_time = 0.01;
    Machine machine(on_rail(pid), {.integrator = kind});
    machine.start_from_pose();
    machine.keep_dense_output();
    run(machine, 0.1, 5e-3);
    std::vector<double> before(machine.column_names().size()), after = before, middle = before;
    machine.columns(before);
    Evaluation between = machine.evaluation();
    machine.columns(between.evaluate(machine.dense_output(), machine.time() - 2e-3), middle);
    machine.columns(after);
    EXPECT_EQ(before, after);
    EXPECT_NE(before, middle);
  }
}

TEST(PidRefusal, SaysWhatIsWrong) {
  const auto refusal = [](const Model& m) { return test::message_of([&] { Machine machine(m, {}); }); };
  const auto says = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  says(refusal(against_spring(of_force(0))), "give it a sensor lag");
  PidController pid = gains;
  pid.filter_time = std::numeric_limits<double>::quiet_NaN();
  says(refusal(on_rail(pid)), "controller 'pid': a derivative gain needs a filter time");
  pid = gains, pid.delay = 0.1;
  says(refusal(on_rail(pid)), "a delay needs a sample time");
  pid = gains, pid.least = 1, pid.largest = -1;
  says(refusal(on_rail(pid)), "minimum must be below maximum");
  pid = gains, pid.proportional = 0, pid.least = 0;
  says(refusal(on_rail(pid)), "needs a tracking time");
  Model m = on_rail(gains);
  m.controllers[0].name = "other";
  says(refusal(m), "force 'push': no controller 'pid'; there are other");
  Machine kinematic(on_rail(gains), {.integrator = IntegratorKind::kinematic});
  says(test::message_of([&] { kinematic.start_from_pose(); }), "take `analysis: dynamics`");
}

}  // namespace
}  // namespace subsoil::mbd::control_test
