#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "libsim/document/document.hpp"
#include "libsim/post/disturbance.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/soil_runs.hpp"

/// Scenarios whose bed goes on with the tool: what comes and goes, frames, restarts, refusals.
namespace subsoil::sim::run_moving {
namespace {

using namespace test;

const std::string pass = moving_pass;

std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::vector<std::int64_t> ids_of(const std::filesystem::path& out, std::size_t frame) {
  char name[48];
  std::snprintf(name, sizeof name, "/frames/%06zu/id", frame);
  return h5::read<std::int64_t>(h5::open_file(out / "run.h5"), name);
}

TEST(RunMoving, WhatComesAndGoesIsBookedAndShown) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(pass), dir / "out"), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out"), moving = summary["moving bed"], soil = summary["soil"];
  EXPECT_EQ(moving["blocks gone on"], 5);
  EXPECT_NEAR(moving["way of the window [m]"], 0.6, 1e-12);
  // Mass: five blocks came; three made the window, less what was carved: at most 0.0105 kg a sphere.
  const double block = static_cast<double>(moving["entered"]["mass [kg]"]) / 5, carved = soil["carved for the machine"];
  const std::size_t spheres = moving["spheres of a period"];
  EXPECT_EQ(static_cast<std::size_t>(soil["spheres"]) + static_cast<std::size_t>(carved), 3 * spheres);
  EXPECT_LT(static_cast<double>(soil["mass [kg]"]), 3 * block);
  EXPECT_NEAR(soil["mass [kg]"], 3 * block, carved * 0.0105);
  EXPECT_EQ(moving["entered"]["spheres"], 5 * spheres);
  const std::size_t left = moving["left"]["spheres"], there = moving["spheres in the window at the end"],
                    fallen = soil["fallen out and removed"];
  EXPECT_GT(carved, 0);
  EXPECT_EQ(left + there + fallen + static_cast<std::size_t>(carved), 8 * spheres);
  EXPECT_NEAR(static_cast<double>(moving["left"]["mass [kg]"]) +
                  static_cast<double>(moving["mass in the window at the end [kg]"]),
              8 * block, (carved + static_cast<double>(fallen)) * 0.0105);
  // Energy: the balance closes over five joints, and at every row.
  const Series series = read_series(dir / "out" / "series.csv");
  const double work = series.at("soil.boundary work").back();
  EXPECT_GT(work, 0.5);
  for (std::size_t row = 0; row < series.rows(); ++row)
    EXPECT_NEAR(conserved_energy(series, row), conserved_energy(series, 0), 5e-3 * work) << row;
  EXPECT_NEAR(series.at("window.travelled").back(), 0.6, 1e-12);
  for (const double way : series.at("window.travelled"))
    EXPECT_NEAR(way, 0.12 * std::round(way / 0.12), 1e-9) << "whole blocks, also in the row at which one comes";
  EXPECT_NEAR(series.at("window.entered").back(), moving["entered"]["mass [kg]"], 1e-7);
  // Frames hold what lies in the window then, each sphere once and always of the same size.
  const FramesFile file(dir / "out" / "run.h5");
  ASSERT_TRUE(file.is_moving_bed());
  for (std::size_t f = 0; f < file.times().size(); ++f) {
    const std::array<double, 2> ends = file.window(f);
    EXPECT_NEAR(ends[1] - ends[0], 0.36, 1e-12);
    EXPECT_GT(file.times()[f] + 0.18, ends[0] + 0.18 - 1e-9) << "the blade keeps its place in the window";
    EXPECT_LT(file.times()[f] + 0.18, ends[0] + 0.18 + 0.12 + 2e-3);
    const FrameSpheres s = file.spheres(f, false), before = file.undisturbed(f);
    // Full to both ends, also where the window goes on in the step that the frame lies in; the held ones besides.
    EXPECT_GT(s.index.size(), 3 * spheres - static_cast<std::size_t>(carved) - 1);
    EXPECT_LT(s.index.size(), 9 * spheres / 2);
    double rear = ends[1], front = ends[0];
    for (std::size_t i = 0; i < s.index.size(); ++i)
      rear = std::min<double>(rear, s.position[3 * i]), front = std::max<double>(front, s.position[3 * i]);
    EXPECT_LT(rear, ends[0] + 0.01) << file.times()[f];
    EXPECT_GT(front, ends[1] - 0.01) << file.times()[f];
    EXPECT_EQ(std::set<std::uint32_t>(s.index.begin(), s.index.end()).size(), s.index.size());
    for (std::size_t i = 0; i < s.index.size(); ++i) {
      EXPECT_GT(s.position[3 * i], ends[0] - 0.06);
      EXPECT_LT(s.position[3 * i], ends[1] + 0.06);
      if (f == 0) {
        EXPECT_NEAR(s.position[3 * i], before.position[3 * i], 1e-6);
      }
    }
  }
  EXPECT_TRUE(summary["disturbance"].contains("furrow area below the surface [m2]")) << summary["disturbance"];
}

// At 0.36 s the blade has gone three blocks: no step follows that would want the third.
TEST(RunMoving, SummaryAndLastRowAgreeAtTheInstantOfABlock) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(pass), dir / "out", {"time.end=0.36 s"}), exit_ok);
  const nlohmann::json moving = summary_of(dir / "out")["moving bed"];
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_NEAR(series.at("time").back(), 0.36, 1e-6);
  EXPECT_NEAR(series.at("window.travelled").back(), moving["way of the window [m]"], 1e-12);
  EXPECT_NEAR(series.at("window.entered").back(), moving["entered"]["mass [kg]"], 1e-7);
  EXPECT_NEAR(series.at("window.left").back(), moving["left"]["mass [kg]"], 1e-7);
  ASSERT_EQ(run_scenario(dir.scenario(pass), dir / "whole", {"time.end=0.4 s"}), exit_ok);
  ASSERT_EQ(run_scenario(dir.scenario(pass), dir / "on", {"time.end=0.4 s"}, state_in(dir / "out")), exit_ok);
  EXPECT_EQ(summary_of(dir / "on")["moving bed"], summary_of(dir / "whole")["moving bed"]);
  EXPECT_EQ(frame_positions(dir / "on", frame_times(dir / "on").size() - 1),
            frame_positions(dir / "whole", frame_times(dir / "whole").size() - 1));
}

TEST(RunMoving, ThreadsAndRestartsGiveTheSameBits) {
  const RunDirectory dir;
  const std::string file = dir.scenario(pass);
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  RunRequest request;
  request.scenario = file, request.out = dir / "two", request.threads = 2;
  ASSERT_EQ(run(request), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "first", {"time.end=0.4 s"}), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "on", {}, state_in(dir / "first")), exit_ok);
  EXPECT_EQ(summary_of(dir / "first")["moving bed"]["blocks gone on"], 3);
  const std::size_t last = frame_times(dir / "whole").size() - 1;
  for (const char* other : {"two", "on"}) {
    const std::size_t its_last = frame_times(dir / other).size() - 1;
    EXPECT_EQ(frame_positions(dir / "whole", last), frame_positions(dir / other, its_last)) << other;
    EXPECT_EQ(ids_of(dir / "whole", last), ids_of(dir / other, its_last)) << other;
    EXPECT_EQ(summary_of(dir / "whole")["moving bed"], summary_of(dir / other)["moving bed"]) << other;
  }
  const std::string moved = subsoil::test::message_of<ScenarioError>(
      [&] { run_scenario(file, dir / "other", {"soil.moving.block=90 mm"}, state_in(dir / "first")); });
  EXPECT_NE(moved.find("soil.moving.block"), std::string::npos) << moved;
}

/// The other way round, with a packing longer than the window, and layers of two materials.
TEST(RunMoving, GoesTheOtherWay) {
  const RunDirectory dir;
  std::string text = with(pass, "block: 120 mm", "block: 120 mm, period: 500 mm, towards: -x");
  text = with(text, "velocity: 1 0 0", "velocity: -1 0 0");
  text = with(text, "time: {end: 0.62 s}", "time: {end: 0.26 s}");
  text = with(
      text, "material: grain, radius: {uniform: 8.5 10 mm}, depth: 60 mm",
      "radius: {uniform: 8.5 10 mm}, layers: [{thickness: 30 mm, material: grain}, {material: stone}], depth: 60 mm");
  text =
      with(text, "{grain: {density: 2500 kg/m^3}}", "{grain: {density: 2500 kg/m^3}, stone: {density: 2700 kg/m^3}}");
  text = with(text, "contacts: [{between: [grain, grain],", "contacts: [&law {between: [grain, grain],");
  text = with(text, "mu_r: 0.1}]",
              "mu_r: 0.1}, {<<: *law, between: [grain, stone]}, {<<: *law, between: [stone, stone]}]");
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out");
  EXPECT_EQ(summary["moving bed"]["blocks gone on"], 2);
  EXPECT_EQ(summary["soil"]["layers"].size(), 2u);
  const std::array<double, 2> ends = FramesFile(dir / "out" / "run.h5").window(7);
  EXPECT_NEAR(ends[0], 0.36 - 0.24, 1e-12);
  EXPECT_NEAR(ends[1], -0.24, 1e-12);
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_NEAR(conserved_energy(series, series.rows() - 1), conserved_energy(series, 0),
              5e-3 * series.at("soil.boundary work").back());
}

/// A third of the grains are clumps of two balls of 8.5 mm. The solid of one is held, comes in and leaves as a whole; a
/// restart half way ends with the same bits, and the frames name each copy of a clump.
TEST(RunMoving, ClumpsComeAndLeave) {
  const RunDirectory dir;
  std::string text =
      with(pass, "  moving:",
           "  clumps: {pair: {spheres: [{at: 0 0 0 mm, radius: 8.5 mm}, {at: 9 0 0 mm, radius: 8.5 mm}]}}\n  moving:");
  text = with(text, "depth: 60 mm,", "depth: 60 mm, clumps: [{shape: pair, share: 0.33}],");
  const std::string file = dir.scenario(text);
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  const nlohmann::json moving = summary_of(dir / "whole")["moving bed"];
  EXPECT_EQ(moving["blocks gone on"], 5);
  const Series series = read_series(dir / "whole" / "series.csv");
  for (std::size_t row = 0; row < series.rows(); ++row)
    EXPECT_NEAR(conserved_energy(series, row), conserved_energy(series, 0),
                5e-3 * series.at("soil.boundary work").back());
  const FramesFile frames(dir / "whole" / "run.h5");
  const FrameSpheres last = frames.spheres(frames.times().size() - 1, false);
  std::map<std::int32_t, std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < last.index.size(); ++i)
    if (frames.clump()[last.index[i]] >= 0) members[frames.clump()[last.index[i]]].push_back(i);
  EXPECT_GT(members.size(), 20u);
  const auto at = [&](std::size_t i) {
    return Vec3{last.position[3 * i], last.position[3 * i + 1], last.position[3 * i + 2]};
  };
  std::size_t whole = 0;
  for (const auto& [clump, spheres] : members) {
    if (spheres.size() != 2) continue;  // held ones at the rear lose their spheres one by one
    EXPECT_NEAR(dem::norm(at(spheres[0]) - at(spheres[1])), 9e-3, 1e-6) << clump;
    ++whole;
  }
  EXPECT_GT(whole, members.size() * 9 / 10);
  ASSERT_EQ(run_scenario(file, dir / "first", {"time.end=0.3 s"}), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "on", {}, state_in(dir / "first")), exit_ok);
  const Series on = read_series(dir / "on" / "series.csv");
  for (const char* column : {"blade.Fx", "soil.kinetic", "window.left energy"})
    EXPECT_EQ(on.at(column).back(), series.at(column).back()) << column;
}

TEST(RunMoving, RefusalsSayWhatIsWrongAndWhatHelps) {
  const auto expect = [](const std::string& from, const std::string& to, const std::string& said) {
    const RunDirectory dir;
    const std::string text = subsoil::test::message_of<ScenarioError>(
        [&] { run_scenario(dir.scenario(with(pass, from, to)), dir / "out"); });
    EXPECT_NE(text.find(said), std::string::npos) << text;
  };
  expect("block: 120 mm", "block: 100 mm", "whole number of times; 0.09 m does");
  expect("block: 120 mm", "block: 36 mm, period: 120 mm", "two diameters of the largest grain");
  expect("block: 120 mm", "block: 120 mm, period: 30 mm", "the period of 0.03 m in x is too short");
  expect("follows: blade, ", "", "soil.moving.follows: is missing");
  expect("follows: blade", "follows: blad", "did you mean `blade`");
  expect("at: 180 20 0 mm", "at: -80 20 0 mm", "outside of the window");
  expect("material: grain}\n  surface", "material: grain, periodic: [x]}\n  surface", "whose window has ends in x");
  expect("material: grain}\n  surface", "material: grain, open after settling: [-x]}\n  surface", "holds the soil");
  expect("  surface: 0 mm", "  active: {}\n  surface: 0 mm", "soil.active");
  expect("depth: 60 mm", "depth: 60 mm, rough floor: 10 mm", "soil.bed.rough floor");
  expect("fill: random", "fill: lattice", "soil.bed.settle: is missing");
  expect("boundaries:\n",
         "boundaries:\n  - {name: stone, shape: {box: 10 10 10 mm}, at: 900 -30 0 mm, material: grain}\n",
         "`stone` stands still");
  expect("mu_r: 0.1}",
         "mu_r: 0.1, bond: {young's modulus: 1 MPa, poisson ratio: 0.2, tensile strength: 1 kPa, cohesion: 1 kPa}}",
         "bond");
}

/// Mz of the floor over its Fy is where the contact forces of the frames press it, by x of the world, as far as the
/// window has travelled. What rolling resistance adds is below mu_r r = 1e-3 m times the force. Between two rows in
/// which the window goes on, the place jumps.
TEST(RunMoving, MomentsOfTheFloorAreAboutTheOriginOfTheWorld) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(pass), dir / "out", {"output.forces=instant", "output.contact forces=yes"}),
            exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_NEAR(series.at("window.travelled").back(), 0.6, 1e-12);
  const auto file = h5::open_file(dir / "out" / "run.h5");
  const std::vector<double> times = frame_times(dir / "out");
  for (std::size_t k = 0; k < times.size(); ++k) {
    const std::string at = fmt::format("/frames/{:06}/contact forces/", k);
    const auto ids = h5::read<std::int64_t>(file, at + "ids");
    const auto ends = h5::read<double>(file, at + "ends"), forces = h5::read<double>(file, at + "force");
    double lowest = 0;
    for (std::size_t i = 0; 2 * i < ids.size(); ++i)
      if (ids[2 * i + 1] == -1) lowest = std::min(lowest, ends[6 * i + 4]);
    double force = 0, moment = 0;
    for (std::size_t i = 0; 2 * i < ids.size(); ++i) {
      if (ids[2 * i + 1] != -1 || ends[6 * i + 4] > lowest + 1e-6) continue;
      force -= forces[3 * i + 1];
      moment -= ends[6 * i + 3] * forces[3 * i + 1] - ends[6 * i + 4] * forces[3 * i];
    }
    const std::vector<double>& time = series.at("time");
    const auto row = static_cast<std::size_t>(
        std::min_element(time.begin(), time.end(),
                         [&](double a, double b) { return std::abs(a - times[k]) < std::abs(b - times[k]); }) -
        time.begin());
    const std::vector<double>& way = series.at("window.travelled");
    if (row + 1 == way.size() || way[row + 1] > way[row] + 0.06) continue;
    EXPECT_NEAR(series.at("floor.Mz")[row] / series.at("floor.Fy")[row], moment / force, 1e-3) << times[k];
  }
}

}  // namespace
}  // namespace subsoil::sim::run_moving
