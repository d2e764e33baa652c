#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "libsim/document/document.hpp"
#include "libsim/run/restart.hpp"
#include "libsim/scenario/load.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Controllers, cylinders, motors, joints that open and close, as scenarios have them; alone and in soil.
namespace subsoil::sim::run_control {
namespace {

using namespace test;

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  if (what.empty()) return text;
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

/// A cart that a motor holds at a speed, and that lets its load go.
constexpr const char* cart = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies:
    drum: {mass: 5 kg, inertia: 0.1 kg m^2, at: 0 0 m}
    load: {mass: 2 kg, inertia: 0.05 kg m^2, at: 0.3 0 m}
  joints:
    shaft: {revolute: [ground, drum], at: 0 0 m}
    hook: {fixed: [drum, load], at: 0.3 0 m}
  forces:
    motor: {electric motor: [ground, drum], torque constant: 0.5 N m/A, resistance: 0.4 ohm, inductance: 2 mH,
            gear ratio: 4, controller: speed control}
  measures: {speed: {angular velocity: drum}}
  controllers:
    speed control: {pid: speed, measured in: rad/s, output in: V, set point: 6 rad/s, proportional: 8 V/(rad/s),
                    integral: 60 V/rad, maximum: 24 V, minimum: -24 V}
  events: {fling: {opens: hook, at: 0.31 s}}
time: {end: 1 s, stop when: {there: {column: load.x, below: -900 mm}}}
output:
  series every: 10 ms
  monitor: {electricity: {integral: motor.power}, most current: {maximum: motor.current}}
)";

TEST(RunControl, AMotorHoldsItsSpeedAndALoadIsFlung) {
  for (const char* method : {"cvode", "ida", "adams-moulton"}) {
    const RunDirectory dir;
    std::vector<std::string> sets{fmt::format("time.machine.integrator={}", method)};
    if (std::string(method) == "adams-moulton") sets.emplace_back("time.machine.step=0.2 ms");
    ASSERT_EQ(run_scenario(dir.scenario(cart), dir / "out", sets), exit_ok);
    const Series s = read_series(dir / "out/series.csv");
    double speed = 0, at_release = 0;
    for (std::size_t i = 0; i < s.at("time").size(); ++i) {
      EXPECT_EQ(s.at("hook.open")[i], s.at("time")[i] >= 0.31 ? 1 : 0) << s.at("time")[i];
      EXPECT_LE(std::abs(s.at("speed control.output")[i]), 24);
      EXPECT_NEAR(s.at("speed control.error")[i], 6 - s.at("speed")[i], 1e-12);
      EXPECT_NEAR(s.at("energy.balance")[i], 0, 2e-5) << method << ": a millionth of what goes through the motor";
      EXPECT_NEAR(s.at("electricity")[i], s.at("energy.force work")[i], 1e-3)
          << "all that the motor takes in, by parabolas of 1 ms across the corner where the voltage leaves its bound";
      if (s.at("time")[i] < 0.3105) at_release = s.at("load.spin")[i];
      speed = std::hypot(s.at("load.vx")[i], s.at("load.vy")[i]);
    }
    EXPECT_NEAR(at_release, 6, 0.2) << "the controller is there by then";
    EXPECT_NEAR(speed, 0.3 * at_release, 1e-4) << "the load flies on as fast as it was";
    EXPECT_NEAR(s.at("load.x").back(), -0.9, 1e-8);
    const auto summary = summary_of(dir / "out");
    EXPECT_EQ(summary["run"]["stopped by"], "there");
    EXPECT_EQ(summary["events"][0]["of"], "hook");
    EXPECT_EQ(summary["events"][0]["direction"], "opens");
    EXPECT_NEAR(summary["events"][0]["time [s]"].get<double>(), 0.31, 1e-12);
  }
}

// A sampled controller at its bound changes nothing at its instants, where rows are. The ball's contact, which might
// stick, makes the methods sample within their steps: forces of a row are of its instant all the same.
TEST(RunControl, RowsAtSamplesAreOfOneInstant) {
  constexpr const char* disk = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies:
    d: {mass: 1 kg, inertia: 0.5 kg m^2, at: 0 0 m, angular velocity: 2 rad/s}
    ball: {mass: 1 kg, inertia: 0.01 kg m^2, at: 1 5 m}
  joints: {p: {revolute: [ground, d], at: 0 0 m}}
  measures: {a: {angle: d}}
  controllers:
    c: {pid: a, measured in: rad, output in: N m, set point: 1 rad, proportional: 4 N m/rad, sample time: 7 ms,
        minimum: -2 N m, maximum: 1 N m}
  forces:
    s: {rotational spring-damper: [ground, d], stiffness: 3 N m/rad, damping: 0.2 N m s/rad, controller: c}
    w: {line contact: [ground, ball], points: [0 0 m, 0 0 m], along: 1 0, radius: 0.1 m, stiffness: 1 MN/m^1.5,
        damping: 0.5 s/m, friction: 0.3, stick stiffness: 100 kN/m}
time: {end: 0.35 s}
output: {series every: 7 ms}
)";
  for (const char* method : {"cvode", "ida", "adams-moulton"}) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(disk), dir / "out", {fmt::format("time.machine.integrator={}", method)}),
              exit_ok);
    const Series s = read_series(dir / "out/series.csv");
    for (std::size_t i = 0; i < s.at("time").size(); ++i) {
      EXPECT_NEAR(s.at("s.angle")[i], s.at("d.angle")[i], 1e-12) << method << " at " << s.at("time")[i];
      EXPECT_NEAR(s.at("s.torque")[i], 0.5 * s.at("d.alpha")[i], 1e-9) << method << " at " << s.at("time")[i];
    }
  }
}

TEST(RunControl, IsKeptInTheRunsScenario) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(cart), dir / "out"), exit_ok);
  ASSERT_EQ(run_scenario((dir / "out/scenario.yaml").string(), dir / "again"), exit_ok);
  std::ifstream one(dir / "out/series.csv"), other(dir / "again/series.csv");
  const std::string a{std::istreambuf_iterator<char>(one), {}}, b{std::istreambuf_iterator<char>(other), {}};
  EXPECT_GT(a.size(), 1000U);
  EXPECT_EQ(a, b);
}

TEST(RunControl, RefusalsNamePlaceRuleAndCure) {
  const auto refusal = [](const std::string& what, const std::string& by) {
    const RunDirectory dir;
    return message_of<ScenarioError>([&] { run_scenario(dir.scenario(replaced(cart, what, by)), dir / "out"); });
  };
  const auto says = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  says(refusal("pid: speed,", "pid: sped,"), "no column of a measure has this name; did you mean `speed`?");
  says(refusal("measured in: rad/s", "measured in: m/s"), "the measure is in rad/s; write that unit");
  says(refusal("output in: V", "output in: N"), "needed is");
  says(refusal("controller: speed control", "controller: sped"), "speed control");
  says(refusal("opens: hook", "opens: hok"), "did you mean `hook`?");
  says(refusal("at: 0.31 s}", "measure: speed}"), "a `measure` passes one value");
  says(refusal("at: 0.31 s}", "measure: speed, above: 3 m}"), "machine.events.fling.above");
  says(refusal(", at: 0.31 s}", "}"), "needs one condition");
  says(refusal("opens: hook", "closes: shaft, opens: hook"), "needs either `opens` or `closes`");
  says(refusal("resistance: 0.4 ohm", "resistance: 0.4 N"), "ohm");
  says(refusal("{angular velocity: drum}", "{angular acceleration: drum}"), "the measure is in rad/s^2");
  says(replaced(refusal("{angular velocity: drum}", "{energy: drum}"), "", ""), "no column of a measure");
}

/// A tine on a trolley, its depth held by a cylinder by what the soil does to it; locked after 60 ms.
constexpr const char* tine = R"(subsoil: 1
materials: {soil: {density: 2600 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 40 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.2}
  - {<<: *dry, between: [soil, steel]}
soil:
  container: {size: 0.4 0.1 0.08 m, at: 0 -0.1 -0.04 m, open after settling: [+x], material: steel}
  surface: 0 m
  bed: {fill: rest-lattice, material: soil, radius: 10 mm, depth: 60 mm, inside machine: carve}
machine:
  bodies:
    trolley: {mass: 40 kg, inertia: 1 kg m^2, at: 0.06 0.5 m}
    tine: {mass: 10 kg, inertia: 0.1 kg m^2, at: 0.06 0.08 m}
  joints:
    rail: {translational: [ground, trolley], at: 0.06 0.5 m, along: 1 0}
    guide: {translational: [trolley, tine], at: 0.06 0.08 m, along: 0 1}
    lock: {fixed: [trolley, tine], at: 0.06 0.2 m}
  drivers: {tow: {coordinate: trolley.x, velocity: 0.5 m/s}}
  forces:
    ram: {hydraulic cylinder: [trolley, tine], ends: [0.06 0.5 m, 0.06 0.08 m], bore: 25 mm, rod: 12 mm,
          closed length: 0.3 m, stroke: 0.25 m, supply pressure: 10 MPa, rated flow: 1e-4 m^3/s, dead volume: 2e-4 m^3,
          start pressure b: 260 kPa, controller: draft control}
  measures: {felt: {soil force: tine, component: x}}
  controllers:
    draft control: {pid: felt, measured in: N, output in: 1, set point: -8 N, proportional: -0.01 1/N, integral: -0.05 1/(N s),
                    maximum: 1, minimum: -1, sample time: 7 ms, delay: 2 ms}
  events: {set: {closes: lock, at: 60 ms}}
  surfaces: {edge: {body: tine, material: steel, box: 20 80 20 mm, at: 0 -70 0 mm}}
time: {end: 90 ms, threads: 1}
output:
  every: 50 ms
  series every: 1 ms
  series digits: all
  state every: 40 ms
  monitor: {draft: {soil force: tine, along: -1 0}, impulse: {integral: draft}, top: {maximum: draft, within: 10 ms}}
)";

/// Observation changes no bit: whatever states, samples of losses, rows and frames are asked for, the motion ends in
/// the same numbers. Columns of an instant, since means follow the rows.
TEST(RunControl, WhatIsAskedForChangesNoBitOfTheMotion) {
  const RunDirectory dir;
  const std::string file = dir.scenario(tine);
  int runs = 0;
  const auto last = [&](const std::vector<std::string>& sets) {
    const std::filesystem::path out = dir / ("out" + std::to_string(++runs));
    EXPECT_EQ(run_scenario(file, out, sets), exit_ok);
    const Series series = read_series(out / "series.csv");
    std::vector<double> row;
    for (const char* column : {"tine.x", "tine.y", "tine.vy", "trolley.vx", "ram.pressure a", "draft control.output",
                               "soil.fastest", "soil.gravity"})
      row.push_back(series.at(column).back());
    return row;
  };
  const std::vector<double> plain = last({});
  for (const char* asked : {"output.state every=7 ms", "output.series every=0.3 ms", "output.every=3 ms",
                            "output.contact forces=yes", "output.state=none", "output.sample losses every=16"})
    EXPECT_EQ(last({asked}), plain) << asked;
}

TEST(RunControl, InSoilGoesOnFromAState) {
  const RunDirectory dir;
  // Rows a few steps apart: were means of the second to begin at the state, they would be off by a share of that.
  const std::string file = dir.scenario(replaced(tine, "series every: 1 ms", "series every: 0.1 ms"));
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  const Series whole = read_series(dir / "whole/series.csv");
  std::filesystem::path state;
  for (const auto& entry : std::filesystem::directory_iterator(dir / "whole"))
    if (entry.path().filename().string().starts_with("state-0.04") ||
        entry.path().filename().string().starts_with("state-0.039"))
      state = entry.path();
  ASSERT_FALSE(state.empty());
  ASSERT_EQ(run_scenario(file, dir / "on", {}, state), exit_ok);
  const Series on = read_series(dir / "on/series.csv");
  std::size_t compared = 0;
  for (std::size_t i = 0; i < whole.at("time").size(); ++i)
    for (std::size_t k = 1; k < on.at("time").size(); ++k) {  // means of the first row begin at the state
      if (on.at("time")[k] != whole.at("time")[i]) continue;
      ++compared;
      for (const char* column : {"tine.y", "ram.pressure a", "ram.pressure b", "ram.valve", "draft control.output",
                                 "lock.open", "energy.balance", "floor.Fy"})
        EXPECT_NEAR(on.at(column)[k], whole.at(column)[i], 1e-9 * (1 + std::abs(whole.at(column)[i])))
            << column << whole.at("time")[i];
    }
  EXPECT_GT(compared, 450U);
}

TEST(RunControl, InSoilAccountsForItsEnergyAndLocks) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(tine), dir / "out"), exit_ok);
  const Series s = read_series(dir / "out/series.csv");
  double most = 0, apart = 0, opening = 0;
  for (std::size_t i = 0; i < s.at("time").size(); ++i) {
    most = std::max(most, std::abs(s.at("energy.balance")[i]));
    opening = std::max(opening, std::abs(s.at("ram.valve")[i]));
    EXPECT_TRUE(s.at("lock.open")[i] == 0 || s.at("lock.open")[i] == 1) << "no value between two instants";
    if (std::abs(s.at("time")[i] - 0.06) > 1e-4) {  // a row takes the state of the nearer instant
      EXPECT_EQ(s.at("lock.open")[i], s.at("time")[i] < 0.06 ? 1 : 0) << s.at("time")[i];
    }
    if (s.at("time")[i] < 0.062) apart = s.at("trolley.y")[i] - s.at("tine.y")[i];
  }
  EXPECT_GT(opening, 0.02) << "the controller acts";
  EXPECT_GT(std::abs(s.at("tine.y").back() - 0.08), 1e-4);
  EXPECT_NEAR(s.at("trolley.y").back() - s.at("tine.y").back(), apart, 1e-9) << "locked";
  EXPECT_LT(most, 1e-3) << "of some J that pump, tow and soil exchange";
  EXPECT_EQ(summary_of(dir / "out")["events"][0]["direction"], "closes");
}

/// A block on a rail that a formula of its place and speed pulls back as a spring and a damper do.
constexpr const char* by_formula = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {b: {mass: 2 kg, inertia: 1 kg m^2, at: 0.1 0 m}}
  joints: {r: {translational: [ground, b], at: 0 0 m, along: 1 0}}
  measures:
    place: {position: b, component: x}
    speed: {velocity: b, component: x}
    both: {position: b}
  controllers: {law: {formula: -50*place - 3*speed, output in: N}}
  forces: {push: {force: b, controller: law}}
time: {end: 1.2 s}
)";

TEST(RunControl, AForceIsAFormulaOfMeasures) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(by_formula), dir / "out"), exit_ok);
  const Series s = read_series(dir / "out/series.csv");
  const double half = 0.75, w = std::sqrt(25 - half * half), t = s.at("time").back();
  EXPECT_NEAR(s.at("b.x").back(), std::exp(-half * t) * (0.1 * std::cos(w * t) + 0.075 / w * std::sin(w * t)), 1e-8);
  EXPECT_NEAR(s.at("law.output").back(), s.at("push.fx").back(), 1e-12);
  EXPECT_EQ(s.find("law.error"), -1) << "a formula has no set point";
  // The copy in the run's folder is the same scenario.
  ASSERT_EQ(run_scenario((dir / "out/scenario.yaml").string(), dir / "again"), exit_ok);
  EXPECT_EQ(read_series(dir / "again/series.csv").at("b.x").back(), s.at("b.x").back());
}

TEST(RunControl, FormulasTransferFunctionsAndTablesAreCheckedWhenRead) {
  const auto text_of = [](const std::string& law) {
    const RunDirectory dir;
    return message_of<ScenarioError>([&] {
      load_scenario(dir.scenario(replaced(by_formula, "{formula: -50*place - 3*speed, output in: N}", law)));
    });
  };
  EXPECT_EQ(text_of("{transfer function: place, measured in: m, output in: N, numerator: 5, denominator: 0.1 1}"),
            "accepted");
  EXPECT_EQ(text_of("{table of two: place; both.y, first in: m, second in: m, output in: N, first: 0 1, second: 0 1, "
                    "values: 1 2 3 4}"),
            "accepted");
  EXPECT_EQ(text_of("{table of two: [place, both.y], first in: m, second in: m, output in: N, first: 0 1, second: 0 1, "
                    "values: 1 2 3 4}"),
            "accepted");
  const auto holds = [&](const std::string& law, const std::string& part) {
    const std::string text = text_of(law);
    EXPECT_NE(text.find(part), std::string::npos) << law << ": " << text;
  };
  holds("{formula: -50*plac, output in: N}", "machine.controllers.law.formula");
  holds("{formula: -50*both, output in: N}", "names in it are those of measures with one column");
  holds("{formula: place, output in: N m}", "what it drives is in N");
  holds("{transfer function: plac, measured in: m, output in: N, numerator: 5, denominator: 1}",
        "did you mean `place`");
  holds("{transfer function: place, measured in: rad, output in: N, numerator: 5, denominator: 1}",
        "the measure is in m");
  holds("{table of two: [place], first in: m, second in: m, output in: N, first: 0 1, second: 0 1, values: 1 2 3 4}",
        "must name two measures");
}

}  // namespace
}  // namespace subsoil::sim::run_control
