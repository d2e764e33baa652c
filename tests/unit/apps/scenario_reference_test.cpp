#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "libdem/laws/wet.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libsim/keys/known_keys.hpp"
#include "libsim/scenario/load.hpp"
#include "scenario_samples.hpp"

namespace subsoil::sim::scenario_reference_test {
namespace {

/// The copy with every default explicit must give the same structs: numbers are written exactly, so the copy of the
/// copy is the same text if and only if every declared value is the same.
void expect_round_trip(const Scenario& scenario) {
  const std::string copy = write_scenario(scenario);
  Scenario again;
  ASSERT_NO_THROW(again = load_scenario_text(copy, "copy.yaml").scenario) << copy;
  EXPECT_EQ(write_scenario(again), copy);
}

TEST(ScenarioCopy, SoilReadsBackTheSame) {
  const Scenario scenario = load_scenario_text(sample_soil).scenario;
  expect_round_trip(scenario);
  const Scenario again = load_scenario_text(write_scenario(scenario)).scenario;
  const auto &first = *scenario.contacts[1].law.get_if<dem::Wet>(), &second = *again.contacts[1].law.get_if<dem::Wet>();
  EXPECT_EQ(first.K_X, second.K_X);
  EXPECT_EQ(first.K_B, second.K_B);
  EXPECT_EQ(first.values, second.values);
  EXPECT_EQ(scenario.soil->container->open_after_settling, again.soil->container->open_after_settling);
}

TEST(ScenarioCopy, MachineReadsBackTheSameBits) {
  const Scenario scenario = load_scenario_text(sample_machine).scenario;
  expect_round_trip(scenario);
  const Scenario again = load_scenario_text(write_scenario(scenario)).scenario;
  EXPECT_EQ(scenario.machine->joints[1].element.get<mbd::Revolute>().p_b,
            again.machine->joints[1].element.get<mbd::Revolute>().p_b);
  EXPECT_EQ(scenario.machine->joints[0].element.get<mbd::Translational>().angle_a,
            again.machine->joints[0].element.get<mbd::Translational>().angle_a);
  EXPECT_EQ(scenario.machine->bodies[1].angle, again.machine->bodies[1].angle);
}

TEST(ScenarioCopy, EveryKindOfThing) {
  expect_round_trip(
      load_scenario_text(sample_soil, "t.yaml",
                         {"soil.bed.fill=random", "soil.bed.radius={table: [[8 mm, 1], [9 mm, 2]]}",
                          "soil.bed.region={size: 0.1 0.1 0.1 m, at: 0 0 0 m}", "soil.bed.count=12",
                          "boundaries.plate.moves=[{angular velocity: 0 0 3 rpm, about: 1 0 0 mm, until: 2 s, "
                          "profile: {harmonic: {amplitude: 1, frequency: 3 Hz}}}]",
                          "boundaries.plate.shape={cylinder: {radius: 3 in, length: 1 m, inner radius: 2.5 in}}",
                          "boundaries.plate.rotation={axis: 1 1 0, angle: 7 deg}",
                          "contacts[0]={between: [soil, soil], law: linear, k_n: 1 kN/m, restitution: 0.3, mu: 0.1}",
                          "time.soil step=12.3 us", "output.region={size: 1 1 1 m, at: 0 0 0 m}",
                          "output.window={from: 1 s, until: 2 s}", "output.columns=[spin]",
                          "title=\"a: b # c, 'd' \\\"e\\\"\"", "output.at=[1 s, 3 ms]"})
          .scenario);
  expect_round_trip(load_scenario_text(sample_soil, "t.yaml",
                                       {"soil.bed={fill: particles, material: soil, particles: [{position: 1 2 3 mm, "
                                        "radius: 1 mm, angular velocity: 1 0 0 rad/s}]}",
                                        "soil.surface=0 m"})
                        .scenario);
  expect_round_trip(
      load_scenario_text(
          sample_machine, "t.yaml",
          {"machine.forces.spring={spring-damper: [arm, ground], ends: [0 0 m, 1 7 m], stiffness: 3 lbf/in}",
           "machine.forces.twist={rotational spring-damper: [sled, arm], stiffness: 2 N m/deg}",
           "machine.forces.rub={joint friction: slide, guide: 0.2 m, mu_s: 0.2, mu_k: 0.1}", "machine.redundant=refuse",
           "machine.forces.load={force: arm, at: 0 1 m, along x: [1 N, {table: [[0 s, 0 N], [1 s, 3 N]]}]}",
           "machine.joints.weld={fixed: [ground, sled], at: 0.3 0.7 m}",
           "machine.drivers.turn={angle: [sled, arm], position: {polynomial: {c1: 3 deg/s}}}",
           "machine.drivers.push={slide: [ground, sled], along: 1 2, velocity: {ramp: {to: 1 m/s, end: 1 s}}}"})
          .scenario);
}

TEST(ScenarioNew, ParsesAndCommentsEveryKey) {
  const std::string text = new_scenario();
  Scenario scenario;
  ASSERT_NO_THROW(scenario = load_scenario_text(text).scenario) << text;
  expect_round_trip(scenario);
  EXPECT_NE(text.find("# normal stiffness"), std::string::npos);
}

TEST(ScenarioExplain, UnitDefaultRangeAndMeaning) {
  const std::string wanted =
      "contacts.wet.K_X\n"
      "    normal stiffness of the repulsion\n"
      "    value:   N/m\n"
      "    default: required\n"
      "    range:   (0, inf)\n";
  EXPECT_EQ(explain("contacts.wet.K_X"), wanted);
  EXPECT_EQ(explain("soil.contacts.wet.K_X"), wanted);
  EXPECT_EQ(explain("K_X"), wanted);
  EXPECT_NE(explain("machine.bodies.shovel.mass").find("machine.bodies.<name>.mass"), std::string::npos);
  EXPECT_NE(explain("machine.forces.H9.free length").find("length without spring force"), std::string::npos);
  EXPECT_NE(explain("contacts[1].mu").find("friction"), std::string::npos);
  EXPECT_NE(explain("time.soil step").find("default: auto"), std::string::npos);
  EXPECT_NE(explain("").find("boundaries"), std::string::npos);
}

/// A path may leave names of one's own out.
TEST(ScenarioExplain, AKeyBelowANameIsFoundWithoutIt) {
  const std::string inertia = explain("soil.clumps.inertia");
  EXPECT_EQ(inertia, explain("soil.clumps.<name>.inertia"));
  EXPECT_TRUE(inertia.starts_with("soil.clumps.<name>.inertia\n    as measured")) << inertia;
  EXPECT_EQ(explain("soil.clumps.spheres.radius"), explain("soil.clumps.<name>.spheres.radius"));
  EXPECT_TRUE(explain("soil.clumps").starts_with("soil.clumps\n"));
}

/// The coefficient of a law's pair, and not that of the materials, which `combine` takes.
TEST(ScenarioExplain, AKeyOfEveryLawIsSoughtInItsOwnSection) {
  const std::string text = explain("contacts.mu");
  EXPECT_EQ(text.find("materials."), std::string::npos) << text;
  EXPECT_TRUE(text.starts_with("contacts.")) << text;
  EXPECT_NE(text.find("contacts.linear.mu\n"), std::string::npos) << text;
  EXPECT_NE(explain("mu").find("materials.<name>.mu\n"), std::string::npos);
}

/// A section is listed key by key on a line each; what is not in it is not taken from elsewhere.
TEST(ScenarioExplain, ASectionIsAScreenAndAnotherSectionsKeyIsNone) {
  const std::string machine = explain("machine"), forces = explain("machine.forces");
  EXPECT_LT(std::count(machine.begin(), machine.end(), '\n'), 60);
  EXPECT_NE(machine.find("\n  machine.joints"), std::string::npos) << machine;
  EXPECT_NE(forces.find("machine.forces.hydraulic cylinder"), std::string::npos) << forces;
  try {
    explain("machine.forces.cylinder");
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("machine.forces.cylinder: no key of a scenario"), std::string::npos)
        << e.what();
  }
}

TEST(ScenarioExplain, TheKeyThatMergesFiles) {
  for (const char* path : {"include", "machine.include"})
    EXPECT_NE(explain(path).find("merged into this mapping key by key"), std::string::npos) << path;
}

TEST(ScenarioExplain, UnknownPathGetsTheNearest) {
  try {
    explain("soil.bed.radus");
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(), "soil.bed.radus: no key of a scenario; did you mean `radius`?");
  }
}

TEST(ScenarioReference, EveryKeyOnceWithItsMeaningAndExplained) {
  const std::string page = reference_markdown();
  std::set<std::string> seen;
  for (const KnownKey& row : known_keys()) {
    EXPECT_FALSE(row.meaning.empty()) << row.path;
    EXPECT_FALSE(row.unit.empty()) << row.path;
    EXPECT_TRUE(seen.insert(row.path).second) << row.path << " stands twice";
    EXPECT_NE(page.find("| `" + row.path + "` |"), std::string::npos) << row.path;
    EXPECT_NE(explain(row.path).find(row.meaning), std::string::npos) << row.path;
  }
  EXPECT_GT(seen.size(), 200u);
}

}  // namespace
}  // namespace subsoil::sim::scenario_reference_test
