#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libsim/io/series.hpp"
#include "libsim/run/runner.hpp"
#include "libsim/scenario/load.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Watches that are formulas of columns.
namespace subsoil::sim::run_watch_formula {
namespace {

using namespace test;

constexpr const char* swinging = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {rod: {mass: 2 kg, inertia: 0.1 kg m^2, at: 0.5 0 m}}
  joints: {pin: {revolute: [ground, rod], at: 0 0 m}}
output:
  monitor:
    speed: {formula: sqrt(u^2 + v^2), of: {u: rod.vx, v: rod.vy}, unit: m/s}
    fall: {formula: -2*9.81*v, of: {v: rod.vy}, unit: W}
    twice: {formula: 2*s, of: {s: speed}, unit: m/s}
    odd: {formula: sqrt(-1 - s^2), of: {s: speed}}
time: {end: 1 s}
)";

// The centre moves on a circle of 0.5 m; the weight of 19.62 N does the work that becomes kinetic energy, 0.5 (0.1 +
// 2/4) w^2.
TEST(RunWatchFormula, IsTheFormulaOfTheRowsColumns) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(swinging), dir / "out"), exit_ok);
  const Series s = read_series(dir / "out/series.csv");
  double work = 0;
  for (std::size_t i = 0; i < s.at("time").size(); ++i) {
    const double w = std::abs(s.at("rod.spin")[i]);
    ASSERT_NEAR(s.at("speed")[i], 0.5 * w, 1e-9);
    ASSERT_EQ(s.at("twice")[i], 2 * s.at("speed")[i]);
    ASSERT_FALSE(std::isfinite(s.at("odd")[i])) << "no value is no number, not a stop";
    if (i > 0) work += 0.5 * (s.at("fall")[i] + s.at("fall")[i - 1]) * (s.at("time")[i] - s.at("time")[i - 1]);
    // Trapezoids of 1 ms: errors of some (1e-3)^2/12 of the power's second derivative, 4e3 W/s^2 at most.
    ASSERT_NEAR(work, 0.3 * w * w, 1e-3);
  }
}

// The column, what is made of it and levels are in the monitor's unit; a formula of it has SI values.
constexpr const char* in_units = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {rod: {mass: 2 kg, inertia: 0.1 kg m^2, at: 0.5 0 m}}
  joints: {pin: {revolute: [ground, rod], at: 0 0 m}}
output:
  monitor:
    speed: {formula: sqrt(u^2 + v^2), of: {u: rod.vx, v: rod.vy}, unit: m/s}
    fast: {formula: s, of: {s: speed}, unit: km/h}
    again: {formula: f, of: {f: fast}, unit: m/s}
    way: {integral: fast}
    slow: {time below: speed, at: 1 m/s}
    slow too: {time below: fast, at: 1000 mm/s}
time: {end: 1 s, stop when: {quick: {column: fast, above: 9 km/h}}}
)";
TEST(RunWatchFormula, IsInAnyUnit) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(in_units), dir / "out"), exit_ok);
  const Series s = read_series(dir / "out/series.csv");
  EXPECT_EQ(s.columns[static_cast<std::size_t>(s.find("fast"))].unit, "km/h");
  EXPECT_EQ(s.columns[static_cast<std::size_t>(s.find("way"))].unit, "km/h s");
  for (std::size_t i = 0; i < s.at("time").size(); ++i) {
    ASSERT_NEAR(s.at("fast")[i], 3.6 * s.at("speed")[i], 1e-14 * s.at("fast")[i]);
    ASSERT_NEAR(s.at("again")[i], s.at("speed")[i], 1e-14 * s.at("speed")[i]);
    ASSERT_NEAR(s.at("slow too")[i], s.at("slow")[i], 1e-9);
  }
  EXPECT_GT(s.at("slow").back(), 0.05);
  EXPECT_NEAR(s.at("speed").back(), 2.5, 1e-9) << "9 km/h";
}

// A block of 5 kg that a driver shakes by 10 mm at 30 Hz beside soil that it does not touch. With soil, forces are
// means over a row: F v of these would be out of phase by half a row, and give power where there is none.
constexpr const char* shaken = R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {stone: {density: 2600 kg/m^3}}
contacts: [{between: [stone, stone], law: linear, k_n: 50 kN/m, restitution: 0.3, mu: 0.3}]
soil: {bed: {fill: particles, material: stone, particles: [{position: 0 0.03 0 m, radius: 0.03 m}]}}
boundaries: [{name: floor, material: stone, shape: {plane: {}}}]
machine:
  bodies: {block: {mass: 5 kg, inertia: 1 kg m^2, at: 1 1 m}}
  joints: {guide: {translational: [ground, block], at: 1 1 m, along: 1 0}}
  drivers: {shaker: {coordinate: block.x, position: {harmonic: {mean: 1 m, amplitude: 10 mm, frequency: 30 Hz}}}}
time: {end: 0.5 s}
output:
  series digits: all
  monitor:
    force: {driver: shaker}
    size: {formula: abs(F), of: {F: force}, unit: N}
    power: {formula: F*v, of: {F: force, v: block.vx}, unit: W}
    half: {formula: P/2, of: {P: power}, unit: W}
    work: {integral: power}
)";

// 15 whole periods: the driver gives back what it took, (m/2) A^2 w^2 = 8.9 J at the most. The trapezium rule is off by
// its (w dt)^2/12, 6e-5, between whole periods and by nothing after them.
TEST(RunWatchFormula, OfForcesIsAMeanOfTheFormulaInEveryStep) {
  const double w = 2 * std::numbers::pi * 30, largest = 0.5 * 5 * 1e-4 * w * w;
  for (const char* every : {"1 ms", "5 ms", "20 ms"}) {
    SCOPED_TRACE(every);
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(shaken), dir / "out", {std::string("output.series every=") + every}), exit_ok);
    const Series s = read_series(dir / "out/series.csv");
    const std::vector<double>& time = s.at("time");
    double work = 0, size = 0;
    for (std::size_t i = 1; i < time.size(); ++i) {
      work += s.at("power")[i] * (time[i] - time[i - 1]);
      size += s.at("size")[i] * (time[i] - time[i - 1]);
      ASSERT_NEAR(work, s.at("energy.driver work")[i], 1e-3 * largest) << time[i];
      ASSERT_NEAR(s.at("half")[i], 0.5 * s.at("power")[i], 1e-12 * largest * w);
    }
    EXPECT_NEAR(work, s.at("energy.driver work").back(), 1e-5 * largest);
    EXPECT_NEAR(s.at("work").back(), work, 1e-9 * largest);
    EXPECT_NEAR(size / time.back(), 2 / std::numbers::pi * 5 * 0.01 * w * w, 1e-3 * 5 * 0.01 * w * w);
  }
}

// A driver moves a mass on x = A sin(w t), machine alone: over a row the mean force is m (v2 - v1)/(t2 - t1), the mean
// power m (v2^2 - v1^2)/2/(t2 - t1). The middle of a step of 1 ms is off by (w h)^2/24 of both, 7e-6 and 3e-5.
TEST(RunWatchFormula, OfMeansIsTheMeanOfTheSameIntervalWithoutSoil) {
  const double w = 2 * std::numbers::pi * 2, mass = 3, force = mass * 0.1 * w * w, power = 0.5 * force * 0.1 * w;
  const auto v = [&](double t) { return 0.1 * w * std::cos(w * t); };
  for (const char* integrator : {"adams-moulton", "cvode", "ida"}) {
    SCOPED_TRACE(integrator);
    const RunDirectory dir;
    const std::string scenario = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {a: {mass: 3 kg, inertia: 0.1 kg m^2, at: 0 0 m, velocity is: about}}
  joints: {r: {translational: [ground, a], at: 0 0 m, along: 1 0}}
  drivers: {d: {coordinate: a.x, position: {harmonic: {amplitude: 0.1 m, frequency: 2 Hz}}}}
output:
  series every: 10 ms
  forces: mean
  monitor:
    q: {formula: f, of: {f: d.force}, unit: N}
    p: {formula: f*v, of: {f: d.force, v: a.vx}, unit: W}
)";
    const std::string time = std::string("time: {end: 1 s, machine: {integrator: ") + integrator + ", step: 1 ms}}\n";
    ASSERT_EQ(run_scenario(dir.scenario(scenario + time), dir / "out"), exit_ok);
    const Series s = read_series(dir / "out/series.csv");
    const std::vector<double>& t = s.at("time");
    for (std::size_t i = 1; i < t.size(); ++i) {
      const double span = t[i] - t[i - 1], before = v(t[i - 1]), now = v(t[i]);
      ASSERT_NEAR(s.at("q")[i], mass * (now - before) / span, 2e-5 * force) << t[i];
      ASSERT_NEAR(s.at("q")[i], s.at("d.force")[i], 1e-12 * force) << t[i];
      ASSERT_NEAR(s.at("p")[i], 0.5 * mass * (now * now - before * before) / span, 5e-5 * power) << t[i];
    }
  }
}

TEST(RunWatchFormula, IsKeptInTheRunsScenario) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(swinging), dir / "out"), exit_ok);
  const Loaded again = load_scenario((dir / "out/scenario.yaml").string(), {});
  ASSERT_EQ(again.scenario.output.watch.size(), 4U);
  const Watch& w = again.scenario.output.watch[0];
  EXPECT_EQ(w.of, "sqrt(u^2 + v^2)");
  EXPECT_EQ(w.unit, "m/s");
  ASSERT_EQ(w.inputs.size(), 2U);
  EXPECT_EQ(w.inputs[1], std::pair(std::string("v"), std::string("rod.vy")));
}

TEST(RunWatchFormula, RefusalsNamePlaceRuleAndCure) {
  const RunDirectory dir;
  const auto refused = [&](const std::string& set) {
    return message_of<ScenarioError>(
        [&] { run_scenario(dir.scenario(swinging), dir / "out", {"output.monitor." + set}); });
  };
  const auto says = [&](const std::string& set, const std::string& part) {
    EXPECT_NE(refused(set).find(part), std::string::npos) << refused(set);
  };
  says("speed.unit=kX", "kX");
  says("speed.of.u=rod.vz", "no column 'rod.vz'; did you mean `rod.vx`?");
  says("speed.formula=sqrt(w)", "`w` is no name of a formula in u, v");
  says("speed.of=3", "must give names columns");
}

/// In any order: those of an included file are read behind one's own.
TEST(RunWatchFormula, OfMonitorsThatStandBelow) {
  const RunDirectory dir;
  const std::string file = dir.scenario(swinging);
  const std::vector<std::string> below{"output.monitor.odd.formula=3*s", "output.monitor.twice.of.s=odd"};
  ASSERT_EQ(run_scenario(file, dir / "out", below), exit_ok);
  const Series s = read_series(dir / "out/series.csv");
  for (std::size_t i = 0; i < s.at("twice").size(); ++i) ASSERT_EQ(s.at("twice")[i], 2 * s.at("odd")[i]);
  const std::string circle = message_of<ScenarioError>([&] {
    run_scenario(file, dir / "none", {"output.monitor.twice.of.s=odd", "output.monitor.odd.of.s=twice"});
  });
  EXPECT_NE(circle.find("output.monitor.twice: uses monitors that use it: a circle"), std::string::npos) << circle;
}

}  // namespace
}  // namespace subsoil::sim::run_watch_formula
