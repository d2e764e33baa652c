#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "apps/commands/commands.hpp"
#include "libsim/document/document.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Instants at which columns pass values, and runs that end there.
namespace subsoil::sim::run_crossings {
namespace {

using namespace test;
constexpr double g = 9.81, pi = std::numbers::pi;

/// x = 0.1 m cos(10 t/s) on a spring.
std::string oscillator(const std::string& crossings) {
  return fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {{mass: {{mass: 1 kg, inertia: 1 kg m^2, at: 1.1 0 m}}}}
  joints: {{rail: {{translational: [ground, mass], along: 1 0}}}}
  forces: {{spring: {{spring-damper: [ground, mass], ends: [0 0 m, 1.1 0 m], stiffness: 100 N/m, free length: 1 m}}}}
time: {{end: 3 s, machine: {{rtol: 1e-11, atol: 1e-12}}}}
output: {{series every: 50 ms, crossings: {{{}}}}}
)",
                     crossings);
}

// cos(10 t) = -1/2 at 10 t = 2 pi/3, 4 pi/3, ...; rising every other time. Both kinds of method find them between their
// outputs, 50 ms apart, to what the quintic over a millisecond leaves.
TEST(Crossings, OfAnOscillatorAreWhereTheCosineIs) {
  const RunDirectory dir;
  const std::string file =
      dir.scenario(oscillator("out: {column: mass.x, at: 950 mm, direction: rising}, middle: {column: mass.vx}, far: "
                              "{column: mass.x, at: 2 m}"));
  for (const std::vector<std::string>& method : {std::vector<std::string>{"time.machine.integrator=cvode"},
                                                 {"time.machine.integrator=adams-moulton", "time.machine.step=1 ms"}}) {
    const auto out = dir / method[0];
    ASSERT_EQ(run_scenario(file, out, method), exit_ok);
    const auto found = summary_of(out)["crossings"];
    ASSERT_EQ(found["out"]["count"], 5) << "in 30/(2 pi) periods";
    for (int k = 0; k < 5; ++k)
      EXPECT_NEAR(found["out"]["times [s]"][k].get<double>(), (4 * pi / 3 + 2 * pi * k) / 10, 1e-8) << method[0];
    EXPECT_NEAR(found["out"]["mean interval [s]"].get<double>(), 2 * pi / 10, 1e-8) << "the period";
    ASSERT_EQ(found["middle"]["count"], 9) << "both ways, the start at rest is none";
    for (int k = 0; k < 9; ++k)
      EXPECT_NEAR(found["middle"]["times [s]"][k].get<double>(), pi * (k + 1) / 10, 1e-8) << method[0];
    EXPECT_EQ(found["far"]["count"], 0);
    EXPECT_FALSE(summary_of(out)["run"].contains("stopped by"));
  }
}

// A beam held at rest at angle 0 never passes it, though methods leave its angle at their rounding, either side of 0;
// an oscillation of a hundred times the tolerance does, twice a period.
TEST(Crossings, OfRoundingAreNone) {
  const RunDirectory dir;
  const auto scenario = [&](const std::string& holds) {
    return dir.scenario(fmt::format(R"(subsoil: 1
machine:
  bodies:
    arm: {{mass: 2 kg, inertia: 0.5 kg m^2, at: 0.5 0 m}}
    end: {{mass: 1 kg, inertia: 0.1 kg m^2, at: 1.5 0 m}}
    ball: {{mass: 1 kg, inertia: 1 kg m^2, at: 1 1 m, velocity: 1e-7 0 m/s}}
  joints:
    pin: {{revolute: [ground, arm], at: 0 0 m}}
    weld: {{fixed: [arm, end], at: 1 0 m}}
    rail: {{translational: [ground, ball], at: 0 1 m, along: 1 0}}
    hold: {{distance: [ground, end], ends: [1.5 2 m, 1.5 0 m]}}
  forces: {{spring: {{spring-damper: [ground, ball], ends: [0 1 m, 1 1 m], stiffness: 100 N/m, free length: 1 m}}}}
time: {{end: 1 s, machine: {{integrator: {}}}}}
output:
  series every: 2 ms
  monitor: {{count: {{count: arm.angle, at: 0 deg}}, below: {{time below: arm.angle, at: 0 deg}}}}
  crossings: {{held: {{column: arm.angle}}, swings: {{column: ball.x, at: 1 m}}}}
)",
                                    holds));
  };
  for (const char* method : {"cvode", "ida", "adams-moulton"}) {
    SCOPED_TRACE(method);
    ASSERT_EQ(run_scenario(scenario(method), dir / method), exit_ok);
    const auto found = summary_of(dir / method)["crossings"];
    EXPECT_EQ(found["held"]["count"], 0);
    EXPECT_EQ(found["swings"]["count"], 3) << "at 10 t = pi, 2 pi, 3 pi";
    const Series series = read_series(dir / method / "series.csv");
    EXPECT_EQ(series.at("count").back(), 0);
    EXPECT_EQ(series.at("below").back(), 0);
  }
}

// A saturated sampled controller pushes a sliding body back and forth: its output passes 0 at samples, which are not to
// rounding where rows are.
TEST(Crossings, OfASampledOutputAreAtItsSamples) {
  for (const char* set_up : {"0.3 0.05 0 1e4", "0.317 0.02 0.02 100", "0.575 0.02 0.02 100"}) {
    double speed = 0, sample = 0, set_point = 0, gain = 0;
    ASSERT_EQ(std::sscanf(set_up, "%lf %lf %lf %lf", &speed, &sample, &set_point, &gain), 4);
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {{b: {{mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m, velocity: {} 0 m/s}}}}
  joints: {{g: {{translational: [ground, b], at: 0 0 m, along: 1 0}}}}
  forces: {{a: {{force: b, controller: c, controls: x}}}}
  measures: {{x: {{position: b, component: x}}}}
  controllers:
    c: {{pid: x, measured in: m, output in: N, set point: {} m, proportional: {} N/m, minimum: -1 N, maximum: 1 N,
        sample time: {} s}}
time: {{end: 2 s}}
output: {{series every: 10 ms, crossings: {{j: {{column: c.output, at: 0 N}}}}, monitor: {{least: {{minimum: c.output}}}}}}
)",
                                                    speed, set_point, gain, sample)),
                           dir / "out"),
              exit_ok)
        << set_up;
    const auto found = summary_of(dir / "out")["crossings"]["j"];
    EXPECT_GE(found["count"], 1) << set_up;
    for (const double t : found["times [s]"]) EXPECT_NEAR(t / sample, std::round(t / sample), 1e-9) << set_up;
    EXPECT_EQ(read_series(dir / "out/series.csv").at("least").back(), -1) << set_up;
  }
}

TEST(Crossings, EndARunWithARowThere) {
  const RunDirectory dir;
  const auto out = dir / "out";
  ASSERT_EQ(run_scenario(dir.scenario(oscillator("third: {column: mass.x, at: 1 m, stop after: 3}")), out), exit_ok);
  const Series series = read_series(out / "series.csv");
  EXPECT_NEAR(series.at("time").back(), 5 * pi / 20, 1e-8);
  EXPECT_NEAR(series.at("mass.x").back(), 1, 1e-9);
  EXPECT_EQ(frame_times(out).back(), series.at("time").back());
  const auto run = summary_of(out)["run"];
  EXPECT_EQ(run["stopped by"], "third");
  EXPECT_EQ(run["end"], "reached");
  EXPECT_EQ(run["simulated [s]"], series.at("time").back());
}

/// Time at which a sphere that falls from 1 m passes 0.8 m of height, by its m g y, with soil steps of `step` ms.
double fall(const RunDirectory& dir, double step) {
  const auto out = dir / fmt::format("{}", step);
  EXPECT_EQ(run_scenario(dir.scenario(fmt::format(R"(subsoil: 1
materials: {{ball: {{density: 1 kg/(4/3*pi*(0.1 m)^3)}}, wall: {{density: 1000 kg/m^3}}}}
contacts: [{{between: [ball, wall], law: linear, k_n: 10 kN/m, restitution: 1, mu: 0}}]
soil: {{bed: {{fill: particles, material: ball, particles: [{{position: 0 1 0 m, radius: 0.1 m}}]}}}}
boundaries: [{{name: wall, shape: {{plane: {{}}}}, material: wall}}]
time: {{end: 0.3 s, soil step: {} ms}}
output: {{state: none, crossings: {{low: {{column: soil.gravity, at: 0.8*9.81 J, stop after: 1}}}}}}
)",
                                                  step)),
                         out),
            exit_ok);
  EXPECT_EQ(summary_of(out)["run"]["stopped by"], "low");
  EXPECT_NEAR(read_series(out / "series.csv").at("time").back(), std::sqrt(0.4 / g), 2.1e-3 * step) << "the next step";
  return summary_of(out)["crossings"]["low"]["times [s]"][0];
}

// The chord of a parabola: off by a dt^2/8 of height at most, so of second order.
// The block of 2 kg has come 0.5 m at a - 3 m/s^2 t from 3 m/s when it catches what comes at -4 m/s, and its friction
// turns round. The last row is of what happened, by every method.
TEST(Crossings, OfALatchEndARunBehindIt) {
  for (const char* method : {"cvode", "ida", "adams-moulton"}) {
    SCOPED_TRACE(method);
    const RunDirectory dir;
    const std::string file = dir.scenario(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies:
    block: {mass: 2 kg, inertia: 1 kg m^2, at: 0 0 m, velocity: 3 0 m/s}
    other: {mass: 4 kg, inertia: 1 kg m^2, at: 5 0 m, velocity: -4 0 m/s}
  joints: {rail: {translational: [ground, block], along: 1 0}, hook: {fixed: [block, other], at: 0 0 m}}
  forces:
    press: {force: block, along y: -20 N}
    rub: {joint friction: rail, guide: 0.5 m, mu_s: 0.3, mu_k: 0.3, stick stiffness: 1e5 N/m}
  measures: {way: {position: block, component: x}}
  events: {catch: {closes: hook, measure: way, above: 0.5 m}}
time: {end: 1 s, stop when: {caught: {column: hook.open, below: 0.5}}}
output: {series every: 7 ms}
)");
    ASSERT_EQ(run_scenario(file, dir / "out", {std::string("time.machine={integrator: ") + method + "}"}), exit_ok);
    const Series s = read_series(dir / "out" / "series.csv");
    const double met = 1 - std::sqrt(1 - 2 * 0.5 / 3), before = 3 * (1 - met);
    EXPECT_NEAR(s.at("time").back(), met, 1e-7);
    EXPECT_EQ(s.at("hook.open").back(), 0);
    EXPECT_EQ(s.at("hook.open")[s.rows() - 2], 1);
    EXPECT_NEAR(s.at("block.vx").back(), (2 * before - 16) / 6, 1e-6);
    EXPECT_NEAR(s.at("rub.force").back(), 6, 1e-6);
    EXPECT_NEAR(s.at("block.ax").back(), 1, 1e-6);
  }
}

TEST(Crossings, WithSoilAreOfSecondOrder) {
  const RunDirectory dir;
  const double exact = std::sqrt(0.4 / g);
  for (const double step : {4.0, 1.0, 0.25})
    EXPECT_NEAR(fall(dir, step), exact, 1.01e-6 * g * step * step / 8 / (g * exact)) << step;
}

/// A driven velocity rises to a value and stays there, by rounding above it or below: it never is above. A peak that
/// touches it is not either, and one that passes it by a thousandth is.
TEST(Crossings, WhatStaysOnAValueIsNotBeyondIt) {
  for (const char* const method : {"cvode", "ida", "adams-moulton"})
    for (const double corner : {0.77, 0.31, 0.5})
      for (const auto& [top, stops] : {std::pair(0.1, false), std::pair(0.1001, true)}) {
        const RunDirectory dir;
        const std::string text = fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {{b: {{mass: 2 kg, inertia: 1 kg m^2, at: 0 0 m}}}}
  joints: {{g: {{translational: [ground, b], at: 0 0 m, along: 1 0}}}}
  drivers: {{d: {{coordinate: b.x, velocity: {{table: {{points: [[0 s, 0 m/s], [{} s, {} m/s], [1 s, 0.1 m/s]], between: linear}}}}}}}}
time: {{end: 1 s, machine: {{integrator: {}}}, stop when: {{q: {{column: b.vx, above: 0.1 m/s}}}}}}
)",
                                             corner, top, method);
        ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok) << text;
        EXPECT_EQ(summary_of(dir / "out")["run"].contains("stopped by"), stops) << text;
      }
}

/// A force that jumps at the ends of given steps has one side there: 40 passages in 0.4 s, to the last one at 0.4 s.
TEST(Crossings, OfAForceThatJumpsAtTheEndsOfStepsCountOnce) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {b: {mass: 2 kg, inertia: 1 kg m^2, at: 0 0 m}}
  joints: {g: {translational: [ground, b], at: 0 0 m, along: 1 0}}
  forces: {f: {force: b, along x: {expression: sign(sin(2*pi*t/0.02)), unit: N}}}
time: {end: 0.4 s, machine: {step: 0.2 ms}}
output: {series every: 7 ms, crossings: {c: {column: f.fx, at: 0.3 N}}}
)"),
                         dir / "out"),
            exit_ok);
  const auto times = summary_of(dir / "out")["crossings"]["c"]["times [s]"].get<std::vector<double>>();
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_GT(times[i] - times[i - 1], 9e-3) << times[i];
  EXPECT_GE(times.size(), 39U);
}

TEST(Crossings, AreRefusedBeforeARunToo) {
  const RunDirectory dir;
  const auto looked_at = [&](const char* crossing) {
    return message_of<ScenarioError>([&] {
      estimate({.scenario = dir.scenario(oscillator(crossing)), .out = {}, .sets = {}, .threads = 1, .from = {}});
    });
  };
  EXPECT_NE(looked_at("half: {column: mas.x, at: 0.05 m}").find("no column 'mas.x'"), std::string::npos);
  EXPECT_EQ(looked_at("half: {column: mass.x, at: 0.05 m}").find("no column"), std::string::npos);
}

TEST(Crossings, RefusalsSayWhatIsWrong) {
  const auto refusal = [](const std::string& crossings) {
    const RunDirectory dir;
    return subsoil::test::message_of<ScenarioError>(
        [&] { run_scenario(dir.scenario(oscillator(crossings)), dir / "out"); });
  };
  EXPECT_NE(refusal("a: {column: mass.y2}").find("no column 'mass.y2'"), std::string::npos)
      << refusal("a: {column: mass.y2}");
  EXPECT_NE(refusal("a: {column: mass.x, at: 3 kg}").find("needed is a length"), std::string::npos)
      << refusal("a: {column: mass.x, at: 3 kg}");
}

}  // namespace
}  // namespace subsoil::sim::run_crossings
