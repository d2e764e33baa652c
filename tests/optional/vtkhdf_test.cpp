#include "libsim/post/vtkhdf.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "tests/tools/program_runs.hpp"

/// Frames as VTKHDF, read back with another reader than ours: every array equals that of run.h5.
namespace subsoil::sim::test::vtkhdf_test {
namespace {

struct Answer {
  int code = -1;
  std::string text;
};

Answer read_back(const std::filesystem::path& run) {
  // Debian's Python, which has the h5py of scripts/setup.
  const std::string command =
      "/usr/bin/python3 " + subsoil::test::source_dir() + "/tests/optional/vtkhdf_read.py " + run.string() + " 2>&1";
  Answer out;
  FILE* pipe = popen(command.c_str(), "r");
  char line[4096];
  while (std::fgets(line, sizeof line, pipe) != nullptr) out.text += line;
  out.code = pclose(pipe);
  return out;
}

void expect_equal(const std::filesystem::path& run, std::size_t steps) {
  const VtkhdfReport report = write_vtkhdf({.run = run, .out = {}});
  EXPECT_EQ(report.steps, steps);
  const Answer answer = read_back(run);
  EXPECT_EQ(answer.code, 0) << answer.text;
  EXPECT_EQ(answer.text.find("specification "), 0U) << answer.text;
}

TEST(Vtkhdf, HoldsContactsLoadsAndSurfacesOfEveryFrame) {
  const RunDirectory dir;
  const std::vector<std::string> sets{"output.contact forces=yes", "machine.surfaces.blade.wear.finnie=1e-12 1/Pa",
                                      "output.every=50 ms"};
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "out", sets), exit_ok);
  expect_equal(dir / "out", 4);
}

TEST(Vtkhdf, KeepsDoublePrecision) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "out", {"output.precision=double", "output.every=50 ms"}),
            exit_ok);
  expect_equal(dir / "out", 4);
}

// The region of frames holds other spheres in each: arrays and cells of every length, ids of their own.
TEST(Vtkhdf, HoldsFramesWithOtherSpheresInEach) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(small_pass), dir / "out",
                         {"output.region={size: 60 500 500 mm, at: 30 -250 -250 mm}", "output.every=20 ms"}),
            exit_ok);
  expect_equal(dir / "out", 9);
}

TEST(Vtkhdf, ARunWithoutFramesIsRefused) {
  const RunDirectory dir;
  EXPECT_THROW(write_vtkhdf({.run = dir / "none", .out = {}}), std::invalid_argument);
}

}  // namespace
}  // namespace subsoil::sim::test::vtkhdf_test
