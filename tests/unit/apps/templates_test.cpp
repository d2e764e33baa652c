#include "apps/commands/templates.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "libsim/scenario/load.hpp"
#include "tests/tools/program_runs.hpp"

/// What the program offers to start from runs to its end, as it is printed, in a folder of its own.
namespace subsoil::sim::templates_test {
namespace {

using namespace test;

class TemplateRuns : public testing::TestWithParam<std::string> {};

TEST_P(TemplateRuns, ToItsEnd) {
  const RunDirectory dir;
  const Template& t = template_of(GetParam());
  const std::filesystem::path file = dir / (std::string(t.name) + ".yaml");
  test::write_file(file, std::string(t.scenario));
  if (!t.mesh.empty()) test::write_file(dir / (std::string(t.name) + ".stl"), std::string(t.mesh));
  ASSERT_EQ(run_scenario(file.string(), dir / "out"), exit_ok) << summary_of(dir / "out")["run"]["failure"];
  const nlohmann::json summary = summary_of(dir / "out");
  EXPECT_EQ(summary["warnings"].dump().find("touched no soil"), std::string::npos) << summary["warnings"];
  EXPECT_EQ(summary["warnings"].dump().find("means are null"), std::string::npos) << summary["warnings"];
  // Draft or resistance, and no balance that is off: the run means something.
  const nlohmann::json tools = summary.value("tools", nlohmann::json::object());  // a heap has none
  for (const auto& [name, tool] : tools.items()) EXPECT_EQ(tool["touched soil"], true) << name;
  EXPECT_LT(std::abs(summary["energy"]["closure over energy there or put in"].get<double>()), 0.05);
}

std::vector<std::string> names() {
  std::vector<std::string> out;
  for (const Template& t : templates()) out.emplace_back(t.name);
  return out;
}
INSTANTIATE_TEST_SUITE_P(All, TemplateRuns, testing::ValuesIn(names()), [](const auto& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(Templates, AreThoseOfTheListAndAreNamed) {
  const std::vector<std::string> wanted{"tine", "chisel",  "rotor",           "wheel", "plate",
                                        "cone", "linkage", "vibrating-shank", "heap",  "drum"};
  EXPECT_EQ(names(), wanted);
  for (const std::string& name : wanted) EXPECT_NE(template_list().find(name + " "), std::string::npos) << name;
  EXPECT_NE(subsoil::test::message_of<std::invalid_argument>([] { template_of("tin"); }).find("did you mean `tine`?"),
            std::string::npos);
}

/// Editors read it; the schema of an installed program is found from the program's place.
TEST(Templates, CarryTheSchemaLine) {
  const test::Scratch scratch;
  std::filesystem::create_directories(scratch / "usr/share/subsoil");
  test::write_file(scratch / "usr/share/subsoil/subsoil.schema.json", "{}");
  for (const Template& t : templates()) {
    EXPECT_TRUE(t.scenario.starts_with("# yaml-language-server: $schema=subsoil.schema.json\n# ")) << t.name;
    EXPECT_EQ(with_schema_line(t.scenario, "/nowhere/bin/subsoil"), t.scenario) << t.name;
    const std::string installed = with_schema_line(t.scenario, scratch / "usr/bin/subsoil");
    EXPECT_EQ(installed.find("# yaml-language-server: $schema=" +
                             (scratch / "usr/share/subsoil/subsoil.schema.json").string() + "\n# "),
              0u);
    EXPECT_EQ(t.about().find("yaml-language-server"), std::string_view::npos);
  }
}

TEST(Templates, TheScenarioOfEveryKeyRunsToItsEnd) {
  const RunDirectory dir;
  EXPECT_EQ(run_scenario(dir.scenario(new_scenario()), dir / "out"), exit_ok);
}

}  // namespace
}  // namespace subsoil::sim::templates_test
