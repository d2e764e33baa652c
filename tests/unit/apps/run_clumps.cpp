#include <gtest/gtest.h>

#include <cmath>

#include "libdem/particles/particles.hpp"
#include "libsim/document/document.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/soil_runs.hpp"

/// Scenarios with clumps: places, shares, frames, restarts, refusals.
namespace subsoil::sim::run_clumps {
namespace {

using namespace test;

/// A dumbbell leans beside a loose sphere and falls over.
const std::string skittle = R"(subsoil: 1
materials: {wood: {density: 700 kg/m^3}}
contacts: [{between: [wood, wood], law: linear, k_n: 20 kN/m, restitution: 0.5, mu: 0.4}]
soil:
  container: {size: 200 200 200 mm, at: 0 0 0 m, material: wood}
  clumps:
    pin: {spheres: [{at: 0 0 0 mm, radius: 10 mm}, {at: 30 0 0 mm, radius: 10 mm}]}
  bed:
    fill: particles
    material: wood
    particles: [{position: 150 10 150 mm, radius: 10 mm}]
    placed: [{shape: pin, position: 100 25 100 mm, rotation: {axis: 0 0 1, angle: 70 deg}}]
time: {end: 0.4 s}
output: {precision: double, every: 50 ms, series every: 10 ms}
)";

/// Half of the grains are clumps.
const std::string mixture = R"(subsoil: 1
materials: {seed: {density: 1200 kg/m^3}}
contacts: [{between: [seed, seed], law: linear, k_n: 5 kN/m, restitution: 0.4, mu: 0.4}]
soil:
  container: {size: 60 60 60 mm, at: 0 0 0 m, material: seed}
  clumps:
    bean: {spheres: [{at: 0 0 0 mm, radius: 3 mm}, {at: 4 0 0 mm, radius: 3 mm}], density: 1300 kg/m^3}
  bed: {fill: random, material: seed, radius: 3 mm, count: 200, clumps: [{shape: bean, share: 0.5}]}
time: {end: 20 ms}
output: {precision: double, every: 10 ms, series every: 10 ms}
)";

std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::vector<std::int32_t> clumps_of(const std::filesystem::path& out) {
  return h5::read<std::int32_t>(h5::open_file(out / "run.h5"), "/particles/clump");
}

TEST(RunClumps, APinFallsOver) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(skittle), dir / "out"), exit_ok);
  EXPECT_EQ(clumps_of(dir / "out"), (std::vector<std::int32_t>{-1, 0, 0}));
  const auto first = frame_positions(dir / "out", 0), last = frame_positions(dir / "out", 8);
  EXPECT_NEAR(first[2].y - first[1].y, 0.03 * std::sin(70 * M_PI / 180), 1e-12);
  EXPECT_NEAR(0.5 * (first[1].x + first[2].x), 0.1, 1e-12);
  for (const auto& at : {first, last}) EXPECT_NEAR(dem::norm(at[2] - at[1]), 0.03, 1e-12);
  EXPECT_LT(last[2].y, 0.011) << "it lies";
  const Series series = read_series(dir / "out" / "series.csv");
  const double fell = series.at("soil.gravity").front() - series.at("soil.gravity").back();
  const double mass = 2 * 700 * 4.0 / 3 * M_PI * 1e-6;
  EXPECT_NEAR(fell, mass * 9.81 * 0.015, 0.02 * fell);
  EXPECT_NEAR(conserved_energy(series, series.rows() - 1), conserved_energy(series, 0), 0.01 * fell);
}

TEST(RunClumps, ARestartEndsWithTheSameBits) {
  const RunDirectory dir;
  const std::string file = dir.scenario(skittle);
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "first", {"time.end=0.2 s"}), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "on", {}, state_in(dir / "first")), exit_ok);
  const auto whole = frame_positions(dir / "whole", 8);
  const auto on = frame_positions(dir / "on", frame_times(dir / "on").size() - 1);
  ASSERT_EQ(on.size(), 3u);
  for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_TRUE(whole[i] == on[i]) << i;
  EXPECT_EQ(clumps_of(dir / "on"), clumps_of(dir / "whole"));
}

/// Density times volume of the spheres in the file is the bed's mass, clumps included.
TEST(RunClumps, AMixtureHasItsMassInTheFrames) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(mixture), dir / "out"), exit_ok);
  const nlohmann::json soil = summary_of(dir / "out")["soil"];
  const auto clumps = soil["clumps"].get<std::size_t>();
  EXPECT_NEAR(static_cast<double>(clumps), 100, 25) << "3.5 standard deviations of 200 draws";
  EXPECT_EQ(soil["spheres"].get<std::size_t>(), 200 + clumps);
  const auto file = h5::open_file(dir / "out" / "run.h5");
  const auto radius = h5::read<double>(file, "/particles/radius"),
             density = h5::read<double>(file, "/particles/density");
  double mass = 0;
  for (std::size_t i = 0; i < radius.size(); ++i) mass += density[i] * dem::sphere_volume(radius[i]);
  EXPECT_NEAR(mass, soil["mass [kg]"].get<double>(), 1e-9 * mass);
  // A bean is two balls of 3 mm but for the lens that they share, pi (4 r + d)(2 r - d)^2/12 (d apart).
  const double ball = dem::sphere_volume(3e-3), lens = M_PI * 16e-3 * 4e-6 / 12;
  EXPECT_NEAR(mass,
              static_cast<double>(200 - clumps) * 1200 * ball + static_cast<double>(clumps) * 1300 * (2 * ball - lens),
              1e-9 * mass);
}

std::string refusal(const std::string& text, const std::string& from, const std::string& to) {
  const RunDirectory dir;
  const std::string file = dir.scenario(with(text, from, to));
  std::string message = subsoil::test::message_of<ScenarioError>([&] { run_scenario(file, dir / "out"); });
  if (const auto at = message.find(file + ":"); at == 0) message.erase(0, file.size() + 1);
  return message;
}

TEST(RunClumps, RefusalsNamePlaceRuleAndCure) {
  const auto expect = [](const std::string& message, const char* part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect(refusal(mixture, "shape: bean", "shape: been"),
         "soil.bed.clumps[0].shape = been: there is no clump of this name; did you mean `bean`?");
  expect(refusal(mixture, "share: 0.5}", "share: 0.6}, {shape: bean, share: 0.6}"),
         "soil.bed.clumps: have shares of 1.2 together; at most 1");
  expect(refusal(mixture, "share: 0.5", "share: 1"), "soil.bed.radius: has no effect: all grains are clumps");
  expect(refusal(mixture, "fill: random", "fill: rest-lattice"),
         "soil.bed.clumps: need `fill: random` or `lattice`; with `fill: particles` list them as `placed`");
  expect(refusal(mixture, "  bed:", "  active: {within: 0.1 m}\n  bed:"),
         "soil.active: freezes spheres one by one, and clumps are rigid; leave it out, or the clumps");
  expect(refusal(mixture, "material: seed}\n  clumps", "material: seed, periodic: [x]}\n  clumps"),
         "soil.container.periodic: lets spheres through one by one, and clumps are rigid");
  expect(refusal(mixture, "count: 200", "count: 200, save: bed.h5"),
         "soil.bed.save: keeps spheres one by one, and this bed has clumps");
  expect(refusal(mixture, "density: 1300 kg/m^3", "mass: 1 g, density: 1300 kg/m^3"),
         "soil.clumps.bean.density: stands beside `mass`; keep one of them");
  expect(refusal(mixture, "density: 1300 kg/m^3", "inertia: 1 1 1 g mm^2"),
         "soil.clumps.bean.inertia: needs `mass`, as measured");
  expect(refusal(mixture, "density: 1300 kg/m^3", "mass: 1 g, inertia: 1 1 5 g mm^2"),
         "soil.clumps.bean: no body has this inertia");
  expect(refusal(mixture, ", clumps: [{shape: bean, share: 0.5}]", ""),
         "soil.clumps: are used nowhere; name them in `soil.bed.clumps`");
  expect(refusal(skittle, "fill: particles", "fill: lattice\n    radius: 10 mm\n    pitch: 20 mm"),
         "soil.bed.placed: needs `fill: particles`; shares of a filled bed are `clumps`");
}

}  // namespace
}  // namespace subsoil::sim::run_clumps
