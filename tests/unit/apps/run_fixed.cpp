#include <gtest/gtest.h>

#include <cmath>

#include "libsim/document/document.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/soil_runs.hpp"

/// Spheres that a scenario fixes: columns, frames, restarts, refusals.
namespace subsoil::sim::run_fixed {
namespace {

using namespace test;

/// Two fixed spheres of 10 mm carry a third one between them.
constexpr const char* nest = R"(subsoil: 1
materials: {steel: {density: 7850 kg/m^3}}
contacts: [{between: [steel, steel], law: linear, k_n: 100 kN/m, restitution: 0.3, mu: 0}]
soil:
  bed:
    fill: particles
    material: steel
    particles:
      - {position: -12 0 0 mm, radius: 10 mm, fixed: nest}
      - {position: 12 0 0 mm, radius: 10 mm, fixed: nest}
      - {position: 1 17 0 mm, radius: 10 mm}
time: {end: 0.4 s}
output: {precision: double, at: [0.1 s], series every: 10 ms, watch: {load: {soil force: nest, along: 0 -1}}}
)";
const double weight = 7850 * 4.0 / 3 * M_PI * 1e-6 * 9.81;

TEST(RunFixed, TheyCarryWhatLiesOnThem) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(nest), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_NEAR(series.at("load").back(), weight, 0.01 * weight);
  EXPECT_NEAR(series.at("nest.Fx").back(), 0, 0.02 * weight);
  EXPECT_NEAR(series.at("nest.Fy").back(), -weight, 0.01 * weight);
  const std::vector<dem::Vec3> places = frame_positions(dir / "out", 1);
  EXPECT_EQ(places[0].x, -0.012);
  EXPECT_EQ(places[0].y, 0);
  EXPECT_EQ(places[1].x, 0.012);
  // The balance closes: what the third one has lost in height is damped or stored.
  const double fell = series.at("soil.gravity").front() - series.at("soil.gravity").back();
  EXPECT_GT(fell, 0);
  EXPECT_NEAR(conserved_energy(series, series.rows() - 1), conserved_energy(series, 0), 0.01 * fell);
}

TEST(RunFixed, ARestartKeepsThem) {
  const RunDirectory dir;
  const std::string file = dir.scenario(nest);
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "first", {"time.end=0.2 s"}), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "on", {}, state_in(dir / "first")), exit_ok);
  const Series whole = read_series(dir / "whole" / "series.csv"), on = read_series(dir / "on" / "series.csv");
  EXPECT_NEAR(on.at("load").back(), whole.at("load").back(), 1e-8 * weight);
  EXPECT_EQ(frame_positions(dir / "on", 0)[0].x, -0.012);
}

std::string refusal(const std::string& from, const std::string& to) {
  const RunDirectory dir;
  std::string text = nest;
  return subsoil::test::message_of<ScenarioError>(
      [&] { run_scenario(dir.scenario(text.replace(text.find(from), from.size(), to)), dir / "out"); });
}

TEST(RunFixed, RefusalsSayWhy) {
  EXPECT_NE(refusal("fixed: nest", "fixed: a.b").find("leave out dots and commas"), std::string::npos);
  EXPECT_NE(refusal("fixed: nest", "fixed: soil").find("is the name of the soil's sums too"), std::string::npos);
  EXPECT_NE(refusal("  bed:\n", "  active: {}\n  bed:\n").find("stands beside `soil.active`"), std::string::npos);
  EXPECT_NE(refusal("    particles:\n      - {position: -12 0 0 mm,",
                    "    settle: {until: 1 mm/s}\n    particles:\n      - {velocity: 1 0 0 m/s, position: -12 0 0 mm,")
                .find("moves while the bed settles"),
            std::string::npos);
}

/// 64 spheres that touch in a box of whole diameters, 16 of them fixed at the floor: pi/6 of their density, and the
/// mass of all, as without the key. They stand a rest overlap deep in the floor, below 1e-3 of the height.
TEST(RunFixed, ARoughFloorBelongsToTheBedThatIsMeasured) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {soil: {density: 2000 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 50 kN/m, restitution: 0.4, mu: 0.3}
  - {<<: *dry, between: [soil, steel]}
soil:
  container: {size: 80 100 80 mm, at: 0 0 0 mm, material: steel}
  bed: {fill: lattice, pitch: 20 mm, material: soil, radius: 10 mm, depth: 80 mm, rough floor: 12 mm}
time: {end: 1 ms}
)"),
                         dir / "out"),
            exit_ok);
  const nlohmann::json soil = summary_of(dir / "out")["soil"];
  const double mass = 64 * 2000 * 4.0 / 3 * M_PI * 1e-6;
  EXPECT_EQ(soil["spheres"], 64);
  EXPECT_NEAR(soil["mass [kg]"], mass, 1e-9 * mass);
  EXPECT_NEAR(soil["bulk density [kg/m3]"], 2000 * M_PI / 6, 2e-3 * 2000 * M_PI / 6);
}

}  // namespace
}  // namespace subsoil::sim::run_fixed
