#include <gtest/gtest.h>

#include <cmath>

#include "libsim/document/document.hpp"
#include "libsim/post/fields.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/soil_runs.hpp"

/// Scenarios with periodic sides: fills, frames, restarts, fields, refusals.
namespace subsoil::sim::run_periodic {
namespace {

using namespace test;

/// Grains of 10 mm between two walls in z, in a gale along x.
const std::string channel = R"(subsoil: 1
gravity: 6 -9.81 0 m/s^2
materials: {grain: {density: 2500 kg/m^3}}
contacts: [{between: [grain, grain], law: linear, k_n: 20 kN/m, restitution: 0.6, mu: 0.3}]
soil:
  container: {size: 120 200 80 mm, at: 0 0 0 m, material: grain, periodic: [x]}
  bed: {fill: lattice, material: grain, radius: 10 mm, pitch: 20 mm, depth: 80 mm, jitter: 0.02}
time: {end: 0.3 s}
output: {precision: double, every: 20 ms, series every: 10 ms, contact forces: yes}
)";

std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::string refusal(const std::string& from, const std::string& to) {
  const RunDirectory dir;
  return subsoil::test::message_of<ScenarioError>(
      [&] { run_scenario(dir.scenario(with(channel, from, to)), dir / "out"); });
}

// Friction holds the bed on a slope of 0.15, a tenth of it does not.
TEST(RunPeriodic, ABedThatSlidesWhileItSettlesIsRefusedWithTheCure) {
  const auto poured = [](const char* settle) {
    const std::string slope = with(channel, "gravity: 6 -9.81", "gravity: 1.5 -9.81");
    const std::string shape = with(slope, "size: 120 200 80 mm", "size: 60 200 40 mm");
    const std::string fill =
        "fill: random, material: grain, radius: 8 mm, depth: 30 mm, settle: " + std::string(settle);
    return with(with(shape, "time: {end: 0.3 s}", "time: {end: 1 ms}"),
                "fill: lattice, material: grain, radius: 10 mm, pitch: 20 mm, depth: 80 mm, jitter: 0.02", fill);
  };
  const RunDirectory dir;
  const std::string fault = subsoil::test::message_of<std::exception>([&] {
    build_world(load_scenario(dir.scenario(poured("{at most: 1 s}")), {}),
                {.threads = 1, .restored = {}, .progress = {}});
  });
  EXPECT_NE(fault.find("the bed slides as one at"), std::string::npos) << fault;
  EXPECT_NE(fault.find("gravity pulls with 1.5 m/s^2 along them, and friction is lowered to 0.1"), std::string::npos)
      << fault;
  EXPECT_EQ(run_scenario(dir.scenario(poured("{lowered: 1}")), dir / "rests"), exit_ok);
}

// A sphere falls freely through the open floor of a channel and is removed with the energy that it began with, m g y,
// but for half a step of its speed.
TEST(RunPeriodic, GoesOnEmptyWhenTheLastSphereHasLeft) {
  const RunDirectory dir;
  const std::string falling = R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {grain: {density: 2500 kg/m^3}}
contacts: [{between: [grain, grain], law: linear, k_n: 5 kN/m, restitution: 0.5, mu: 0.5}]
soil:
  container: {size: 120 600 60 mm, at: 0 0 0 m, material: grain, periodic: [x, z], open: [-y, +y]}
  bed: {fill: particles, material: grain, particles: [{position: 60 20 30 mm, radius: 5 mm}]}
  remove below: 0.3 m
time: {end: 400 ms}
output: {series every: 20 ms, every: 100 ms}
)";
  ASSERT_EQ(run_scenario(dir.scenario(falling), dir / "out"), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out");
  EXPECT_EQ(summary["soil"]["fallen out and removed"], 1);
  EXPECT_NEAR(summary["run"]["simulated [s]"], 0.4, 1e-3);
  const double energy = 2500 * 4.0 / 3 * M_PI * 1.25e-7 * 9.81 * 0.02;
  EXPECT_NEAR(read_series(dir / "out" / "series.csv").at("soil.removed").back(), energy, 0.01 * energy);
}

TEST(RunPeriodic, GrainsGoRoundAndStayInTheCell) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(channel), dir / "out"), exit_ok);
  const std::size_t frames = frame_times(dir / "out").size();
  int came_round = 0;
  std::vector<dem::Vec3> before;
  for (std::size_t f = 0; f < frames; ++f) {
    const std::vector<dem::Vec3> now = frame_positions(dir / "out", static_cast<int>(f));
    ASSERT_EQ(now.size(), 6u * 4 * 4);
    for (std::size_t i = 0; i < now.size(); ++i) {
      EXPECT_TRUE(now[i].x >= 0 && now[i].x < 0.12 && now[i].y > 0 && now[i].z > 0 && now[i].z < 0.08) << f << i;
      if (!before.empty()) came_round += now[i].x < before[i].x - 0.06;
    }
    before = now;
  }
  EXPECT_GT(came_round, 50);
  const Series series = read_series(dir / "out" / "series.csv");
  const double gained = -series.at("soil.removed").back();
  EXPECT_GT(gained, 0.5) << "by gravity along x, of those that went round";
  EXPECT_NEAR(conserved_energy(series, series.rows() - 1), conserved_energy(series, 0), 0.01 * gained);
  const Json energy = summary_of(dir / "out")["energy"];
  const double put_in = energy["work put in [J]"].get<double>();
  EXPECT_NEAR(energy["round a period or with spheres removed [J]"].get<double>(), gained, 1e-6 * gained);
  EXPECT_NEAR(put_in, gained + energy["gravity on the soil [J]"].get<double>(), 1e-6 * gained);
  EXPECT_EQ(summary_of(dir / "out")["soil"]["outside the container at the end"], 0);
}

TEST(RunPeriodic, ARestartEndsWithTheSameBits) {
  const RunDirectory dir;
  const std::string file = dir.scenario(channel);
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "first", {"time.end=0.14 s"}), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "on", {}, state_in(dir / "first")), exit_ok);
  const auto whole = frame_positions(dir / "whole", 15);
  const auto on = frame_positions(dir / "on", static_cast<int>(frame_times(dir / "on").size()) - 1);
  for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_TRUE(whole[i] == on[i]) << i;
}

/// Coarse graining goes on beyond the sides: a lattice looks the same from place to place, a pitch apart. The far sides
/// are the near ones and have no points.
TEST(RunPeriodic, FieldsGoOnBeyondTheSides) {
  const RunDirectory dir;
  std::string text = with(channel, "periodic: [x]", "periodic: [x, z]");
  text = with(text, ", jitter: 0.02", "");
  text = with(text, "end: 0.3 s", "end: 1 ms");
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
  FieldsRequest request{.run = dir / "out"};
  request.spacing = 0.01, request.width = 0.02;
  request.times = {0};
  const FieldsReport report = write_fields(request);
  ASSERT_EQ(report.grid.n[0], 12u);
  ASSERT_EQ(report.grid.n[2], 8u);
  EXPECT_NEAR(report.grid.low.x, 0, 1e-12);
  const auto file = h5::open_file(dir / "out" / "fields.h5");
  for (const char* name : {"bulk density", "porosity"}) {
    const std::vector<float> field = h5::read<float>(file, std::string("/frames/000000/") + name);
    for (std::size_t k = 0; k < 8; ++k)
      for (std::size_t j = 0; j < report.grid.n[1]; ++j)
        for (std::size_t i = 0; i < 12; ++i) {
          const auto at = [&](std::size_t a, std::size_t c) { return field[(c * report.grid.n[1] + j) * 12 + a]; };
          EXPECT_NEAR(at(i, k), at(i % 2, k % 2), 1e-5F * (1 + at(i, k))) << name << i << j << k;
        }
  }
}

/// A plate of 240 by 160 mm rests on the spheres of a cell of 120 by 80 mm: of each of the two triangles below 4,800
/// mm2 lie in it, and the rest bears nothing.
TEST(RunPeriodic, LoadsOfASurfaceThatSpansTheCellAreThoseOfItsPartInIt) {
  const RunDirectory dir;
  std::string text = with(channel, "gravity: 6 -9.81 0 m/s^2\n", "");
  text = with(text, "periodic: [x]", "periodic: [x, z]");
  text = with(text, "time: {end: 0.3 s}",
              "boundaries: [{name: plate, material: grain, shape: {box: 240 20 160 mm}, at: 60 88 40 mm, "
              "wear: {coefficient: 1, hardness: 1 GPa}}]\ntime: {end: 20 ms}");
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
  const double force = summary_of(dir / "out")["wear"]["plate"]["mean normal force [N]"];
  ASSERT_GT(force, 1);
  const auto file = h5::open_file(dir / "out" / "run.h5");
  double sum = 0;
  for (const double p : h5::read<double>(file, "/frames/000001/loads/plate/mean pressure")) sum += p * 4.8e-3;
  EXPECT_NEAR(sum, force, 0.01 * force)
      << "the frame is of a step more or less; all of the plate has four times the area";
}

/// A blade through a cell of 80 mm works 80 mm, however far it reaches beyond the sides.
TEST(RunPeriodic, AFurrowFillsTheCell) {
  const RunDirectory dir;
  std::string text = with(channel, "gravity: 6 -9.81 0 m/s^2\n", "");
  text = with(text, "size: 120 200 80 mm", "size: 200 200 80 mm");
  text = with(text, "periodic: [x]", "periodic: [z]");
  text = with(text, "time: {end: 0.3 s}",
              "boundaries: [{name: blade, material: grain, shape: {box: 10 80 160 mm}, at: -20 100 40 mm, "
              "moves: [{velocity: 1 0 0 m/s}]}]\ntime: {end: 0.18 s}");
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
  const nlohmann::json d = summary_of(dir / "out")["disturbance"];
  ASSERT_FALSE(d.contains("none")) << d;
  EXPECT_NEAR(d["width in the soil [m]"].get<double>(), 0.08, 1e-12);
  const std::vector<double> z = d["profile"]["z [m]"];
  ASSERT_EQ(z.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(z[k], 0.01 + 0.02 * static_cast<double>(k), 1e-12);
  EXPECT_LE(d["furrow width [m]"].get<double>(), 0.08 + 1e-12);
}

TEST(RunPeriodic, RainFillsACellWithoutSeam) {
  const RunDirectory dir;
  std::string text = with(channel, "gravity: 6 -9.81 0 m/s^2\n", "");
  text = with(text, "periodic: [x]", "periodic: [x, z]");
  text = with(text, "fill: lattice, material: grain, radius: 10 mm, pitch: 20 mm, depth: 80 mm, jitter: 0.02",
              "fill: random, material: grain, radius: 6 mm, count: 300");
  text = with(text, "end: 0.3 s", "end: 10 ms");
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
  const nlohmann::json soil = summary_of(dir / "out")["soil"];
  EXPECT_EQ(soil["spheres"], 300);
  EXPECT_GT(soil["contacts per sphere"], 4.0) << "sides count";
  // Thirds of the cell hold as much at its sides as in its middle.
  int thirds[3]{};
  for (const dem::Vec3& x : frame_positions(dir / "out", 0)) ++thirds[static_cast<int>(x.x / 0.04)];
  for (const int n : thirds) EXPECT_NEAR(n, 100, 15);
}

TEST(RunPeriodic, RefusalsSayWhy) {
  const auto expect = [](const std::string& from, const std::string& to, const std::string& said) {
    const std::string text = refusal(from, to);
    EXPECT_NE(text.find(said), std::string::npos) << text;
  };
  expect("pitch: 20 mm", "pitch: 21 mm", "is no whole number of pitches of 21 mm; make it 105 mm or 126 mm");
  expect("periodic: [x]", "periodic: [x], open: [+x]", "the face +x is periodic and has no wall; leave it out");
  expect("periodic: [x]", "periodic: [x], open after settling: [-x]", "the face -x is periodic");
  expect("periodic: [x]", "periodic: [q]", "directions are x, y, z");
  expect("size: 120 200 80 mm", "size: 40 200 80 mm", "soil.container: the period of 0.04 m in x is too short");
  expect("periodic: [x]}", "periodic: [x, y]}\n  surface: 0 m", "has no floor and no surface");
}

}  // namespace
}  // namespace subsoil::sim::run_periodic
