#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "tests/tools/paths.hpp"
#include "tests/tools/scratch.hpp"

/// FMUs under an importer that is not ours, FMPy (fmu_fmpy.py): validation, simulation, states, instances. FMPy is no
/// package of Debian; SUBSOIL_FMPY_PYTHON names the Python of a virtual environment that has it.
namespace subsoil::sim::fmu_test {
namespace {

constexpr int kNoPackage = 77;  ///< exit code of fmu_fmpy.py

TEST(Fmu, ValidatesAndStepsUnderFmpy) {
  const char* python = std::getenv("SUBSOIL_FMPY_PYTHON");
  const test::Scratch scratch;
  const std::string command = std::string(python != nullptr ? python : "python3") + " " + subsoil::test::source_dir() +
                              "/tests/optional/fmu_fmpy.py " + subsoil::test::program() + " " +
                              scratch.path().string() + " 2>&1";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNoPackage)
    GTEST_SKIP() << "no FMPy: python3 -m venv fmpy && fmpy/bin/pip install --no-deps fmpy attrs lark lxml msgpack "
                    "numpy, and SUBSOIL_FMPY_PYTHON=fmpy/bin/python";
  EXPECT_EQ(WEXITSTATUS(status), 0) << "its messages stand above";
}

}  // namespace
}  // namespace subsoil::sim::fmu_test
