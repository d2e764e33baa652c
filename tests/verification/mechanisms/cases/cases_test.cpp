// Every case of the list: the program's numbers against the reference, in every row of the series.
//
// With SUBSOIL_CASES_TABLE=FILE the findings are written there as the table of docs/verification/mechanisms.md (see
// scripts/verify_mechanisms).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/verification/mechanisms/cases/replay.hpp"

namespace subsoil::cases {

std::vector<Case> all_cases() {
  std::vector<Case> all;
  for (const auto& list : {published(), pendulums(), oscillators(), driven_linkages(), free_linkages(), elements()})
    all.insert(all.end(), list.begin(), list.end());
  return all;
}

namespace {

std::string printed(double value, const char* format) {
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// Rows of the table, in the order of the cases.
class Table : public testing::Environment {
 public:
  void add(std::size_t index, const Case& c, const std::vector<Finding>& findings) {
    std::ostringstream text;
    for (const Finding& f : findings)
      text << "| " << c.name << " | " << f.kind << " | " << c.source << " | `" << f.column << "` at "
           << printed(f.t, "%.6g") << " s | " << printed(f.ours, "%.12g") << " " << f.unit << " | "
           << printed(f.reference, "%.12g") << " | " << printed(f.difference, "%.1e") << " | "
           << printed(f.bound, "%.0e") << " |\n";
    rows_[index] = text.str();
  }
  void TearDown() override {
    const char* const path = std::getenv("SUBSOIL_CASES_TABLE");
    if (path == nullptr || rows_.empty()) return;
    std::ofstream out(path);
    out << "| case | quantity | source of the reference | where the difference is maximum | ours | reference | "
           "difference | bound |\n|---|---|---|---|---|---|---|---|\n";
    for (const auto& [index, text] : rows_) out << text;
  }

 private:
  std::map<std::size_t, std::string> rows_;
};
Table* const table = static_cast<Table*>(testing::AddGlobalTestEnvironment(new Table));

class Cases : public testing::TestWithParam<std::size_t> {
 protected:
  Case of() const { return all_cases()[GetParam()]; }
};

/// The cases that come first with their file.
class Scenarios : public Cases {};
std::vector<std::size_t> first_of_each_file() {
  const std::vector<Case> all = all_cases();
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (i == 0 || all[i].name != all[i - 1].name) first.push_back(i);
  return first;
}

TEST_P(Cases, AgreeWithTheirReference) {
  const Case c = of();
  const std::vector<Finding> findings = compare(c);
  ASSERT_FALSE(findings.empty());
  for (const Finding& f : findings)
    EXPECT_LE(f.difference, f.bound) << f.kind << ": " << f.column << " at " << f.t << " s is " << f.ours << " "
                                     << f.unit << ", reference " << f.reference;
  table->add(GetParam(), c, findings);
}

// The document has rows for every case, with the case's own source. Its numbers are not compared.
TEST_P(Cases, StandInTheDocument) {
  const Case c = of();
  std::ifstream file(subsoil::test::source_dir() + "/docs/verification/mechanisms.md");
  std::stringstream text;
  text << file.rdbuf();
  const auto has = [&](const std::string& kind) {
    return text.str().find("| " + c.name + " | " + kind + " | " + c.source + " | ") != std::string::npos;
  };
  EXPECT_TRUE(has("position") || has("velocity"))
      << "docs/verification/mechanisms.md is old: run scripts/verify_mechanisms";
}

// What `subsoil run` writes is what was compared: same machine, same steps, the same bits in every column, forces too,
// since without soil series.csv holds all of them at the row's time with all their digits.
TEST_P(Scenarios, SeriesOfTheProgramHoldsTheSameNumbers) {
  const Case c = of();
  const sim::test::RunDirectory dir;
  ASSERT_EQ(sim::test::run_scenario(file_of(c), dir / "out", {"output.state=none"}), 0);
  const sim::Series series = sim::read_series(dir / "out" / "series.csv");
  Replay replay(c);
  const std::vector<double>& times = series.at("time");
  std::size_t row = 0;
  do {
    ASSERT_LT(row, times.size());
    ASSERT_NEAR(times[row], replay.time(), 1e-12);
    for (const sim::SeriesColumn& column : series.columns) {
      if (column.name == "time") continue;
      ASSERT_EQ(series.at(column.name)[row], replay.value(column.name)) << column.name << " at " << times[row];
    }
    ++row;
  } while (replay.next());
  EXPECT_EQ(row, times.size());
}

// A machine alone without a step of its own: `auto` chooses the steps by their error, and its tolerances are what they
// are by default. The bounds are those of the case. Its step is a row of the series.
TEST_P(Cases, AgreeWithDefaultSettings) {
  for (const Finding& f : compare(of(), {"time.machine.integrator=cvode", "time.machine.step=1 s"}))
    EXPECT_LE(f.difference, f.bound) << f.kind << ": " << f.column << " at " << f.t << " s is " << f.ours << " "
                                     << f.unit << ", reference " << f.reference;
}

// The other integrator of the same equations, at its own tolerance: rtol = atol = 1e-10 leaves some 1e3 steps of local
// error, which a pendulum near its upper rest magnifies by up to 1e2; a wrong term would show in the third digit. Its
// step is a row of the series.
TEST_P(Scenarios, IdaAgreesToo) {
  const Case c = of();
  try {
    for (const Finding& f : compare(c, {"time.machine.integrator=ida", "time.machine.rtol=1e-10",
                                        "time.machine.atol=1e-10", "time.machine.step=1 s"})) {
      if (f.kind != "position" && f.kind != "velocity") continue;
      EXPECT_LE(f.difference, std::max(1e-4, f.bound))
          << f.kind << ": " << f.column << " at " << f.t << " s is " << f.ours << ", reference " << f.reference;
    }
  } catch (const std::runtime_error& stopped) {
    // Where constraints lose rank the stabilised index-2 system is singular: it may stop there, and says when.
    EXPECT_TRUE(c.passes_singular) << stopped.what();
    EXPECT_NE(std::string(stopped.what()).find("t = "), std::string::npos) << stopped.what();
  }
}

std::string name_of(const testing::TestParamInfo<std::size_t>& info) {
  std::string name = std::to_string(info.index) + "_" + all_cases()[info.param].name;
  for (char& letter : name)
    if (!std::isalnum(static_cast<unsigned char>(letter))) letter = '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(All, Cases, testing::Range(std::size_t{0}, all_cases().size()), name_of);
INSTANTIATE_TEST_SUITE_P(All, Scenarios, testing::ValuesIn(first_of_each_file()), name_of);

}  // namespace
}  // namespace subsoil::cases
