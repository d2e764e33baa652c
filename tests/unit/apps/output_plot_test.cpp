#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>

#include "libsim/io/series.hpp"
#include "libsim/io/series_writer.hpp"
#include "libsim/plot/plot.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/scratch.hpp"

namespace subsoil::sim::output_plot_test {
namespace {

using test::message_of;

/// A result directory whose draft jitters about 1000 N and whose pitch swings slowly.
void make_run(const std::filesystem::path& directory, std::vector<SeriesColumn> watches) {
  std::filesystem::create_directories(directory);
  watches.insert(watches.begin(), {{"time", "s"}, {"shovel.x", "m"}});
  SeriesWriter writer(directory / "series.csv", watches);
  for (int k = 0; k <= 1000; ++k) {
    const double t = k * 1e-3;
    std::vector<double> row{t, 0.5 * t};
    for (std::size_t i = 2; i < watches.size(); ++i)
      row.push_back(watches[i].unit == "N" ? 1000 + 200 * (k % 2) : 0.05 * std::sin(8 * t));
    writer.write(row);
  }
}

bool drawn(const std::filesystem::path& svg, const std::string& text) {
  return test::text_of(svg).find(text) != std::string::npos;
}

TEST(Plot, OverlaysRunsWithUnitsAndNames) {
  if (!gnuplot_found()) GTEST_SKIP() << "gnuplot is not installed";
  test::Scratch scratch;
  make_run(scratch / "free_spring", {{"draft", "N"}, {"pitch", "rad"}});
  make_run(scratch / "locked's", {{"draft", "N"}, {"pitch", "rad"}});
  const auto out = scratch / "both.svg";
  plot({scratch / "free_spring", scratch / "locked's/"}, out);
  for (const char* text : {"draft [N]", "pitch [deg]", "free_spring", "locked's", "time [s]", "50 ms means"})
    EXPECT_TRUE(drawn(out, text)) << text;
  EXPECT_FALSE(drawn(out, "shovel.x")) << "only what is watched is drawn unasked";
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path()), {}), 3) << "no litter";
}

TEST(Plot, AnyRunDrawsItsOwnWatchesOrWhatIsAskedFor) {
  if (!gnuplot_found()) GTEST_SKIP() << "gnuplot is not installed";
  test::Scratch scratch;
  make_run(scratch / "pendulum", {{"swing", "rad"}});
  plot({scratch / "pendulum"}, scratch / "p.svg");
  EXPECT_TRUE(drawn(scratch / "p.svg", "swing [deg]"));
  EXPECT_FALSE(drawn(scratch / "p.svg", "50 ms means")) << "a smooth curve is not smoothed";
  PlotOptions options;
  options.columns = {"shovel.x"};
  plot({scratch / "pendulum"}, scratch / "x.png", options);
  EXPECT_EQ(test::text_of(scratch / "x.png").substr(1, 3), "PNG");
}

TEST(Plot, DrawsEveryWatchBesideTheUsualOnes) {
  if (!gnuplot_found()) GTEST_SKIP() << "gnuplot is not installed";
  test::Scratch scratch;
  make_run(scratch / "run", {{"torque", "N m"}, {"draft", "N"}});
  plot({scratch / "run"}, scratch / "p.svg");
  EXPECT_TRUE(drawn(scratch / "p.svg", "draft [N]"));
  EXPECT_TRUE(drawn(scratch / "p.svg", "torque [N m]")) << "one known name must not hide the others";
}

/// Two runs whose monitors have other units: one axis, in the unit of the first; not where the dimensions differ.
TEST(Plot, OverlaysRunsInOneUnit) {
  if (!gnuplot_found()) GTEST_SKIP() << "gnuplot is not installed";
  test::Scratch scratch;
  make_run(scratch / "a", {{"draft", "N"}});
  make_run(scratch / "b", {{"draft", "kN"}});
  make_run(scratch / "c", {{"draft", "J"}});
  PlotOptions options;
  options.columns = {"draft"};
  plot({scratch / "a", scratch / "b"}, scratch / "two.svg", options);
  // b is 0.05 sin(8 t) kN: at most 50 N beside the 1200 N of a.
  EXPECT_TRUE(drawn(scratch / "two.svg", "draft [N]"));
  plot({scratch / "b", scratch / "a"}, scratch / "other.svg", options);
  EXPECT_TRUE(drawn(scratch / "other.svg", "draft [kN]"));
  EXPECT_EQ(message_of([&] {
              plot({scratch / "a", scratch / "c"}, scratch / "no.svg", options);
            }),
            "column draft: is in J in c and in N before it; leave it out, or draw one run");
}

TEST(Plot, DrawsOverAnotherColumn) {
  if (!gnuplot_found()) GTEST_SKIP() << "gnuplot is not installed";
  test::Scratch scratch;
  make_run(scratch / "run", {{"draft", "N"}});
  PlotOptions options;
  options.over = "shovel.x";
  plot({scratch / "run"}, scratch / "p.svg", options);
  EXPECT_TRUE(drawn(scratch / "p.svg", "shovel.x [mm]"));
  EXPECT_FALSE(drawn(scratch / "p.svg", "time [s]"));
  EXPECT_FALSE(drawn(scratch / "p.svg", "50 ms means")) << "means over time belong over time";
  options.over = "depth";
  EXPECT_EQ(test::message_of<std::invalid_argument>([&] { plot({scratch / "run"}, scratch / "p.svg", options); }),
            "--over depth: series.csv has no column of this name; known here: time, shovel.x, draft");
}

TEST(Plot, RefusalsNameTheCure) {
  test::Scratch scratch;
  make_run(scratch / "run", {{"draft", "N"}});
  // What a user wrote: std::invalid_argument, exit code 2; a program that is not installed: std::runtime_error, 3.
  const auto refusal = [&](const std::string& run, const std::string& out, const PlotOptions& options) {
    return test::message_of<std::invalid_argument>([&] { plot({scratch / run}, scratch / out, options); });
  };
  EXPECT_NE(refusal("nothing", "a.png", {}).find("holds no series.csv"), std::string::npos);
  EXPECT_NE(refusal("run", "a.jpg", {}).find("must be .png, .svg or .pdf, not '.jpg'"), std::string::npos);
  PlotOptions options;
  options.columns = {"drift"};
  EXPECT_EQ(refusal("run", "a.png", options),
            "--columns drift: series.csv has no column of this name; did you mean `draft`?");
  const std::string path = getenv("PATH");
  setenv("PATH", scratch.path().c_str(), 1);
  EXPECT_NE(test::message_of<std::runtime_error>([&] {
              plot({scratch / "run"}, scratch / "a.png");
            }).find("apt-get install gnuplot-nox"),
            std::string::npos);
  setenv("PATH", path.c_str(), 1);
}

}  // namespace
}  // namespace subsoil::sim::output_plot_test
