#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "libsim/io/joined_frame.hpp"
#include "libsim/post/frames_file.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/xdmf.hpp"

/// Soil on several processes by LIGGGHTS (`engine: liggghts`, docs/reference/many-nodes.md) beside the same soil
/// stepped by the bed itself. Contacts are evaluated by the same kernels; what differs is the order in which forces on
/// a sphere are added, 1e-16 of them. Chaos lets such differences grow, which the few spheres and short times here
/// leave no room for. Left out where subsoil-mpi is not built or mpirun is missing (scripts/setup --mpi).
namespace subsoil::sim::many_nodes_test {
namespace {

using namespace test;

constexpr double kRounding = 1e-10;  // 1e-16 of a step, over thousands of steps of contacts that do not diverge

bool built() {
  const std::filesystem::path program = std::filesystem::path(subsoil::test::program()).parent_path() / "subsoil-mpi";
  return std::filesystem::exists(program) && std::system("command -v mpirun >/dev/null 2>&1") == 0;
}
#define SKIP_UNLESS_BUILT() \
  if (!built()) GTEST_SKIP() << "no subsoil-mpi, or no mpirun: scripts/setup --mpi"

const std::string mpirun =
    "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1 mpirun --oversubscribe ";

std::string run_words(const std::string& scenario, const std::filesystem::path& out, const std::string& more) {
  return subsoil::test::program() + " run " + scenario + " --out " + out.string() + " --set engine=liggghts " + more;
}

/// By a shell; the exit code, and what is said in out.log.
int shell(const std::string& command, const std::filesystem::path& out) {
  return WEXITSTATUS(std::system(("(" + command + ") >" + out.string() + ".log 2>&1").c_str()));
}

/// `mpirun -np RANKS subsoil run ...`, each process on one thread; the exit code of rank 0, what it says in out.log.
int run_on(int ranks, const std::string& scenario, const std::filesystem::path& out, const std::string& more = "") {
  return shell(mpirun + "-np " + std::to_string(ranks) + " " + run_words(scenario, out, more), out);
}

/// Runs on two processes, and once the frame is named, does something to the second, PID; code and words as those of
/// run_on.
int disturbed(const std::string& words, const std::filesystem::path& out, const std::string& frame,
              const std::string& what) {
  const std::string second = "sh -c 'echo $$ >" + out.string() + ".pid; exec " + words + "'";
  return shell("timeout 90 env " + mpirun + "-np 1 " + words + " : -np 1 " + second +
                   " & run=$!; for i in $(seq 800); do " + "grep -qs '\"frame " + frame + "\"' " +
                   (out / "run.xdmf").string() + " && break; sleep 0.1; done; PID=$(cat " + out.string() + ".pid); " +
                   what + "; wait $run",
               out);
}

/// Every value of two series, by the largest of its unit in the first, 1e-6 of the unit at least: some columns are
/// rounding alone.
double largest_difference(const std::filesystem::path& one, const std::filesystem::path& other) {
  const Series a = read_series(one / "series.csv"), b = read_series(other / "series.csv");
  EXPECT_GT(a.rows(), 2u);
  EXPECT_EQ(a.rows(), b.rows());
  EXPECT_EQ(a.columns.size(), b.columns.size());
  if (a.rows() != b.rows() || a.columns.size() != b.columns.size()) return HUGE_VAL;
  std::map<std::string, double> scale;
  for (std::size_t c = 0; c < a.columns.size(); ++c) {
    EXPECT_EQ(a.columns[c].label(), b.columns[c].label());
    for (const double value : a.values[c])
      scale[a.columns[c].unit] = std::max(scale[a.columns[c].unit], std::abs(value));
  }
  double worst = 0;
  for (std::size_t c = 0; c < a.columns.size(); ++c)
    for (std::size_t k = 0; k < a.rows(); ++k) {
      const double off = std::abs(a.values[c][k] - b.values[c][k]);
      if (off > 0) worst = std::max(worst, off / std::max(scale[a.columns[c].unit], 1e-6));
    }
  return worst;
}

/// Of a frame, in rising id, whoever wrote it.
struct FrameNumbers {
  FrameNumbers(const std::filesystem::path& out, std::size_t frame) {
    const auto file = h5::open_file(out / "run.h5");
    char group[32];
    std::snprintf(group, sizeof group, "/frames/%06zu", frame);
    const JoinedFrame joined(file, group);
    in_parts = joined.in_parts();
    for (const char* name : {"position", "velocity", "spin", "force", "torque"})
      values[name] = joined.read<double>(name);
    contacts = joined.read<std::int32_t>("contacts");
    for (const char* name : {"radius", "density"})
      values[name] =
          joined.holds(name) ? joined.read<double>(name) : h5::read<double>(file, std::string("/particles/") + name);
    id = joined.holds("id") ? joined.read<std::int64_t>("id") : h5::read<std::int64_t>(file, "/particles/id");
  }
  double mass() const {
    double sum = 0;
    for (std::size_t i = 0; i < id.size(); ++i)
      sum += values.at("density")[i] * 4 / 3 * M_PI * std::pow(values.at("radius")[i], 3);
    return sum;
  }
  bool in_parts = false;
  std::map<std::string, std::vector<double>> values;
  std::vector<std::int32_t> contacts;
  std::vector<std::int64_t> id;
};

/// Grains of two sizes meet each other, a moving box, a floor, walls and a corner; they cross the middle.
std::string few_grains(const std::string& law) {
  return "subsoil: 1\nmaterials: {stone: {density: 2500 kg/m^3, young's modulus: 10 MPa, poisson ratio: "
         "0.3}}\ncontacts: [{between: [stone, stone], " +
         law +
         "}]\n"
         "soil:\n  container: {size: 100 100 100 mm, at: 0 0 0 m, material: stone}\n"
         "  bed:\n    fill: particles\n    material: stone\n    particles:\n"
         "      - {position: 40 30 50 mm, velocity: 0.5 0 0 m/s, radius: 10 mm}\n"
         "      - {position: 65 33 50 mm, velocity: -0.5 0 0.05 m/s, radius: 8 mm}\n"
         "      - {position: 50 70 45 mm, radius: 10 mm}\n"
         "      - {position: 55 50 60 mm, radius: 9 mm}\n"
         "boundaries: [{name: paddle, material: stone, shape: {box: 10 40 60 mm}, at: 20 30 50 mm, moves: [{velocity: "
         "0.1 0 0 m/s}]}]\n"
         "time: {end: 60 ms}\noutput: {every: 20 ms, series digits: all}\n";
}

class FewGrains : public testing::TestWithParam<const char*> {};

TEST_P(FewGrains, MoveAsInTheBedOnOneToEightProcesses) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  const std::string scenario = work.scenario(few_grains(GetParam()));
  ASSERT_EQ(run_scenario(scenario, work / "bed"), 0);
  for (const int ranks : {1, 2, 4, 8}) {  // of four borders cross, of eight they do in all directions
    const std::filesystem::path out = work / ("on" + std::to_string(ranks));
    ASSERT_EQ(run_on(ranks, scenario, out), 0) << text_of(out.string() + ".log");
    EXPECT_LT(largest_difference(work / "bed", out), kRounding) << ranks << " processes";
  }
}
INSTANTIATE_TEST_SUITE_P(
    All, FewGrains,
    testing::Values("law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0.3, mu_r: 0.1",
                    "law: wet, K_X: 100 kN/m, C_X: 5 N s/m, K_Y: 80 kN/m, C_Y: 3 N s/m, K_B: 7 kN/m, dc: 0.5 mm, dB: "
                    "0.5 mm, mu: 0.5, mu_r: 0.3",
                    "law: hertz-mindlin, restitution: 0.5, mu: 0.4",
                    "law: luding, k1: 50 kN/m, k2: 100 kN/m, k_c: 10 kN/m, phi_f: 0.05, restitution: 0.6, mu: 0.3"));

TEST(ManyNodes, APassWithItsMachineIsThatOfTheBed) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  const std::string scenario = work.scenario(small_pass);
  ASSERT_EQ(run_scenario(scenario, work / "bed"), 0);
  ASSERT_EQ(run_on(2, scenario, work / "mpi"), 0) << text_of(work / "mpi.log");
  EXPECT_LT(largest_difference(work / "bed", work / "mpi"), 1e-8);  // 300 grains, disturbed by a tine for 0.1 s
  ASSERT_EQ(run_on(4, scenario, work / "four"), 0) << text_of(work / "four.log");
  EXPECT_LT(largest_difference(work / "bed", work / "four"), 1e-8);
  const auto bed = summary_of(work / "bed"), mpi = summary_of(work / "mpi");
  EXPECT_EQ(mpi["run"]["engine"], "LIGGGHTS on 2 processes");
  for (const auto& [section, value] : bed.items()) EXPECT_TRUE(mpi.contains(section)) << section;
  EXPECT_EQ(frame_times(work / "bed"), frame_times(work / "mpi"));
  const std::vector<double> a = FrameNumbers(work / "bed", 3).values.at("position"),
                            b = FrameNumbers(work / "mpi", 3).values.at("position");
  ASSERT_EQ(a.size(), b.size());
  double off = 0;
  for (std::size_t k = 0; k < a.size(); ++k) off = std::max(off, std::abs(a[k] - b[k]));
  EXPECT_LT(off, 1e-6);  // frames are rounded, m
}

TEST(ManyNodes, AStateIsGoneOnFromByEitherEngine) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  const std::string scenario = work.scenario(small_pass);
  ASSERT_EQ(run_on(2, scenario, work / "whole", "--set \"output.state every=0.05 s\""), 0);
  std::filesystem::path state;
  for (const auto& entry : std::filesystem::directory_iterator(work / "whole"))
    if (entry.path().filename().string().rfind("state-0.05", 0) == 0) state = entry.path();
  ASSERT_FALSE(state.empty());
  ASSERT_EQ(run_on(2, scenario, work / "on", "--from " + state.string()), 0) << text_of(work / "on.log");
  ASSERT_EQ(run_scenario(scenario, work / "by the bed", {}, state), 0);
  // Sums and means over the rows since the start of a run begin anew: values of an instant are compared, a mean later.
  const Series whole = read_series(work / "whole/series.csv");
  for (const char* out : {"on", "by the bed"}) {
    const Series part = read_series(work / out / "series.csv");
    const std::size_t before = whole.rows() - part.rows();
    for (const char* name : {"tine.x", "soil.kinetic", "draft"}) {
      const std::vector<double>&values = whole.at(name), &again = part.at(name);
      double most = 0, off = 0;
      for (std::size_t k = 5; k < part.rows(); ++k) {
        most = std::max(most, std::abs(values[before + k]));
        off = std::max(off, std::abs(values[before + k] - again[k]));
      }
      EXPECT_LT(off, 1e-7 * most) << name << " of " << out;
    }
  }
}

/// Every number of every frame the same, to the bit: gathering changes nothing, nor does going on from a state.
void expect_same_frames(const std::filesystem::path& a, const std::filesystem::path& b) {
  const std::vector<double> times = frame_times(a);
  ASSERT_EQ(times, frame_times(b));
  for (std::size_t k = 0; k < times.size(); ++k) {
    const FrameNumbers one(a, k), other(b, k);
    ASSERT_EQ(one.id, other.id) << k;
    ASSERT_EQ(one.values, other.values) << k;
    ASSERT_EQ(one.contacts, other.contacts) << k;
  }
}

/// Frames lie between the steps, and spheres change their process meanwhile.
TEST(ManyNodes, FramesInPartsAreThoseThatTheFirstProcessGathers) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  const std::string scenario = work.scenario(few_grains("law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0.3"));
  const std::string often = "--set \"output.every=1.7 ms\" --set output.precision=double ";
  for (const int ranks : {1, 2, 4}) {
    const std::string n = std::to_string(ranks);
    const std::string parts = ranks == 1 ? "--set output.frames=parts" : "";
    ASSERT_EQ(run_on(ranks, scenario, work / ("parts" + n), often + parts), 0)
        << text_of(work / ("parts" + n + ".log"));
    ASSERT_EQ(run_on(ranks, scenario, work / ("gathered" + n), often + "--set output.frames=gathered"), 0);
    expect_same_frames(work / ("parts" + n), work / ("gathered" + n));
    EXPECT_TRUE(FrameNumbers(work / ("parts" + n), 0).in_parts);
    EXPECT_FALSE(FrameNumbers(work / ("gathered" + n), 0).in_parts);
    EXPECT_GT(check_xdmf(work / ("parts" + n) / "run.xdmf"), 30 * ranks * 11);
  }
}

TEST(ManyNodes, PartsHoldTheMassOfTheBed) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  ASSERT_EQ(run_on(2, work.scenario(small_pass), work / "out", "--set output.precision=double"), 0);
  const double bed = summary_of(work / "out")["soil"]["mass [kg]"];
  for (std::size_t k = 0; k < frame_times(work / "out").size(); ++k) {
    const FrameNumbers frame(work / "out", k);
    EXPECT_TRUE(frame.in_parts);
    EXPECT_NEAR(frame.mass(), bed, 1e-9 * bed) << k;  // the summary has ten digits
  }
  const FramesFile file(work / "out/run.h5");
  EXPECT_EQ(file.spheres(0, true).velocity.size(), 3 * file.particles());
}

/// Points of the blocks whose names begin so, by ParaView's reader: lines are BLOCK|points|...
long points_of(const std::string& text, const std::string& block) {
  long points = 0;
  for (std::size_t at = text.find("\n" + block); at != std::string::npos; at = text.find("\n" + block, at + 1))
    points += std::stol(text.substr(text.find('|', at) + 1));
  return points;
}

TEST(ManyNodes, ParaViewOpensPartsAsOneRun) {
  SKIP_UNLESS_BUILT();
  if (std::system("command -v pvpython >/dev/null 2>&1") != 0) GTEST_SKIP() << "no pvpython";
  const RunDirectory work;
  ASSERT_EQ(run_on(2, work.scenario(small_pass), work / "out"), 0) << text_of(work / "out.log");
  const std::string read = "timeout 100 pvpython " + subsoil::test::source_dir() + "/tests/optional/paraview_read.py ";
  for (const char* file : {"out/run.xdmf2", "out/run.xdmf"}) {
    shell(read + (work / file).string(), work / "read");
    const std::string said = text_of(work / "read.log");
    EXPECT_EQ(points_of(said, "soil"), 224) << said;
    EXPECT_NE(said.find("times 7 0.15"), std::string::npos) << said;
    EXPECT_NE(said.find("contacts:1,density:1,force:3,id:1,material:1,radius:1,spin:3,torque:3,velocity:3|\n"),
              std::string::npos)
        << said;
  }
}

TEST(ManyNodes, ARunGoesOnWithPartsAsIfItHadNotStopped) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  const std::string scenario = work.scenario(few_grains("law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0.3"));
  ASSERT_EQ(run_on(2, scenario, work / "whole",
                   "--set \"output.every=1.7 ms\" --set output.precision=double --set \"output.state every=20 ms\""),
            0);
  std::filesystem::copy(work / "whole", work / "cut", std::filesystem::copy_options::recursive);
  std::filesystem::remove(work / "cut/summary.json");
  for (const auto& entry : std::filesystem::directory_iterator(work / "cut")) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("state-", 0) == 0 && std::stod(name.substr(6)) > 0.03) std::filesystem::remove(entry.path());
  }
  ASSERT_EQ(shell(mpirun + "-np 2 " + subsoil::test::program() + " resume " + (work / "cut").string(), work / "on"), 0)
      << text_of(work / "on.log");
  expect_same_frames(work / "whole", work / "cut");
}

/// Longer than anything here lets it run.
constexpr const char* usual_law = "law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0.3";
constexpr const char* long_run = "--set boundaries=[] --set \"time.end=20 s\" --set \"output.every=1 ms\"";

/// Frames that a run came to, each with all its parts.
void expect_readable(const std::filesystem::path& out, std::size_t least, std::size_t spheres) {
  check_xdmf(out / "run.xdmf");
  const std::size_t frames = frame_times(out).size();
  EXPECT_GE(frames, least);
  for (std::size_t k = 0; k < frames; ++k) EXPECT_EQ(FrameNumbers(out, k).id.size(), spheres) << k;
}

/// No file may have more than 500 bytes: as on a disk that is full after some frames.
TEST(ManyNodes, AFullDiskUnderOneProcessEndsTheRunWithThePartsName) {
  SKIP_UNLESS_BUILT();
  if (std::system("command -v prlimit >/dev/null 2>&1") != 0) GTEST_SKIP() << "no prlimit";
  const RunDirectory work;
  const std::string words = run_words(work.scenario(few_grains(usual_law)), work / "out", long_run);
  EXPECT_EQ(disturbed(words, work / "out", "5", "prlimit --pid $PID --fsize=500"), 3);
  const std::string said = text_of(work / "out.log");
  EXPECT_NE(said.find(".rank-01.h5"), std::string::npos) << said;
  EXPECT_NE(said.find("ulimit -f"), std::string::npos) << said;
  expect_readable(work / "out", 5, 4);
  for (const auto& entry : std::filesystem::directory_iterator(work / "out/frames"))
    EXPECT_EQ(entry.path().extension(), ".h5") << "what was not finished is thrown away";
}

TEST(ManyNodes, AProcessThatIsKilledLeavesAllFramesBefore) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  const std::string words = run_words(work.scenario(few_grains(usual_law)), work / "out", long_run);
  EXPECT_NE(disturbed(words, work / "out", "5", "kill -9 $PID"), 0);
  EXPECT_NE(text_of(work / "out.log").find("signal 9"), std::string::npos) << text_of(work / "out.log");
  expect_readable(work / "out", 5, 4);
}

TEST(ManyNodes, WhatTheEngineCannotDoIsRefusedWithItsPlaceAndTheCure) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  const std::string scenario = work.scenario(few_grains("law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0.3"));
  const auto refused = [&](const std::string& more) {
    EXPECT_EQ(run_on(1, scenario, work / "no", more), 2) << more;
    return text_of(work / "no.log");
  };
  EXPECT_NE(refused("--set precision=mixed").find("`engine: liggghts` has double only; leave it out"),
            std::string::npos);
  EXPECT_NE(refused("--set \"output.contact forces=true\"").find("cannot do single contacts in frames; leave it out"),
            std::string::npos);
  EXPECT_NE(refused("--set \"soil.container.periodic=[z]\"").find("cannot do periodic sides"), std::string::npos);
  EXPECT_NE(refused("--set \"soil.bed.particles=[]\"").find("is empty; list a sphere at least"), std::string::npos);
}

int count_of(const std::string& words, const std::string& text) {
  int count = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++count;
  return count;
}

TEST(ManyNodes, AFaultOfTheScenarioIsSaidByTheFirstProcessAlone) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  const std::string scenario = work.scenario(small_pass);
  EXPECT_EQ(run_on(2, scenario, work / "fault", "--set \"time.end=3 kg\""), 2);
  const std::string said = text_of(work / "fault.log");
  EXPECT_EQ(count_of("time.end", said), 1) << said;
}

TEST(ManyNodes, SeveralProcessesAreRefusedWithTheEngineOfOne) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  const std::string scenario = work.scenario(small_pass);
  EXPECT_EQ(run_on(2, scenario, work / "two", "--set engine=subsoil"), 2);
  const std::string said = text_of(work / "two.log");
  EXPECT_EQ(count_of("mpirun started 2 processes, and this engine works in one", said), 1) << said;
  EXPECT_FALSE(std::filesystem::exists(work / "two"));
}

TEST(ManyNodes, AFaultIsThatOfTheBed) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  const std::string scenario = work.scenario(small_pass);
  EXPECT_EQ(run_on(2, scenario, work / "fault", "--set \"limits.speed=0.3 m/s\""), 3);
  const std::string said = text_of(work / "fault.log");
  EXPECT_NE(said.find("limit 0.3 m/s"), std::string::npos) << said;
  EXPECT_TRUE(std::filesystem::exists(work / "fault/summary.json"));
}

}  // namespace
}  // namespace subsoil::sim::many_nodes_test
