#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "libsim/io/csv.hpp"
#include "libsim/io/series.hpp"
#include "libsim/io/series_writer.hpp"
#include "libsim/io/summary.hpp"
#include "tests/tools/scratch.hpp"

namespace subsoil::sim::output_series_test {
namespace {

TEST(Series, HeaderHoldsNamesAndUnitsAndRowsComeBack) {
  test::Scratch scratch;
  const auto path = scratch / "series.csv";
  SeriesWriter writer(path, {{"time", "s"}, {"shovel.x", "m"}, {"left, front", "N"}, {"pull", "N"}});
  writer.write(std::vector{0.0, -1.224, 1e-12, 1090.123456789});
  writer.write(std::vector{0.001, 2.0 / 3, -0.0, 328.9});
  writer.flush();
  EXPECT_EQ(test::text_of(path),
            "time [s],shovel.x [m],\"left, front [N]\",pull [N]\n"
            "0,-1.224,1e-12,1090.12346\n0.001,0.666666667,-0,328.9\n");
  const auto series = read_series(path);
  EXPECT_EQ(series.columns.at(2).name, "left, front");
  EXPECT_EQ(series.columns.at(2).unit, "N");
  EXPECT_EQ(series.rows(), 2u);
  EXPECT_EQ(series.at("pull").at(1), 328.9);
  EXPECT_TRUE(series.columns.at(3).is_watch());
  EXPECT_FALSE(series.columns.at(1).is_watch());
  EXPECT_FALSE(series.columns.at(0).is_watch());
  EXPECT_NE(test::message_of<std::runtime_error>([&] { series.at("push"); }).find("'push'; it has time, shovel.x"),
            std::string::npos);
}

TEST(Series, ALineCutShortByAKillIsLeftOut) {
  test::Scratch scratch;
  test::write_file(scratch / "s.csv", "time [s],a [N]\n0,1\n0.1,2\n0.2,3");
  EXPECT_EQ(read_series(scratch / "s.csv").rows(), 2u) << "3 may have been the start of 345";
  test::write_file(scratch / "s.csv", "time [s],a [N]\n0,1\n0.1\n0.2,3\n");
  EXPECT_NE(test::message_of<std::runtime_error>([&] { read_series(scratch / "s.csv"); }).find("s.csv:3: 1 fields"),
            std::string::npos);
}

TEST(Series, IntervalMeansAreWeightedWithTheSteps) {
  IntervalMean mean(1);
  mean.add(0.1, std::vector{1.0});
  mean.add(0.3, std::vector{5.0});
  EXPECT_DOUBLE_EQ(mean.take()[0], 4.0);  // (0.1 + 1.5)/0.4
  EXPECT_DOUBLE_EQ(mean.take()[0], 4.0) << "nothing new: the last value stands";
  mean.add(2.0, std::vector{-7.0});
  EXPECT_DOUBLE_EQ(mean.take()[0], -7.0) << "the interval before is forgotten";
}

TEST(Csv, QuotesAndNumbers) {
  EXPECT_EQ(csv::split("a, \"b, \"\"c\"\"\" ,,d\r"), (std::vector<std::string>{"a", "b, \"c\"", "", "d"}));
  double x = 0;
  EXPECT_TRUE(csv::to_number(" +1.5e-3 ", x));
  EXPECT_EQ(x, 1.5e-3);
  EXPECT_FALSE(csv::to_number("1.5 m", x));
  EXPECT_FALSE(csv::to_number("", x));
  EXPECT_EQ(csv::split_label("H9 force [N m]").name, "H9 force");
  EXPECT_EQ(csv::split_label("H9 force [N m]").unit, "N m");
}

TEST(MovingMean, OfASineIsTheClosedForm) {
  // Mean of sin(w t) over [t - L, t] = [cos(w (t-L)) - cos(w t)]/(w L). Piecewise constant at midpoints: error
  // (w dt)^2/24 = 4e-8 relative; steps alternate in length so that the interval's start falls inside one.
  const double w = 20, length = 50e-3;
  MovingMean mean(length);
  double t = 0;
  for (int k = 0; k < 4000; ++k) {
    const double dt = k % 2 ? 4e-5 : 7e-5;
    mean.add(t + dt, dt, std::sin(w * (t + dt / 2)));
    t += dt;
    EXPECT_EQ(mean.full(), t >= length * (1 - 1e-9));
    // The start of the interval lies inside a step: up to (w dt) dt/L more.
    if (!mean.full()) continue;
    ASSERT_NEAR(mean.mean(), (std::cos(w * (t - length)) - std::cos(w * t)) / (w * length), 3e-6);
  }
}

/// Ramp value = time, from 0 to 2 s in steps of 0.1 ms, through a summary with the window [0.5, 1.5].
Summary ramp() {
  Summary summary({{"ramp", "N"}, {"draft", "N"}, {"side wall", "N"}});
  summary.set_window(0.5, 1.5, "for the test");
  const double dt = 1e-4;
  for (int k = 0; k < 20000; ++k) {
    const double t = (k + 1) * dt;
    const double wall = t > 1.0 && t < 1.2 ? 130.0 : 10.0;
    summary.sample(t, dt, std::vector{t - dt / 2, 1000.0, wall});
  }
  return summary;
}

TEST(Summary, MeansAreThoseOfTheWindow) {
  const auto summary = ramp();
  EXPECT_NEAR(summary.mean("ramp"), 1.0, 1e-12);  // the ramp's middle; 10^4 terms add rounding of 1e-13
  const auto json = summary.to_json();
  EXPECT_NEAR(json["window"]["covered [s]"].get<double>(), 1.0, 1e-12);
  EXPECT_EQ(json["window"]["rule"], "for the test");
  const auto& column = json["columns"]["ramp"];
  // The mean over the last L of a ramp is t - L/2; in the window it starts with t = 0.5 + L.
  EXPECT_NEAR(column["50 ms means in window"]["min"].get<double>(), 0.525, 1e-9);
  EXPECT_NEAR(column["50 ms means in window"]["max"].get<double>(), 1.475, 1e-9);
  EXPECT_NEAR(column["50 ms means in run"]["min"].get<double>(), 0.025, 1e-9);
  EXPECT_NEAR(column["50 ms means in run"]["max"].get<double>(), 1.975, 1e-9);
  EXPECT_NEAR(column["1 ms means in window"]["max"].get<double>(), 1.4995, 1e-9);
  EXPECT_NEAR(column["1 ms means in window"]["at max [s]"].get<double>(), 1.5, 1e-9);
  EXPECT_NEAR(column["steps in window"]["at min [s]"].get<double>(), 0.5, 1e-9) << "where the step begins";
}

TEST(Summary, AWindowMayBeClosedAndHoldsWholePeriods) {
  // 1 + sin over periods of 0.3 s, sampled every ms from 0 to 2 s; the window opens at 0.5 and is closed at 1.52.
  const auto mean_with = [](double period) {
    Summary summary(std::vector<SeriesColumn>{{"force", "N"}});
    summary.set_window(0.5, 2.0);
    if (period > 0) summary.take_whole_periods(period);
    for (int k = 0; k < 2000; ++k) {
      const double t = (k + 0.5) * 1e-3;
      if (k == 1520) summary.close_window(1.52);
      summary.sample((k + 1) * 1e-3, 1e-3, std::vector{1 + std::sin(2 * std::acos(-1.0) * (t - 0.5) / 0.3)});
    }
    return std::pair{summary.mean("force"), summary.to_json()["window"]["covered [s]"].get<double>()};
  };
  const auto [all, covered] = mean_with(0);
  // The part beyond three periods: 0.3/(2 pi) (1 - cos(2 pi 0.12/0.3)) over 1.02 s.
  EXPECT_NEAR(all, 1 + 0.3 / (2 * std::acos(-1.0)) * (1 - std::cos(2 * std::acos(-1.0) * 0.4)) / 1.02, 1e-5);
  EXPECT_NEAR(covered, 1.02, 1e-9);
  const auto [whole, held] = mean_with(0.3);
  EXPECT_NEAR(whole, 1, 1e-9) << "midpoints of a whole number of periods sum to nothing";
  EXPECT_NEAR(held, 0.9, 1e-9);
}

TEST(Summary, AWindowNeverReachedIsNullAndSaid) {
  test::Scratch scratch;
  Summary summary(std::vector<SeriesColumn>{{"pull", "N"}});
  summary.sample(0.1, 0.1, std::vector{5.0});
  summary.section("run")["threads"] = 2;
  summary.warn("hello");
  summary.write(scratch / "summary.json");
  const auto json = nlohmann::json::parse(test::text_of(scratch / "summary.json"));
  EXPECT_TRUE(json["columns"]["pull"]["mean in window"].is_null());
  EXPECT_TRUE(json["columns"]["pull"]["1 ms means in window"].is_null());
  EXPECT_EQ(json["run"]["threads"], 2);
  EXPECT_EQ(json["warnings"].size(), 1u);
}

TEST(Summary, TheWindowMayBeSetLateButNotMovedWhenOpen) {
  Summary summary(std::vector<SeriesColumn>{{"pull", "N"}});
  summary.sample(1.0, 1.0, std::vector{5.0});
  summary.set_window(1.5, 3.0);
  summary.sample(2.0, 1.0, std::vector{7.0});
  summary.sample(3.0, 1.0, std::vector{10.0});
  EXPECT_DOUBLE_EQ(summary.mean("pull"), (0.5 * 7 + 10) / 1.5);
  EXPECT_THROW(summary.set_window(2, 3), std::logic_error);
}

}  // namespace
}  // namespace subsoil::sim::output_series_test
