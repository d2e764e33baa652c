// What the documents show is what the program does.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "apps/commands/commands.hpp"
#include "libmbd/elements.hpp"
#include "libsim/run/column_table.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/studies/laboratory/tests.hpp"
#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"

namespace subsoil::sim::docs_test {
namespace {

namespace fs = std::filesystem;
const fs::path root = subsoil::test::source_dir();

std::string read(const fs::path& path) {
  std::ifstream in(path);
  EXPECT_TRUE(in) << path;
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The ```yaml blocks of a document.
std::vector<std::string> yaml_blocks(const std::string& text) {
  std::vector<std::string> blocks;
  std::istringstream lines(text);
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("```", 0) == 0) {
      inside = !inside && line == "```yaml";
      if (inside) blocks.emplace_back();
    } else if (inside) {
      blocks.back() += line + "\n";
    }
  }
  return blocks;
}

TEST(Docs, ScenarioReferenceIsWhatTheProgramPrints) {
  EXPECT_EQ(read(root / "docs/reference/keys.md"), reference_markdown())
      << "docs/reference/keys.md is old: build/release/apps/subsoil reference > docs/reference/keys.md";
}

TEST(Docs, ColumnsShownAreThoseOfTheTable) {
  EXPECT_NE(read(root / "docs/reference/output-variables.md").find(columns_markdown()), std::string::npos)
      << "docs/reference/output-variables.md is old; build/release/apps/subsoil reference --columns prints:\n"
      << columns_markdown();
}

/// Every force of libmbd has its line; what libmbd calls its columns is what the table shows.
TEST(Docs, ForcesAndTheMachinesOwnColumnsAreInTheTable) {
  std::set<std::vector<std::pair<std::string, std::string>>> shown;
  std::set<std::pair<std::string, std::string>> names;
  for (const MachineColumns& m : machine_columns()) {
    shown.insert(m.columns);
    names.insert(m.columns.begin(), m.columns.end());
  }
  std::apply(
      [&](const auto&... force) {
        const auto look = [&](const auto& f) {
          std::vector<std::pair<std::string, std::string>> columns;
          for (const auto& c : f.columns) columns.emplace_back(c.name, c.unit);
          EXPECT_TRUE(shown.count(columns)) << "a force whose first column is " << columns.front().first;
        };
        (look(force), ...);
      },
      mbd::Forces{});
  const Loaded loaded = load_scenario((root / "configs/1s300-towed-reduced.yaml").string(), {});
  BuildOptions options;
  options.settle = false;
  const World world = build_world(loaded, options);
  for (std::size_t i = 0; i < world.machine->column_names().size(); ++i) {
    const std::string& name = world.machine->column_names()[i];
    EXPECT_TRUE(names.count({name.substr(name.rfind('.') + 1), world.machine->column_units()[i]})) << name;
  }
}

/// The scenarios that a newcomer copies first.
TEST(Docs, FirstScenariosRunToTheirEnd) {
  for (const char* name : {"README.md", "docs/reference/scenario-file.md"}) {
    const test::RunDirectory dir;
    const std::string block = yaml_blocks(read(root / name)).front();
    EXPECT_EQ(test::run_scenario(dir.scenario(block), dir / "out"), exit_ok) << name;
    const Series series = read_series(dir / "out" / "series.csv");
    const auto watch =
        std::find_if(series.columns.begin(), series.columns.end(), [](const auto& c) { return c.is_watch(); });
    ASSERT_NE(watch, series.columns.end()) << name << ": `plot` must have something to draw";
    const std::vector<double>& values = series.at(watch->name);
    EXPECT_GT(*std::max_element(values.begin(), values.end()), 0) << name << ": something must be met";
  }
}

/// Studies of impacts and samples of laboratory tests that a page shows whole.
TEST(Docs, StudiesAndSamplesShownAreRun) {
  const test::RunDirectory dir;
  for (const std::string& block : yaml_blocks(read(root / "docs/reference/impact.md"))) {
    ImpactRequest request;
    request.words = {dir.scenario(block)};
    EXPECT_NO_THROW(EXPECT_EQ(impact_command(request), exit_ok)) << block;
  }
  const std::string sample = yaml_blocks(read(root / "docs/reference/laboratory-tests.md")).front();
  EXPECT_NO_THROW(load_tests(dir.scenario(sample), {})) << sample;
}

/// The pages of docs and README, by their names.
std::vector<fs::path> all_pages() {
  std::vector<fs::path> found{root / "README.md", root / "CONTRIBUTING.md"};
  for (const auto& entry : fs::recursive_directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") found.push_back(entry.path());
  return found;
}

TEST(Docs, KeysToExplainExist) {
  static const std::regex command(R"(subsoil explain ([A-Za-z_.]+[A-Za-z_]))");
  int seen = 0;
  for (const fs::path& page : all_pages()) {
    const std::string text = read(page);
    for (std::sregex_iterator it(text.begin(), text.end(), command), end; it != end; ++it) {
      if ((*it)[1] == "KEY") continue;
      EXPECT_NO_THROW(explain((*it)[1])) << page << ": " << it->str();
      ++seen;
    }
  }
  EXPECT_GT(seen, 2);
}

/// Links are checked by tests/docs/links.py.
TEST(Docs, ScriptsNamedAreThere) {
  static const std::regex script(R"((scripts/[a-z0-9_]+(?:\.py)?))");
  for (const fs::path& page : all_pages()) {
    const std::string text = read(page);
    for (std::sregex_iterator it(text.begin(), text.end(), script), end; it != end; ++it) {
      const fs::path file = root / it->str();
      ASSERT_TRUE(fs::exists(file)) << page << ": " << it->str();
      EXPECT_EQ(access(file.c_str(), X_OK), 0) << file << " cannot be executed";
    }
  }
}

TEST(Docs, CommandsOfTheReadmeAreThere) {
  const std::string text = read(root / "README.md");
  for (const char* command : {"scripts/reduced", "scripts/test"}) {
    EXPECT_NE(text.find(std::string("\n") + command), std::string::npos) << command;
    EXPECT_EQ(access((root / command).c_str(), X_OK), 0) << command;
  }
  EXPECT_NE(read(root / ".ci/run").find("scripts/test"), std::string::npos) << ".ci/run must pass the README's tests";
}

}  // namespace
}  // namespace subsoil::sim::docs_test
