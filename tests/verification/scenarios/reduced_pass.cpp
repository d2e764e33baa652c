#include <algorithm>

#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"

/// The first 0.42 s of configs/1s300-towed-reduced.yaml, 0.15 m of the shovel's way in soil, and the landing of the
/// source's pass.
namespace subsoil::sim::reduced_pass {
namespace {

/// The towed rig outside the soil holds spring force and pitch still (a steady state), so whatever they swing by is the
/// soil's doing. The bounds are the least that a working self-excited subsoiler must show: a fifth of the source's
/// spring range and of its pitch range.
TEST(ReducedPass, SoilSwingsTheSpringAndThePitch) {
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(subsoil::test::source_dir() + "/configs/1s300-towed-reduced.yaml", dir / "out",
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
  EXPECT_LT(std::abs(energy["closure over energy there or put in"].get<double>()), 0.01);
}

double least(const std::vector<double>& v) { return *std::min_element(v.begin(), v.end()); }
double largest(const std::vector<double>& v) { return *std::max_element(v.begin(), v.end()); }

/// The first 0.3 s of configs/1s300-reduced.yaml: wheels and tip have landed at 0.25 s. Yuan & Yu (2020), figures 5 and
/// 6, print least pull, largest tension of the spring and span of height, which the landing gives; the bound is the 20
/// % that docs/1s300.md claims. The pitch's span is reached later; where the tension is largest the swing is at rest,
/// so that the damper is idle and the angle between shovel and frame is that of the spring alone, F = k a dphi with a =
/// 0.27 m (cosine: 0.1 %).
TEST(SourcePass, LandingGivesTheSourcesLeastPullTensionAndHeight) {
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(test::config("1s300-reduced"), dir / "out", {"time.end=0.3 s", "output.every=0.3 s"}),
            exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_NEAR(least(series.at("pull")), -331.0, 0.2 * 331.0);
  EXPECT_NEAR(least(series.at("spring force")), -2231.0, 0.2 * 2231.0);
  const std::vector<double>& height = series.at("height");
  EXPECT_NEAR(largest(height) - least(height), 0.181, 0.2 * 0.181);
  const std::vector<double>& spring = series.at("spring force");
  const auto row = static_cast<std::size_t>(std::min_element(spring.begin(), spring.end()) - spring.begin());
  EXPECT_NEAR(series.at("shovel.angle")[row] - series.at("frame.angle")[row], -spring[row] / 164e3 / 0.27, 0.002);
  const nlohmann::json energy = test::summary_of(dir / "out")["energy"];
  EXPECT_LT(std::abs(energy["closure over energy there or put in"].get<double>()), 0.01);
}

}  // namespace
}  // namespace subsoil::sim::reduced_pass
