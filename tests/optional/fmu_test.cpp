#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "tests/tools/paths.hpp"
#include "tests/tools/scratch.hpp"

/// FMUs under an importer that is not ours, FMPy (fmu_fmpy.py): validation, simulation, states, instances; and a tine
/// of the multibody program Exudyn in the soil FMU (fmu_exudyn.py). Neither is a package of Debian; SUBSOIL_FMPY_PYTHON
/// names the Python of a virtual environment that has them.
namespace subsoil::sim::fmu_test {
namespace {

constexpr int kNoPackage = 77;  ///< exit code of the scripts

/// @param packages of PyPI that the script needs
void expect_passes(const std::string& script, const std::string& packages) {
  const char* python = std::getenv("SUBSOIL_FMPY_PYTHON");
  const test::Scratch scratch;
  const std::string command = std::string(python != nullptr ? python : "python3") + " " + subsoil::test::source_dir() +
                              "/tests/optional/" + script + " " + subsoil::test::program() + " " +
                              scratch.path().string() + " 2>&1";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNoPackage)
    GTEST_SKIP() << "python3 -m venv fmpy && fmpy/bin/pip install --no-deps " << packages
                 << ", and SUBSOIL_FMPY_PYTHON=fmpy/bin/python";
  EXPECT_EQ(WEXITSTATUS(status), 0) << "its messages stand above";
}

TEST(Fmu, ValidatesAndStepsUnderFmpy) { expect_passes("fmu_fmpy.py", "fmpy attrs lark lxml msgpack numpy"); }

TEST(Fmu, HoldsATineOfExudyn) { expect_passes("fmu_exudyn.py", "exudyn fmpy attrs lark lxml msgpack numpy"); }

}  // namespace
}  // namespace subsoil::sim::fmu_test
