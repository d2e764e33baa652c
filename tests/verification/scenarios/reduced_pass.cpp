#include <algorithm>

#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"

/// The first 0.42 s of configs/1s300-reduced.yaml: 0.15 m of the shovel's way in soil, what two minutes of one core
/// allow.
namespace subsoil::app {
namespace {

/// The towed rig outside the soil holds spring force and pitch still (a steady state), so whatever they swing by is the
/// soil's doing. The bounds are the least that a working self-excited subsoiler must show: a fifth of the source's
/// spring range and of its pitch range.
TEST(ReducedPass, SoilSwingsTheSpringAndThePitch) {
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(subsoil::test::source_dir() + "/configs/1s300-reduced.yaml", dir / "out",
                               {"time.end=0.42 s", "output.every=0.2 s", "output.state=none"}),
            exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const auto swing = [&](const char* name) {
    const std::vector<double>& values = series.at(name);
    return *std::max_element(values.begin(), values.end()) - *std::min_element(values.begin(), values.end());
  };
  EXPECT_GT(swing("spring force"), 500.0);
  EXPECT_GT(swing("pitch"), 0.02);
  // Before it meets soil (0.06 m at 0.5 m/s) it is towed steadily.
  EXPECT_NEAR(series.at("pull")[50], 328.9, 0.1) << "the equilibrium without soil, at 50 ms";
  const nlohmann::json energy = test::summary_of(dir / "out")["energy"];
  EXPECT_LT(std::abs(energy["closure over work put in"].get<double>()), 0.01);
}

}  // namespace
}  // namespace subsoil::app
