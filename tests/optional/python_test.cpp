#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "tests/tools/paths.hpp"

/// scripts/python/subsoil.py by its own unittests, tests/optional/python_module.py: a class of them each. Left out
/// where Debian's Python has no h5py, NumPy, pandas or PyYAML (scripts/setup installs them).
namespace subsoil::sim::python_test {
namespace {

constexpr int kNoPackage = 77;  ///< exit code of python_module.py

class PythonModule : public testing::TestWithParam<const char*> {};

TEST_P(PythonModule, PassesItsTests) {
  const std::string command = subsoil::test::source_dir() + "/tests/optional/python_module.py " +
                              subsoil::test::program() + " " + GetParam() + " 2>&1";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNoPackage) GTEST_SKIP() << "a package of Python is missing: scripts/setup";
  EXPECT_EQ(WEXITSTATUS(status), 0) << "its messages stand above";
}

INSTANTIATE_TEST_SUITE_P(All, PythonModule, testing::Values("Results", "Loads", "Machine", "Failures", "Guide"),
                         [](const auto& of) { return std::string(of.param); });

}  // namespace
}  // namespace subsoil::sim::python_test
