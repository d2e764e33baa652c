#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "libsim/report/report.hpp"
#include "tests/tools/program_runs.hpp"

/// A report opened in headless Chromium (scripts/setup --browser): it draws itself without an error, and a chart shows
/// the value of the series. Left out where there is no Chromium.
namespace subsoil::sim::browser_test {
namespace {

std::string output_of(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) text += buffer.data();
  pclose(pipe);
  return text;
}

/// Runs the page; the document as its scripts leave it, and what they say on the console.
std::string opened(const std::filesystem::path& page, const std::string& hash, const test::Scratch& scratch) {
  return output_of(
      "timeout 300 chromium --headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
      "--disable-background-networking --disable-component-update --disable-sync --user-data-dir=" +
      (scratch / "profile").string() + " --virtual-time-budget=30000 --enable-logging=stderr --dump-dom 'file://" +
      page.string() + hash + "' 2>&1");
}

TEST(Browser, ReportDrawsItselfAndShowsValues) {
  if (std::system("command -v chromium >/dev/null 2>&1") != 0) GTEST_SKIP() << "no chromium: scripts/setup --browser";
  const test::RunDirectory directory;
  ASSERT_EQ(test::run_scenario(directory.scenario(test::small_pass), directory / "run"), exit_ok);
  ReportRequest request;
  request.runs = {directory / "run"};
  request.out = directory / "page.html";
  write_report(request);
  const std::string dom = opened(request.out, "#probe=draft@0.1", directory);
  EXPECT_NE(dom.find("data-ready=\"yes\""), std::string::npos) << dom.substr(0, 2000);
  EXPECT_NE(dom.find("data-errors=\"0\""), std::string::npos);
  EXPECT_EQ(dom.find("CONSOLE"), std::string::npos) << dom.substr(dom.find("CONSOLE"), 500);
  // The cursor sits on a row near 0.1 s: its time and value stand in the page and in the series alike.
  const std::size_t at = dom.find("data-probe=\"");
  ASSERT_NE(at, std::string::npos);
  double time = 0, value = 0;
  ASSERT_EQ(std::sscanf(dom.c_str() + at, "data-probe=\"%lf s | %lf N", &time, &value), 2) << dom.substr(at, 80);
  EXPECT_NEAR(time, 0.1, 2e-3);
  const Series series = read_series(directory / "run" / "series.csv");
  const std::vector<double>& t = series.at("time");
  double nearest = 1, expected = 0;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (std::abs(t[i] - time) < nearest) nearest = std::abs(t[i] - time), expected = series.at("draft")[i];
  EXPECT_NEAR(value, expected, 1e-4 * std::abs(expected) + 1e-6) << "five digits are shown";
}

}  // namespace
}  // namespace subsoil::sim::browser_test
