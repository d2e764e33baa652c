#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/tools/paths.hpp"

/// python/subsoil by unittests of its own in Python, a class of them each: what reads results (python_module.py), the
/// compiled part (python_simulation.py), examples (python_examples.py). Left out where Debian's Python lacks a package
/// (scripts/setup), or the compiled part is not built (scripts/setup --python).
namespace subsoil::sim::python_test {
namespace {

constexpr int kNoPackage = 77;  ///< exit code of the scripts

void passes(const std::string& script, const std::string& of_class) {
  const std::filesystem::path program = subsoil::test::program();
  const std::string command = subsoil::test::source_dir() + "/tests/optional/" + script + " " + program.string() + " " +
                              (program.parent_path().parent_path() / "python").string() + " " + of_class + " 2>&1";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNoPackage) GTEST_SKIP() << "its message stands above";
  EXPECT_EQ(WEXITSTATUS(status), 0) << "its messages stand above";
}

const auto name = [](const auto& of) { return std::string(of.param); };

class PythonModule : public testing::TestWithParam<const char*> {};
TEST_P(PythonModule, PassesItsTests) { passes("python_module.py", GetParam()); }
INSTANTIATE_TEST_SUITE_P(All, PythonModule, testing::Values("Results", "Loads", "Machine", "Failures", "Guide"), name);

class PythonSimulation : public testing::TestWithParam<const char*> {};
TEST_P(PythonSimulation, PassesItsTests) { passes("python_simulation.py", GetParam()); }
INSTANTIATE_TEST_SUITE_P(All, PythonSimulation,
                         testing::Values("Bits", "Arrays", "Control", "Calls", "Faults", "Wheel"), name);

class PythonExamples : public testing::TestWithParam<const char*> {};
TEST_P(PythonExamples, PassTheirTests) { passes("python_examples.py", GetParam()); }
INSTANTIATE_TEST_SUITE_P(All, PythonExamples, testing::Values("DepthControl", "ParameterStudy", "Bucket", "Notebook"),
                         name);

}  // namespace
}  // namespace subsoil::sim::python_test
