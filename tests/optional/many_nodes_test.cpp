#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "tests/tools/program_runs.hpp"

/// Soil on several processes by LIGGGHTS (`engine: liggghts`, docs/many-nodes.md) beside the same soil stepped by the
/// bed itself. Contacts are evaluated by the same kernels; what differs is the order in which forces on a sphere are
/// added, 1e-16 of them. Chaos lets such differences grow, which the few spheres and short times here leave no room
/// for. Left out where subsoil-mpi is not built or mpirun is missing (scripts/setup --mpi).
namespace subsoil::app::many_nodes_test {
namespace {

using namespace test;

constexpr double kRounding = 1e-10;  // 1e-16 of a step, over thousands of steps of contacts that do not diverge

bool built() {
  const std::filesystem::path program = std::filesystem::path(subsoil::test::program()).parent_path() / "subsoil-mpi";
  return std::filesystem::exists(program) && std::system("command -v mpirun >/dev/null 2>&1") == 0;
}
#define SKIP_UNLESS_BUILT() \
  if (!built()) GTEST_SKIP() << "no subsoil-mpi, or no mpirun: scripts/setup --mpi"

/// `mpirun -np RANKS subsoil run ...`, each process on one thread; the exit code of rank 0, what it says in out.log.
int run_on(int ranks, const std::string& scenario, const std::filesystem::path& out, const std::string& more = "") {
  const std::string command =
      "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1 mpirun "
      "--oversubscribe -np " +
      std::to_string(ranks) + " " + subsoil::test::program() + " run " + scenario + " --out " + out.string() +
      " --set engine=liggghts " + more + " >" + out.string() + ".log 2>&1";
  return WEXITSTATUS(std::system(command.c_str()));
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

TEST_P(FewGrains, MoveAsInTheBedOnOneProcessAndOnTwo) {
  SKIP_UNLESS_BUILT();
  const RunDirectory work;
  const std::string scenario = work.scenario(few_grains(GetParam()));
  ASSERT_EQ(run_scenario(scenario, work / "bed"), 0);
  for (const int ranks : {1, 2}) {
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
  const auto bed = summary_of(work / "bed"), mpi = summary_of(work / "mpi");
  EXPECT_EQ(mpi["run"]["engine"], "LIGGGHTS on 2 processes");
  for (const auto& [section, value] : bed.items()) EXPECT_TRUE(mpi.contains(section)) << section;
  EXPECT_EQ(frame_times(work / "bed"), frame_times(work / "mpi"));
  const auto a = frame_positions(work / "bed", 3), b = frame_positions(work / "mpi", 3);
  ASSERT_EQ(a.size(), b.size());
  double off = 0;
  for (std::size_t k = 0; k < a.size(); ++k) off = std::max(off, norm(a[k] - b[k]));
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
}  // namespace subsoil::app::many_nodes_test
