#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/tools/paths.hpp"

namespace subsoil::sim::abuse_test {
namespace {

/// A sample of what scripts/abuse does to a run; docs/reliability.md has the table of all. Its oracle is a reader of
/// HDF5 and XML that is not ours, and the run that nothing happened to.
TEST(Abuse, ShortFormLosesNothing) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer's runtime refuses a library that is loaded before it, as the trials' is";
#endif
  const std::string command =
      subsoil::test::source_dir() + "/scripts/abuse --short --program " + subsoil::test::program();
  EXPECT_EQ(std::system(command.c_str()), 0);
}

}  // namespace
}  // namespace subsoil::sim::abuse_test
