// Kinematics with inverse dynamics, static equilibria with their stability, modes with their shapes.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/equilibrium/equilibrium.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/measures/control_input.hpp"
#include "libmbd/measures/position.hpp"
#include "tests/tools/mechanisms.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::mbd::analyses_test {
namespace {

using std::numbers::pi;

using test::message_of;

// ---- kinematics ----------------------------------------------------------------------------------------------------

Model driven_slider_crank(double speed) {
  Model m = test::make_slider_crank(0);
  m.add("motor", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = speed}});
  return m;
}

// Two turns in steps of a tenth of a radian. Positions are roots of closed equations, so only rounding is left; the
// torque carries the rounding of accelerations (1e-14 of 1e2 m/s^2).
TEST(Kinematics, SliderCrankFollowsItsClosedFormWithItsTorque) {
  constexpr double speed = 20, r = 0.15, l = 0.5;
  Machine machine(driven_slider_crank(speed), {.integrator = IntegratorKind::kinematic});
  machine.start_from_pose();
  for (int i = 1; i <= 126; ++i) {
    machine.advance(0.005);
    const double a = 0.7 + speed * 0.005 * i, sine = r * std::sin(a), rod = std::sqrt(l * l - sine * sine);
    const BodyState& slider = machine.body(3);
    ASSERT_NEAR(slider.r.x, r * std::cos(a) + rod, 1e-13);
    ASSERT_NEAR(slider.v.x, -speed * (sine + sine * r * std::cos(a) / rod), 1e-11);
    const test::SliderCrankTerms terms = test::slider_crank_terms(a);
    ASSERT_NEAR(machine.driver_force("motor"), 0.5 * terms.mass_slope * speed * speed + terms.weight, 1e-10);
  }
  // Gauss's rule of order 6 in steps of 0.1 rad: (0.1)^6/2000 of some joules.
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-9);
}

// A sledge of 2 kg along a path of straight velocities: the driving force jumps at each corner, inside steps and at
// their ends. Work is the change of the kinetic energy, the polynomial of a part being of degree 1: rounding.
TEST(Kinematics, WorkOfADriverOverTheCornersOfATable) {
  for (const double step : {0.01, 0.025, 0.0017}) {
    Model m;
    m.add({.name = "sledge", .mass = 2, .inertia = 0.02, .velocity = {0.3, 0, 0}});
    m.add("rail", Translational{.body_a = ground, .body_b = 1});
    const TableFunction path({0, 0.025, 0.05, 0.075, 0.1}, {0.3, -0.4, 0.5, 0.45, -0.35}, false, Between::linear);
    m.add("motor", CoordinateDriver{.body = 1, .coordinate = Coordinate::x, .motion = {.velocity = path}});
    Machine machine(m, {.integrator = IntegratorKind::kinematic});
    machine.start_from_pose();
    for (int i = 1; i * step < 0.1; ++i) machine.advance(step);
    const double v = machine.body(1).v.x;
    EXPECT_NEAR(machine.energy().driver_work, v * v - 0.3 * 0.3, 1e-14) << step;
  }
}

// Three quarters of a turn between outputs: what Newton would make of that in one step is chance.
TEST(Kinematics, StaysOnItsBranchBetweenFarOutputs) {
  Machine machine(driven_slider_crank(20), {.integrator = IntegratorKind::kinematic});
  machine.start_from_pose();
  for (int i = 1; i <= 12; ++i) {
    machine.advance(0.25);
    const double a = 0.7 + 20 * 0.25 * i, sine = 0.15 * std::sin(a);
    ASSERT_NEAR(machine.body(3).r.x, 0.15 * std::cos(a) + std::sqrt(0.25 - sine * sine), 1e-12);
  }
}

TEST(Kinematics, CvodeStaysOnItTooWhenNothingIsFree) {
  Machine machine(driven_slider_crank(20), {.integrator = IntegratorKind::cvode});
  machine.start_from_pose();
  machine.advance(3.0);
  const double a = 0.7 + 60, sine = 0.15 * std::sin(a);
  EXPECT_NEAR(machine.body(3).r.x, 0.15 * std::cos(a) + std::sqrt(0.25 - sine * sine), 1e-12);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
}

TEST(Kinematics, RefusesAMachineThatIsNotDrivenAndNamesWhatIsFree) {
  Machine machine(test::make_slider_crank(), {.integrator = IntegratorKind::kinematic});
  const std::string text = message_of([&] { machine.start_from_pose(); });
  EXPECT_NE(text.find("1 of the machine's freedoms"), std::string::npos) << text;
  EXPECT_NE(text.find("crank."), std::string::npos) << text;
  EXPECT_NE(text.find("analysis: dynamics"), std::string::npos) << text;
}

/// A sledge of 1 kg driven at 0.3 m/s along two rails, one too many, pressed down by 30 N/s besides its weight.
Model sledge_on_two_rails(const JointEvent& event) {
  Model m;
  m.add({.name = "sledge", .mass = 1, .inertia = 0.02, .velocity = {0.3, 0, 0}});
  m.add("rail", Translational{.body_a = ground, .body_b = 1});
  m.add("second rail", Translational{.body_a = ground, .body_b = 1});
  m.add("motor", CoordinateDriver{.body = 1, .coordinate = Coordinate::x, .motion = {.velocity = 0.3}});
  m.add("load", AppliedForce{.body = 1, .fy = PolynomialFunction{{0, -30}}});
  m.add("free", event);
  return m;
}

// The rails share the load until the second lets go; by a time, a place, or half the load, (9.81 + 30 t)/2 N.
TEST(Kinematics, EventsOfJointsHappenWhenTheyAreDue) {
  constexpr double g = 9.81, place = 0.145, limit = 12;
  const auto at_x = input_of(PositionMeasure{.of = {.name = "sledge", .body = 1}, .part = VectorPart::x});
  const auto opens = [](JointEvent e) { return e.joint = "second rail", e.does = JointEvent::Does::opens, e; };
  const std::pair<JointEvent, double> cases[] = {
      {opens({.at = 0.433}), 0.433},
      {opens({.input = at_x, .above = place}), place / 0.3},
      {opens({.reaction_above = limit}), (2 * limit - g) / 30},
  };
  for (const auto& [event, due] : cases) {
    Machine machine(sledge_on_two_rails(event), {.integrator = IntegratorKind::kinematic});
    machine.start_from_pose();
    for (int k = 1; k <= 20; ++k) {
      machine.advance(0.05);
      const double t = 0.05 * k, load = g + 30 * t;
      ASSERT_NEAR(machine.body(1).r.x, 0.3 * t, 1e-12);
      ASSERT_NEAR(machine.joint_reaction("rail").fy, t > due ? -load : -load / 2, 1e-9) << t << " of " << due;
    }
    ASSERT_EQ(machine.events().size(), 1U);
    EXPECT_NEAR(machine.events()[0].t, due, 1e-9);
  }
}

// ---- start poses ---------------------------------------------------------------------------------------------------

TEST(Assemble, No_RefusesAnOpenPoseNamingTheJoint) {
  Model m = test::make_slider_crank();
  m.bodies[2].pose[0] += 1e-6;
  Machine closed(m);
  EXPECT_NO_THROW(closed.start_from_pose());
  Machine as_given(m, {.assemble = false});
  const std::string text = message_of([&] { as_given.start_from_pose(); });
  EXPECT_NE(text.find("joint 'B' by -1e-06 m"), std::string::npos) << text;
  EXPECT_NE(text.find("let the program assemble it"), std::string::npos) << text;
  Machine good(test::make_slider_crank(), {.assemble = false});
  EXPECT_NO_THROW(good.start_from_pose());
}

// ---- equilibria ----------------------------------------------------------------------------------------------------

StabilityReport stability_of(Machine& machine) {
  return stability(modes(machine.system(), machine.time(), *machine.equilibrium()));
}

// From any start that is not the upright itself three rods come to hang; their pins carry what is below.
TEST(StaticEquilibrium, ThreeRodsHang) {
  Machine machine(test::make_chain(3));
  machine.start_from_towing_equilibrium(0);
  for (int i = 1; i <= 3; ++i) {
    EXPECT_NEAR(std::remainder(machine.body(i).angle + pi / 2, 2 * pi), 0, 1e-9) << i;
    EXPECT_NEAR(machine.body(i).r.y, 0.5 - i, 1e-9) << i;
    EXPECT_NEAR(std::abs(machine.joint_reaction("pin " + std::to_string(i)).fy), (4 - i) * 9.81, 1e-9) << i;
  }
  const StabilityReport report = stability_of(machine);
  EXPECT_EQ(report.kind, Stability::stable);
  EXPECT_EQ(report.unstable, 0);
}

TEST(StaticEquilibrium, AnUprightRodIsUnstableInOneDirection) {
  Model m;
  const int rod = test::add_rod(m, "rod", {0, 0}, {0, 1}, 1);
  m.add("pin", test::pin_at(m, ground, rod, {0, 0}));
  Machine machine(m);
  machine.start_from_towing_equilibrium(0);
  EXPECT_NEAR(machine.body(rod).angle, pi / 2, 1e-12);
  const auto found = modes(machine.system(), 0, *machine.equilibrium());
  const StabilityReport report = stability(found);
  EXPECT_EQ(report.kind, Stability::unstable);
  EXPECT_EQ(report.unstable, 1);
  // a'' = (3/2) g a: real roots of both signs.
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(std::abs(found[0].rate), std::sqrt(1.5 * 9.81), 1e-8);
}

TEST(StaticEquilibrium, ABalancedWheelIsNeutral) {
  Model m;
  m.add({.name = "wheel", .mass = 3, .inertia = 0.1, .pose = {0.2, 0.4, 0.3}});
  m.add("axle", Revolute{.body_a = ground, .body_b = 1, .p_a = {0.2, 0.4}});
  Machine machine(m);
  machine.start_from_towing_equilibrium(0);
  EXPECT_NEAR(machine.body(1).angle, 0.3, 1e-12) << "it stays where it was put";
  const StabilityReport report = stability_of(machine);
  EXPECT_EQ(report.kind, Stability::neutral);
  EXPECT_EQ(report.neutral, 1);
}

// Without joints and drivers every body has the towing speed, and stays where it is.
TEST(StaticEquilibrium, OfAMachineWithoutConstraintsInTow) {
  Model m;
  m.gravity = {0, 0};
  const int body = m.add({.name = "body", .mass = 2, .inertia = 0.1, .pose = {0.1, 0.2, 0.3}});
  Machine machine(m);
  machine.start_from_towing_equilibrium(0.7);
  EXPECT_EQ(machine.body(body).v.x, 0.7);
  EXPECT_EQ(machine.body(body).v.y, 0);
  EXPECT_EQ(machine.body(body).omega, 0);
  EXPECT_EQ(machine.body(body).r.y, 0.2);
}

TEST(StaticEquilibrium, RefusesADriverThatMoves) {
  Machine machine(driven_slider_crank(3));
  const std::string text = message_of([&] { machine.start_from_towing_equilibrium(0); });
  EXPECT_NE(text.find("driver 'motor' moves (at 3.0"), std::string::npos) << text;
}

// ---- modes ---------------------------------------------------------------------------------------------------------

constexpr double mass = 2, stiffness = 800, damping = 4;

/// wall - spring - mass - spring - mass - spring - wall, with dampers beside the springs.
Model two_masses(double c) {
  Model m;
  m.gravity = {0, 0};
  for (int i = 0; i < 2; ++i) {
    const int body = m.add({.name = i ? "right" : "left", .mass = mass, .inertia = 1, .pose = {1.0 + i, 0, 0}});
    m.add(i ? "right rail" : "left rail", Translational{.body_a = ground, .body_b = body});
  }
  const auto spring = [&](const char* name, int a, int b, double at_a, double at_b) {
    m.add(name,
          SpringDamper{
              .body_a = a, .body_b = b, .p_a = {at_a, 0}, .p_b = {at_b, 0}, .stiffness = stiffness, .damping = c});
  };
  spring("first", ground, 1, 0, 0);
  spring("middle", 1, 2, 0, 0);
  spring("last", 2, ground, 0, 3);
  return m;
}

// k/m and 3 k/m, in phase and against each other; damping ratios c w/(2 k).
TEST(Modes, TwoMassesSwingTogetherAndAgainstEachOther) {
  Machine machine(two_masses(damping));
  machine.start_from_towing_equilibrium(0);
  const auto found = modes(machine.system(), 0, *machine.equilibrium());
  ASSERT_EQ(found.size(), 2U);
  for (int i = 0; i < 2; ++i) {
    const Mode& mode = found[static_cast<std::size_t>(i)];
    const double w = std::sqrt((i ? 3 : 1) * stiffness / mass), ratio = damping * w / (2 * stiffness);
    EXPECT_NEAR(mode.frequency, w * std::sqrt(1 - ratio * ratio) / (2 * pi), 1e-8);
    EXPECT_NEAR(mode.damping, ratio, 1e-8);
    ASSERT_EQ(mode.shape.size(), 6);
    const std::complex<double> quotient = mode.shape[3] / mode.shape[0];
    EXPECT_NEAR(quotient.real(), i ? -1 : 1, 1e-8);
    EXPECT_NEAR(quotient.imag(), 0, 1e-8);
    EXPECT_NEAR(mode.shape.cwiseAbs().maxCoeff(), 1, 1e-12);
  }
}

// Dependent coordinates follow: the centre of a hanging rod moves sideways by half its length times the angle.
// A soft spring to the ground and a hard one between two masses: rounding in the hard one hides the soft one sooner or
// later. Then the zero comes with the frequency below which it may be held. Squares of both: (1 + 2 K +- sqrt(1 + 4
// K^2))/2.
TEST(Modes, ASoftSpringBesideAHardOneIsFoundOrItsBoundIs) {
  for (const double stiffness : {1e3, 1e6, 1e9, 1e10, 1e11, 1e13}) {
    const double square = 0.5 * (1 + 2 * stiffness + std::sqrt(1 + 4 * stiffness * stiffness));
    const double hard = std::sqrt(square), soft = std::sqrt(stiffness / square);
    Model m;
    m.gravity = {0, 0};
    for (const int body : {1, 2}) {
      const std::string number = std::to_string(body);
      m.add({.name = "mass " + number, .mass = 1, .inertia = 1, .pose = {1.0 * body, 0, 0}});
      m.add("rail " + number, Translational{.body_a = ground, .body_b = body, .p_a = {1.0 * body, 0}});
      m.add("spring " + number,
            SpringDamper{.body_a = body - 1, .body_b = body, .stiffness = body == 1 ? 1 : stiffness});
    }
    Machine machine(m);
    machine.start_from_towing_equilibrium(0);
    const auto found = modes(machine.system(), 0, *machine.equilibrium());
    ASSERT_EQ(found.size(), 2U) << stiffness;
    if (found[0].is_zero())
      EXPECT_GT(found[0].error, soft) << stiffness;
    else
      EXPECT_NEAR(2 * pi * found[0].frequency, soft, found[0].error) << stiffness;
    EXPECT_NEAR(2 * pi * found[1].frequency, hard, 1e-7 * hard);
  }
}

TEST(Modes, ShapesHoldDependentCoordinates) {
  Machine machine(test::make_chain(1));
  machine.start_from_towing_equilibrium(0);
  const auto found = modes(machine.system(), 0, *machine.equilibrium());
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].frequency, std::sqrt(1.5 * 9.81) / (2 * pi), 1e-8);
  EXPECT_NEAR(std::abs(found[0].shape[0] / found[0].shape[2]), 0.5, 1e-9);
  EXPECT_NEAR(std::abs(found[0].shape[1]), 0, 1e-9);
}

}  // namespace
}  // namespace subsoil::mbd::analyses_test
