#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/tools/program_runs.hpp"

/// What the summary says of a machine alone.
namespace subsoil::sim::run_motion_summary {
namespace {

using namespace test;

/// x = 0.1 m sin(20 t/s) on a spring, rows as far apart as the whole run. F = -40 N sin(20 t/s).
std::string vibrating_mass(const std::string& output, const std::string& time = {}) {
  return fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {{s: {{mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m, velocity: 2 0 m/s}}}}
  joints: {{slide: {{translational: [ground, s], at: 0 0 m, along: 1 0}}}}
  forces: {{sp: {{spring-damper: [ground, s], ends: [-5 0 m, 0 0 m], stiffness: 400 N/m, free length: 5 m}}}}
time: {{end: 3 s{}}}
output: {{every: 1 s, series every: 1 s, {}}}
)",
                     time, output);
}

double mean_of_sine(double from, double until) {
  return 0.1 * (std::cos(20 * from) - std::cos(20 * until)) / (20 * (until - from));
}

constexpr const char* watched = "monitor: {x: s.x, v: s.vx}";

// Parabolas over 1 ms leave (20 * 1 ms)^4/2880 = 6e-11 of a mean, and less of an extreme.
TEST(RunMotionSummary, OfAVibrationIsWhatTheSineSaysHoweverFarRowsAreApart) {
  for (const char* method : {"integrator: cvode", "integrator: ida", "step: 1 ms, order: 6"}) {
    const std::string time = fmt::format(", machine: {{{}}}", method);
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(vibrating_mass(watched, time)), dir / "out"), exit_ok);
    const nlohmann::json columns = summary_of(dir / "out")["columns"], &x = columns["x"], &v = columns["v"];
    EXPECT_NEAR(x["mean in window"], mean_of_sine(0, 3), 1e-8) << method;
    EXPECT_NEAR(x["steps in window"]["max"], 0.1, 1e-8) << method;
    EXPECT_NEAR(x["steps in window"]["min"], -0.1, 1e-8) << method;
    EXPECT_NEAR(v["steps in window"]["max"], 2, 2e-7) << method;
    EXPECT_NEAR(v["steps in window"]["min"], -2, 2e-7) << method;
    EXPECT_NEAR(std::sin(20 * x["steps in window"]["at max [s]"].get<double>()), 1, 1e-8) << method;
    EXPECT_NEAR(x["50 ms means in run"]["max"], 0.1 * std::sin(0.5) / 0.5, 2e-5) << method << ": to 1 ms";
  }
}

// Within its window alone: x rises from 0.1 m sin(0.2) at its start to 0.1 m sin(1) at its end.
TEST(RunMotionSummary, ExtremesAndMeansAreOfTheWindowAlone) {
  const RunDirectory dir;
  const std::string window = ", window: {from: 10 ms, until: 50 ms}";
  ASSERT_EQ(run_scenario(dir.scenario(vibrating_mass(watched + window)), dir / "out"), exit_ok);
  const nlohmann::json x = summary_of(dir / "out")["columns"]["x"];
  EXPECT_NEAR(x["mean in window"], mean_of_sine(0.01, 0.05), 1e-9);
  EXPECT_NEAR(x["steps in window"]["min"], 0.1 * std::sin(0.2), 1e-9);
  EXPECT_NEAR(x["steps in window"]["max"], 0.1 * std::sin(1.0), 1e-9);
}

TEST(RunMotionSummary, DoesNotDependOnWhatElseIsAskedFor) {
  const RunDirectory dir;
  const std::string others[] = {"monitor: {x: s.x, v: s.vx, i: {integral: s.x}, most: {maximum: s.vx}}",
                                watched + std::string(", crossings: {up: {column: s.x, at: 50 mm}}")};
  ASSERT_EQ(run_scenario(dir.scenario(vibrating_mass(watched)), dir / "plain"), exit_ok);
  const nlohmann::json plain = summary_of(dir / "plain")["columns"];
  for (const std::string& other : others) {
    const RunDirectory second;
    ASSERT_EQ(run_scenario(second.scenario(vibrating_mass(other)), second / "out"), exit_ok);
    const nlohmann::json columns = summary_of(second / "out")["columns"];
    for (const char* column : {"x", "v"}) {
      EXPECT_NEAR(columns[column]["mean in window"], plain[column]["mean in window"], 1e-8) << other;
      for (const char* end : {"min", "max"})
        EXPECT_NEAR(columns[column]["steps in window"][end], plain[column]["steps in window"][end], 2e-7) << other;
    }
  }
}

// x = 0.1 m sin(20 t) beside a driver of 0.25 s. Means of a window whose end is given hold all of it; without an end
// they hold whole periods of the driver: one, from 0.13 s. Three per mille: steps of the method at the period's end.
TEST(RunMotionSummary, AGivenEndOfTheWindowStandsBesideAPeriod) {
  for (const auto& [given, until] : {std::pair(", until: 0.455 s", 0.455), std::pair("", 0.38)}) {
    const RunDirectory dir;
    const std::string text = fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies:
    s: {{mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m, velocity: 2 0 m/s}}
    n: {{mass: 1 kg, inertia: 1 kg m^2, at: 0 1 m, pose is: about}}
  joints: {{g: {{translational: [ground, s], at: 0 0 m, along: 1 0}}, h: {{translational: [ground, n], at: 0 1 m, along: 1 0}}}}
  forces: {{spring: {{spring-damper: [ground, s], ends: [-1 0 m, 0 0 m], stiffness: 400 N/m, free length: 1 m}}}}
  drivers: {{d: {{coordinate: n.x, position: {{harmonic: {{amplitude: 0.1 m, frequency: 4 Hz}}}}}}}}
time: {{end: 0.5 s}}
output: {{monitor: {{x: s.x}}, window: {{from: 0.13 s{}}}}}
)",
                                         given);
    ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
    const nlohmann::json summary = summary_of(dir / "out");
    EXPECT_NEAR(summary["window"]["until [s]"], until, 1e-3);
    EXPECT_NEAR(summary["columns"]["x"]["mean in window"], mean_of_sine(0.13, until), 3e-4) << given;
  }
}

// A rim point turns at 0.1 m and 300 rad/s past a post 0.1 mm outside its circle: their distance changes at w R A
// sin/d, 30 m/s at the most (w R), reached where the line to the post touches the circle, and turns over from -30 to 30
// m/s within 0.015 ms. Extremes are values that were there, so none is larger; they miss the peaks by what looks 0.5 ms
// apart leave after locating them.
TEST(RunMotionSummary, ExtremesAreValuesThatWereThere) {
  const RunDirectory dir;
  const std::string rotor = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {p: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0 0 m, angular velocity: 300 rad/s}}
  joints: {pin: {revolute: [ground, p], at: 0 0 m}}
  markers: {rim: {body: p, at: 0.1 0 m}, post: {at: -0.06006 0.08008 m}}
  measures: {rate: {distance rate: [rim, post]}}
time: {end: 0.2 s}
output: {series every: 1 ms, monitor: {r: rate, most: {maximum: rate}, least: {minimum: rate}, recent: {maximum: rate, within: 25 ms}}}
)";
  ASSERT_EQ(run_scenario(dir.scenario(rotor), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out/series.csv");
  for (const auto& [name, sign] : {std::pair("most", 1), std::pair("least", -1), std::pair("recent", 1)}) {
    EXPECT_LT(sign * series.at(name).back(), 30 * (1 + 1e-9)) << name;
    EXPECT_GT(sign * series.at(name).back(), 30 * (1 - 1e-6)) << name;
  }
}

// w = 1/(a + cos(1500 t/s)) has a peak of a + 1 over a - 1 = 401 times its least value in each turn of 4.2 ms, 0.13 ms
// wide at half its height; looks are 0.25 ms apart. Its integral over a turn is 2 pi/(w sqrt(a^2 - 1)). Parts are
// halved until that changes their integral by less than 3e-3 of the mean, so both err by less.
TEST(RunMotionSummary, IntegralsAndMeansHoldPeaksThatAreNarrow) {
  const RunDirectory dir;
  const double spin = 1500, a = 1.005, turns = 48, end = turns * 2 * std::numbers::pi / spin;
  const std::string rotor = fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {{p: {{mass: 1 kg, inertia: 0.01 kg m^2, at: 0 0 m, angular velocity: {} rad/s}}}}
  joints: {{pin: {{revolute: [ground, p], at: 0 0 m}}}}
time: {{end: {:.17g} s}}
output:
  series every: 10 ms
  monitor: {{w: {{formula: 1/({} + cos(turned)), of: {{turned: p.angle}}}}, sum: {{integral: w}}, mean: {{mean: w}}}}
)",
                                        spin, end, a);
  ASSERT_EQ(run_scenario(dir.scenario(rotor), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out/series.csv");
  const double mean = 1 / std::sqrt(a * a - 1);
  EXPECT_NEAR(series.at("sum").back(), mean * end, 3e-3 * mean * end);
  EXPECT_NEAR(series.at("mean").back(), mean, 3e-3 * mean);
}

// The last row is of the time at which x passes 50 mm; what is followed over time is followed to there.
TEST(RunMotionSummary, TheRowOfAStopHasItsIntegrals) {
  for (const char* method : {"integrator: cvode", "integrator: ida", "step: 1 ms, order: 6"}) {
    const RunDirectory dir;
    const std::string time =
        fmt::format(", machine: {{{}}}, stop when: {{far: {{column: s.x, above: 50 mm}}}}", method);
    const char* watches = "monitor: {x: s.x, sum: {integral: s.x}, mean: {mean: s.x, within: 10 ms}}";
    ASSERT_EQ(run_scenario(dir.scenario(vibrating_mass(watches, time)), dir / "out"), exit_ok);
    const Series series = read_series(dir / "out/series.csv");
    const double t = std::asin(0.5) / 20, end = series.values[0].back();
    EXPECT_NEAR(end, t, 1e-9) << method;
    EXPECT_NEAR(series.at("sum").back(), t * mean_of_sine(0, t), 1e-10) << method;
    EXPECT_NEAR(series.at("mean").back(), mean_of_sine(t - 0.01, t), 1e-8) << method;
  }
}

// A force that jumps from 0 to 1 N between two looks was 0 and 1 N, and nothing beyond.
TEST(RunMotionSummary, ExtremesOfWhatJumpsAreValuesThatWereThere) {
  const RunDirectory dir;
  const std::string pushed = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {b: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}
  forces: {f: {force: b, along x: {ramp: {begin: 0.10023 s, end: 0.10024 s, to: 1 N}}}}
time: {end: 0.3 s}
output: {series every: 0.1 s, monitor: {f: f.fx}}
)";
  ASSERT_EQ(run_scenario(dir.scenario(pushed), dir / "out"), exit_ok);
  const nlohmann::json f = summary_of(dir / "out")["columns"]["f"];
  EXPECT_NEAR(f["steps in window"]["min"], 0, 1e-15);
  EXPECT_NEAR(f["steps in window"]["max"], 1, 1e-15);
  EXPECT_NEAR(f["mean in window"], 1 - 0.100235 / 0.3, 1e-3);
}

// A body flies past a post at 10 m/s, 0.1 mm beside it: d^2 = (0.1 mm)^2 + (x - x_post)^2 turns within 0.02 ms. All
// that looks at d must see it, wherever between two looks it lies. Bounds: 1e-6 of the parts looked at (0.5 ms) at 10
// m/s squared over 0.1 mm are far below 1e-9 m; times of passages are located to rounding of 0.1 s.
TEST(RunMotionSummary, AClosestApproachIsSeenHoweverShort) {
  for (const double post : {1.0, 1.0007, 1.0021, 1.00431, 1.0083}) {
    const RunDirectory dir;
    const std::string flight = fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {{b: {{mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m, velocity: 10 0 m/s}}}}
  markers: {{post: {{at: {} 0.0001 m}}}}
  measures: {{d: {{distance: [post, b]}}}}
time: {{end: 0.2 s}}
output:
  series every: 0.1 s
  monitor: {{gap: d, least: {{minimum: d}}, last: {{minimum: d, within: 0.15 s}}, passed: {{count: d, at: 0.5 mm}}, near: {{time below: d, at: 0.5 mm}}}}
  crossings: {{by: {{column: d, at: 0.5 mm}}}}
)",
                                           post);
    SCOPED_TRACE(flight);
    ASSERT_EQ(run_scenario(dir.scenario(flight), dir / "out"), exit_ok);
    const double half = std::sqrt(0.25 - 0.01) * 1e-3 / 10, met = post / 10;
    const nlohmann::json summary = summary_of(dir / "out"), columns = summary["columns"];
    EXPECT_NEAR(columns["gap"]["steps in window"]["min"], 1e-4, 1e-9);
    const Series series = read_series(dir / "out/series.csv");
    const auto last = [&](const char* name) { return series.at(name).back(); };
    EXPECT_NEAR(last("least"), 1e-4, 1e-9);
    EXPECT_NEAR(last("last"), 1e-4, 1e-9);
    EXPECT_EQ(last("passed"), 2);
    EXPECT_NEAR(last("near"), 2 * half, 1e-9);
    const std::vector<double> times = summary["crossings"]["by"]["times [s]"];
    ASSERT_EQ(times.size(), 2U);
    EXPECT_NEAR(times[0], met - half, 1e-9);
    EXPECT_NEAR(times[1], met + half, 1e-9);
  }
}

}  // namespace
}  // namespace subsoil::sim::run_motion_summary
