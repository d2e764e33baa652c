// What README and docs show is what the program does: tests/docs/blocks.py runs every block of every page.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/paths.hpp"

namespace subsoil::docs::pages_test {
namespace {

namespace fs = std::filesystem;
const fs::path root = subsoil::test::source_dir();

/// README and all pages that hold a fenced block.
std::vector<std::string> pages() {
  std::vector<std::string> found{"README.md"};
  for (const auto& entry : fs::recursive_directory_iterator(root / "docs")) {
    if (entry.path().extension() != ".md") continue;
    std::stringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    if (text.str().find("```") != std::string::npos) found.push_back(fs::relative(entry.path(), root).generic_string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

void run_blocks(const std::string& page, const std::string& option) {
  const std::string command =
      (root / "tests/docs/blocks.py").string() + " " + subsoil::test::program() + option + " " + (root / page).string();
  const int status = std::system((command + " 2>&1").c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0) << page << ": the faults stand above";
}

TEST(Pages, AreFound) {
  const std::vector<std::string> found = pages();
  EXPECT_GT(found.size(), 30u);
  EXPECT_EQ(std::count(found.begin(), found.end(), "docs/start.md"), 1);
}

class Page : public testing::TestWithParam<std::string> {};

TEST_P(Page, BlocksRun) { run_blocks(GetParam(), ""); }

/// Blocks marked `long` too: `scripts/test --all` sets the variable.
TEST_P(Page, LongBlocksRun) {
  if (std::getenv("SUBSOIL_LONG_BLOCKS") == nullptr) GTEST_SKIP() << "only with scripts/test --all";
  run_blocks(GetParam(), " --all");
}

INSTANTIATE_TEST_SUITE_P(All, Page, testing::ValuesIn(pages()), [](const auto& of) {
  std::string name = of.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
});

}  // namespace
}  // namespace subsoil::docs::pages_test
