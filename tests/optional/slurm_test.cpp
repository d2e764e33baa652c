#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/tools/paths.hpp"
#include "tests/tools/scratch.hpp"

/// A sweep as a job array under Slurm on this machine as its only node (scripts/setup --slurm). Left out where Slurm is
/// not installed, and without root, whom its daemons need here.
namespace subsoil::sim::slurm_test {
namespace {

TEST(Slurm, ArrayRunsAndIsGathered) {
  if (std::system("command -v slurmctld >/dev/null 2>&1 && command -v munged >/dev/null 2>&1") != 0 || geteuid() != 0)
    GTEST_SKIP() << "no Slurm, or not root: scripts/setup --slurm";
  const test::Scratch scratch;
  const std::string script = subsoil::test::source_dir() + "/tests/optional/slurm_node", log = scratch / "log";
  const std::string sweep = subsoil::test::program() + " sweep " + subsoil::test::source_dir() +
                            "/configs/sweep/pendulum.yaml --slurm --out " + (scratch / "sweep").string();
  const int code =
      std::system((script + " " + (scratch / "node").string() + " '" + sweep + "' >" + log + " 2>&1").c_str());
  EXPECT_EQ(code, 0) << test::text_of(log);
  const std::string table = test::text_of(scratch / "sweep/sweep.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 7) << table << test::text_of(log);  // a head, 2 x 3 points
  EXPECT_EQ(table.find("failed"), std::string::npos) << table;
  EXPECT_EQ(table.find("open"), std::string::npos) << table;
}

}  // namespace
}  // namespace subsoil::sim::slurm_test
