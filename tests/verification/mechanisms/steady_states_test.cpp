// Steady states with the states of elements, and the modes beside contacts, stops and friction.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libmbd/controllers/transfer_function.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/equilibrium/equilibrium.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/electric_motor.hpp"
#include "libmbd/forces/hydraulic_cylinder.hpp"
#include "libmbd/forces/joint_friction.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/forces/rotational_stop.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "libmbd/measures/angle.hpp"
#include "libmbd/measures/control_input.hpp"

namespace subsoil::mbd::steady_states_test {
namespace {

using std::numbers::pi;
constexpr double g = 9.81, up = pi / 2;

std::vector<Mode> modes_of(Machine& machine) {
  machine.start_from_towing_equilibrium(0);
  return modes(machine.system(), machine.time(), *machine.equilibrium());
}

/// A block on a vertical slide over a contact of the ground.
Model block(double mass, double stiffness, double n) {
  Model m;
  m.add({.name = "block", .mass = mass, .inertia = mass, .pose = {0, 0, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = 1, .angle_a = up});
  m.add("contact", LineContact{.body_a = ground, .body_b = 1, .law = {.normal = {.n = n, .stiffness = stiffness}}});
  return m;
}

// At the depth d of its weight, k d^n = m g, a contact is a spring of n k d^(n-1). Depths are 1e-4 to 1e-10 m: 1e-16 m
// of rounding in the place is up to 1e-6 of the last. The eigenvalue's own estimate says so.
TEST(ModesBesideContacts, AreThoseOfTheContactAtItsDepth) {
  for (const double n : {1.0, 1.5})
    for (const double k : {1e5, 1e6, 1e8, 1e9, 1e11}) {
      Machine machine(block(1, k, n));
      const auto found = modes_of(machine);
      ASSERT_EQ(found.size(), 1U);
      const double depth = std::pow(g / k, 1 / n), omega = std::sqrt(n * k * std::pow(depth, n - 1));
      EXPECT_NEAR(2 * pi * found[0].frequency, omega, (1e-9 + 1e-16 / depth) * omega) << "k = " << k << ", n = " << n;
      EXPECT_LT(found[0].error, 1e-5 * omega);
      EXPECT_NEAR(machine.body(1).r.y, -depth, 1e-9 * depth + 1e-16);
    }
}

// A length of 10 m makes the steps of differences longer, and the depth of 0.5 mm no deeper.
TEST(ModesBesideContacts, DoNotDependOnTheMachinesLength) {
  Model m = block(1000, 2e7, 1);
  m.add({.name = "far", .mass = 1, .inertia = 1, .pose = {10, 0, 0}});
  m.add("hinge", Revolute{.body_a = 1, .body_b = 2, .p_a = {10, 0}});
  m.add("twist", RotationalSpringDamper{.body_a = 1, .body_b = 2, .stiffness = 1000});
  Machine machine(m);
  const auto found = modes_of(machine);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0].frequency, std::sqrt(1000.0) / (2 * pi), 1e-8);
  EXPECT_NEAR(found[1].frequency, std::sqrt(2e7 / 1001) / (2 * pi), 1e-7);
}

// An arm rests on its stop 10 microradians deep: k/I about the pin; its weight changes that by 1e-10.
TEST(ModesBesideContacts, OfARotationalStop) {
  Model m;
  m.add({.name = "arm", .mass = 2, .inertia = 0.2, .pose = {0.5, 0, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.5, 0}});
  m.add("stop",
        RotationalStop{.body_a = ground, .body_b = 1, .limits = {.least = 0, .law = {.n = 1, .stiffness = 1e6}}});
  Machine machine(m);
  const auto found = modes_of(machine);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].frequency, std::sqrt(1e6 / 0.7) / (2 * pi), 1e-6);
}

// Regularised friction is a damper mu m g/v_reg at rest: s^2 + (mu g/v_reg) s + k/m = 0, whose slow root is not lost
// beside a fast one that is 4e8 times as large.
TEST(ModesBesideContacts, OfRegularisedFriction) {
  for (const double v : {1e-2, 1e-4, 1e-7}) {
    Model m;
    m.add({.name = "mass", .mass = 1, .inertia = 1});
    m.add("slide", Translational{.body_a = ground, .body_b = 1});
    m.add("spring", SpringDamper{.body_a = ground, .body_b = 1, .p_a = {-1, 0}, .stiffness = 1e6});
    m.add("friction",
          JointFriction{.joint = "slide", .guide = 0.2, .mu_s = 0.2, .mu_k = 0.2, .regularisation_speed = v});
    Machine machine(m);
    const auto found = modes_of(machine);
    const double half = 0.5 * 0.2 * g / v, root = half * half - 1e6;
    if (root < 0) {
      ASSERT_EQ(found.size(), 1U);
      EXPECT_NEAR(found[0].rate, -half, 1e-7 * half);
      EXPECT_NEAR(2 * pi * found[0].frequency, std::sqrt(-root), 1e-6);
    } else {
      ASSERT_EQ(found.size(), 2U) << v;
      const double fast = -half - std::sqrt(root), slow = 1e6 / fast;
      const double low = std::max(found[0].rate, found[1].rate), high = std::min(found[0].rate, found[1].rate);
      EXPECT_NEAR(low, slow, 1e-6 * std::abs(slow)) << v;
      EXPECT_NEAR(high, fast, 1e-7 * std::abs(fast)) << v;
    }
  }
}

/// A rod of 0.4 m from its pin to its centre, hanging.
Model pendulum(double mass) {
  Model m;
  m.add({.name = "rod", .mass = mass, .inertia = 0.05, .pose = {0, -0.4, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {0, 0.4}});
  return m;
}

void expect_stable(Machine& machine) {
  const auto found = modes(machine.system(), machine.time(), *machine.equilibrium());
  EXPECT_EQ(stability(found).kind, Stability::stable);
}

/// Largest acceleration of a body, or rate of a state, as the motion begins at the equilibrium: a steady state has
/// none.
double unrest(Machine& machine) {
  double most = machine.integrator().state().acceleration.cwiseAbs().maxCoeff();
  const MotionState& at = machine.integrator().state();
  for (Eigen::Index i = 0; i < at.states.size(); ++i) {
    const double scale = machine.system().state_scales()[static_cast<std::size_t>(i)] + std::abs(at.states[i]);
    most = std::max(most, std::abs(at.rates[machine.system().flow_count() + i]) / scale);
  }
  return most;
}

// At rest the current is u/R: sin(angle) = n K u/R over m g l.
TEST(SteadyStates, OfAMotorThatHoldsARod) {
  Model m = pendulum(1);
  m.add("motor", ElectricMotor{.body_a = ground,
                               .body_b = 1,
                               .torque_constant = 0.05,
                               .resistance = 1,
                               .inductance = 2e-3,
                               .ratio = 2,
                               .voltage = 12.0});
  Machine machine(m);
  machine.start_from_towing_equilibrium(0);
  EXPECT_NEAR(machine.body(1).angle, std::asin(1.2 / (g * 0.4)), 1e-10);
  EXPECT_NEAR(machine.force_value("motor", "current"), 12, 1e-9);
  EXPECT_LT(unrest(machine), 1e-7);
  expect_stable(machine);
}

/// A PID controller of the rod's angle by a moment on it.
Model controlled(double integral, double derivative) {
  Model m = pendulum(1.2);
  PidController c;
  c.input = input_of(AngleMeasure{.of = {.name = "rod", .body = 1}});
  c.measured_unit = "rad", c.output_unit = "N m";
  c.set_point = 1.5, c.proportional = 30, c.integral = integral, c.derivative = derivative, c.filter_time = 5e-3;
  m.add("controller", c);
  m.add("damper", RotationalSpringDamper{.body_a = ground, .body_b = 1, .stiffness = 0, .damping = 3});
  m.add("torque", AppliedForce{.body = 1, .controller = "controller", .controls = Controls::moment});
  return m;
}

// The integral carries the weight, so the error is 0; without one the error does, 30 (1.5 - a) = m g l sin a.
TEST(SteadyStates, OfControllersWithIntegralAndFilter) {
  for (const double derivative : {0.0, 3.0}) {
    Machine machine(controlled(40, derivative));
    machine.start_from_towing_equilibrium(0);
    EXPECT_NEAR(machine.body(1).angle, 1.5, 1e-10) << derivative;
    EXPECT_NEAR(machine.integrator().state().states[0], 1.2 * g * 0.4 * std::sin(1.5), 1e-8);
    EXPECT_LT(unrest(machine), 1e-7);
    expect_stable(machine);
  }
  Machine proportional(controlled(0, 3));
  proportional.start_from_towing_equilibrium(0);
  const double a = proportional.body(1).angle;
  EXPECT_NEAR(30 * (1.5 - a), 1.2 * g * 0.4 * std::sin(a), 1e-9);
}

/// A body on an arm of 1 m at `start` from the horizontal, on a pin, with a spring and a damper.
Model arm_at(double start) {
  Model m;
  m.add({.name = "arm", .mass = 1, .inertia = 0.1, .pose = {std::cos(start), std::sin(start), start}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-1, 0}});
  m.add("spring",
        RotationalSpringDamper{.body_a = ground, .body_b = 1, .stiffness = 20, .free_angle = 0, .damping = 1});
  m.add("torque", AppliedForce{.body = 1, .controller = "controller", .controls = Controls::moment});
  return m;
}

template <class C>
void measures_the_arm(C& c) {
  c.input = input_of(AngleMeasure{.of = {.name = "arm", .body = 1}});
  c.measured_unit = "rad", c.output_unit = "N m";
}

// x' = 0 does not depend on how slow a state is. An integral brings the angle to the set point, whatever its gain is
// and wherever the arm starts; how it is damped decides whether that is stable.
TEST(SteadyStates, DoNotDependOnAnIntegralsGain) {
  for (const double start : {0.0, 1.0, -1.2})
    for (const double integral : {1e-4, 1e-2, 0.1, 1.0, 10.0, 1e3}) {
      Model m = arm_at(start);
      PidController c;
      measures_the_arm(c);
      c.set_point = -0.3, c.proportional = 6.5, c.integral = integral;
      m.add("controller", c);
      Machine machine(m);
      machine.start_from_towing_equilibrium(0);
      EXPECT_NEAR(machine.body(1).angle, -0.3, 1e-9) << integral << " from " << start;
      const double moment = g * std::cos(0.3) - 20 * 0.3;  // that of the weight less the spring's
      EXPECT_NEAR(machine.integrator().state().states[0], moment, 1e-7) << integral;
      const auto found = modes(machine.system(), machine.time(), *machine.equilibrium());
      // (0.1 + 1) s^3 + s^2 + (26.5 + g sin 0.3) s + K_i: Routh.
      const double limit = (26.5 + g * std::sin(0.3)) / 1.1;
      EXPECT_EQ(stability(found).kind, integral < limit ? Stability::stable : Stability::unstable) << integral;
    }
}

// The lag of a low pass has no say either: -(20 + 10) a = g cos a.
TEST(SteadyStates, DoNotDependOnALag) {
  double a = 0;
  for (int i = 0; i < 60; ++i) a -= (30 * a + g * std::cos(a)) / (30 - g * std::sin(a));
  for (const double start : {0.0, 1.0, -1.2})
    for (const double lag : {1e-3, 1.0, 30.0, 1e3, 1e4}) {
      Model m = arm_at(start);
      TransferFunction c;
      measures_the_arm(c);
      c.numerator = {-10}, c.denominator = {lag, 1};
      m.add("controller", c);
      Machine machine(m);
      machine.start_from_towing_equilibrium(0);
      EXPECT_NEAR(machine.body(1).angle, a, 1e-9) << lag << " s from " << start;
      expect_stable(machine);
    }
}

// An integral that nothing brings to rest: there is no steady state, and the message names whose state runs away.
TEST(SteadyStates, OfAnIntegralWithoutEffectIsRefused) {
  Model m = controlled(40, 0);
  m.forces.erase(m.forces.begin() + 1);
  Machine machine(m);
  try {
    machine.start_from_towing_equilibrium(0);
    FAIL() << "found one";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("controller 'controller'"), std::string::npos) << error.what();
  }
}

/// An arm on a pin that a cylinder with a closed valve holds; its oil is at the tank's pressure, 0, at the start.
struct OilArm {
  static constexpr double start = 0.148889947609497, closed = 0.9, stroke = 0.6, dead = 1e-4, bulk = 1.4e9;
  static constexpr std::array<double, 2> foot{0.4, -0.9};
  HydraulicCylinder cylinder{};
  std::array<double, 2> head{}, centre{};  // in the axes of an arm at angle 0, from the pin

  OilArm() {
    const double c = std::cos(start), s = std::sin(start);
    const auto turned_back = [&](double x, double y) { return std::array<double, 2>{c * x + s * y, c * y - s * x}; };
    centre = turned_back(1, 0.15), head = turned_back(1.0, 0.15);
    cylinder.body_a = ground, cylinder.body_b = 1, cylinder.p_a = foot, cylinder.p_b = {0, 0};
    cylinder.bore = 0.05, cylinder.rod = 0.025, cylinder.closed = closed, cylinder.stroke = stroke;
    cylinder.supply = 12e6, cylinder.rated_flow = 5e-4, cylinder.dead = dead, cylinder.friction = 5e4;
    cylinder.valve = 0.;
  }
  Model model() const {
    Model m;
    m.add({.name = "arm", .mass = 80, .inertia = 27, .pose = {1, 0.15, start}});
    m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-centre[0], -centre[1]}});
    m.add("cylinder", cylinder);
    return m;
  }
  std::array<double, 2> at(const std::array<double, 2>& p, double angle) const {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * p[0] - s * p[1], s * p[0] + c * p[1]};
  }
  double length(double angle) const {
    const auto h = at(head, angle);
    return std::hypot(h[0] - foot[0], h[1] - foot[1]);
  }
  /// Moment of weight and oil: the cap side holds its oil, p = beta ln(V_0/V); the rod side, which grows, fills from
  /// the tank through its check valve.
  double moment(double angle) const {
    const auto h = at(head, angle);
    const double l = length(angle), area = cylinder.cap_area();
    const double p = bulk * std::log((dead + area * (length(start) - closed)) / (dead + area * (l - closed)));
    const double fx = p * area * (h[0] - foot[0]) / l, fy = p * area * (h[1] - foot[1]) / l;
    return h[0] * fy - h[1] * fx - 80 * g * at(centre, angle)[0];
  }
};

// The oil gives way by 0.3 mm. What is locked in follows the motion to the second order: 1e-3 of the volume, times 1e-4
// rad of sinking.
TEST(SteadyStates, OfOilThatAClosedValveLocksIn) {
  const OilArm arm;
  double low = 0.14, high = OilArm::start;
  for (int i = 0; i < 80; ++i) {
    const double middle = 0.5 * (low + high);
    (arm.moment(middle) > 0 ? low : high) = middle;
  }
  EXPECT_NEAR(low, 0.148725, 3e-6) << "of a motion that overshoots a little, and compresses the rod side by it";
  Machine machine(arm.model());
  machine.start_from_towing_equilibrium(0);
  EXPECT_NEAR(machine.body(1).angle, low, 1e-7);
  EXPECT_LT(unrest(machine), 1e-6);
  expect_stable(machine);
}

/// A cart that is drawn along, and an arm behind it with a wheel on the ground.
Model towed_wheel(double friction, double start_spin) {
  Model m;
  m.add({.name = "cart", .mass = 100, .inertia = 10, .pose = {0, 0.5, 0}, .velocity = {1.5, 0, 0}});
  m.add({.name = "arm", .mass = 50, .inertia = 5, .pose = {-0.5, 0.4, 0}, .velocity = {1.5, 0, 0}});
  m.add({.name = "wheel", .mass = 20, .inertia = 0.9, .pose = {-1, 0.3, 0}, .velocity = {1.5, 0, start_spin}});
  m.add("road", Translational{.body_a = ground, .body_b = 1, .p_a = {0, 0.5}});
  m.add("hinge", Revolute{.body_a = 1, .body_b = 2, .p_b = {0.5, 0.1}});
  m.add("axle", Revolute{.body_a = 2, .body_b = 3, .p_a = {-0.5, -0.1}});
  m.add("tow", CoordinateDriver{.body = 1, .coordinate = Coordinate::x, .motion = {.velocity = 1.5}});
  m.add("tyre",
        LineContact{
            .body_a = ground,
            .body_b = 3,
            .radius = 0.3,
            .law = {.normal = {.n = 1, .stiffness = 4e5, .damping = 1}, .friction = friction, .slip_speed = 0.01}});
  return m;
}

// The wheel rolls, whatever spin the tow begins with: no friction, so hinge, centre and axle, which are in line, give
// 45 kg of weight on it and the depth N/k.
TEST(SteadyStates, OfATowedWheelThatRolls) {
  for (const double spin : {-5.0, 0.0, 20.0}) {
    Machine machine(towed_wheel(0.5, spin));
    machine.start_from_towing_equilibrium(1.5);
    EXPECT_NEAR(machine.body(3).omega, -5, 1e-9) << spin;
    EXPECT_NEAR(machine.force_value("tyre", "normal force"), 45 * g, 1e-7);
    EXPECT_NEAR(machine.body(3).r.y, 0.3 - 45 * g / 4e5, 1e-11);
    EXPECT_NEAR(machine.force_value("tyre", "friction"), 0, 1e-7);
    EXPECT_LT(unrest(machine), 1e-6);
  }
}

// A bearing's friction mu N r is taken by the tyre's, mu N r/R, at a creep s with tanh(s/s_0) of it.
TEST(SteadyStates, OfATowedWheelWithFrictionInItsAxle) {
  Model m = towed_wheel(0.5, -5);
  m.add("bearing", JointFriction{.joint = "axle", .radius = 0.02, .mu_s = 0.1, .mu_k = 0.1});
  Machine machine(m);
  machine.start_from_towing_equilibrium(1.5);
  const double torque = machine.force_value("bearing", "torque"), drag = machine.force_value("tyre", "friction");
  EXPECT_GT(torque, 0.4) << "against the spin";
  EXPECT_NEAR(torque, -0.3 * drag, 1e-9);
  const double load = machine.force_value("bearing", "normal force");
  EXPECT_NEAR(torque, 0.1 * load * 0.02, 1e-9);
  EXPECT_NEAR(machine.force_value("tyre", "slip"),
              -0.01 * std::atanh(drag / (0.5 * machine.force_value("tyre", "normal force"))), 1e-9);
  EXPECT_LT(unrest(machine), 1e-6);
}

}  // namespace
}  // namespace subsoil::mbd::steady_states_test
