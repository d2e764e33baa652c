// The rig 1S-300: steady towing equilibria, joint forces and small oscillations of rig-1s300.md, to the printed digits.

#include "tests/tools/rig.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/tools/verified.hpp"

namespace subsoil::mbd::rig_test {
namespace {

using subsoil::test::absolute;
using subsoil::test::Verified;

const std::string kField = "Machines";
const std::string kRig = "the rig's equations solved beforehand, to the printed digits";

struct Printed {
  double h, v, phi1, phi7, cg, tip, sinkage, wheel, spring, pull;
};
constexpr Printed table[] = {
    {0, 0, -.04822, .00236, .2093, -.2969, .0282, 805.1, 7.8, 328.9},
    {363, 145, -.06779, .00243, .2080, -.3023, .0294, 864.9, 875.7, 723.4},
    {700, 280, -.08590, .00249, .2070, -.3071, .0304, 920.4, 1677.2, 1090.1},
    {1000, 400, -.10196, .00254, .2061, -.3112, .0313, 969.4, 2387.2, 1416.8},
    {1492, 600, -.12826, .00261, .2048, -.3173, .0327, 1050.9, 3546.0, 1954.1},
};

class RigTable : public testing::TestWithParam<Printed> {};

// Half a unit of the last printed digit, and a hair for the table's own rounding.
TEST_P(RigTable, EquilibriumToThePrintedDigits) {
  const Printed& row = GetParam();
  const auto rig = test::make_rig({.rearward = row.h, .downward = row.v});
  Machine machine(rig.model);
  machine.start_from_towing_equilibrium(0.5);
  const BodyState& shovel = machine.body(rig.shovel);
  const Verified found(kField, "Rig 1S-300 towed at 0.5 m/s: steady equilibria", kRig);
  char load[48];
  std::snprintf(load, sizeof load, ", load %g/%g N", row.h, row.v);
  const auto near = [&](const char* quantity, const char* unit, double ours, double printed, double half) {
    found.near(std::string(quantity) + load, unit, ours, printed, absolute(half), "half a unit of the last digit");
  };
  near("pitch of the shovel", "rad", shovel.angle, row.phi1, 0.51e-5);
  near("pitch of the frame", "rad", machine.body(rig.frame).angle, row.phi7, 0.51e-5);
  near("height of the shovel's centre of mass", "m", shovel.r.y, row.cg, 0.51e-4);
  near("height of the tip", "m", shovel.r.y + shovel.vector_in_world({.244, -.495}).y, row.tip, 0.51e-4);
  near("force of the spring", "N", machine.force_value("H9", "force"), row.spring, 0.051);
  near("pull", "N", machine.driver_force("H10"), row.pull, 0.051);
  double resistance = 0;
  for (const char* wheel : {"left wheel on soil", "right wheel on soil"}) {
    near((std::string("sinkage, ") + wheel).c_str(), "m", machine.force_value(wheel, "sinkage"), row.sinkage, 0.51e-4);
    near((std::string("normal force, ") + wheel).c_str(), "N", machine.force_value(wheel, "N"), row.wheel, 0.051);
    resistance += machine.force_value(wheel, "R_c");
  }
  EXPECT_NEAR(machine.driver_force("H10"), row.h + resistance, 1e-8);
}
INSTANTIATE_TEST_SUITE_P(Rows, RigTable, testing::ValuesIn(table));

TEST(Rig, JointForcesAtThe700Load) {
  const auto rig = test::make_rig({.rearward = 700, .downward = 280});
  Machine machine(rig.model);
  machine.start_from_towing_equilibrium(0.5);
  const struct {
    const char* joint;
    double fx, fy;
  } printed[] = {{"H2", -200.4, -47.3}, {"H3", -889.7, -69.4}, {"H4", -200.4, 29.2},   {"H5", -889.7, 28.7},
                 {"H6", 195.1, -675.1}, {"H7", 195.1, -675.1}, {"H8", -2377.1, -635.1}};
  for (const auto& row : printed) {
    const Reaction r = machine.joint_reaction(row.joint);
    const Verified found(kField, "Rig 1S-300: joint forces at 700/280 N", kRig);
    const char* const digit = "half a unit of the last digit";
    found.near(std::string(row.joint) + ", along x", "N", r.fx, row.fx, absolute(0.051), digit);
    found.near(std::string(row.joint) + ", along y", "N", r.fy, row.fy, absolute(0.051), digit);
    EXPECT_NEAR(r.moment, 0, 1e-9) << row.joint;  // a pin carries none
  }
}

std::vector<Mode> rig_modes(double h, double v, double damping) {
  const auto rig = test::make_rig({.damping = damping, .rearward = h, .downward = v});
  System system(rig.model);
  return modes(system, 0, towing_equilibrium(system, 0, system.start_position(), 0.5));
}

// Printed to 1e-3 Hz; "modes 4.080 and 8.558 Hz at 700/280 to 1e-3".
TEST(Rig, ModesUndamped) {
  const auto loaded = rig_modes(700, 280, 0), empty = rig_modes(0, 0, 0);
  ASSERT_EQ(loaded.size(), 4U);
  EXPECT_EQ(loaded[0].frequency, 0);  // the wheels' spins
  EXPECT_EQ(loaded[1].frequency, 0);
  const Verified found(kField, "Rig 1S-300: small oscillation", kRig);
  const char* const digit = "printed to 1e-3 Hz";
  found.near("first mode, load 700/280 N", "Hz", loaded[2].frequency, 4.080, absolute(1e-3), digit);
  found.near("second mode, load 700/280 N", "Hz", loaded[3].frequency, 8.558, absolute(1e-3), digit);
  found.near("first mode, no load", "Hz", empty[2].frequency, 3.940, absolute(1e-3), digit);
  found.near("second mode, no load", "Hz", empty[3].frequency, 8.557, absolute(1e-3), digit);
  EXPECT_NEAR(loaded[2].damping, 0, 1e-6);
  EXPECT_NEAR(loaded[3].damping, 0, 1e-6);
}

TEST(Rig, DampingRatios) {
  const auto loaded = rig_modes(700, 280, 611);
  ASSERT_EQ(loaded.size(), 4U);
  const Verified found(kField, "Rig 1S-300: damping of the modes, 611 N s/m", kRig);
  const char* const digit = "half a unit of the last digit";
  found.near("damping ratio of the first mode", "1", loaded[2].damping, 0.000, absolute(0.51e-3), digit);
  found.near("damping ratio of the second mode", "1", loaded[3].damping, 0.099, absolute(0.51e-3), digit);
}

// What was found steady must stay where it is for half a second, two cycles of heave: a wrong velocity or load would
// set it swinging. The solver leaves 1e-12 of the weight, the integrator adds nothing to a steady state.
TEST(Rig, EquilibriumStaysWhereItIs) {
  const auto rig = test::make_rig({.raise = 0.125, .rearward = 400, .downward = 100});
  Machine machine(rig.model);
  machine.start_from_towing_equilibrium(0.5);
  const double angle = machine.body(rig.shovel).angle, height = machine.body(rig.shovel).r.y;
  for (int i = 0; i < 5000; ++i) machine.advance(1e-4);
  EXPECT_NEAR(machine.body(rig.shovel).angle, angle, 1e-9);
  EXPECT_NEAR(machine.body(rig.shovel).r.y, height, 1e-9);
  EXPECT_NEAR(machine.body(rig.trolley).r.x, 0.2 + 0.25, 1e-12);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-9);
  EXPECT_NEAR(machine.energy().driver_work, 0.25 * machine.driver_force("H10"), 1e-8);
}

// The working depth of the scenarios: 0.18 m under load (rig-1s300.md), quasi-static.
TEST(Rig, RaisedVariantWorksAt18Centimetres) {
  const auto rig = test::make_rig({.raise = 0.125, .rearward = 700, .downward = 280});
  Machine machine(rig.model);
  machine.start_from_towing_equilibrium(0.5);
  const BodyState& shovel = machine.body(rig.shovel);
  EXPECT_NEAR(shovel.r.y + shovel.vector_in_world({.244, -.495}).y, -0.18, 0.005);
}

TEST(Rig, HoldsTheDriverToTheTowingSpeed) {
  const auto rig = test::make_rig();
  Machine machine(rig.model);
  try {
    machine.start_from_towing_equilibrium(0.8);
    FAIL() << "a trolley driven at 0.5 m/s was towed at 0.8 m/s";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("driver 'H10'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace subsoil::mbd::rig_test
