// Hydraulic cylinder and electric motor against closed forms.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/equilibrium/equilibrium.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/electric_motor.hpp"
#include "libmbd/forces/hydraulic_cylinder.hpp"
#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/forces/torque_speed_motor.hpp"
#include "libmbd/joints/fixed.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::mbd::actuators_test {
namespace {

constexpr double pi = std::numbers::pi;

MachineOptions options(IntegratorKind kind) {
  return {.integrator = kind, .ida = {.rtol = 1e-9, .atol = 1e-10}, .cvode = {.rtol = 1e-10, .atol = 1e-11}};
}
void run(Machine& machine, double until, double h) {
  while (machine.time() < until - 0.5 * h) machine.advance(h);
}

class Actuators : public testing::TestWithParam<IntegratorKind> {};
INSTANTIATE_TEST_SUITE_P(All, Actuators,
                         testing::Values(IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida));

/// 80 x 40 mm, 0.3 m of stroke.
HydraulicCylinder cylinder() {
  HydraulicCylinder c{.body_a = 0, .body_b = 1};
  c.bore = 0.08, c.rod = 0.04, c.closed = 0.5, c.stroke = 0.3, c.supply = 18e6, c.tank = 2e5;
  c.rated_flow = 1e-3, c.dead = 2e-4;
  return c;
}

/// A cylinder from the origin moves 100 kg along x, from x of its stroke on.
Model lifting(const HydraulicCylinder& c, double x, double load = 0) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "mass", .mass = 100, .inertia = 1, .pose = {0.5 + x, 0, 0}});
  m.add("rail", Translational{.body_a = 0, .body_b = 1});
  m.add("cylinder", c);
  m.add("load", AppliedForce{.body = 1, .fx = -load});
  return m;
}

// A closed valve locks oil on both sides: omega^2 = beta (A_A^2/V_A + A_B^2/V_B)/m, the textbook's oil spring.
TEST(Cylinder, NaturalFrequencyIsThatOfTheOil) {
  HydraulicCylinder c = cylinder();
  c.valve = 0.;
  c.start_a = 3e6, c.start_b = 3e6 * c.cap_area() / c.rod_area();
  const double x = 0.12, a = c.cap_area(), b = c.rod_area();
  const double omega = std::sqrt(1.4e9 * (a * a / (2e-4 + a * x) + b * b / (2e-4 + b * 0.18)) / 100);
  System system(lifting(c, x));
  Equilibrium at;
  at.q = system.start_position(), at.velocity = system.start_velocity(), at.lambda = Eigen::VectorXd::Zero(2);
  const auto found = modes(system, 0, at);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].frequency, omega / (2 * pi), 1e-7 * omega);
  EXPECT_NEAR(found[0].damping, 0, 1e-7);
  EXPECT_EQ(stability(found).kind, Stability::stable);
}

// Oil that leaks past the piston of a closed valve is locked as a whole: nothing is free. Beside the swing it creeps
// with A_A dp_A = A_B dp_B, so at the rate -beta k (A_A - A_B)^2/(A_B^2 V_A + A_A^2 V_B), to the share of the inertia.
TEST(Cylinder, LeakingOilOfAClosedValveIsStable) {
  HydraulicCylinder c = cylinder();
  c.valve = 0., c.leakage = 2e-12, c.start_a = 4e6, c.start_b = 4e6 * (1 + 1e-15);  // rounding, as where it is found
  const double x = 0.12, a = c.cap_area(), b = c.rod_area(), v_a = 2e-4 + a * x, v_b = 2e-4 + b * 0.18;
  System system(lifting(c, x, 4e6 * (a - b)));
  Equilibrium at;
  at.q = system.start_position(), at.velocity = system.start_velocity(), at.lambda = Eigen::VectorXd::Zero(2);
  const auto found = modes(system, 0, at);
  ASSERT_EQ(found.size(), 2U);
  const double rate = -1.4e9 * 2e-12 * (a - b) * (a - b) / (b * b * v_a + a * a * v_b);
  EXPECT_NEAR(found[0].rate, rate, 1e-3 * std::abs(rate));
  EXPECT_EQ(stability(found).kind, Stability::stable);
}

// Three discs that drag at J w' = -c w and turn free else: beside three neutral modes the rates c/J, the slowest first,
// however the discs are listed.
TEST(Modes, ThatDoNotSwingAreInOrderOfTheirRates) {
  const std::array<double, 3> drag{70, 3, 11};
  for (const auto& order : {std::array<std::size_t, 3>{0, 1, 2}, {2, 1, 0}, {1, 0, 2}}) {
    Model m;
    for (const std::size_t i : order) {
      const int disc = m.add({.name = "disc " + std::to_string(i), .mass = 1, .inertia = 0.5});
      m.add("axle " + std::to_string(i), Revolute{.body_a = 0, .body_b = disc});
      m.add("drag " + std::to_string(i),
            RotationalSpringDamper{.body_a = 0, .body_b = disc, .stiffness = 0, .damping = drag[i]});
    }
    System system(m);
    Equilibrium at;
    at.q = system.start_position(), at.velocity = system.start_velocity(), at.lambda = Eigen::VectorXd::Zero(6);
    const auto found = modes(system, 0, at);
    ASSERT_EQ(found.size(), 6U);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(found[k].is_zero());
    EXPECT_NEAR(found[3].rate, -6, 1e-9);
    EXPECT_NEAR(found[4].rate, -22, 1e-9);
    EXPECT_NEAR(found[5].rate, -140, 1e-9);
  }
}

// The same over time: 1 mm/s swings by 1e-3/omega, and volumes change by 1e-4 of themselves.
TEST_P(Actuators, LockedOilSwingsAtItsFrequency) {
  HydraulicCylinder c = cylinder();
  c.valve = 0.;
  c.start_a = 3e6, c.start_b = 3e6 * c.cap_area() / c.rod_area();
  Model m = lifting(c, 0.12);
  m.bodies[0].velocity[0] = 1e-3;
  const double a = c.cap_area(), b = c.rod_area();
  const double omega = std::sqrt(1.4e9 * (a * a / (2e-4 + a * 0.12) + b * b / (2e-4 + b * 0.18)) / 100);
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 2 * pi / omega * 3.25, 2 * pi / omega / 400);
  EXPECT_NEAR(machine.body(1).r.x - 0.62, 1e-3 / omega, 1e-3 * 1e-3 / omega);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6 * machine.energy().moved);
}

// Held fast, the difference of pressures leaks away: d' = -beta k (1/V_A + 1/V_B) d, while p_A V_A + p_B V_B stays.
TEST_P(Actuators, LeakageDecaysExponentially) {
  HydraulicCylinder c = cylinder();
  c.valve = 0., c.leakage = 2e-12, c.start_a = 9e6, c.start_b = 1e6;
  Model m = lifting(c, 0.1);
  m.add("weld", Fixed{.body_a = 0, .body_b = 1, .p_a = {0.6, 0}});
  m.joints.erase(m.joints.begin());
  const double v_a = 2e-4 + c.cap_area() * 0.1, v_b = 2e-4 + c.rod_area() * 0.2;
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 0.2, 1e-3);
  const double left = 8e6 * std::exp(-1.4e9 * 2e-12 * (1 / v_a + 1 / v_b) * 0.2);
  const double p_a = machine.force_value("cylinder", "pressure a"), p_b = machine.force_value("cylinder", "pressure b");
  EXPECT_NEAR(p_a - p_b, left, 1e-6 * left);
  EXPECT_NEAR(p_a * v_a + p_b * v_b, 9e6 * v_a + 1e6 * v_b, 1e-9 * 9e6 * v_a);
  EXPECT_GT(machine.energy().lost, 1);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-7 * machine.energy().lost);
}

// A given flow against a constant load: once the friction has calmed it, v = Q/A and p_A A_A = load + p_T A_B + c v.
TEST_P(Actuators, ConstantFlowIsConstantSpeed) {
  HydraulicCylinder c = cylinder();
  c.flow = 2e-4, c.friction = 8e3, c.start_a = 2.2e6;
  Machine machine(lifting(c, 0.02, 1e4), options(GetParam()));
  machine.start_from_pose();
  run(machine, 1.5, 1e-4);
  const double v = 2e-4 / c.cap_area();
  EXPECT_NEAR(machine.body(1).v.x, v, 1e-6 * v);
  EXPECT_NEAR(machine.force_value("cylinder", "pressure a"), (1e4 + 8e3 * v + 2e5 * c.rod_area()) / c.cap_area(), 30);
  // The oil that came is in the volume swept, and in the compression, of order p/beta.
  const double swept = c.cap_area() * (machine.body(1).r.x - 0.52);
  EXPECT_NEAR(swept, 1.5 * 2e-4, 3e-3 * 1.5 * 2e-4);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6 * machine.energy().moved);
}

/// Speed at which a massless piston balances two orifices: A_A (p_S - (A_A v/K)^2) = A_B (p_T + (A_B v/K)^2).
double free_speed(const HydraulicCylinder& c, double opening) {
  const double k = opening * c.rated_flow / std::sqrt(c.rated_drop), a = c.cap_area(), b = c.rod_area();
  return k * std::sqrt((a * c.supply - b * c.tank) / (a * a * a + b * b * b));
}

// With the valve half open and no load it runs at the speed of its orifices; the laminar part of 1/20 of the rated drop
// changes them by (dp_0/dp)^2/4, below 1e-5 at the supply and 1e-4 at the tank. Then it meets the end stop and rests.
TEST_P(Actuators, ValveSetsTheSpeedAndTheStopEndsIt) {
  HydraulicCylinder c = cylinder();
  c.valve = 0.3, c.friction = 300;
  Machine machine(lifting(c, 0.02), options(GetParam()));
  machine.start_from_pose();
  const double v = free_speed(c, 0.3);
  run(machine, 0.12 / v, 1e-4);
  EXPECT_NEAR(machine.body(1).v.x, v, 3e-3 * v);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6 * machine.energy().moved);
  run(machine, 0.6 / v, 1e-4);
  EXPECT_NEAR(machine.body(1).v.x, 0, 1e-4);
  EXPECT_NEAR(machine.force_value("cylinder", "pressure a"), c.supply, 1e-3 * c.supply);
  EXPECT_NEAR(machine.body(1).r.x, 0.8 + (c.supply * c.cap_area() - c.tank * c.rod_area()) / 1e8, 1e-5);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-5 * machine.energy().moved);
}

// Pulled by 5 kN with the valve shut, the cap side falls to the tank's pressure and is fed from there; pushed by 200 kN
// the relief valve opens.
TEST_P(Actuators, FeedsFromTheTankAndRelieves) {
  HydraulicCylinder c = cylinder();
  c.valve = 0., c.relief = 2e7, c.friction = 2e3;
  Machine pulled(lifting(c, 0.1, -5e3), options(GetParam()));
  pulled.start_from_pose();
  run(pulled, 0.05, 5e-5);
  EXPECT_GT(pulled.force_value("cylinder", "pressure a"), 0);
  Machine pushed(lifting(c, 0.2, 2e5), options(GetParam()));
  pushed.start_from_pose();
  run(pushed, 0.05, 5e-5);
  EXPECT_LT(pushed.body(1).v.x, -0.01) << "it gives way";
  EXPECT_LT(pushed.force_value("cylinder", "pressure a"), 6e7);
  for (const Machine* m : {&pulled, &pushed}) EXPECT_NEAR(m->energy().balance(), 0, 1e-6 * m->energy().moved);
}

TEST(Cylinder, RefusalsSayWhatIsWrong) {
  const auto refusal = [](auto change) {
    HydraulicCylinder c = cylinder();
    change(c);
    return test::message_of([&] { Machine machine(lifting(c, 0.1), {}); });
  };
  const auto says = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  says(refusal([](auto&) {}), "needs either `flow given`, or `valve` or `controller`");
  says(refusal([](auto& c) { c.valve = 0., c.rod = 0.09; }), "rod must be thinner than the bore");
  says(refusal([](auto& c) { c.valve = 0., c.rated_flow = std::nan(""); }), "a valve needs its rated flow");
  says(refusal([](auto& c) { c.valve = 0., c.rated_flow = 1e-4, c.supply = 1e7, c.tank = 1e6, c.relief = 1e6; }),
       "relief pressure must be above the tank's");
  says(refusal([](auto& c) { c.flow = 1e-4, c.start_b = 1e6; }),
       "the rod side is open to the tank then and has its pressure; leave it out, and give `tank pressure` instead");
}

/// Pressure drop of an orifice for the flow q: phi(dp) = q/K means dp^4 = y^2 (dp^2 + dp_0^2) with y = (q/K)^2.
double drop_at(double q, double rated_flow, double rated_drop) {
  const double y = q * q / (rated_flow * rated_flow) * rated_drop, laminar = rated_drop / 20;
  return std::sqrt((y * y + std::sqrt(y * y * (y * y + 4 * laminar * laminar))) / 2);
}

// 12 l/min into a cylinder held fast: all of it leaves through the relief valve, whose excess is that of its orifice;
// left out, that passes the stroke in 0.1 s, or 15 l/s here. Excess and energy to 1e-4: the transient is over (26 us).
TEST_P(Actuators, AGivenFlowIsRelieved) {
  for (const double rated : {std::nan(""), 2e-3}) {
    HydraulicCylinder c = cylinder();
    c.flow = 2e-4, c.relief = 2e7, c.start_a = 1.99e7, c.rated_flow = rated;
    Model m = lifting(c, 0.1);
    m.add("weld", Fixed{.body_a = 0, .body_b = 1, .p_a = {0.6, 0}});
    m.joints.erase(m.joints.begin());
    Machine machine(m, options(GetParam()));
    machine.start_from_pose();
    run(machine, 0.02, 1e-5);
    const double excess = drop_at(2e-4, rated > 0 ? rated : c.cap_area() * 0.3 / 0.1, c.rated_drop);
    EXPECT_NEAR(machine.force_value("cylinder", "pressure a"), 2e7 + excess, 1e-4 * excess);
    if (std::isnan(rated)) {
      EXPECT_LT(excess, 1.1e4) << "0.06 % of the relief pressure";
    }
    EXPECT_NEAR(machine.energy().balance(), 0, 1e-6 * machine.energy().moved);
  }
}

// Pulled out at a stroke per second with no flow given: the tank feeds A_A v, and the pressure is below its by the drop
// of the same orifice, 0.08 MPa.
TEST_P(Actuators, AGivenFlowIsFedFromTheTank) {
  HydraulicCylinder c = cylinder();
  c.flow = 0., c.rated_flow = std::nan("");
  Model m = lifting(c, 0.1);
  m.bodies[0].velocity[0] = 0.3;
  m.add("pull", CoordinateDriver{.body = 1, .coordinate = Coordinate::x, .motion = {.velocity = 0.3}});
  Machine machine(m, options(GetParam()));
  machine.start_from_pose();
  run(machine, 0.02, 1e-5);
  const double drop = drop_at(c.cap_area() * 0.3, c.cap_area() * 0.3 / 0.1, c.rated_drop);
  EXPECT_NEAR(machine.force_value("cylinder", "pressure a"), 2e5 - drop, 1e-4 * drop);
  EXPECT_LT(drop, 8.5e4);
  EXPECT_EQ(machine.force_value("cylinder", "pressure b"), 2e5);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6 * machine.energy().moved);
}

/// A rotor on a pin.
Model turning(const ElectricMotor& motor) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "rotor", .mass = 1, .inertia = 0.02, .pose = {0, 0, 0}});
  m.add("pin", Revolute{.body_a = 0, .body_b = 1});
  m.add("motor", motor);
  return m;
}
ElectricMotor direct(double inductance) {
  ElectricMotor motor{.body_a = 0, .body_b = 1};
  motor.torque_constant = 0.3, motor.resistance = 0.8, motor.inductance = inductance, motor.ratio = 2;
  motor.friction = 1e-3, motor.voltage = 24.;
  return motor;
}

// A current comes to rest of itself and holds no angle: beside its zero stands the swing of (i, w) below. That was
// all there was, and the wheel counted as held.
TEST(Modes, ACurrentHoldsNoWheel) {
  const double l = 0.01, k = 0.3 * 2, b = 4e-3, j = 0.02;
  Model m = turning(direct(l));
  m.forces[0].element.get_if<ElectricMotor>()->voltage = 0.;
  System system(m);
  Equilibrium at;
  at.q = system.start_position(), at.velocity = system.start_velocity(), at.lambda = Eigen::VectorXd::Zero(2);
  at.states = Eigen::VectorXd::Zero(1);
  const auto found = modes(system, 0, at);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(stability(found).kind, Stability::neutral);
  EXPECT_TRUE(found[0].is_zero());
  Eigen::Matrix2d a;
  a << -0.8 / l, -k / l, k / j, -b / j;
  const std::complex<double> rate = a.eigenvalues()[0];
  EXPECT_NEAR(found[1].rate, rate.real(), 1e-7 * std::abs(rate));
  EXPECT_NEAR(found[1].frequency, std::abs(rate.imag()) / (2 * pi), 1e-7 * std::abs(rate));
}

// (i, w): L i' = u - R i - K n w, J w' = n K i - n^2 b w.
TEST_P(Actuators, MotorStepIsTheLinearSystem) {
  const double l = 0.01, k = 0.3 * 2, b = 4e-3, j = 0.02;
  Machine machine(turning(direct(l)), options(GetParam()));
  machine.start_from_pose();
  Eigen::Matrix3d a;
  a << -0.8 / l, -k / l, 24 / l, k / j, -b / j, 0, 0, 0, 0;
  for (const double t : {0.02, 0.1, 0.5}) {
    run(machine, t, 2e-4);
    const Eigen::Vector3d z = (a * t).exp() * Eigen::Vector3d(0, 0, 1);
    EXPECT_NEAR(machine.force_value("motor", "current"), z[0], 1e-6) << t;
    EXPECT_NEAR(machine.body(1).omega, z[1], 1e-6) << t;
  }
  const MachineEnergy e = machine.energy();
  EXPECT_NEAR(e.balance(), 0, 1e-7 * e.moved);
  EXPECT_NEAR(e.force_work, e.kinetic + e.stored + e.lost, 1e-7 * e.moved);
}

// Without inductance: w = w_0 (1 - exp(-t/T)), T = J/(n^2 b + n^2 K^2/R), w_0 = n K u/R T/J.
TEST_P(Actuators, MotorWithoutInductanceIsOfFirstOrder) {
  Machine machine(turning(direct(0)), options(GetParam()));
  machine.start_from_pose();
  const double time = 0.02 / (4e-3 + 0.36 / 0.8), speed = 0.6 * 24 / 0.8 * time / 0.02;
  run(machine, 0.06, 2e-4);
  EXPECT_NEAR(machine.body(1).omega, speed * (1 - std::exp(-0.06 / time)), 1e-6);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-7 * machine.energy().moved);
}

// f = T_0 (1 - w/w_0), as a table of its two ends, on a flywheel: J w' = n f(n w), so n w = w_0 (1 - exp(-t/tau)) with
// tau = J w_0/(n^2 T_0). All work is the wheel's kinetic energy. Errors are those of the methods' tolerances, 1e-9.
TEST_P(Actuators, TorqueSpeedMotorRunsUpAFlywheel) {
  constexpr double torque = 40, idle = 150, ratio = 3, inertia = 2;
  for (const auto between : {Between::spline, Between::linear, Between::monotone}) {
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "wheel", .mass = 5, .inertia = inertia});
    m.add("axle", Revolute{.body_a = ground, .body_b = 1});
    m.add("motor", TorqueSpeedMotor{.body_a = ground,
                                    .body_b = 1,
                                    .curve = TableCharacteristic({0, idle}, {torque, 0}, between),
                                    .ratio = ratio});
    Machine machine(m, options(GetParam()));
    machine.start_from_pose();
    run(machine, 0.6, 1e-3);
    const double tau = inertia * idle / (ratio * ratio * torque), w = idle / ratio * (1 - std::exp(-0.6 / tau));
    EXPECT_NEAR(machine.body(1).omega, w, 1e-7 * w);
    EXPECT_NEAR(machine.force_value("motor", "speed"), ratio * w, 1e-6 * w);
    EXPECT_NEAR(machine.energy().force_work, 0.5 * inertia * w * w, 1e-6 * w * w);
    EXPECT_NEAR(machine.energy().balance(), 0, 1e-7 * machine.energy().moved);
  }
}

// A share of the torque scales it and is held within its bounds; beyond the idle speed the motor brakes.
TEST(TorqueSpeedMotor, ShareScalesTheTorque) {
  TorqueSpeedMotor motor{.body_a = ground, .body_b = 1, .curve = TableCharacteristic({0, 100, 150}, {40, 0, -20})};
  const auto torque = [&](double share, double speed) {
    motor.share = share;
    const std::array<BodyState, 2> bodies{BodyState{}, BodyState{{}, 0, {}, speed}};
    std::array<std::array<double, 3>, 2> wrench{};
    Loads loads(wrench);
    ForceValues values{};
    const double work = motor.evaluate({bodies, 0, {}}, loads, values).work;
    EXPECT_DOUBLE_EQ(work, wrench[1][2] * speed);
    EXPECT_EQ(wrench[0][2], -wrench[1][2]);
    return wrench[1][2];
  };
  EXPECT_DOUBLE_EQ(torque(1, 0), 40);
  EXPECT_DOUBLE_EQ(torque(0.25, 0), 10);
  EXPECT_DOUBLE_EQ(torque(7, 0), 40);
  EXPECT_DOUBLE_EQ(torque(-1, 0), -40);
  EXPECT_DOUBLE_EQ(torque(1, 150), -20);
}

}  // namespace
}  // namespace subsoil::mbd::actuators_test
