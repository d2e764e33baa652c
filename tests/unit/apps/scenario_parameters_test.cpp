// Named values and arithmetic in all others.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "libsim/document/arithmetic.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/scenario/load.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::sim::scenario_parameters_test {
namespace {

/// 200 mm, 430 mm, 30 deg/s and 16 kN/m.
struct Some {
  ParametersInScope scope;
  Some() {
    for (const auto& [name, text] :
         {std::pair("a", "200 mm"), {"b", "2*a + 30 mm"}, {"w", "30 deg/s"}, {"k_1", "16 kN/m"}})
      add_parameter(name, evaluate_arithmetic(text));
  }
};

std::string refusal(const std::string& text, const std::string& unit) {
  return test::message_of<UnitError>([&] { parse_quantity(text, unit); });
}

TEST(Arithmetic, TakesParametersNumbersAndUnits) {
  const Some some;
  EXPECT_DOUBLE_EQ(parse_quantity("b", "m"), 0.43);
  EXPECT_DOUBLE_EQ(parse_quantity("-a/2", "m"), -0.1);
  EXPECT_DOUBLE_EQ(parse_quantity("50 mm - 3 mm", "m"), 0.047);
  EXPECT_DOUBLE_EQ(parse_quantity("200 mm*2", "m"), 0.4);
  EXPECT_DOUBLE_EQ(parse_quantity("k_1*a", "N"), 3200);
  EXPECT_DOUBLE_EQ(parse_quantity("30 kN/m*a", "N"), 6000);
  EXPECT_DOUBLE_EQ(parse_quantity("0.2 kg/(2*a)", "kg/m"), 0.5);
  EXPECT_DOUBLE_EQ(parse_quantity("sqrt(a^2 + b^2)", "m"), std::hypot(0.2, 0.43));
  EXPECT_DOUBLE_EQ(parse_quantity("sin(30 deg)*a", "m"), 0.1);
  EXPECT_DOUBLE_EQ(parse_quantity("atan2(a, b)", "rad"), std::atan2(0.2, 0.43));
  EXPECT_DOUBLE_EQ(parse_quantity("2*pi rad", "rad"), 2 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(parse_quantity("w*2 s", "rad"), std::numbers::pi / 3);
  EXPECT_DOUBLE_EQ(parse_quantity("1/3", "1"), 1. / 3);
  EXPECT_EQ(parse_quantity("(18 mm)", "m"), 0.018) << "to the last bit, as without brackets";
}

// A name behind a number is a unit, whatever parameters there are.
TEST(Arithmetic, LeavesPlainValuesAlone) {
  const Some some;
  EXPECT_EQ(parse_quantity("16 kN/m", "N/m"), 16000.0);
  EXPECT_EQ(parse_quantity("1e+3 m", "m"), 1000.0);
  EXPECT_EQ(parse_quantities("1 +2 -3 mm", "m", 3), (std::vector<double>{0.001, 0.002, -0.003}));
  EXPECT_EQ(parse_quantity("2 kN/mm^(n+2)", "N/m^(n+2)", 1.0), 2e12);
  EXPECT_NE(refusal("2 a", "m").find("is an area"), std::string::npos) << refusal("2 a", "m");
}

TEST(Arithmetic, RefusalsSayWhatIsWrong) {
  const Some some;
  EXPECT_EQ(refusal("a*a", "m"), "`a*a` is an area (m^2), but needed is a length (m), such as m");
  EXPECT_EQ(refusal("a + 3 kg", "m"), "adds kg to m; both must be of one dimension");
  EXPECT_NE(refusal("2*bb", "m").find("`bb` is no parameter"), std::string::npos) << refusal("2*bb", "m");
  EXPECT_NE(refusal("c_", "m").find("`c_` is no parameter"), std::string::npos) << refusal("c_", "m");
  EXPECT_NE(refusal("(a", "m").find("expected `)`, got its end"), std::string::npos);
  EXPECT_NE(refusal("a b", "m").find("several values stand in a list"), std::string::npos);
  EXPECT_NE(refusal("sqrt(-a)", "m^0.5").find("root of a negative"), std::string::npos);
  EXPECT_NE(refusal("exp(a)", "1").find("takes a plain number"), std::string::npos);
  EXPECT_NE(refusal("min(a)", "m").find("takes two values"), std::string::npos);
  EXPECT_NE(refusal("a/0", "m").find("no finite value"), std::string::npos);
  EXPECT_NE(test::message_of<UnitError>([] { parse_quantities("2*a", "m", 2); }).find("list of its own"),
            std::string::npos);
}

TEST(Parameters, NamesOfUnitsAndFunctionsAreRefused) {
  const ParametersInScope scope;
  for (const char* name : {"m", "kN", "sin", "pi", "2a", "a b", "t"})
    EXPECT_THROW(add_parameter(name, {1, {}}), UnitError) << name;
  EXPECT_NO_THROW(add_parameter("h_2", {1, {}}));
}

std::string with(const std::string& parameters, const std::string& body, const std::string& more = "") {
  return "subsoil: 1\nparameters: {" + parameters + "}\nmachine:\n  bodies: {rod: {" + body + "}}\n" + more +
         "time: {end: 1 s}\n";
}

// A rod described by its length alone scales with it.
TEST(Parameters, AMachineScalesWithThem) {
  const std::string text =
      with("len: 500 mm, m_rod: 6 kg/m*len", "mass: m_rod, inertia: m_rod*len^2/12, at: [len/2, 0 m]",
           "  joints: {pin: {revolute: [ground, rod], at: 0 0 m}}\n");
  const Scenario one = load_scenario_text(text, "rod.yaml", {}).scenario;
  EXPECT_DOUBLE_EQ(one.machine->bodies[0].mass, 3);
  EXPECT_DOUBLE_EQ(one.machine->bodies[0].inertia, 3 * 0.25 / 12);
  EXPECT_DOUBLE_EQ(one.machine->bodies[0].at[0], 0.25);
  const Scenario two = load_scenario_text(text, "rod.yaml", {"parameters.len=1 m"}).scenario;
  EXPECT_DOUBLE_EQ(two.machine->bodies[0].mass, 6);
  EXPECT_DOUBLE_EQ(two.machine->bodies[0].inertia, 0.5);
}

// In any order: those of an included file are read behind one's own.
TEST(Parameters, HoldEachOtherInAnyOrder) {
  const Scenario s =
      load_scenario_text(with("half: len/2, len: 2*unit, unit: 1 m", "mass: 1 kg, inertia: 1 kg m^2, at: [half, 0 m]"),
                         "rod.yaml", {})
          .scenario;
  EXPECT_DOUBLE_EQ(s.machine->bodies[0].at[0], 1);
}

// In the unit of a column that is known later: they were refused without their place.
TEST(Parameters, StandInLevelsOfEventsStopsAndCrossings) {
  const std::string more =
      "  joints: {pin: {revolute: [ground, rod], at: 0 0 m}}\n"
      "  measures: {turn: {angle: rod}}\n"
      "  events: {drop: {opens: pin, measure: turn, below: -amp}}\n"
      "output: {crossings: {up: {column: turn, at: amp/2}}}\n";
  std::string text = with("amp: 20 deg", "mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m", more);
  text.replace(text.find("{end: 1 s}"), 10, "{end: 1 s, stop when: {far: {column: turn, above: 3*amp}}}");
  const Scenario s = load_scenario_text(text, "rod.yaml", {}).scenario;
  const double amp = 20 * std::numbers::pi / 180;
  EXPECT_DOUBLE_EQ(parse_quantity(s.machine->events[0].below, "rad"), -amp);
  EXPECT_DOUBLE_EQ(parse_quantity(s.time.stop_when[0].above, "rad"), 3 * amp);
  EXPECT_DOUBLE_EQ(parse_quantity(s.output.crossings[0].at, "rad"), amp / 2);
  EXPECT_THROW(parse_quantity(s.output.crossings[0].at, "m"), UnitError);
}

TEST(Parameters, StandInFormulasForTheirNumbers) {
  const std::string load = "  forces: {load: {force: rod, moment: {expression: F_0*sin(w*t), unit: % m}}}\n";
  const auto filled = [&](const std::string& unit) {
    std::string text = load;
    return with("F_0: 2 kN m, w: 3", "mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m", text.replace(text.find('%'), 1, unit));
  };
  EXPECT_NO_THROW(load_scenario_text(filled("N"), "f.yaml", {}));
  const std::string text = test::message_of<ScenarioError>([&] { load_scenario_text(filled("kN"), "f.yaml", {}); });
  EXPECT_NE(text.find("`F_0` has a unit"), std::string::npos) << text;
}

std::string fault(const std::string& text, const std::vector<std::string>& sets = {}) {
  return test::message_of<ScenarioError>([&] { load_scenario_text(text, "rod.yaml", sets); });
}

TEST(Parameters, RefusalsNameThePlace) {
  const std::string body = "mass: 2*q kg, inertia: 1 kg m^2, at: 0 0 m";
  EXPECT_NE(fault(with("p: 2", body)).find("rod.yaml:4:24 machine.bodies.rod.mass = 2*q kg: `q` is no parameter"),
            std::string::npos)
      << fault(with("p: 2", body));
  const std::string circle = fault(with("half: len/2, len: 2*half", "mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m"));
  EXPECT_NE(circle.find("rod.yaml:2:20 parameters.half = len/2: `len` has no value: it holds this one"),
            std::string::npos)
      << circle;
  EXPECT_NE(fault(with("len: 1 m", "mass: 1 kg, inertia: 1 kg m^2, at: [len, 0 m]"), {"parameters.lem=2 m"})
                .find("--set parameters.lem = 2 m: no value names this parameter"),
            std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::scenario_parameters_test
