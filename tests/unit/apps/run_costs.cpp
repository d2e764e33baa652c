#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"

/// What `check` promises of memory and disk against what the run that follows takes. The promised time is held against
/// the clock by `scripts/bench --promise`: it depends on what else the machine does.
namespace subsoil::sim::run_costs {
namespace {

using test::RunDirectory;

struct Costs {
  double memory = 0, disk = 0;
};

/// "28.4 MB" in bytes.
double byte_count(const std::string& text) {
  double value = 0;
  char unit[8] = {};
  if (std::sscanf(text.c_str(), "%lf %7s", &value, unit) != 2) return NAN;
  return value * (std::string(unit) == "GB" ? 1e9 : 1e6);
}

/// The program's own words.
std::vector<std::string> lines_of_check(const std::string& file) {
  std::vector<std::string> lines;
  FILE* pipe = popen((subsoil::test::program() + " check --threads 1 " + file).c_str(), "r");
  std::array<char, 512> line{};
  while (pipe != nullptr && std::fgets(line.data(), line.size(), pipe) != nullptr) lines.push_back(line.data());
  EXPECT_EQ(pclose(pipe), 0);
  return lines;
}

Costs promised(const std::string& file) {
  Costs costs;
  for (const std::string& text : lines_of_check(file)) {
    const std::size_t about = text.find("about ");
    if (about == std::string::npos) continue;
    if (text.rfind("memory", 0) == 0) costs.memory = byte_count(text.substr(about + 6));
    if (text.rfind("disk", 0) == 0) costs.disk = byte_count(text.substr(about + 6));
  }
  return costs;
}

Costs taken(const std::string& file, const std::filesystem::path& out) {
  const std::string command =
      subsoil::test::program() + " run --threads 1 --force --out " + out.string() + " " + file + " >/dev/null";
  EXPECT_EQ(std::system(command.c_str()), 0);
  const nlohmann::json run = test::summary_of(out)["run"];
  Costs costs{.memory = run["peak memory [bytes]"], .disk = 0};
  for (const auto& entry : std::filesystem::recursive_directory_iterator(out))
    if (entry.is_regular_file()) costs.disk += static_cast<double>(entry.file_size());
  return costs;
}

void expect_within(double promised, double taken, const char* what) {
  EXPECT_LT(promised / taken, 1.5) << what << ": promised " << promised << ", taken " << taken;
  EXPECT_GT(promised / taken, 1 / 1.5) << what << ": promised " << promised << ", taken " << taken;
}

TEST(RunCosts, CheckHoldsMemoryAndDiskWithinAFactorOfOneAndAHalf) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "check promises costs of the program that users run; the sanitizers triple its memory";
#endif
  const RunDirectory dir;
  std::string text = test::small_pass;
  // A bed of 4,000 spheres and twenty frames, so that no fixed cost hides what is estimated.
  text.replace(text.find("0.16 0.085 0.13 m"), 17, "0.40 0.130 0.26 m");
  text.replace(text.find("at: 0 -0.085 -0.065 m"), 21, "at: 0 -0.130 -0.13 m");
  text.replace(text.find("end: 0.15 s"), 11, "end: 0.20 s");
  text.replace(text.find("every: 25 ms"), 12, "every: 10 ms");
  const std::string file = dir.scenario(text + "limits: {overlap: 1.5}\n");
  const Costs before = promised(file), after = taken(file, dir / "out");
  expect_within(before.memory, after.memory, "memory");
  expect_within(before.disk, after.disk, "disk");
}

/// What follows `name` in the first line of `check` that has it.
std::string word_of_check(const std::string& file, const std::string& name) {
  for (const std::string& text : lines_of_check(file))
    if (const std::size_t at = text.find(name); at != std::string::npos) return text.substr(at + name.size());
  return {};
}

/// Before anything is poured: even masses of 3 and 6 mm are eight small spheres to a large one, and the small ones set
/// the step. What is promised stands on a cubic lattice of whole rows, 0.45 of the room or more, where poured spheres
/// take 0.6; spheres of the middle radius would be 0.4 of their number.
TEST(RunCosts, CheckExpectsTheSizesThatWillRain) {
  const RunDirectory dir;
  const std::string file = dir.scenario(R"(subsoil: 1
materials: {grain: {density: 2600 kg/m^3}}
contacts: [{between: [grain, grain], law: linear, k_n: 20 kN/m, restitution: 0.4, mu: 0.5}]
soil:
  container: {size: 0.1 0.1 0.1 m, at: 0 0 0 m, material: grain}
  bed:
    {fill: random, material: grain, radius: {table: [[3 mm, 1], [6 mm, 1]]}, shares: mass, depth: 60 mm,
     settle: {until: 30 mm/s}}
time: {end: 1 ms, safety: 0.8}
)");
  EXPECT_EQ(word_of_check(file, "on a sphere of radius ").substr(0, 4), "3.00");
  const double solid = 0.6 * 0.1 * 0.1 * 0.06,
               each = 4.0 / 3.0 * 3.14159 * 2 / (std::pow(0.003, -3) + std::pow(0.006, -3));
  const double promised = std::stod(word_of_check(file, "spheres         about "));
  EXPECT_NEAR(promised, solid / each, 0.3 * solid / each);
}

/// Of 40 grains that are clumps of three or of two spheres, by lot.
TEST(RunCosts, CheckCountsTheClumpsThatAreDrawn) {
  const RunDirectory dir;
  const std::string file = dir.scenario(R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {grain: {density: 1200 kg/m^3}}
contacts: [{between: [grain, grain], law: linear, k_n: 10 kN/m, restitution: 0.4, mu: 0.5}]
soil:
  container: {size: 160 200 160 mm, at: 0 0 0 m, material: grain}
  clumps:
    three: {spheres: [{at: -5 0 0 mm, radius: 7 mm}, {at: 5 0 0 mm, radius: 6 mm}, {at: 0 6 0 mm, radius: 5 mm}]}
    two: {spheres: [{at: 0 0 0 mm, radius: 8 mm}, {at: 7 0 2 mm, radius: 7 mm}]}
  bed: {fill: random, material: grain, count: 40, clumps: [{shape: three, share: 0.6}, {shape: two, share: 0.4}], settle: {for: 1 ms}}
time: {end: 1 ms}
)");
  const double promised = std::stod(word_of_check(file, "spheres         "));
  ASSERT_EQ(test::run_scenario(file, dir / "out"), exit_ok);
  EXPECT_EQ(promised, test::summary_of(dir / "out")["soil"]["spheres"].get<double>());
}

}  // namespace
}  // namespace subsoil::sim::run_costs
