#include "libsim/setup/world.hpp"
#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"

/// Every file in configs/ and configs/validation is read, built and stepped 200 times; whoever adds one need not add a
/// test. What the short ones show is asserted where they run to their end: tests/verification/scenarios.
namespace subsoil::sim::run_configs {
namespace {

using test::config;

std::vector<std::string> all_configs() {
  std::vector<std::string> names;
  for (const std::string folder : {"", "validation/"})
    for (const auto& entry : std::filesystem::directory_iterator(subsoil::test::source_dir() + "/configs/" + folder))
      if (entry.path().extension() == ".yaml") names.push_back(folder + entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// What makes a scenario small enough to be built in a second: a short settling, a slice of a large bin, a low heap.
std::vector<std::string> cuts(const Scenario& s) {
  if (!s.soil || !s.soil->bed) return {};
  const BedSection& bed = *s.soil->bed;
  std::vector<std::string> sets;
  for (std::size_t i = 0; i < bed.layers.size(); ++i)
    sets.push_back("soil.bed.layers[" + std::to_string(i) + "].thickness=15 mm");
  // Spheres of a random bed fall on each other for some 30 ms. How it comes to rest the templates' runs show.
  if (bed.settle && !bed.settle->compacts())
    sets.push_back(bed.fill == Fill::random ? "soil.bed.settle={for: 30 ms}" : "soil.bed.settle={for: 3 ms}");
  if (bed.fill == Fill::random && bed.layers.empty())
    sets.push_back(bed.count ? "soil.bed.count=500" : "soil.bed.depth=40 mm");
  if (bed.fill == Fill::random) return sets;
  if (s.soil->container && s.soil->container->size.z > 1)
    sets.push_back("soil.bed.region={size: 0.3 0.4 0.2 m, at: 0.5 -0.4 -0.1 m}");
  return sets;
}

class Config : public testing::TestWithParam<std::string> {};

TEST_P(Config, OpensWithACommentThatSaysWhatToExpect) {
  std::ifstream file(config(GetParam()));
  std::string first;
  std::getline(file, first);
  EXPECT_EQ(first.rfind("# ", 0), 0U);
}

TEST_P(Config, IsBuiltAndStepped) {
  std::vector<std::string> sets = cuts(load_scenario(config(GetParam())).scenario);
  const Loaded loaded = load_scenario(config(GetParam()), sets);
  const test::RunDirectory directory;
  if (!loaded.scenario.runs_in_time()) {  // an analysis of one pose has no steps
    EXPECT_EQ(test::run_scenario(config(GetParam()), directory / "out"), exit_ok);
    return;
  }
  BuildOptions options;
  options.threads = 1;
  options.settle = false;
  const World world = build_world(loaded, options);
  const double step = world.bed ? world.step.soil_step : world.step.machine_step;
  sets.push_back("time.end=" + std::to_string(200 * step * 1e6) + " us");
  const Window& window = loaded.scenario.output.window;
  if (window.from || window.until) sets.push_back("output.window={from: 0 s}");  // its own lies beyond this end
  ASSERT_EQ(test::run_scenario(config(GetParam()), directory / "out", sets), exit_ok);
  EXPECT_NO_THROW(load_scenario(directory / "out/scenario.yaml")) << "what the run writes reads as it stands";
  // Random beds have no spheres yet when their step is guessed, so allow for another step.
  const double steps = test::summary_of(directory / "out")["run"]["steps"].get<double>();
  EXPECT_GT(steps, 140);
  // What a machine alone is watched for is looked at within the steps that the method chose, however short.
  const auto& out = loaded.scenario.output;
  const bool looks = !world.bed && (!out.watch.empty() || !out.crossings.empty());
  if (!looks) {
    EXPECT_LT(steps, 260);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Config, testing::ValuesIn(all_configs()), [](const auto& info) {
  std::string name = info.param;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
});

}  // namespace
}  // namespace subsoil::sim::run_configs
