#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <numbers>
#include <thread>

#include "libsim/document/document.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/run/output_folder.hpp"
#include "libsim/run/resume.hpp"
#include "libsim/run/settling_checkpoint.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/unit/apps/trench.hpp"

/// A run that is killed goes on where its folder stands and ends as if nothing had been: series to the last byte, every
/// number of every frame, the summary but for clock and memory.
namespace subsoil::sim::run_resume {
namespace {

using namespace test;

constexpr const char* grains = R"(subsoil: 1
materials: {soil: {density: 2600 kg/m^3}, pan: {density: 2600 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 20 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.2}
  - {<<: *dry, between: [soil, pan]}
  - {<<: *dry, between: [pan, pan]}
  - {<<: *dry, between: [soil, steel]}
  - {<<: *dry, between: [pan, steel]}
soil:
  container: {size: 100 120 80 mm, at: 0 0 0 m, material: steel}
  bed: {BED}
boundaries:
  - {name: tool, material: steel, shape: {box: 20 20 20 mm}, at: 50 75 40 mm, moves: [{velocity: 0 -0.3 0 m/s}]}
time: {end: 60 ms, stop when: {never: {column: force, above: 1 MN, for: 1 ms}}}
output:
  every: 5 ms
  series every: 1 ms
  monitor:
    force: {soil force: tool, along: 0 1}
    impulse: {integral: force}
    lately: {mean: tool.y, within: 7 ms}
    most: {maximum: force, within: 5 ms}
    pressed: {time above: force, at: 0.1 N}
    moment: {formula: f*y, of: {f: force, y: tool.y}, unit: N m}
    turned: {integral: moment}
)";

std::string with_bed(const std::string& bed) {
  std::string text = grains;
  return text.replace(text.find("{BED}"), 5, "{" + bed + "}");
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Runs in a process of its own until it has left a checkpoint and some ms more, then kills it. False if it was faster.
bool run_and_kill(const std::string& scenario, const std::filesystem::path& out, int more,
                  const std::vector<std::string>& sets) {
  const pid_t child = fork();
  if (child == 0) {
    set_checkpoint_interval(0.02);
    run_scenario(scenario, out, sets);
    _exit(0);
  }
  const auto has_checkpoint = [&] {
    std::error_code none;
    for (const auto& file : std::filesystem::directory_iterator(out, none))
      if (file.path().filename().string().starts_with("checkpoint-") && file.path().extension() == ".h5") return true;
    return false;
  };
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0 && !has_checkpoint())
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(more));
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  return std::filesystem::exists(out / "scenario.yaml") && !std::filesystem::exists(out / "summary.json");
}

nlohmann::json lasting(const std::filesystem::path& out) {
  nlohmann::json summary = summary_of(out);
  // Where no checkpoint is left the run begins anew, from its own copy of the scenario.
  for (const char* key : {"wall time [s]", "peak memory [bytes]", "particle-steps per second", "threads", "scenario"})
    summary["run"].erase(key);
  // Lists are built for the state and again for a grain that comes at that instant, where the whole run built them
  // once.
  if (summary.contains("inlets")) summary["run"].erase("neighbour builds");
  return summary;
}

void expect_same(const std::filesystem::path& whole, const std::filesystem::path& out) {
  EXPECT_EQ(text_of(whole / "series.csv"), text_of(out / "series.csv"));
  EXPECT_EQ(lasting(whole), lasting(out));
  const std::vector<double> times = frame_times(whole);
  ASSERT_EQ(times, frame_times(out));
  const auto a = h5::open_file(whole / "run.h5"), b = h5::open_file(out / "run.h5");
  for (std::size_t k = 0; k < times.size(); ++k) {
    const std::string group = fmt::format("/frames/{:06}", k);
    for (const std::string column :
         {"/position", "/velocity", "/force", "/spin", "/torque", "/loads/tool/mean pressure", "/loads/tool/shear work",
          "/loads/tool/Archard wear depth"})
      if (h5::exists(a, group + column)) {
        EXPECT_EQ(h5::read<double>(a, group + column), h5::read<double>(b, group + column)) << group << column;
      }
  }
  EXPECT_EQ(states_in(out).size(), states_in(whole).size()) << "checkpoints go when the end is reached";
}

void expect_no_seam(const std::string& scenario, const std::vector<std::string>& sets = {}) {
  const RunDirectory dir;
  const std::string file = dir.scenario(scenario);
  ASSERT_EQ(run_scenario(file, dir / "whole", sets), exit_ok);
  int stopped = 0;
  for (const int more : {0, 30}) {
    const auto out = dir / ("out" + std::to_string(more));
    stopped += run_and_kill(file, out, more, sets) ? 1 : 0;
    RunRequest request;
    request.threads = 2;
    spdlog::set_level(spdlog::level::off);
    EXPECT_EQ(resume(out, request), exit_ok);
    expect_same(dir / "whole", out);
  }
  EXPECT_GT(stopped, 0) << "nothing was tried";
}

TEST(Resume, CoupledRunEndsWithTheSameBits) { expect_no_seam(small_pass); }
TEST(Resume, CoupledRunInMixedPrecision) { expect_no_seam(small_pass, {"precision=mixed"}); }
TEST(Resume, SettledBed) { expect_no_seam(with_bed("fill: random, material: soil, radius: 8 mm, count: 120")); }
/// Without a grain at the start there is no soil yet that a tool would travel in.
TEST(Resume, AToolInABinThatStartsEmpty) {
  expect_no_seam(R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {soil: {density: 2600 kg/m^3}}
contacts: [{between: [soil, soil], law: linear, k_n: 30 kN/m, restitution: 0.4, mu: 0.5}]
soil:
  container: {size: 0.3 0.3 0.1 m, at: 0 -0.1 -0.05 m, material: soil}
  inlets:
    a: {box: {at: 20 130 -45 mm, size: 100 50 90 mm}, rate: 2 kg/s, material: soil, radius: 5 mm}
boundaries:
  - {name: bar, material: soil, shape: {box: 20 20 60 mm}, at: 60 60 0 mm, moves: [{velocity: 0.1 0 0 m/s}]}
time: {end: 0.25 s}
output: {every: 10 ms}
)");
}
/// A run from a state pours on where it was, with other contacts too, though its own step is another one.
TEST(Resume, AnInletPoursOnBesideChangedContacts) {
  constexpr const char* pours = R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {grain: {density: 2500 kg/m^3}}
contacts: [{between: [grain, grain], law: linear, k_n: 50 kN/m, restitution: 0.5, mu: 0.4}]
soil:
  container: {size: 200 250 60 mm, at: -100 0 -30 mm, material: grain}
  inlets:
    feed: {box: {at: -40 190 -30 mm, size: 80 50 60 mm}, rate: 0.2 kg/s, material: grain, radius: 5 mm}
time: {end: 0.3 s}
)";
  const RunDirectory dir;
  const std::string file = dir.scenario(pours);
  ASSERT_EQ(run_scenario(file, dir / "first", {"time.end=0.15 s"}), exit_ok);
  spdlog::set_level(spdlog::level::off);
  ASSERT_EQ(run({.scenario = file,
                 .out = dir / "softer",
                 .sets = {"contacts.grain-grain.k_n=2 kN/m"},
                 .threads = 1,
                 .changes = {"contacts.grain-grain.k_n"},
                 .from = state_in(dir / "first")}),
            exit_ok);
  const double grain = 2500 * 4 * std::numbers::pi / 3 * 125e-9, interval = 50 * 2e-5;
  EXPECT_NEAR(summary_of(dir / "softer")["inlets"]["feed"]["mass [kg]"].get<double>(), 0.2 * 0.3,
              0.5 * grain + 0.2 * interval);
}
/// Without a sphere there is no impact that a step would have to resolve: the run continues with its own.
TEST(Resume, ABinFromWhichAllHaveFallen) {
  constexpr const char* leaks = R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {soil: {density: 2600 kg/m^3}}
contacts: [{between: [soil, soil], law: linear, k_n: 30 kN/m, restitution: 0.4, mu: 0.5}]
soil:
  container: {size: 0.2 0.3 0.1 m, at: 0 -0.1 -0.05 m, material: soil, open after settling: [-y]}
  remove below: 50 mm
  bed: {fill: random, material: soil, radius: 8 mm, depth: 40 mm, inside machine: carve}
boundaries:
  - {name: bar, material: soil, shape: {box: 20 20 60 mm}, at: 60 -60 0 mm, moves: [{velocity: 0.01 0 0 m/s}]}
time: {end: 0.8 s}
)";
  const RunDirectory dir;
  const std::string file = dir.scenario(leaks);
  ASSERT_EQ(run_scenario(file, dir / "first"), exit_ok);
  ASSERT_EQ(read_run(state_in(dir / "first")).bed.spheres.size(), 0u);
  ASSERT_EQ(run_scenario(file, dir / "on", {"time.end=0.85 s"}, state_in(dir / "first")), exit_ok);
  EXPECT_EQ(summary_of(dir / "on")["run"]["soil step [s]"], summary_of(dir / "first")["run"]["soil step [s]"]);
}
/// What lies in the window, which block comes next and what has been booked are in the checkpoint.
TEST(Resume, MovingBed) { expect_no_seam(moving_pass); }
/// What the tool's triangles have borne, and the pressure since the frame before, are in the checkpoint.
TEST(Resume, WornSurface) {
  std::string text = with_bed("fill: random, material: soil, radius: 8 mm, count: 120");
  text.replace(text.find("at: 50 75 40 mm,"), 16,
               "at: 50 75 40 mm, wear: {coefficient: 1e-4, hardness: 2 GPa, finnie: 1e-12 1/Pa},");
  expect_no_seam(text);
}
/// A section without a key says something by being there: the results' own scenario.yaml has it.
TEST(Resume, WearWithoutConstants) {
  std::string text = with_bed("fill: random, material: soil, radius: 8 mm, count: 120");
  ASSERT_NE(text.find("at: 50 75 40 mm,"), std::string::npos);
  text.replace(text.find("at: 50 75 40 mm,"), 16, "at: 50 75 40 mm, wear: {},");
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
  EXPECT_TRUE(summary_of(dir / "out").contains("wear"));
  ASSERT_EQ(run_scenario((dir / "out/scenario.yaml").string(), dir / "again"), exit_ok);
  EXPECT_EQ(summary_of(dir / "again")["wear"], summary_of(dir / "out")["wear"]);
  expect_no_seam(text);
}
/// A lag that is left out follows from the run's step, which spheres that have moved would choose otherwise.
TEST(Resume, ServoWithoutALag) {
  std::string text = with_bed("fill: random, material: soil, radius: {uniform: 7 8 mm}, count: 120");
  text.replace(text.find("time:"), 5,
               "  - {name: plate, material: steel, shape: {box: 40 10 40 mm}, at: 50 65 40 mm, servo: {load: 2 N, "
               "speed limit: 0.5 m/s}}\ntime:");
  text.replace(text.find("at: 50 75 40 mm"), 15, "at: 50 110 40 mm");
  expect_no_seam(text);
}
/// Begun from a state in which its body swings back, a run gives the draft the sign that the whole run has.
TEST(Resume, DraftOfABodyThatHasTurnedRound) {
  const std::string text = R"(subsoil: 1
materials: {soil: {density: 2600 kg/m^3}}
contacts: [{between: [soil, soil], law: linear, k_n: 10 kN/m, restitution: 0.5, mu: 0.4}]
soil:
  container: {size: 300 120 60 mm, at: -150 0 -30 mm, material: soil}
  bed: {fill: random, material: soil, radius: 10 mm, depth: 50 mm, inside machine: carve}
machine:
  bodies: {arm: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0 0.1 m, velocity: -0.8 0 m/s}}
  joints: {rail: {translational: [ground, arm], at: 0 0.1 m, along: 1 0}}
  forces: {spring: {spring-damper: [ground, arm], ends: [-1 0.1 m, 0 0.1 m], stiffness: 4 kN/m}}
  surfaces: {blade: {body: arm, material: soil, box: 20 140 40 mm, at: 0 0 0 mm}}
time: {end: 80 ms}
output: {every: 80 ms, series every: 5 ms, state every: 40 ms}
)";
  const RunDirectory dir;
  const std::string file = dir.scenario(text);
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  std::filesystem::path state;
  for (const auto& entry : std::filesystem::directory_iterator(dir / "whole"))
    if (entry.path().filename().string().rfind("state-0.04", 0) == 0) state = entry.path();
  ASSERT_FALSE(state.empty());
  ASSERT_EQ(run_scenario(file, dir / "rest", {}, state), exit_ok);
  const Series whole = read_series(dir / "whole" / "series.csv"), rest = read_series(dir / "rest" / "series.csv");
  EXPECT_GT(rest.at("arm.vx").front(), 0) << "the body swings back";
  double most = 0;
  for (std::size_t i = 2; i < rest.rows(); ++i) {  // the first interval began before the state
    const std::size_t same = whole.rows() - rest.rows() + i;
    ASSERT_EQ(rest.at("time")[i], whole.at("time")[same]);
    ASSERT_EQ(rest.at("soil.draft")[i], whole.at("soil.draft")[same]);
    most = std::max(most, std::abs(rest.at("soil.draft")[i]));
  }
  EXPECT_GT(most, 0.1);
}
/// Steps that a folder's bed on its way to rest has been saved with; none: -1.
double settling_steps(const std::filesystem::path& out) {
  if (!std::filesystem::exists(out / "settling.h5")) return -1;
  const auto state = SettlingCheckpoint(out, text_of(out / "scenario.yaml")).read();
  return state ? static_cast<double>(state->state.steps) : -1;
}

/// Killed before the bed is at rest, three times: what has settled is not settled again. A kill that comes when the bed
/// is at rest, because this process had to wait, shows nothing: that folder is begun anew.
TEST(Resume, ABedOnItsWayToRest) {
  const RunDirectory dir;
  const std::string file = dir.scenario(
      with_bed("fill: random, material: soil, radius: 5 mm, count: 450, settle: {until: 1 mm/s, stages: yes}"));
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  const auto out = dir / "out";
  RunRequest going_on;
  going_on.threads = 1;
  double before = -1;
  int kills = 0;
  for (int trial = 0; kills < 3 && trial < 30; ++trial) {
    const pid_t child = fork();
    if (child == 0) {
      set_checkpoint_interval(0.05);
      _exit(kills == 0 ? run_scenario(file, out) : resume(out, going_on));
    }
    while (settling_steps(out) <= before && !std::filesystem::exists(out / "series.csv"))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    if (std::filesystem::exists(out / "series.csv")) {
      std::filesystem::remove_all(out);
      before = -1;
      kills = 0;
    } else {
      before = settling_steps(out);
      ++kills;
    }
  }
  ASSERT_EQ(kills, 3) << "the bed always came to rest before it could be killed";
  going_on.threads = 2;
  ASSERT_EQ(resume(out, going_on), exit_ok);
  expect_same(dir / "whole", out);
  EXPECT_FALSE(std::filesystem::exists(out / "settling.h5"));
}

/// Killed before anything of the settling is kept: it begins again. A refusal after settling leaves no folder to
/// resume.
TEST(Resume, ABedKilledAtOnceBeginsAgain) {
  const RunDirectory dir;
  const std::string file =
      dir.scenario(with_bed("fill: random, material: soil, radius: 5 mm, count: 450, settle: {until: 1 mm/s}"));
  const auto out = dir / "out";
  const pid_t child = fork();
  if (child == 0) _exit(run_scenario(file, out));
  while (!std::filesystem::exists(out / "scenario.yaml")) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  RunRequest request;
  request.threads = 1;
  EXPECT_EQ(resume(out, request), exit_ok);
  EXPECT_TRUE(std::filesystem::exists(out / "summary.json"));
}

/// What is saved of a bed is of no use for another one.
TEST(Resume, ASettlingOfAnotherScenarioIsNotTaken) {
  const test::Scratch dir;
  const std::string scenario = with_bed("fill: random, material: soil, radius: 8 mm, count: 30"),
                    other = with_bed("fill: random, material: soil, radius: 7 mm, count: 30");
  SettlingCheckpoint(dir.path(), scenario)
      .keep({.decisions = {1, 2}, .steps = 10, .steps_of_run = 10, .load = {}, .bed = {}}, "portable");
  const auto state = SettlingCheckpoint(dir.path(), scenario).read();
  ASSERT_TRUE(state);
  EXPECT_EQ(state->state.decisions, (std::vector<double>{1, 2}));
  EXPECT_FALSE(SettlingCheckpoint(dir.path(), other).read());
  EXPECT_EQ(text_of(dir / "scenario.yaml"), scenario);
}

TEST(Resume, LayeredBedOfManySizes) {
  expect_no_seam(
      with_bed("fill: lattice, layers: [{thickness: 40 mm, material: soil, radius: 8 mm}, {thickness: 36 mm, "
               "material: pan, radius: 6 mm}]"));
}

TEST(Resume, BondedBed) {
  std::string text = with_bed("fill: lattice, material: soil, radius: 8 mm, depth: 60 mm");
  text.replace(text.find("law: linear, k_n"), 16,
               "law: linear, bond: parallel, bond modulus: 20 MPa, bond tensile strength: 20 kPa, bond shear strength: "
               "20 kPa, bond friction angle: 20 deg, bond damping: 0.1, k_n");
  // Surfaces have none: they get a law without.
  text.replace(text.find("{<<: *dry, between: [soil, steel]}"), 34,
               "{between: [soil, steel], law: linear, k_n: 20 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.2}");
  text.replace(text.find("{<<: *dry, between: [pan, steel]}"), 33,
               "{between: [pan, steel], law: linear, k_n: 20 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.2}");
  expect_no_seam(text);
}

constexpr const char* sleeping = R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {soil: {density: 2600 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 20 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.2}
  - {<<: *dry, between: [soil, steel]}
soil:
  container: {size: 100 120 80 mm, at: 0 0 0 m, material: steel, open after settling: [+x]}
  surface: 0 mm
  active: {within: 20 mm, below: 5 mm/s}
  bed: {fill: random, material: soil, radius: 8 mm, count: 150, settle: {until: 1 mm/s}}
boundaries:
  - {name: weir, material: steel, shape: {box: 4 200 200 mm}, at: 102 0 0 mm}
time: {end: 150 ms}
output: {every: 50 ms, series every: 2 ms, monitor: {weight: {soil force: container, along: 0 -1}}}
)";

/// Sleeping spheres are not evaluated again: what they bear on walls comes with the state, and under another gravity
/// nothing that was known of them holds.
TEST(Resume, SleepingSoilRestsOnItsWallsAndWakesUnderAnotherGravity) {
  const RunDirectory dir;
  const std::string file = dir.scenario(sleeping);
  RunRequest request;
  request.scenario = file, request.out = dir / "first", request.sets = {"output.state=full"};
  ASSERT_EQ(run(request), exit_ok);
  const Series first = read_series(dir / "first" / "series.csv");
  const double asleep = first.at("soil.frozen spheres").back(), weight = first.at("weight").back();
  ASSERT_GT(asleep, 100);
  ASSERT_GT(weight, 1);

  request.from = latest_state(dir / "first").value(), request.out = dir / "further", request.sets = {"time.end=170 ms"};
  ASSERT_EQ(run(request), exit_ok);
  const Series further = read_series(dir / "further" / "series.csv");
  for (const double w : further.at("weight")) EXPECT_NEAR(w, weight, 1e-6 * weight);
  const nlohmann::json summary = test::summary_of(dir / "further");
  for (const auto& warning : summary["warnings"])
    EXPECT_EQ(warning.get<std::string>().find("beyond a wall"), std::string::npos) << warning;

  request.out = dir / "tilted", request.sets.push_back("gravity=6 -7.75 0 m/s^2"), request.changes = {"gravity"};
  ASSERT_EQ(run(request), exit_ok);
  EXPECT_EQ(read_series(dir / "tilted" / "series.csv").at("soil.frozen spheres")[1], 0);
}

TEST(Resume, AMachineAloneIsRunAgain) {
  const RunDirectory dir;
  const std::string file = config("pendulum");
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  std::filesystem::create_directories(dir / "out");
  std::filesystem::copy_file(dir / "whole/scenario.yaml", dir / "out/scenario.yaml");
  write_file(dir / "out/series.csv", "time [s]\n0.0\n0.1");
  EXPECT_EQ(resume(dir / "out", {}), exit_ok);
  EXPECT_EQ(text_of(dir / "whole" / "series.csv"), text_of(dir / "out" / "series.csv"));
}

TEST(Resume, ADamagedCheckpointIsPassedOver) {
  const RunDirectory dir;
  const std::string file = dir.scenario(small_pass);
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  if (!run_and_kill(file, dir / "out", 60, {})) GTEST_SKIP() << "the machine was faster than the kill";
  const std::filesystem::path last = states_in(dir / "out").at(0);
  std::string bytes = text_of(last);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x10);
  for (std::size_t k = bytes.size() / 2; k < bytes.size() / 2 + 4000 && k < bytes.size(); ++k) bytes[k] = 7;
  write_file(last, bytes);
  EXPECT_EQ(resume(dir / "out", {}), exit_ok);
  expect_same(dir / "whole", dir / "out");
}

/// Its last state is of the end, where there is nothing to go on with: the one before is taken.
TEST(Resume, ACutBetweenTheLastStateAndTheSummary) {
  const RunDirectory dir;
  const std::string file = dir.scenario(small_pass);
  ASSERT_EQ(run_scenario(file, dir / "whole", {"output.state every=10 ms"}), exit_ok);
  std::filesystem::copy(dir / "whole", dir / "out", std::filesystem::copy_options::recursive);
  std::filesystem::remove(dir / "out" / "summary.json");
  ASSERT_GT(states_in(dir / "out").size(), 1u);
  EXPECT_EQ(resume(dir / "out", {}), exit_ok);
  expect_same(dir / "whole", dir / "out");
}

/// A machine step of five soil steps: rows inside it are between its ends for all that the machine knows, the work that
/// the interface does on it too, and are those of a run that begins at a state within it.
TEST(Resume, RowsInsideAMachineStep) {
  const std::vector<std::string> sets{"time.machine={soil steps per machine step: 5}", "output.series digits=all",
                                      "output.precision=double"};
  const RunDirectory dir;
  const std::string file = dir.scenario(small_pass);
  std::vector<std::string> first = sets;
  first.emplace_back("output.state every=7 ms");
  ASSERT_EQ(run_scenario(file, dir / "whole", first), exit_ok);
  const Series whole = read_series(dir / "whole" / "series.csv");
  const std::vector<double>&by_interface = whole.at("interface.on machine"),
        &external = whole.at("energy.external work");
  EXPECT_GT(std::abs(external.back()), 0.01);
  for (std::size_t k = 0; k < whole.rows(); ++k)
    ASSERT_NEAR(by_interface[k], external[k], 1e-12) << whole.at("time")[k];
  const std::vector<std::filesystem::path> states = states_in(dir / "whole");
  ASSERT_GT(states.size(), 6u);
  for (std::size_t i = 1; i < 6; ++i) {
    const auto out = dir / ("from" + std::to_string(i));
    ASSERT_EQ(run_scenario(file, out, sets, states[i]), exit_ok);
    const Series rest = read_series(out / "series.csv");
    const std::size_t skipped = whole.rows() - rest.rows();
    for (std::size_t k = 2; k < rest.rows(); ++k)  // means of the first row begin at the state
      for (const char* column : {"time", "tine.x", "tine.vx", "tine.soil.Fx", "energy.external work"})
        ASSERT_EQ(rest.at(column)[k], whole.at(column)[skipped + k]) << column << " of state " << i << ", row " << k;
  }
}

TEST(Resume, WhatIsNoRunIsRefused) {
  const RunDirectory dir;
  std::filesystem::create_directories(dir / "empty");
  EXPECT_THROW(resume(dir / "empty", {}), ScenarioError);
  EXPECT_THROW(resume(dir / "nowhere", {}), ScenarioError);
}

TEST(FolderLock, KeepsASecondRunOut) {
  const RunDirectory dir;
  const std::string file = dir.scenario(small_pass);
  {
    const FolderLock lock(dir / "out");
    try {
      RunRequest second;
      second.scenario = file, second.out = dir / "out", second.threads = 1, second.force = true;
      run(second);
      FAIL() << "two runs in one folder";
    } catch (const ScenarioError& error) {
      EXPECT_NE(std::string(error.what()).find("another run writes into it (process " + std::to_string(getpid())),
                std::string::npos)
          << error.what();
    }
  }
  EXPECT_FALSE(std::filesystem::exists(dir / "out")) << "nothing was put into it";
}

/// Cut off between summary and end: the run is done, and its lock and checkpoints are tidied away.
TEST(Resume, OfARunThatHasEndedTidiesWhatACutLeft) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "out", {"time.end=4 ms"}), exit_ok);
  write_file(dir / "out/run.lock", "");
  write_file(dir / "out/checkpoint-0.002.h5", "");
  write_file(dir / "out/checkpoint-0.003.h5.part", "");
  EXPECT_EQ(resume(dir / "out", {}), exit_ok);
  EXPECT_FALSE(std::filesystem::exists(dir / "out/run.lock"));
  EXPECT_FALSE(std::filesystem::exists(dir / "out/checkpoint-0.002.h5"));
  EXPECT_FALSE(std::filesystem::exists(dir / "out/checkpoint-0.003.h5.part"));
}

TEST(FolderLock, ForceLeavesNothingOfAnotherRun) {
  const RunDirectory dir;
  const std::string file = dir.scenario(small_pass);
  ASSERT_EQ(run_scenario(file, dir / "out", {"time.end=12 ms", "output.state every=3 ms"}), exit_ok);
  ASSERT_GT(states_in(dir / "out").size(), 2u);
  write_file(dir / "out/notes.txt", "mine");
  ASSERT_EQ(run({.scenario = file, .out = dir / "out", .sets = {"time.end=2 ms"}, .threads = 1, .force = true}),
            exit_ok);
  EXPECT_EQ(states_in(dir / "out").size(), 1u);
  EXPECT_TRUE(std::filesystem::exists(dir / "out/notes.txt"));
}

}  // namespace
}  // namespace subsoil::sim::run_resume
