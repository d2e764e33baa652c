// The verification report: its rows belong to tests, and the helper that states them fails when it should.
#include "tests/tools/verified.hpp"

#include <gtest/gtest-spi.h>

#include <filesystem>
#include <set>
#include <sstream>

#include "tests/tools/paths.hpp"
#include "tests/tools/scratch.hpp"

namespace subsoil::test::verified_test {
namespace {

namespace fs = std::filesystem;
const fs::path root = subsoil::test::source_dir();

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(Verified, FailsOutsideItsToleranceAndOnNoNumber) {
  setenv("SUBSOIL_VERIFY", "1", 1);  // the committed report is another matter
  const Verified row("A field", "A case", "by hand");
  EXPECT_NONFATAL_FAILURE(row.near("q", "m", 1.02, 1, share(0.01), "test"), "A case, q: 1.02 m, reference 1");
  EXPECT_NONFATAL_FAILURE(row.near("q", "m", std::nan(""), 1, absolute(1), "test"), "");
  row.near("q", "m", 1.005, 1, share(0.01), "test");
  Worst worst;
  worst.take("here", 1.001, 1), worst.take("there", 0.9, 1), worst.take("yonder", 1.002, 1);
  EXPECT_NONFATAL_FAILURE(worst.near(row, "q", "m", absolute(0.05), "test"), "0.9");
  unsetenv("SUBSOIL_VERIFY");
}

/// Of another program's figure no agreement is claimed; that the page shows it is.
TEST(Verified, ComparesWithoutAClaim) {
  const Verified row("A field", "A case", "another program");
  setenv("SUBSOIL_VERIFY", "1", 1);
  row.compare("q", "m", 2, 1, 0.01, "test");
  unsetenv("SUBSOIL_VERIFY");
  EXPECT_NONFATAL_FAILURE(row.compare("q", "m", 2, 1, 0.01, "test"), "run scripts/verify");
}

TEST(Verified, FailsWhenTheReportHasNoSuchRow) {
  const Verified row("A field", "A case of no report", "by hand");
  EXPECT_NONFATAL_FAILURE(row.near("q", "m", 1, 1, share(0.01), "test"), "run scripts/verify");
}

TEST(Verified, ReadsTheFiguresOfAReport) {
  const sim::test::Scratch folder;
  std::ofstream(folder / "report.md") << "| case | source | quantity | ours | reference |\n|---|---|---|---|---|\n"
                                         "| A | by hand | q at 1 m/s | -1.25e-3 m (worst there) | 0 |\n";
  const CommittedReport report((folder / "report.md").string());
  EXPECT_EQ(report.ours("A", "q at 1 m/s"), -1.25e-3);
  EXPECT_TRUE(std::isnan(report.ours("A", "q")));
  EXPECT_TRUE(still_agrees(1.0001, 1.0, 0.01));
  EXPECT_FALSE(still_agrees(1.001, 1.0, 0.01)) << "a tenth of the tolerance is another figure";
}

/// A row whose test has gone would never be looked at again: every case of the report stands in a test, as a literal.
TEST(Verified, EveryCaseOfTheReportStandsInATest) {
  std::string sources;
  for (const auto& entry : fs::recursive_directory_iterator(root / "tests/verification"))
    if (entry.path().extension() == ".cpp") sources += text_of(entry.path());
  std::istringstream report(text_of(root / "docs/verification/index.md"));
  std::set<std::string> cases;
  for (std::string line; std::getline(report, line);)
    if (line.rfind("| ", 0) == 0 &&
        (line.find(" | yes |") != std::string::npos || line.find(" | not reproduced |") != std::string::npos ||
         line.find(" | **NO** |") != std::string::npos))
      cases.insert(line.substr(2, line.find(" | ") - 2));
  EXPECT_GT(cases.size(), 40U);
  for (const std::string& name : cases)
    EXPECT_NE(sources.find('"' + name + '"'), std::string::npos)
        << "no test states `" << name << "`: run scripts/verify";
}

TEST(Verified, TheReportHoldsNoFailure) {
  EXPECT_EQ(text_of(root / "docs/verification/index.md").find("**NO**"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::test::verified_test
