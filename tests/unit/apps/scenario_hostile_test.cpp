// Scenarios that are short to write and long to read: each is refused, with the number found and the limit, within a
// second or two; without the limits these tests run for minutes, until the memory ends, or crash.

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "libsim/base/input_limits.hpp"
#include "libsim/document/arithmetic.hpp"
#include "libsim/document/expression.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/scenario/load.hpp"
#include "scenario_samples.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/scratch.hpp"

namespace subsoil::sim::scenario_hostile_test {
namespace {

std::string refusal(const std::string& text) {
  return test::message_of<ScenarioError>([&] { load_scenario_text(text, "bad.yaml"); });
}
std::string changed(const std::string& from, const std::string& to) {
  std::string text = sample_soil;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}
::testing::AssertionResult holds(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "`" << part << "` is not in: " << text.substr(0, 500);
}
std::string repeated(const std::string& part, int times) {
  std::string text;
  for (int i = 0; i < times; ++i) text += part;
  return text;
}

TEST(HostileScenario, EndlessAndLongFiles) {
  EXPECT_TRUE(holds(test::message_of<ScenarioError>([] { load_scenario("/dev/zero"); }), "/dev/zero: is too long"));
  const test::Scratch scratch;
  const std::string file = (scratch.path() / "long.yaml").string();
  std::ofstream(file) << sample_soil << "# " << std::string(10 << 20, 'x') << '\n';
  EXPECT_TRUE(holds(test::message_of<ScenarioError>([&] { load_scenario(file); }),
                    "may have 1048576 bytes together; keep tables and meshes in files of their own"));
}

TEST(HostileScenario, ManyKeys) {
  std::string text = sample_soil;
  for (int i = 0; i < 20000; ++i) text += "k" + std::to_string(i) + ": 1\n";
  EXPECT_TRUE(holds(refusal(text), "holds 20008 keys; at most 5000 may stand in one mapping"));
}

/// What no line of the text is long for, and yaml-cpp would take many seconds to keep.
TEST(HostileScenario, ManyValuesAnchorsAndLevels) {
  EXPECT_EQ(refusal(repeated("-\n", 200000)),
            "bad.yaml:100001:1: more than 100000 keys and values; SUBSOIL_LIMITS=values=N in the environment allows "
            "more");
  std::string anchors = "a: [";
  for (int i = 0; i < 50000; ++i) anchors += "&a" + std::to_string(i) + " 1, ";
  EXPECT_TRUE(holds(refusal(anchors + "1]\n"), "more than 1000 anchors and aliases; SUBSOIL_LIMITS=anchors=N"));
  for (const char* open : {"[", "{a: ", "- ", "? "})
    EXPECT_TRUE(holds(refusal(repeated(open, 100000)), "more than 60 mappings and lists within each other")) << open;
  EXPECT_TRUE(holds(refusal("a: &a [*a]\n"), "nested deeper than 60; does an anchor hold itself?"));
}

TEST(HostileScenario, LongNamesValuesAndDirectives) {
  const std::string many(20001, 'x');
  EXPECT_TRUE(holds(refusal(std::string(300, 'x') + ": 1\n"), "a name of 300 bytes; it may have 200"));
  EXPECT_TRUE(holds(refusal("title: " + many + "\n"), "a value of 20001 bytes; it may have 20000"));
  EXPECT_TRUE(holds(refusal("title: !<" + many + "> x\n"), "a tag of"));
  EXPECT_TRUE(holds(refusal(std::string(1000000, '%')), "bad.yaml:1:1: a directive of 1000000 bytes; leave it out"));
  EXPECT_TRUE(holds(refusal("boundaries: [{name: " + std::string(201, 'x') + "}]\n"), "a name is too long"));
}

/// yaml-cpp reads the first document and stops at a line that begins with %: what follows would be dropped in silence.
TEST(HostileScenario, TextThatYamlWouldDrop) {
  const std::string sample = sample_soil;
  EXPECT_EQ(refusal("---\n" + sample + "...\n"), "accepted") << "one document between its marks";
  EXPECT_TRUE(holds(refusal(sample + "---\ngravity: 1.62 m/s^2\n"), "a second document begins"));
  EXPECT_TRUE(holds(refusal("subsoil: 1\n%gravity: 1.62 m/s^2\n" + sample),
                    "bad.yaml:2:1: a line that begins with % is a directive of YAML, and this is none"));
  EXPECT_TRUE(holds(refusal(sample + "%YAML 1.2\n---\ngravity: 1.62 m/s^2\n"), "a second document begins"));
}

TEST(HostileScenario, LimitsAreSettable) {
  InputLimits limits;
  read_limits("triangles=5e6,depth=100", limits);
  EXPECT_EQ(limits.triangles, 5000000u);
  EXPECT_EQ(limits.depth, 100u);
  EXPECT_EQ(limits.values, InputLimits{}.values);
  const auto wrong = [](const std::string& text) {
    return test::message_of<ScenarioError>([&] {
      InputLimits unused;
      read_limits(text, unused);
    });
  };
  EXPECT_TRUE(holds(wrong("triangle=5"), "SUBSOIL_LIMITS: `triangle` is no limit; there are scenario-bytes, values"));
  for (const char* number : {"", "0", "-1", "nan", "1e300", "5 m"})
    EXPECT_TRUE(holds(wrong(std::string("depth=") + number), "must be a whole number in [1, 1e18]")) << number;
}

TEST(HostileScenario, AliasesInAliases) {
  std::string text = "subsoil: 1\na0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    text += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before + repeated(", " + before, 9) + "]\n";
  }
  EXPECT_TRUE(holds(refusal(text), "more than 100000 keys and values; are aliases nested in aliases?"));
}

TEST(HostileScenario, ChainsOfIncludes) {
  const test::Scratch scratch;
  const auto name = [](int i) { return "part" + std::to_string(i) + ".yaml"; };
  for (int i = 0; i < 300; ++i) std::ofstream(scratch.path() / name(i)) << "include: " << name(i + 1) << '\n';
  std::ofstream(scratch.path() / name(300)) << "subsoil: 1\n";
  EXPECT_TRUE(holds(test::message_of<ScenarioError>([&] { load_scenario((scratch.path() / name(0)).string()); }),
                    "is the 101th file of this scenario; at most 100 may be included"));
}

TEST(HostileScenario, TextThatIsNoUtf8) {
  EXPECT_EQ(refusal("subsoil: 1\ntitle: Gr\xF6\xDF"
                    "e\n"),
            "bad.yaml:2:10: holds the byte 0xF6, which is no UTF-8 text; save the file as UTF-8");
  EXPECT_TRUE(holds(refusal("subsoil: 1\ntitle: \xC0\xAF\n"), "0xC0"));      // overlong
  EXPECT_TRUE(holds(refusal("subsoil: 1\ntitle: \xED\xA0\x80\n"), "0xED"));  // half of a surrogate pair
  EXPECT_TRUE(holds(refusal("subsoil: 1\ntitle: \"a\\x01\"\n"), "title: holds the control character 0x01"));
  const std::string marked = std::string("\xEF\xBB\xBF") + changed("title: till",
                                                                   "title: Gr\xC3\xB6\xC3\x9F"
                                                                   "e");
  EXPECT_EQ(load_scenario_text(marked, "bom.yaml").scenario.title,
            "Gr\xC3\xB6\xC3\x9F"
            "e");
}

TEST(HostileScenario, NumbersBeyondAnyMachine) {
  EXPECT_TRUE(holds(refusal(changed("density: 1800 kg/m^3", "density: 1e300 kg/m^3")),
                    "materials.soil.density = 1e300 kg/m^3: is above 1e30 in SI units; check number and unit"));
  EXPECT_TRUE(holds(refusal(changed("end: 4 s", "end: 1e30 s")), "makes 1e+33 rows of series.csv"));
  EXPECT_TRUE(
      holds(refusal(changed("time:\n", "output: {series every: 1e-300 s}\ntime:\n")), "is below 1e-30 in SI units"));
  // A component of a point or vector that small is the rounding of whoever wrote it.
  EXPECT_EQ(load_scenario_text(changed("gravity: 9.81 m/s^2", "gravity: 1e-43 -9.81 1e-320 m/s^2"), "a.yaml")
                .scenario.gravity.x,
            0);
  EXPECT_TRUE(holds(refusal(changed("time:\n", "output: {every: 1e-6 s}\ntime:\n")), "makes 4e+06 frames until 4 s"));
  EXPECT_TRUE(holds(refusal(changed("fill: rest-lattice", "fill: random\n    count: 1000000000")),
                    "must be in [1, 100000000]"));
}

TEST(HostileScenario, NestedUnits) {
  const std::string unit = std::string(50000, '(') + "m" + std::string(50000, ')');
  EXPECT_TRUE(
      holds(test::message_of<UnitError>([&] { parse_quantity("1 " + unit, "m"); }), "nests more than 50 brackets"));
  EXPECT_TRUE(holds(test::message_of<UnitError>([&] { parse_quantity("1 m^" + std::string(400, '9'), "m"); }),
                    "has a power that is too large"));
}

TEST(HostileScenario, SignsAndPowersOfArithmetic) {
  const auto fault = [](const std::string& text) {
    return test::message_of<UnitError>([&] { evaluate_arithmetic(text); });
  };
  EXPECT_TRUE(holds(fault("1+" + std::string(50000, '-') + "1"), "is a formula of more than 10,000 characters"));
  EXPECT_TRUE(holds(fault(repeated("1^", 4000) + "1"), "of powers in a row it must say which comes first"));
  EXPECT_TRUE(holds(fault(std::string(5000, '(') + "1"), "nests more than 100 brackets"));
  EXPECT_EQ(evaluate_arithmetic("1 + " + std::string(20, '-') + "2 mm/mm").value, 3);
}

// ---- formulas ------------------------------------------------------------------------------------------------------

std::string formula_refusal(const std::string& text) {
  return test::message_of<UnitError>([&] { make_expression(text, "1", 1); });
}

TEST(HostileFormula, EmptyBrackets) {
  for (const char* word : {"sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt",
                           "pow", "atan2", "abs", "sign", "min", "max"})
    EXPECT_EQ(formula_refusal(std::string(word) + "( )"),
              std::string(word) + "() has empty brackets; write what it is the function of: " + word + "(t)");
  EXPECT_EQ(formula_refusal("0^-e"), "divides by 0");
  EXPECT_EQ(formula_refusal("2*()"), "holds empty brackets; write what belongs between them");
}

TEST(HostileFormula, Nesting) {
  const auto nested = [](const std::string& open, int n) { return repeated(open, n) + "t" + std::string(n, ')'); };
  EXPECT_TRUE(holds(formula_refusal(nested("(", 100000)), "is a formula of more than 10,000 characters"));
  EXPECT_TRUE(holds(formula_refusal(nested("(", 4000)), "nests more than 100 brackets"));
  EXPECT_TRUE(holds(formula_refusal(nested("sin(", 1000)), "nests more than 100 brackets"));
  EXPECT_EQ(make_expression(std::string(9001, '-') + "t", "1", 1).value(0.25), -0.25);
  EXPECT_EQ(make_expression(nested("(", 90), "1", 1).value(0.25), 0.25);
}

TEST(HostileFormula, PowersOfPowers) {
  const char* large = "holds a number too large for double precision";
  EXPECT_EQ(formula_refusal("10^(10^10)"), large);
  EXPECT_EQ(formula_refusal("t*9^(9^9)"), large);
  EXPECT_EQ(formula_refusal("pow(pow(7, 9999), 9999)"), large);
  EXPECT_EQ(make_expression("((((2*t)^1000)^1000)^1000)^1000", "1", 1).value(0.5), 1);
  EXPECT_EQ(formula_refusal("1e1000000000"), "holds a number too large for double precision");
  EXPECT_EQ(formula_refusal("1e-1000000000*t"), "holds a number too small for double precision; write 0");
  EXPECT_DOUBLE_EQ(make_expression("2^10*t + 10^6 + (2*t)^3", "1", 1).value(0.5), 512 + 1e6 + 1);
}

}  // namespace
}  // namespace subsoil::sim::scenario_hostile_test
