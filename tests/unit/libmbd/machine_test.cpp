#include "libmbd/machine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"
#include "libmbd/integrators/adaptive.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/rig.hpp"

namespace subsoil::mbd::machine_test {
namespace {

std::string refusal(auto action) { return test::message_of(action); }

class AnyIntegrator : public testing::TestWithParam<IntegratorKind> {
 protected:
  MachineOptions options() const { return {.integrator = GetParam(), .ida = {.rtol = 1e-10, .atol = 1e-11}}; }
};
INSTANTIATE_TEST_SUITE_P(Both, AnyIntegrator, testing::Values(IntegratorKind::adams_moulton, IntegratorKind::ida));

// Without constraints nothing is dependent; a thrown body follows its parabola, exact for a method of order 2 and more.
TEST_P(AnyIntegrator, FreeBodyFliesOnAParabola) {
  Model m;
  m.add({.name = "stone", .mass = 2, .inertia = 1, .pose = {0, 1, 0}, .velocity = {3, 4, 5}});
  Machine machine(m, options());
  machine.start_from_pose();
  for (int i = 0; i < 100; ++i) machine.advance(0.01);
  EXPECT_NEAR(machine.body(1).r.x, 3, 1e-8);
  EXPECT_NEAR(machine.body(1).r.y, 1 + 4 - 9.81 / 2, 1e-8);
  EXPECT_NEAR(machine.body(1).angle, 5, 1e-8);
  EXPECT_NEAR(machine.time(), 1, 1e-14);
  std::vector<double> values(machine.column_names().size());
  machine.columns(values);
  EXPECT_EQ(machine.column_names()[7], "stone.ay");
  EXPECT_EQ(machine.column_units()[7], "m/s^2");
  EXPECT_NEAR(values[6], 0, 1e-15);
  EXPECT_NEAR(values[7], -9.81, 1e-15);
  EXPECT_EQ(machine.column_names()[8], "stone.alpha");
  EXPECT_NEAR(values[8], 0, 1e-15);
}

// Places that are read or moved are rounded: a rail through a centre of gravity may miss it by 1e-18 m, or 1e-13 m a
// kilometre from the origin. That is no length of the machine, and the body slides as on the rail through the centre.
TEST_P(AnyIntegrator, RoundingOfAPlaceIsNoLengthOfTheMachine) {
  for (const double off : {0.0, 2e-18, 2e-13}) {
    Model m;
    m.add({.name = "block", .mass = 0.3, .inertia = 0.01, .velocity = {-0.8, -0.6}});
    m.add("rail",
          Translational{.body_a = 0, .body_b = 1, .p_a = {0, 0}, .p_b = {off, 0}, .angle_a = std::atan2(-0.6, -0.8)});
    Machine machine(m, options());
    machine.start_from_pose();
    EXPECT_EQ(machine.system().length_scale(), std::sqrt(0.01 / 0.3)) << off << ": the radius of gyration";
    for (int i = 0; i < 100; ++i) machine.advance(1e-4);
    // v t + a t^2/2 along the rail, a = 9.81 * 0.6
    EXPECT_NEAR(machine.body(1).r.x, -0.8 * (0.01 + 0.5 * 9.81 * 0.6 * 1e-4), 1e-9) << off;
  }
}

// Two bodies joined by a pin and a spring-damper to a third, no gravity, nothing from outside.
TEST_P(AnyIntegrator, KeepsLinearAndAngularMomentum) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "a", .mass = 2, .inertia = 0.1, .pose = {0, 0, 0}, .velocity = {0.3, 0, 1}});
  m.add({.name = "b", .mass = 1, .inertia = 0.2, .pose = {1, 0, 0}, .velocity = {0, 0.8, -1}});
  m.add({.name = "c", .mass = 3, .inertia = 0.3, .pose = {1.5, 1, 0}, .velocity = {-0.4, 0, 2}});
  m.add("pin", Revolute{.body_a = 1, .body_b = 2, .p_a = {0.5, 0}, .p_b = {-0.5, 0}});
  m.add("spring",
        SpringDamper{.body_a = 2, .body_b = 3, .p_a = {0.2, 0.1}, .p_b = {0, -0.3}, .stiffness = 50, .damping = 2});
  Machine machine(m, options());
  machine.start_from_pose();
  const auto momentum = [&] {
    std::array<double, 3> sum{};
    for (int i = 1; i < 4; ++i) {
      const auto& data = m.bodies[static_cast<std::size_t>(i - 1)];
      const BodyState& b = machine.body(i);
      sum[0] += data.mass * b.v.x, sum[1] += data.mass * b.v.y;
      sum[2] += data.mass * cross(b.r, b.v) + data.inertia * b.omega;
    }
    return sum;
  };
  const auto before = momentum();
  for (int i = 0; i < 2000; ++i) machine.advance(1e-3);
  const auto after = momentum();
  // Partitioned bodies feel their reactions through the constraints, so angular momentum is kept to the order of the
  // method, not to rounding; linear momentum is a linear invariant of both.
  EXPECT_NEAR(after[0], before[0], 1e-8);
  EXPECT_NEAR(after[1], before[1], 1e-8);
  EXPECT_NEAR(after[2], before[2], 1e-7);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-7);
  EXPECT_GT(machine.energy().lost, 0.01);
}

// The rig dropped from its printed pose onto the ground and driven: every kind of energy flows. With one dissipation
// left out the balance must not close.
TEST_P(AnyIntegrator, EnergyBalanceOfTheDroppedRigCloses) {
  const auto rig = test::make_rig({.raise = 0.125, .rearward = 500, .downward = 100});
  Machine machine(rig.model, options());
  machine.start_from_pose();
  machine.set_external_wrench(rig.shovel, -80, 40, 15);
  for (int i = 0; i < 2000; ++i) machine.advance(2e-4);
  const MachineEnergy e = machine.energy();
  EXPECT_GT(e.driver_work, 50);
  EXPECT_LT(e.force_work, -50);
  EXPECT_NE(e.external_work, 0);
  EXPECT_NEAR(e.balance(), 0, 1e-6 * e.driver_work);
  MachineEnergy dropped = e;
  dropped.lost -= machine.integrator().flows().of_elements[0];  // the damper of H9
  EXPECT_GT(std::abs(dropped.balance()), 1e-3);
}

// Work of an external wrench: constant force times displacement.
TEST_P(AnyIntegrator, ExternalWrenchActsAtTheCentreAndItsWorkIsAccumulated) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "sled", .mass = 4, .inertia = 0.5});
  Machine machine(m, options());
  machine.start_from_pose();
  machine.set_external_wrench(1, 8, -4, 0.25);
  for (int i = 0; i < 100; ++i) machine.advance(0.01);
  EXPECT_NEAR(machine.body(1).r.x, 1.0, 1e-9);
  EXPECT_NEAR(machine.body(1).r.y, -0.5, 1e-9);
  EXPECT_NEAR(machine.body(1).angle, 0.25, 1e-9);
  EXPECT_NEAR(machine.energy().external_work, 8 * 1.0 + 4 * 0.5 + 0.25 * 0.25, 1e-7);
  machine.set_external_wrench(1, 0, 0, 0);
  machine.advance(0.01);
  EXPECT_NEAR(machine.body(1).v.x, 2, 1e-8);  // a jump of the wrench leaves no tail
}

TEST_P(AnyIntegrator, SnapshotContinuesTheRun) {
  const auto rig = test::make_rig({.raise = 0.125, .rearward = 300});
  Machine whole(rig.model, options()), second(rig.model, options());
  whole.start_from_pose();
  const auto go = [&](Machine& machine, int from, int to) {
    for (int i = from; i < to; ++i) {
      machine.set_external_wrench(rig.shovel, -200 * std::sin(0.1 * i), 30, 5);
      machine.advance(5e-4);
    }
  };
  go(whole, 0, 30);
  second.restore(whole.snapshot());
  go(whole, 30, 60);
  go(second, 30, 60);
  std::vector<double> a(whole.column_names().size()), b = a;
  whole.columns(a), second.columns(b);
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_NEAR(a[i], b[i], 1e-7 * (1 + std::abs(a[i]))) << whole.column_names()[i];
  EXPECT_EQ(whole.time(), second.time());
}

TEST(Machine, SnapshotOfAnotherMachineIsRefused) {
  Model one;
  one.add({.name = "stone", .mass = 2, .inertia = 1});
  Machine small(one), large(test::make_rig().model);
  small.start_from_pose(), large.start_from_pose();
  EXPECT_EQ(refusal([&] { small.restore(Snapshot{}); }),
            "restart: the state has 0 numbers of pose, this machine has 3");
  for (const bool to_large : {false, true}) {
    const std::string refused =
        refusal([&] { to_large ? large.restore(small.snapshot()) : small.restore(large.snapshot()); });
    EXPECT_TRUE(refused.starts_with("restart: the state has ")) << refused;
    EXPECT_NE(refused.find(" numbers of pose, this machine has "), std::string::npos) << refused;
  }
}

TEST(Machine, ColumnsHaveNamesUnitsAndValues) {
  const auto rig = test::make_rig({.rearward = 700, .downward = 280});
  Machine machine(rig.model);
  machine.start_from_towing_equilibrium(0.5);
  const auto& names = machine.column_names();
  ASSERT_EQ(names.size(), machine.column_units().size());
  std::vector<double> values(names.size());
  machine.columns(values);
  const auto value = [&](const std::string& name) {
    return values[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin())];
  };
  EXPECT_EQ(value("H10.force"), machine.driver_force("H10"));
  EXPECT_EQ(value("H9.force"), machine.force_value("H9", "force"));
  EXPECT_EQ(value("H8.fx"), machine.joint_reaction("H8").fx);
  EXPECT_EQ(value("shovel.angle"), machine.body(rig.shovel).angle);
  EXPECT_EQ(value("left wheel on soil.sinkage"), machine.force_value("left wheel on soil", "sinkage"));
}

TEST(Machine, RefusalsNameWhatRuleAndCure) {
  const auto with = [](auto change) {
    Model m;
    m.add({.name = "a", .mass = 1, .inertia = 1});
    m.add({.name = "b", .mass = 1, .inertia = 1});
    change(m);
    return refusal([&] { Machine machine(m); });
  };
  EXPECT_EQ(with([](Model& m) { m.bodies[1].mass = -2; }),
            "body 'b': mass = -2.000000 kg: must be in (0, inf); a planar body needs both mass and inertia");
  EXPECT_EQ(with([](Model& m) { m.bodies[1].name = "a"; }),
            "body 'a': the name is taken; every body needs its own (ground is the ground's)");
  EXPECT_EQ(with([](Model& m) { m.add("pin", Revolute{.body_a = 1, .body_b = 7}); }),
            "joint 'pin': body index 7 does not exist; there are 2 bodies and the ground (0)");
  EXPECT_EQ(with([](Model& m) { m.add("pin", Revolute{.body_a = 1, .body_b = 1}); }),
            "joint 'pin' connects 'a' to itself; name two different bodies");
  EXPECT_EQ(with([](Model& m) { m.add("motor", AngleDriver{.first = 0, .second = 1}); }),
            "driver 'motor': needs exactly one of position, velocity and acceleration as a function of time; give one, "
            "leave the others out");
  EXPECT_EQ(with([](Model& m) { m.add("s", SpringDamper{.body_a = 1, .body_b = 2}); }),
            "force 's': stiffness and damping must be given and not negative; stiffness 0 is a damper alone");
  EXPECT_EQ(
      with([](Model& m) { m.add("w", WheelOnSoil{.body = 1}); }),
      "force 'w': radius and width must be above 0, n in (0, 3), k_c and k_phi not negative; all five must be given");
  EXPECT_EQ(refusal([] { Machine machine(Model{}); }),
            "machine without bodies; give at least one body with mass and inertia");
  Machine rig(test::make_rig().model);
  rig.start_from_pose();
  EXPECT_EQ(refusal([&] { rig.joint_reaction("H11"); }), "no joint 'H11'; there are H1, H2, H3, H4, H5, H6, H7, H8");
  EXPECT_EQ(refusal([&] { rig.force_value("H9", "torque"); }),
            "force 'H9' reports no 'torque'; it reports force, length, damper force");
  EXPECT_EQ(
      refusal([&] { rig.body_index("plough"); }),
      "no body 'plough'; there are ground, shovel, left wheel, right wheel, lower link, trolley, upper link, frame");
  EXPECT_EQ(refusal([&] { rig.advance(0); }), "machine step = 0.000000 s: must be above 0");
  EXPECT_EQ(refusal([] { Machine machine(test::make_rig().model, {.adams_moulton = {.order = 7}}); }),
            "adams-moulton order = 7: must be in [1, 6]");
}

// Two links that meet 0.2 rad above the line of their pins bear a load and do not move, beside a singular configuration
// that they do not come nearer to: a method takes the steps of what swings beside them, and no other.
TEST(Machine, ATrussThatStandsChangesNoStep) {
  for (const IntegratorKind kind : {IntegratorKind::cvode, IntegratorKind::ida})
    for (const bool far : {false, true}) {
      SCOPED_TRACE(testing::Message() << (kind == IntegratorKind::ida ? "ida" : "cvode") << (far ? " far" : ""));
      const double x = far ? 317.3 : 0, c = std::cos(0.2), s = std::sin(0.2);
      const auto swing = [&](bool truss) {
        Model m;
        m.add({.name = "rod", .mass = 3, .inertia = 0.25, .pose = {x + 0.5, 0, 0}});
        m.add("pin", Revolute{.body_a = 0, .body_b = 1, .p_a = {x, 0}, .p_b = {-0.5, 0}});
        if (truss) {
          m.add({.name = "one", .mass = 2, .inertia = 0.2, .pose = {x + 0.5 * c, 1 + 0.5 * s, 0.2}});
          m.add({.name = "two", .mass = 2, .inertia = 0.2, .pose = {x + 1.5 * c, 1 + 0.5 * s, -0.2}});
          m.add("a", Revolute{.body_a = 0, .body_b = 2, .p_a = {x, 1}, .p_b = {-0.5, 0}});
          m.add("b", Revolute{.body_a = 2, .body_b = 3, .p_a = {0.5, 0}, .p_b = {-0.5, 0}});
          m.add("c", Revolute{.body_a = 0, .body_b = 3, .p_a = {x + 2 * c, 1}, .p_b = {0.5, 0}});
        }
        Machine machine(m, {.integrator = kind});
        machine.start_from_pose();
        for (int k = 0; k < 200; ++k) machine.advance(0.01);
        return std::pair(dynamic_cast<const Adaptive&>(machine.integrator()).steps(), machine.body(1).angle);
      };
      const auto alone = swing(false), beside = swing(true);
      EXPECT_NEAR(beside.second, alone.second, 1e-6);
      // ida holds all coordinates in one norm, in which those that rest count too.
      const long share = kind == IntegratorKind::ida ? alone.first / 5 : 0;
      EXPECT_LE(std::abs(beside.first - alone.first), share) << alone.first;
    }
}

TEST(Machine, EndOfTravelNamesTheJoint) {
  // A slider-crank whose slider is pulled beyond the stretched linkage.
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "crank", .mass = 1, .inertia = 1, .pose = {0.15, 0.26, std::acos(0.5)}});
  m.add({.name = "rod", .mass = 1, .inertia = 1, .pose = {0.6, 0.25, -0.5}});
  m.add({.name = "slider", .mass = 1, .inertia = 1, .pose = {1.0, 0, 0}});
  m.add("A", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.3, 0}});
  m.add("B", Revolute{.body_a = 1, .body_b = 2, .p_a = {0.3, 0}, .p_b = {-0.5, 0}});
  m.add("C", Revolute{.body_a = 2, .body_b = 3, .p_a = {0.5, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = 3});
  m.add("puller", CoordinateDriver{.body = 3, .coordinate = Coordinate::x, .motion = {.velocity = 1.0}});
  Machine machine(m);
  machine.start_from_pose();
  const std::string text = refusal([&] {
    for (int i = 0; i < 1000; ++i) machine.advance(1e-3);
  });
  EXPECT_EQ(text.find("the joints cannot be kept closed at t = "), 0U) << text;
  EXPECT_NE(text.find("beyond which driver 'puller' leads"), std::string::npos) << text;
}

}  // namespace
}  // namespace subsoil::mbd::machine_test
