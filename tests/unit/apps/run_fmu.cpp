#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "tests/tools/paths.hpp"

/// FMUs of the built program under an importer in Python's standard library: a class of fmu_checks.py each.
namespace subsoil::sim::run_fmu {
namespace {

class Fmu : public testing::TestWithParam<const char*> {};

TEST_P(Fmu, PassesItsChecks) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "no FMUs with the sanitizers: their library must be loaded before all others";
#endif
  const std::string command = "OMP_NUM_THREADS=1 python3 " + subsoil::test::source_dir() +
                              "/tests/unit/apps/fmu_checks.py " + subsoil::test::program() + " " + GetParam() + " 2>&1";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0) << "its messages stand above";
}

INSTANTIATE_TEST_SUITE_P(All, Fmu, testing::Values("Archive", "States", "Mechanics", "Errors", "Exchange"),
                         [](const auto& of) { return std::string(of.param); });

}  // namespace
}  // namespace subsoil::sim::run_fmu
