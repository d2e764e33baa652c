#include <gtest/gtest.h>

#include "apps/output/series.hpp"
#include "tests/tools/program_runs.hpp"

/// Every named surface of a body has columns and a block of its own, also where one boundary of the bed carries
/// several.
namespace subsoil::app::run_surfaces {
namespace {

using namespace test;

/// A body that is held, with two shelves apart and a sphere over each: 20 mm and 10 mm of radius.
constexpr const char* shelves = R"(subsoil: 1
materials:
  stone: {density: 2000 kg/m^3}
  steel: {density: 7850 kg/m^3}
contacts:
  - {between: [stone, stone], law: linear, k_n: 20 kN/m, restitution: 0.3, mu: 0.5}
  - {between: [stone, steel], law: linear, k_n: 20 kN/m, restitution: 0.1, mu: 0.5}
soil:
  bed:
    fill: particles
    material: stone
    particles:
      - {position: -0.1 0.031 0 m, radius: 20 mm}
      - {position: 0.1 0.021 0 m, radius: 10 mm}
machine:
  bodies:
    rack: {mass: 5 kg, inertia: 1 kg m^2, at: 0 0 m}
  joints:
    held: {fixed: [ground, rack], at: 0 0 m}
  surfaces:
    left: {body: rack, material: steel, box: 100 20 100 mm, at: -0.1 0 0 m}
    right: {body: rack, material: steel, box: 100 20 100 mm, at: 0.1 0 0 m}
time: {end: 0.4 s}
output: {every: 0.1 s, watch: {on the right: {soil force: right, along: 0 1}}}
)";

double mean_of_last(const std::vector<double>& values, std::size_t rows) {
  double sum = 0;
  for (std::size_t i = values.size() - rows; i < values.size(); ++i) sum += values[i];
  return sum / static_cast<double>(rows);
}

TEST(RunSurfaces, EachCarriesTheWeightOfWhatLiesOnIt) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(shelves), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const auto weight = [](double r) { return 2000 * 4.0 / 3 * 3.141592653589793 * r * r * r * 9.81; };
  // At rest over the last 50 ms: what is left of the bounce is below 0.1 % after twenty half periods at 0.1.
  EXPECT_NEAR(mean_of_last(series.at("left.Fy"), 50), -weight(0.02), 1e-3 * weight(0.02));
  EXPECT_NEAR(mean_of_last(series.at("right.Fy"), 50), -weight(0.01), 1e-3 * weight(0.01));
  EXPECT_EQ(series.at("on the right"), series.at("right.Fy"));
  // Moment of a weight on an arm of 0.1 m about the body's centre, on either side.
  EXPECT_NEAR(mean_of_last(series.at("left.Mz"), 50), 0.1 * weight(0.02), 1e-3 * weight(0.02));
  EXPECT_NEAR(mean_of_last(series.at("right.Mz"), 50), -0.1 * weight(0.01), 1e-3 * weight(0.01));
  for (std::size_t row = 0; row < series.rows(); ++row)
    EXPECT_NEAR(series.at("rack.soil.Fy")[row], series.at("left.Fy")[row] + series.at("right.Fy")[row],
                1e-7 * weight(0.02))
        << "nine digits of the file, row " << row;
}

TEST(RunSurfaces, EachIsABlockOfTheFrames) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(shelves), dir / "out", {"time.end=1 ms"}), exit_ok);
  const auto file = h5::open_file(dir / "out" / "run.h5");
  for (const char* name : {"left", "right"}) {
    ASSERT_TRUE(h5::exists(file, std::string("/surfaces/") + name)) << name;
    EXPECT_EQ(h5::shape(file, std::string("/surfaces/") + name + "/triangles").at(0), 12U) << "a box";
  }
}

}  // namespace
}  // namespace subsoil::app::run_surfaces
