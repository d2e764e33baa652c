#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <string>

#include "tests/tools/paths.hpp"

/// What happens before the first line of main().
namespace subsoil::sim::program_start {
namespace {

std::string output_of(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  std::array<char, 512> piece{};
  std::string text;
  while (pipe != nullptr && std::fgets(piece.data(), piece.size(), pipe) != nullptr) text += piece.data();
  EXPECT_EQ(pclose(pipe), 0) << command;
  return text;
}

// Loading them was half of the 29 ms that a start took: HDF5's shared library needs curl and thirty libraries behind
// it. A library of the network, of compression or of encryption is of no use to a run.
TEST(ProgramStart, LoadsNoLibrariesThatOnlyFewCommandsNeed) {
  const std::string libraries = output_of("ldd " + subsoil::test::program());
  EXPECT_NE(libraries.find("libc.so"), std::string::npos) << libraries;  // that ldd tells anything
  for (const char* name : {"libcurl", "libssh", "libssl", "libcrypto", "libbrotli", "libhdf5"})
    EXPECT_EQ(libraries.find(name), std::string::npos) << name;
}

// GNU's library says itself how often a thread looks before it sleeps.
TEST(ProgramStart, WaitingThreadsSleepUnlessToldOtherwise) {
  const std::string show = "OMP_DISPLAY_ENV=verbose " + subsoil::test::program() + " --version";
  EXPECT_NE(output_of("env -u OMP_WAIT_POLICY " + show).find("GOMP_SPINCOUNT = '0'"), std::string::npos);
  EXPECT_EQ(output_of("OMP_WAIT_POLICY=active " + show).find("GOMP_SPINCOUNT = '0'"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::program_start
