// Markers, measures and outlines as a scenario writes them: read, refused with place and cure, copied without loss.
#include <gtest/gtest.h>

#include <string>

#include "libmbd/measures/position.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/machine.hpp"

namespace subsoil::sim::scenario_measures_test {
namespace {

/// A rod on a pin with a spring; line 5 is the rod, 7 the markers, 12 the pin, 16 the measures. One thing is changed.
std::string pendulum(const std::string& what = "", const std::string& by = "") {
  std::string text = R"(subsoil: 1
time: {end: 1 s}
machine:
  bodies:
    rod: {mass: 1 kg, inertia: 0.1 kg m^2, at: 1 3 m, angle: 90 deg, outline: [-1 -0.1 m, 1 0 m, -1 0.1 m]}
    weight: {mass: 1 kg, inertia: 0.1 kg m^2, at: 5 3 m}
  markers:
    tip: {body: rod, at: 1 4 m, angle: 30 deg}
    base: {at: 1 0 m}
    middle: {body: rod}
  joints:
    pin: {revolute: [ground, rod], at: 1 2 m}
  forces:
    spring: {spring-damper: [ground, rod], ends: [0 0 m, 1 4 m], stiffness: 1 kN/m}
  measures:
    path: {position: tip, from: base, in: rod}
    speed: {velocity: tip, component: size}
    bend: {corner: [base, middle, tip]}
    gap: {distance: [ground, tip]}
    pin force: {reaction: pin, on: ground, in: tip, about: base}
    pull: {force: spring, component: moment}
    swing: {energy: rod, component: kinetic}
)";
  if (const std::size_t at = text.find(what); !what.empty() && at != std::string::npos)
    text.replace(at, what.size(), by);
  return text;
}

std::string refusal(const std::string& what, const std::string& by) {
  try {
    build_machine(load_scenario_text(pendulum(what, by), "rod.yaml"));
  } catch (const ScenarioError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ScenarioMeasures, AMarkerIsAPointOfTheStartPoseInItsBodysAxes) {
  const MachineSection m = *load_scenario_text(pendulum(), "rod.yaml").scenario.machine;
  ASSERT_EQ(m.markers.size(), 3U);
  EXPECT_EQ(m.markers[0].body, 1);
  EXPECT_NEAR(m.markers[0].p[0], 1, 1e-15);  // the rod stands upright
  EXPECT_NEAR(m.markers[0].p[1], 0, 1e-15);
  EXPECT_NEAR(m.markers[0].angle, 0.52359877559829887, 1e-15);
  EXPECT_EQ(m.markers[1].body, mbd::ground);
  EXPECT_EQ(m.markers[2].p[0], 0);
  const auto& path = m.measures[0].element.get<mbd::PositionMeasure>();
  EXPECT_EQ(path.from.p[0], 1);
  EXPECT_EQ(path.in.body, 1) << "a body stands for the marker of its own axes";
  EXPECT_EQ(m.bodies[0].outline.size(), 3U);
}

TEST(ScenarioMeasures, ColumnsCarryTheMeasuresNames) {
  const auto machine = build_machine(load_scenario_text(pendulum(), "rod.yaml"));
  const std::vector<std::string> names(machine->column_names().end() - 10, machine->column_names().end());
  const std::vector<std::string> expected{"path.x",      "path.y",           "speed", "bend", "gap", "pin force.x",
                                          "pin force.y", "pin force.moment", "pull",  "swing"};
  EXPECT_EQ(names, expected);
  const std::vector<std::string> units(machine->column_units().end() - 10, machine->column_units().end());
  const std::vector<std::string> wanted{"m", "m", "m/s", "rad", "m", "N", "N", "N m", "N m", "J"};
  EXPECT_EQ(units, wanted);
}

TEST(ScenarioMeasures, CopyReadsBackTheSame) {
  const std::string copy = write_scenario(load_scenario_text(pendulum(), "rod.yaml").scenario);
  Scenario again;
  ASSERT_NO_THROW(again = load_scenario_text(copy, "copy.yaml").scenario) << copy;
  EXPECT_EQ(write_scenario(again), copy);
}

TEST(ScenarioMeasures, RefusalsNamePlaceRuleAndCure) {
  EXPECT_EQ(
      refusal("position: tip", "position: tipp"),
      "rod.yaml:16:22 machine.measures.path.position = tipp: there is no marker or body of this name; did you mean "
      "`tip`?");
  EXPECT_EQ(refusal("[base, middle, tip]", "[base, tip]"),
            "rod.yaml:18:20 machine.measures.bend.corner = [base, tip]: must be a list of 3 markers or bodies, such as "
            "[base, elbow, tip]");
  EXPECT_EQ(refusal("{distance: [ground, tip]}", "{distanse: [ground, tip]}"),
            "rod.yaml:19:10 machine.measures.gap = {distanse: [ground, tip]}: does not say what it is; did you mean "
            "`distance`?");
  EXPECT_EQ(refusal("reaction: pin", "reaction: pim"),
            "rod.yaml:20:27 machine.measures.pin force.reaction = pim: there is no joint of this name; did you mean "
            "`pin`?");
  EXPECT_EQ(
      refusal("on: ground", "on: weight"),
      "rod.yaml:20:16 machine.measures.pin force: joint 'pin' does not act on 'weight'; let `on` be one of ground, "
      "rod");
  EXPECT_EQ(refusal("component: size", "component: z"),
            "rod.yaml:17:39 machine.measures.speed.component = z: unknown word; did you mean `x`?");
  EXPECT_EQ(refusal("tip: {body: rod,", "tip: {body: rob,"),
            "rod.yaml:8:17 machine.markers.tip.body = rob: there is no body of this name; did you mean `rod`?");
  EXPECT_EQ(refusal("-0.1 m, 1 0 m, -1 0.1 m]", "-0.1 m, 1 0 m]"),
            "rod.yaml:5:79 machine.bodies.rod.outline = [-1 -0.1 m, 1 0 m]: an outline needs at least three points");
}

TEST(ScenarioMeasures, NamesOfColumnsMustDiffer) {
  EXPECT_EQ(refusal("gap: {distance", "pin: {distance"),
            "rod.yaml:19:10 machine.measures.pin: `pin` is the name of one of machine.joints too; names in the results "
            "must differ: take another");
  EXPECT_EQ(
      refusal("gap: {distance", "time: {distance"),
      "rod.yaml:19:11 machine.measures.time: `time` is the name of the first column too; names in the results must "
      "differ: take another");
  EXPECT_EQ(refusal("kinetic}\n", "kinetic}\noutput: {monitor: {gap: rod.x}}\n"),
            "rod.yaml:23:25 output.monitor.gap: is a measure of the machine, which is a column by itself; drop one");
}

}  // namespace
}  // namespace subsoil::sim::scenario_measures_test
