#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/tools/paths.hpp"
#include "tests/tools/scratch.hpp"

/// The schemas of `subsoil reference --schema` under a validator that is not ours: every config validates, mistakes do
/// not (check_schema.py lists them).
namespace subsoil::sim::schema_test {
namespace {

TEST(Schema, ConfigsValidateAndMistakesDoNot) {
  if (std::system("python3 -c 'import jsonschema, yaml' >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "no python3-jsonschema or python3-yaml: scripts/setup --schema";
  const test::Scratch scratch;
  const std::string root = subsoil::test::source_dir(), log = scratch / "log";
  const std::string command = "python3 " + root + "/tests/optional/check_schema.py " + subsoil::test::program() + " " +
                              root + "/configs >" + log + " 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << test::text_of(log);
}

}  // namespace
}  // namespace subsoil::sim::schema_test
