// Language and links of the docs, and that their checkers fail when they should: tests/docs/*.py.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "tests/tools/paths.hpp"

namespace {

class DocsChecks : public testing::TestWithParam<const char*> {};

TEST_P(DocsChecks, Pass) {
  const std::string command = "python3 " + subsoil::test::source_dir() + "/tests/docs/" + GetParam() + ".py 2>&1";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0) << command << ": the faults stand above";
}

INSTANTIATE_TEST_SUITE_P(All, DocsChecks, testing::Values("style", "links", "test_checkers"),
                         [](const auto& of) { return std::string(of.param); });

}  // namespace
