#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "libsim/document/document.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/post/fields.hpp"
#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"

/// Runs that end otherwise than planned: faults, signals; and runs that go on from a state.
extern char** environ;

namespace subsoil::sim::run_ends {
namespace {

using namespace test;

TEST(RunEnds, AFaultExitsWithThreeSaysWhereAndKeepsWhatWasWritten) {
  const RunDirectory dir;
  // The tine is at 0.5 m/s and meets the first spheres at about 25 ms; they must not exceed 50 mm/s.
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "out", {"limits.speed=50 mm/s", "output.every=5 ms"}),
            exit_failed);
  const nlohmann::json run = summary_of(dir / "out")["run"];
  EXPECT_EQ(run["end"], "failed");
  const std::string failure = run["failure"];
  double time = 0, x = NAN, y = NAN, z = NAN;
  ASSERT_EQ(std::sscanf(failure.c_str(), "t = %lf", &time), 1) << failure;
  EXPECT_GT(time, 0.0);
  EXPECT_LT(time, 0.15);
  const std::size_t sphere = failure.find("sphere"), place = failure.find('(', sphere);
  ASSERT_NE(sphere, std::string::npos) << failure;
  ASSERT_NE(place, std::string::npos) << failure;
  EXPECT_EQ(std::sscanf(failure.c_str() + place, "(%lf, %lf, %lf)", &x, &y, &z), 3) << failure;
  const std::vector<double> frames = frame_times(dir / "out");
  ASSERT_FALSE(frames.empty());
  EXPECT_NEAR(frames.back(), time, 0.0051) << "frames up to the fault";
  EXPECT_FALSE(test::frame_positions(dir / "out", frames.size() - 1).empty());
  EXPECT_NEAR(read_series(dir / "out" / "series.csv").at("time").back(), time, 0.0011);
}

TEST(RunEnds, AnOverlapNamesWhoPressesByWhichLawAndWhatWouldDo) {
  const RunDirectory dir;
  // A ball of 4.19e-3 m^3 x 2000 kg/m^3 = 8.4 kg falls 5 mm on a plate of 1 kN/m: 8.4 x 9.81 = 82 N press it in by more
  // than the 50 mm that are half its radius. Of 82 N x 55 mm = 4.5 J the dashpot has taken a part there and the
  // law 1.25 J; half the limit, 25 mm, takes 4.5 J / (25 mm)^2 x 2 = 14.5 kN/m at the most.
  const char* ball = R"(subsoil: 1
materials: {stone: {density: 2000 kg/m^3}}
contacts: [{between: [stone, stone], law: linear, k_n: 1 kN/m, restitution: 0.5, mu: 0.5}]
soil: {bed: {fill: particles, material: stone, particles: [{position: 0 0.105 0 m, radius: 100 mm}]}}
boundaries: [{name: anvil, material: stone, shape: {box: 1 1 1 m}, at: 0 -0.5 0 m}]
time: {end: 1 s, soil step: 0.2 ms}
)";
  ASSERT_EQ(run_scenario(dir.scenario(ball), dir / "out"), exit_failed);
  const std::string failure = summary_of(dir / "out")["run"]["failure"];
  for (const char* part : {"into `anvil`", "half the limit takes k_n of contacts.stone-stone at least 1", "(now 1)",
                           "--set \"contacts.stone-stone.k_n=1"})
    EXPECT_NE(failure.find(part), std::string::npos) << failure;
  const std::size_t force = failure.find(" with ");
  ASSERT_NE(force, std::string::npos);
  EXPECT_NEAR(std::stod(failure.substr(force + 6)), 50, 1) << "1 kN/m times half of 100 mm";
  const std::string key = "contacts.stone-stone.k_n=";
  const double advised = std::stod(failure.substr(failure.find(key) + key.size()));
  EXPECT_GT(advised, 8) << "m g (h + 25 mm) over (25 mm)^2/2 without a dashpot: 7.9 kN/m";
  EXPECT_LT(advised, 14.6);
  std::string stiffer = ball;
  stiffer.replace(stiffer.find("1 kN/m"), 6, fmt::format("{} kN/m", advised));
  EXPECT_EQ(run_scenario(dir.scenario(stiffer), dir / "stiffer"), exit_ok);
}

/// The built program, started beside this test; what it says goes to a file.
pid_t start(std::vector<std::string> words, const std::string& said = "/dev/null") {
  words.insert(words.begin(), subsoil::test::program());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  posix_spawn_file_actions_addopen(&quiet, 1, said.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&quiet, 2, "/dev/null", O_WRONLY, 0);
  pid_t child = -1;
  EXPECT_EQ(posix_spawn(&child, subsoil::test::program().c_str(), &quiet, nullptr, argv.data(), environ), 0);
  posix_spawn_file_actions_destroy(&quiet);
  return child;
}

/// Waits until a file of the program holds a text, at most a minute.
void wait_for(const std::filesystem::path& file, const std::string& text) {
  for (int k = 0; k < 6000; ++k) {
    std::ifstream in(file);
    const std::string read((std::istreambuf_iterator<char>(in)), {});
    if (read.find(text) != std::string::npos) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ADD_FAILURE() << file << " never held " << text;
}
int exit_code_of(pid_t child) {
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status)) << "it died of the signal instead of ending";
  return WEXITSTATUS(status);
}

void expect_orderly_end(int signal, int code) {
  const RunDirectory dir;
  const std::string file = dir.scenario(small_pass), out = (dir / "out").string();
  // The tine stands still, so this goes on until it is killed.
  const std::vector<std::string> words{"run",       file,
                                       "--out",     out,
                                       "--threads", "1",
                                       "--set",     "time.end=60 s",
                                       "--set",     "machine.drivers.tow.velocity=0 m/s",
                                       "--set",     "output.every=2 ms"};
  const pid_t child = start(words);
  ASSERT_GT(child, 0);
  wait_for(dir / "out" / "run.xdmf", "/frames/000002");  // beyond the first
  kill(child, signal);
  EXPECT_EQ(exit_code_of(child), code);
  const nlohmann::json run = summary_of(out)["run"];
  EXPECT_EQ(run["end"], "interrupted");
  const double end = run["simulated [s]"].get<double>(), step = run["soil step [s]"].get<double>();
  EXPECT_NEAR(frame_times(out).back(), end, step) << "a last frame";
  EXPECT_NEAR(read_series(dir / "out" / "series.csv").at("time").back(), end, step) << "a last row";
  // And it can go on from there.
  const auto state = latest_state(out);
  ASSERT_TRUE(state.has_value());
  ASSERT_EQ(
      run_scenario(file, dir / "on",
                   {"machine.drivers.tow.velocity=0 m/s", "time.end=" + std::to_string(end + 0.002) + " s"}, *state),
      exit_ok);
  EXPECT_NEAR(read_series(dir / "on" / "series.csv").at("time").front(), end, 0.0011) << "the next sample";
}

TEST(RunEnds, SigtermFinishesTheStepAndExitsWith143) { expect_orderly_end(SIGTERM, exit_terminated); }
TEST(RunEnds, SigintFinishesTheStepAndExitsWith130) { expect_orderly_end(SIGINT, exit_interrupted); }

TEST(RunEnds, ASignalWhileTheBedSettlesLeavesAFrameAndASummaryButNoState) {
  const RunDirectory dir;
  // The blade begins in the bed, of which what is in its way would have been taken out at rest.
  const pid_t child = start({"run", dir.scenario(small_pass), "--out", (dir / "out").string(), "--threads", "1",
                             "--set", "soil.bed.settle.for=1000 s", "--set", "soil.bed.inside machine=carve", "--set",
                             "machine.bodies.tine.at=0.08 -0.04 m"},
                            (dir / "said").string());
  ASSERT_GT(child, 0);
  wait_for(dir / "said", "settling");
  kill(child, SIGTERM);
  EXPECT_EQ(exit_code_of(child), exit_terminated);
  const nlohmann::json summary = summary_of(dir / "out");
  EXPECT_EQ(summary["run"]["end"], "interrupted");
  EXPECT_NE(summary["warnings"].dump().find("while the bed settled"), std::string::npos) << summary["warnings"];
  EXPECT_EQ(frame_times(dir / "out"), std::vector<double>{0});
  EXPECT_FALSE(latest_state(dir / "out").has_value()) << "a restart from it would skip the settling";
}

/// What joins a bed only at rest is not there yet: whom a moving bed follows, and the columns of fibres.
TEST(RunEnds, ASignalWhileABedSettlesThatIsNotWholeYet) {
  for (const auto& [config, long_settling] :
       {std::pair("long-pass", "soil.bed.settle.for=1000 s"), std::pair("straw", "soil.bed.settle.until=1e-6 m/s")}) {
    const RunDirectory dir;
    const pid_t child =
        start({"run", test::config(config), "--out", (dir / "out").string(), "--threads", "1", "--set", long_settling},
              (dir / "said").string());
    ASSERT_GT(child, 0);
    wait_for(dir / "said", "settling");
    kill(child, SIGINT);
    EXPECT_EQ(exit_code_of(child), exit_interrupted) << config;
    const nlohmann::json summary = summary_of(dir / "out");
    EXPECT_EQ(summary["run"]["end"], "interrupted") << config;
    ASSERT_EQ(summary["warnings"].size(), 1U) << summary["warnings"];
    EXPECT_NE(summary["warnings"].dump().find("while the bed settled"), std::string::npos) << summary["warnings"];
  }
}

TEST(RunEnds, ARestartComesToTheSameEndWithinRounding) {
  const RunDirectory dir;
  const std::string file = dir.scenario(small_pass);
  const std::vector<std::string> sets{"output.state every=60 ms", "time.end=0.1 s"};
  ASSERT_EQ(run_scenario(file, dir / "whole", sets), exit_ok);
  std::filesystem::path state;
  for (const auto& entry : std::filesystem::directory_iterator(dir / "whole"))
    if (entry.path().filename().string().rfind("state-0.0", 0) == 0) state = entry.path();  // the other is of 0.1 s
  ASSERT_FALSE(state.empty()) << "no state at 60 ms";
  ASSERT_EQ(run_scenario(file, dir / "again", {"time.end=0.1 s"}, state), exit_ok);
  const Series whole = read_series(dir / "whole" / "series.csv"), again = read_series(dir / "again" / "series.csv");
  ASSERT_EQ(whole.columns.size(), again.columns.size());
  EXPECT_GT(*std::max_element(whole.at("draft").begin(), whole.at("draft").end()), 5) << "the tool must be in soil";
  // Sums may be taken in another order after the restart: 1e-16 grows by collisions over 500 steps, and the series
  // keeps nine digits.
  for (std::size_t c = 0; c < whole.columns.size(); ++c) {
    double size = 0;
    for (const double v : whole.values[c]) size = std::max(size, std::abs(v));
    EXPECT_NEAR(again.values[c].back(), whole.values[c].back(), 1e-7 * size + 1e-9) << whole.columns[c].name;
  }
  const std::vector<double> frames = frame_times(dir / "whole"), later = frame_times(dir / "again");
  EXPECT_NEAR(later.back(), frames.back(), 1e-12);
  const auto a = test::frame_positions(dir / "whole", frames.size() - 1),
             b = test::frame_positions(dir / "again", later.size() - 1);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_LT(dem::norm(a[i] - b[i]), 2e-6) << i;  // a quantum of the frames
}

TEST(RunEnds, ARestartOfAnotherScenarioIsRefused) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(test::config("pendulum"), dir / "out", {"time.end=10 ms"}), exit_ok);
  const auto state = latest_state(dir / "out");
  ASSERT_TRUE(state.has_value());
  try {
    run_scenario(dir.scenario(small_pass), dir / "on", {}, *state);
    FAIL() << "taken";
  } catch (const ScenarioError& error) {
    EXPECT_NE(std::string(error.what()).find("state of another scenario"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(dir / "on"));
}

/// Two spheres fall through an open floor; the run goes on with an empty bed.
TEST(RunEnds, ABedThatHasEmptiedEndsNoRun) {
  constexpr const char* falling = R"(subsoil: 1
materials: {g: {density: 2000 kg/m^3}}
contacts: [{between: [g, g], law: linear, k_n: 10 kN/m, restitution: 0.5, mu: 0.5}]
soil:
  container: {size: 0.1 0.2 0.1 m, at: 0 0 0 m, material: g, open: [+y, -y]}
  bed: {fill: particles, particles: [{position: 30 20 50 mm, radius: 10 mm, material: g}, {position: 70 30 50 mm, radius: 10 mm, material: g}]}
time: {end: 0.5 s}
output: {every: 50 ms}
)";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(falling), dir / "out"), exit_ok);
  const std::vector<double> times = frame_times(dir / "out");
  EXPECT_NEAR(times.back(), 0.5, 1e-12);
  EXPECT_EQ(frame_positions(dir / "out", 0).size(), 2U);
  EXPECT_TRUE(frame_positions(dir / "out", times.size() - 1).empty());
  const FieldsReport fields = write_fields({.run = dir / "out", .all = true});
  EXPECT_EQ(fields.frames, times.size());
}

}  // namespace
}  // namespace subsoil::sim::run_ends
