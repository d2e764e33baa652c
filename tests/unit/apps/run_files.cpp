#include "apps/commands/commands.hpp"
#include "libsim/scenario/load.hpp"
#include "tests/tools/program_runs.hpp"

/// What a run leaves, what it refuses to touch, and its exit codes.
namespace subsoil::sim::run_files {
namespace {

using namespace test;

/// The command line in this process.
int subsoil_words(std::vector<std::string> words) {
  words.insert(words.begin(), "subsoil");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  const int code = main_command(static_cast<int>(argv.size()), argv.data());
  testing::internal::GetCapturedStdout();
  testing::internal::GetCapturedStderr();
  return code;
}

TEST(RunFiles, ARunLeavesFramesSeriesSummaryScenarioAndState) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "out"), exit_ok);
  for (const char* name : {"run.h5", "run.xdmf", "series.csv", "summary.json", "scenario.yaml"})
    EXPECT_TRUE(std::filesystem::exists(dir / "out" / name)) << name;
  EXPECT_EQ(frame_times(dir / "out").size(), 7U);  // 0, 25, ... 150 ms

  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_EQ(series.at("time").size(), 151U);  // every ms, both ends
  for (const char* column :
       {"tine.x", "tine.vy", "tine.angle", "slide.fx", "spring.force", "tow.force", "soil.draft", "soil.lift",
        "tine.soil.Fx", "tine.soil.Mz", "floor.Fy", "energy.balance", "soil.slid", "pull", "draft"})
    EXPECT_GE(series.find(column), 0) << column;
  EXPECT_GT(*std::max_element(series.at("draft").begin(), series.at("draft").end()), 5) << "the tine met no soil";

  const nlohmann::json summary = summary_of(dir / "out");
  for (const char* key : {"version", "scenario", "instruction set", "threads", "wall time [s]", "soil step [s]",
                          "steps", "neighbour builds", "frames", "end"})
    EXPECT_TRUE(summary["run"].contains(key)) << key;
  EXPECT_EQ(summary["run"]["end"], "reached");
  EXPECT_EQ(summary["run"]["threads"], 1);
  EXPECT_TRUE(summary["columns"].contains("pull"));
  EXPECT_TRUE(summary["window"].contains("rule"));
  EXPECT_NEAR(summary["soil"]["bulk density [kg/m3]"].get<double>(), 1293, 13) << "rest pitch: model.md, packing";
}

TEST(RunFiles, TheCopyOfTheScenarioReadsBackAndRunsTheSame) {
  const RunDirectory dir;
  const std::vector<std::string> short_run{"time.end=20 ms"};
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "a", short_run), exit_ok);
  const std::string copy = (dir / "a" / "scenario.yaml").string();
  EXPECT_EQ(write_scenario(load_scenario(copy).scenario),
            write_scenario(load_scenario(dir.scenario(small_pass), short_run).scenario));
  ASSERT_EQ(run_scenario(copy, dir / "b"), exit_ok);
  std::ifstream a(dir / "a" / "series.csv"), b(dir / "b" / "series.csv");
  const std::string of_a((std::istreambuf_iterator<char>(a)), {}), of_b((std::istreambuf_iterator<char>(b)), {});
  EXPECT_EQ(of_a, of_b) << "defaults made explicit must mean the same";
}

TEST(RunFiles, AnExistingDirectoryIsWrittenOverOnlyWithForce) {
  const RunDirectory dir;
  const std::string file = dir.scenario(small_pass), out = (dir / "out").string();
  const std::vector<std::string> words{"run", file, "--out", out, "--threads", "1", "--set", "time.end=2 ms"};
  EXPECT_EQ(subsoil_words(words), exit_ok);
  const auto written = std::filesystem::last_write_time(dir / "out" / "series.csv");
  EXPECT_EQ(subsoil_words(words), exit_bad_input);
  EXPECT_EQ(std::filesystem::last_write_time(dir / "out" / "series.csv"), written)
      << "a refused run must touch nothing";
  std::vector<std::string> forced = words;
  forced.push_back("--force");
  EXPECT_EQ(subsoil_words(forced), exit_ok);
}

TEST(RunFiles, BadInputExitsWithTwoAndWritesNothing) {
  const RunDirectory dir;
  const std::string file = dir.scenario(small_pass), out = (dir / "out").string();
  for (const char* bad :
       {"soil.bed.radius=10 kg", "soil.bed.raduis=10 mm", "time.soil step=1 ms", "machine.bodies.tine.at=0.05 0 m",
        "output.monitor.pull={driver: nobody}", "output.monitor.pull=tine.nothing"}) {
    EXPECT_EQ(subsoil_words({"run", file, "--out", out, "--threads", "1", "--set", bad}), exit_bad_input) << bad;
    EXPECT_FALSE(std::filesystem::exists(out)) << bad;
  }
  EXPECT_EQ(subsoil_words({"run", (dir / "none.yaml").string(), "--out", out}), exit_bad_input);
  EXPECT_EQ(subsoil_words({"run", file, "--nonsense"}), exit_bad_input);
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(RunFiles, CheckWritesNothing) {
  const RunDirectory dir;
  const std::string file = dir.scenario(small_pass);
  EXPECT_EQ(subsoil_words({"check", file, "--threads", "1"}), exit_ok);
  std::size_t entries = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(dir / "")) ++entries;
  EXPECT_EQ(entries, 1U) << "only the scenario itself";
}

TEST(RunFiles, FramesStandAtListedTimesToo) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "out",
                         {"time.end=20 ms", "output.every=15 ms", "output.at=[3 ms, 7 ms]"}),
            exit_ok);
  const std::vector<double> times = frame_times(dir / "out");
  const double half = 0.5 * summary_of(dir / "out")["run"]["soil step [s]"].get<double>();
  const std::vector<double> expected{0, 0.003, 0.007, 0.015, 0.020};  // spaced, listed, and the last instant
  ASSERT_EQ(times.size(), expected.size());
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(times[i], expected[i], half);
}

TEST(RunFiles, ColumnsOfFramesAreSelectable) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "out",
                         {"time.end=2 ms", "output.columns=[position, contacts]", "output.precision=double"}),
            exit_ok);
  const auto file = h5::open_file(dir / "out" / "run.h5");
  EXPECT_TRUE(h5::exists(file, "/frames/000000/position"));
  EXPECT_TRUE(h5::exists(file, "/frames/000000/contacts"));
  for (const char* left_out : {"velocity", "spin", "force", "torque"})
    EXPECT_FALSE(h5::exists(file, std::string("/frames/000000/") + left_out)) << left_out;
}

TEST(RunFiles, EnergyClosesWithinOnePercentOfTheWorkPutIn) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "out"), exit_ok);
  const nlohmann::json energy = summary_of(dir / "out")["energy"];
  EXPECT_GT(energy["work of drivers [J]"].get<double>(), 0.1) << "nothing was done: the test tests nothing";
  EXPECT_LT(std::abs(energy["closure over energy there or put in"].get<double>()), 0.01);
  // Each balance by itself, and their difference at the interface: none is the remainder of the others.
  const double put_in = energy["work put in [J]"].get<double>();
  for (const char* part : {"bed closure [J]", "machine closure [J]", "interface error [J]"})
    EXPECT_LT(std::abs(energy[part].get<double>()), 0.01 * put_in) << part;
  EXPECT_GT(energy["damped [J]"].get<double>() + energy["slid [J]"].get<double>(), 0);
}

}  // namespace
}  // namespace subsoil::sim::run_files
