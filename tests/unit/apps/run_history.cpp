#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libsim/document/document.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Watches that follow a column over time, and conditions that end a run.
namespace subsoil::sim::run_history {
namespace {

using namespace test;
constexpr double pi = std::numbers::pi;

std::string unit(const Series& s, const char* column) {
  return s.columns[static_cast<std::size_t>(s.find(column))].unit;
}

/// x = 1 m + 0.1 m cos(10 t/s) on a spring.
std::string oscillator(const std::string& watch, const std::string& stop = {}) {
  return fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {{mass: {{mass: 1 kg, inertia: 1 kg m^2, at: 1.1 0 m}}}}
  joints: {{rail: {{translational: [ground, mass], along: 1 0}}}}
  forces: {{spring: {{spring-damper: [ground, mass], ends: [0 0 m, 1.1 0 m], stiffness: 100 N/m, free length: 1 m}}}}
time: {{end: 2 s, machine: {{rtol: 1e-11, atol: 1e-12}}{}}}
output: {{series every: 37 ms, monitor: {{{}}}}}
)",
                     stop.empty() ? "" : ", stop when: {" + stop + "}", watch);
}

const std::vector<std::vector<std::string>> methods{
    {"time.machine.integrator=cvode"},
    {"time.machine.integrator=adams-moulton", "time.machine.step=1 ms", "time.machine.order=6"},
    {"time.machine.integrator=ida"}};

/// A motor turns a wheel after a swinging set point, by samples every 5 ms whose outputs come 7 ms later.
std::string servo(const std::string& output) {
  return R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {w: {mass: 1 kg, inertia: 0.05 kg m^2, at: 0 0 m}}
  joints: {p: {revolute: [ground, w], at: 0 0 m}}
  measures: {ang: {angle: w}}
  controllers:
    c: {pid: ang, measured in: rad, output in: V, set point: {harmonic: {amplitude: 1 rad, frequency: 1 Hz}},
        proportional: 30 V/rad, sample time: 5 ms, delay: 7 ms, derivative: 2 V s/rad, integral: 10 V/(rad s),
        minimum: -20 V, maximum: 20 V}
  forces:
    m: {electric motor: [ground, w], torque constant: 0.1 N m/A, resistance: 0.5 ohm, inductance: 2 mH, gear ratio: 5,
        controller: c}
time: {end: 2 s}
)" + output;
}

// A derivative has no value at the start. What follows it begins there all the same: the integral of dx/dt from the
// start is x - x_0, a count has come from no side.
TEST(RunHistory, WhatFollowsADerivativeBeginsWithoutAValue) {
  for (const std::vector<std::string>& method : methods) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(oscillator(
                               "x: mass.x, v: {derivative: x}, way: {integral: v}, power: {formula: v*v, of: {v: v}}, "
                               "sum: {integral: power}, passes: {count: v, at: -0.5 m/s}")),
                           dir / "out", method),
              exit_ok);
    const Series s = read_series(dir / "out/series.csv");
    const auto last = [&](const char* name) { return s.at(name).back(); };
    // dx/dt is taken over rows and steps of milliseconds: 1/2 dt v' a value.
    EXPECT_NEAR(last("way"), last("x") - 1.1, 2e-3) << method[0];
    EXPECT_NEAR(last("sum"), 0.5 * (2 - std::sin(40) / 20), 2e-2) << "integral of sin^2(10 t)";
    // -sin(10 t) passes -0.5 at 10 t = pi/6, 5 pi/6 and each 2 pi later: 20 rad hold 3 whole turns and 1.15.
    EXPECT_EQ(last("passes"), 7) << method[0];
  }
}

// Watches look between rows; what they see there is no part of the rows. Steps end at other times with them, which
// leaves the tolerance's 1e-8 (times the gain of 30 V/rad and 10 A/V). Samples, delays and rows meet at multiples of
// 1 ms, to rounding: no step is as short as that.
TEST(RunHistory, LooksBetweenRowsLeaveASampledControllerAlone) {
  const RunDirectory dir;
  const std::string watch = "output: {monitor: {ta: {integral: w.angle}, u: c.output, e: c.error}}\n";
  ASSERT_EQ(run_scenario(dir.scenario(servo("")), dir / "plain"), exit_ok);
  ASSERT_EQ(run_scenario(dir.scenario(servo(watch)), dir / "watched"), exit_ok);
  const Series plain = read_series(dir / "plain/series.csv"), watched = read_series(dir / "watched/series.csv");
  for (const char* column : {"c.error", "c.output", "m.voltage", "m.current"}) {
    const std::vector<double>&a = plain.at(column), &b = watched.at(column);
    ASSERT_EQ(a.size(), b.size());
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
    EXPECT_LT(worst, 1e-6) << column;
  }
  EXPECT_EQ(watched.at("u"), watched.at("c.output"));
  EXPECT_EQ(watched.at("e"), watched.at("c.error"));
}

/// A block on a slide, pushed by 3 N sin(10 pi t) along x and pressed by 3 N sin(14 pi t).
std::string pushed_block(const std::string& output) {
  return R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {b: {mass: 2 kg, inertia: 1 kg m^2, at: 0 0 m}}
  joints: {s: {translational: [ground, b], at: 0 0 m, along: 1 0}}
  forces:
    f: {force: b, along x: {harmonic: {amplitude: 3 N, frequency: 5 Hz}}, along y: {harmonic: {amplitude: 3 N, frequency: 7 Hz}}}
    k: {bushing: [ground, b], at: 0 0 m, stiffness x: 100 N/m, stiffness y: 100 N/m}
    r: {joint friction: s, guide: 0.1 m, mu_s: 0.1, mu_k: 0.1}
    o: {outline contact: [ground, b], first: {flat: 0 -1 m, direction: 90 deg}, second: {disk: 10 mm}, stiffness: 1e4 N/m, n: 1}
    beam: {beam: [ground, b], ends: [-1 0 m, 0 0 m], axial stiffness: 1 N, bending stiffness: 1 N m^2}
time: {end: 0.5 s}
)" + output;
}

// Forces with components are projected, others are the one number they have.
TEST(RunHistory, WatchedForcesAreForces) {
  const RunDirectory dir;
  const std::string watch =
      "output: {monitor: {fx: {force: f}, fy: {force: f, along: 0 2}, kx: {force: k}, rub: {force: r}, n: {force: "
      "o}}}\n";
  ASSERT_EQ(run_scenario(dir.scenario(pushed_block(watch)), dir / "run"), exit_ok);
  const Series s = read_series(dir / "run/series.csv");
  EXPECT_EQ(s.at("fx"), s.at("f.fx"));
  EXPECT_EQ(s.at("fy"), s.at("f.fy"));
  EXPECT_EQ(s.at("kx"), s.at("k.force x"));
  EXPECT_EQ(s.at("rub"), s.at("r.force"));
  EXPECT_EQ(s.at("n"), s.at("o.normal force"));
  EXPECT_EQ(unit(s, "fx"), "N");
  EXPECT_GT(std::abs(s.at("fx")[1]), 1e-3);
  const auto refusal = [&](const std::string& of) {
    return message_of(
        [&] { run_scenario(dir.scenario(pushed_block("output: {monitor: {w: " + of + "}}\n")), dir / "refused"); });
  };
  EXPECT_NE(refusal("{force: beam}").find("monitor one of its columns, beam.axial force"), std::string::npos)
      << refusal("{force: beam}");
  EXPECT_NE(refusal("{force: r, along: 0 1}").find("is one number"), std::string::npos);
}

// Regularised friction of mu_s 0.5 and mu_k 0.3 is 0.482 of N at the most with speeds of 10 and 1 mm/s, and 0.3 with a
// Stribeck speed of 0.5 mm/s, where what mu_s adds has faded before friction has built up: said.
TEST(RunHistory, FrictionThatNeverReachesItsMuSIsSaid) {
  const RunDirectory dir;
  for (const char* speed : {"10 mm/s", "0.5 mm/s"}) {
    const std::string name = speed[0] == '1' ? "high" : "low";
    const std::vector<std::string> set{
        "machine.forces.r={joint friction: s, guide: 0.1 m, mu_s: 0.5, mu_k: 0.3, "
        "Stribeck speed: " +
        std::string(speed) + "}"};
    ASSERT_EQ(run_scenario(dir.scenario(pushed_block("")), dir / name, set), exit_ok);
    const std::string warnings = summary_of(dir / name)["warnings"].dump();
    EXPECT_EQ(warnings.find("r: its friction is 0.3 of the normal force at the most") != std::string::npos,
              name == "low")
        << warnings;
  }
}

// Means of a row are those of the middles of steps of 1 ms, f'' dt^2/24 = 3 N (10 pi)^2 1e-6/24 = 1.2e-4 N off at the
// most; of the window alone, by Simpson's rule, 3 N (10 pi 1e-3)^4/2880 = 1e-9 N. Values of one end would be off by up
// to f' dt/2 = 0.05 N.
TEST(RunHistory, MeansOfForcesAreOfSecondOrder) {
  const RunDirectory dir;
  const std::string outputs[] = {
      "output: {forces: mean, series every: 10 ms, window: {from: 0.13 s, until: 0.25 s}, monitor: {fx: {force: f}}}\n",
      "output: {series every: 10 ms, window: {from: 0.13 s, until: 0.25 s}, monitor: {fx: {force: f}}}\n"};
  const auto mean = [](double a, double b) {
    constexpr double w = 10 * pi;
    return 3 * (std::cos(w * a) - std::cos(w * b)) / (w * (b - a));
  };
  for (const std::string& output : outputs) {
    const bool of_rows = output == outputs[0];
    const std::string run = of_rows ? "rows" : "summary";
    ASSERT_EQ(run_scenario(dir.scenario(pushed_block(output)), dir / run), exit_ok);
    const Series s = read_series(dir / run / "series.csv");
    const std::vector<double>& t = s.at("time");
    for (std::size_t i = 1; of_rows && i < t.size(); ++i) EXPECT_NEAR(s.at("fx")[i], mean(t[i - 1], t[i]), 1.5e-4) << i;
    EXPECT_NEAR(summary_of(dir / run)["columns"]["fx"]["mean in window"], mean(0.13, 0.25), of_rows ? 1.5e-4 : 1e-8);
  }
}

// Beside soil a machine stands at the ends of steps, here of 50 us, or of windows of ten. A body that falls has v = -g
// t, which is a line between them: integral and mean of rows in between are then right to rounding and the integrator's
// 1e-10, whereas a line from step to step would be off by up to g (50 us)^2/8 = 3e-9 m.
TEST(RunHistory, RowsBetweenStepsHaveTheIntegralUpToThem) {
  const std::string text = R"(subsoil: 1
materials: {stone: {density: 2500 kg/m^3}}
contacts: [{between: [stone, stone], law: linear, k_n: 1 kN/m, restitution: 0.5, mu: 0.4}]
soil:
  container: {size: 100 100 100 mm, at: 0 0 0 m, material: stone}
  bed: {fill: particles, material: stone, particles: [{position: 50 10 50 mm, radius: 10 mm}]}
machine:
  bodies: {weight: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0 1 m}}
time: {end: 5 ms, soil step: 50 us}
output: {every: 5 ms, series every: 70 us, series digits: all, monitor: {way: {integral: weight.vy}, mean: {mean: weight.vy}}}
)";
  for (const char* steps : {"1", "10"}) {
    const RunDirectory dir;
    const std::string file = dir.scenario(text);
    ASSERT_EQ(run_scenario(file, dir / "run", {"time.machine.soil steps per machine step=" + std::string(steps)}),
              exit_ok);
    const Series s = read_series(dir / "run" / "series.csv");
    const std::vector<double>& t = s.at("time");
    ASSERT_GT(t.size(), 70U);
    for (std::size_t i = 1; i < t.size(); ++i) {
      EXPECT_NEAR(s.at("way")[i], -0.5 * 9.81 * t[i] * t[i], 1e-12) << steps << " row " << i;
      EXPECT_NEAR(s.at("mean")[i], -0.5 * 9.81 * t[i], 1e-9) << steps << " row " << i;
    }
  }
}

// 1 kHz over 0.5003 s, seen in rows of 1 ms: x' = v cos(w t), F = -(k v/w) sin(w t). Parabolas over half a step of
// cvode, some 0.25 rad, leave 0.25^4/2880 of an integral of F^2, whose phase is twice that: some 2e-5.
TEST(RunHistory, OfAFastVibrationIsWhatTheSineSays) {
  constexpr double w = 2000 * pi, v = 0.02 * pi, k = w * w, end = 0.5003;
  const RunDirectory dir;
  const std::string machine = fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {{b: {{mass: 1 kg, inertia: 1 kg m^2, at: 1 0 m, velocity: {:.17g} 0 m/s}}}}
  joints: {{g: {{translational: [ground, b], at: 1 0 m, along: 1 0}}}}
  forces: {{k: {{spring-damper: [ground, b], ends: [0 0 m, 1 0 m], stiffness: {:.17g} N/m}}}}
)",
                                          v, k);
  const std::string watches = R"(
output:
  monitor: {sq: {formula: F*F, of: {F: k.force}, unit: N^2}, isq: {integral: sq}, mx: {maximum: b.vx}, n: {count: b.vx, at: 0 m/s, direction: rising}}
  crossings: {z: {column: b.vx, at: 0 m/s, direction: rising}}
)";
  const double integral = std::pow(k * v / w, 2) * (end / 2 - std::sin(2 * w * end) / (4 * w));
  for (const char* method : {"cvode", "ida"}) {
    const std::vector<std::string> set{fmt::format("time.machine.integrator={}", method)};
    ASSERT_EQ(
        run_scenario(dir.scenario(machine + fmt::format("time: {{end: {} s}}", end) + watches), dir / method, set),
        exit_ok);
    const Series s = read_series(dir / method / "series.csv");
    EXPECT_NEAR(s.at("isq").back(), integral, 1e-4 * integral) << method;
    EXPECT_NEAR(s.at("mx").back(), v, 1e-4 * v) << method;
    EXPECT_EQ(s.at("n").back(), 500) << method;
    EXPECT_EQ(summary_of(dir / method)["crossings"]["z"]["count"], 500) << method;
    // |F| = k v/w sin(w t) passes 0.9 of its amplitude first at w t = asin 0.9, from below.
    const auto out = dir / fmt::format("{}-stop", method);
    const std::string stop = fmt::format(
        "time: {{end: {} s, stop when: {{high: {{column: k.force, above: {:.17g} N}}}}}}\n", end, 0.9 * k * v / w);
    ASSERT_EQ(run_scenario(dir.scenario(machine + stop), out, set), exit_ok);
    const double at = read_series(out / "series.csv").at("time").back();
    EXPECT_LT(at, 1e-3) << method << ": within the first period";
  }
}

double largest_cosine(double from, double until) {  // of cos(10 t)
  const double first = std::ceil(10 * from / (2 * pi)) * 2 * pi / 10;
  return first <= until ? 1 : std::max(std::cos(10 * from), std::cos(10 * until));
}

// Rows are 37 ms apart: the quantities are those of the motion between them, not of the rows. Parabolas of 1 ms leave
// y''' h^2/12 = 1e-5 m/s of a derivative at their end, y''' h^3/72 of an extreme.
TEST(RunHistory, OfAnOscillatorIsWhatTheCosineSays) {
  const std::string file_text = oscillator(
      "way: {integral: mass.vx}, speed: {derivative: mass.x}, mean: {mean: mass.x, within: 0.628318530717959 s}, top: "
      "{maximum: mass.x}, low: {minimum: mass.x}, top lately: {maximum: mass.x, within: 0.2 s}, passes: {count: "
      "mass.x, at: 1 m, direction: rising}, above: {time above: mass.x, at: 1050 mm}, below: {time below: mass.x, at: "
      "1.05 m, unbroken: yes}");
  for (const auto& method : methods) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(file_text), dir / "out", method), exit_ok);
    const Series s = read_series(dir / "out/series.csv");
    EXPECT_EQ(unit(s, "way"), "m");
    EXPECT_EQ(unit(s, "speed"), "m/s");
    EXPECT_EQ(unit(s, "passes"), "1");
    EXPECT_EQ(unit(s, "above"), "s");
    EXPECT_TRUE(std::isnan(s.at("speed").front())) << "one instant has no slope";
    for (std::size_t i = 1; i < s.at("time").size(); ++i) {
      const double t = s.at("time")[i], x = 1 + 0.1 * std::cos(10 * t);
      ASSERT_NEAR(s.at("way")[i], x - 1.1, 1e-8) << method[0] << t;
      ASSERT_NEAR(s.at("speed")[i], -std::sin(10 * t), 1e-5) << method[0] << t;
      ASSERT_NEAR(s.at("mean")[i], t > 2 * pi / 10 ? 1 : 1 + 0.01 * std::sin(10 * t) / t, 1e-8) << t;
      ASSERT_NEAR(s.at("top")[i], 1.1, 1e-9);
      ASSERT_NEAR(s.at("low")[i], 10 * t > pi ? 0.9 : x, 1e-8) << t;
      ASSERT_NEAR(s.at("top lately")[i], 1 + 0.1 * largest_cosine(std::max(0.0, t - 0.2), t), 1e-8) << t;
      ASSERT_EQ(s.at("passes")[i], std::floor(10 * t / (2 * pi) + 0.25)) << t;
      // Above 1.05 for a third of each turn, a sixth on either side of the top.
      const double turns = 10 * t / (2 * pi), whole = std::floor(turns), rest = turns - whole;
      const double thirds = whole / 3 + std::min(rest, 1. / 6) + std::max(0.0, rest - 5. / 6);
      ASSERT_NEAR(s.at("above")[i], thirds * 2 * pi / 10, 1e-6) << t;
      const double since = rest > 1. / 6 && rest < 5. / 6 ? (rest - 1. / 6) * 2 * pi / 10 : 0;
      ASSERT_NEAR(s.at("below")[i], since, 1e-6) << t;
    }
  }
}

// sin(v)/v has no value where it sets out, v = 0; of |v| <= 1 m/s it goes from 1 down to sin 1.
TEST(RunHistory, ExtremesPassOverRowsWithoutAValue) {
  const RunDirectory dir;
  const std::string watch =
      "q: {formula: sin(v)/v, of: {v: mass.vx}, unit: 1}, least: {minimum: q}, most: {maximum: q}, "
      "lately: {minimum: q, within: 1 s}";
  ASSERT_EQ(run_scenario(dir.scenario(oscillator(watch)), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_TRUE(std::isnan(series.at("q").front()));
  EXPECT_NEAR(series.at("least").back(), std::sin(1.0), 1e-9);
  EXPECT_NEAR(series.at("lately").back(), std::sin(1.0), 1e-9);
  EXPECT_NEAR(series.at("most").back(), 1, 1e-3);
}

// x/v of a body at rest is 0/0 until 0.1 s, and then half of the time since, under a force that begins there. Means are
// of the time in which there is a value, from the millisecond on that begins at 0.1 s.
TEST(RunHistory, AMeanIsOfTheTimeInWhichThereIsAValue) {
  const RunDirectory dir;
  const std::string started = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {b: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}
  forces: {f: {force: b, along x: {ramp: {begin: 0.1 s, end: 0.1000001 s, to: 1 N}}}}
time: {end: 0.5 s}
output: {series every: 0.1 s, monitor: {r: {formula: x/v, unit: s, of: {x: b.x, v: b.vx}}, all: {mean: r}, recent: {mean: r, within: 0.2 s}}}
)";
  ASSERT_EQ(run_scenario(dir.scenario(started), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out/series.csv");
  EXPECT_NEAR(series.at("all").back(), 0.1, 1e-3);
  EXPECT_NEAR(series.at("recent").back(), 0.15, 1e-6);
}

// A pin bears 10 N + 100 N/s t until 0.5 s, or until it bears 60 N; from then on 0. Values lie in [-60, 0] N.
TEST(RunHistory, OfAForceThatJumpsStaysWithinIt) {
  for (const char* opens : {"at: 0.5 s", "reaction above: 60 N"})
    for (const auto& method : methods) {
      const RunDirectory dir;
      ASSERT_EQ(run_scenario(dir.scenario(fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {{w: {{mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}}}
  joints: {{guide: {{translational: [ground, w], at: 0 0 m, along: 0 1}}, pin: {{distance: [ground, w], ends: [0 1 m, 0 0 m]}}}}
  forces: {{load: {{force: w, along y: {{polynomial: {{c0: -10 N, c1: -100 N/s}}}}}}}}
  events: {{shear: {{opens: pin, {}}}}}
time: {{end: 1 s}}
output:
  series every: 10 ms
  monitor: {{peak: {{maximum: pin.fy}}, low: {{minimum: pin.fy}}, impulse: {{integral: pin.fy}}, open: {{maximum: pin.open}},
           n: {{count: pin.fy, at: -40 N}}, held: {{time below: pin.fy, at: -20 N}}}}
)",
                                                      opens)),
                             dir / "out", method),
                exit_ok);
      const Series s = read_series(dir / "out/series.csv");
      // ida carries the reaction, whose error of ten tolerances, 6e-6 N, puts the crossing of 100 N/s off by 6e-8 s.
      const double late = method[0].find("ida") != std::string::npos ? 6e-8 : 1.6e-10;
      EXPECT_NEAR(s.at("peak").back(), 0, 1e-9) << opens << method[0];
      EXPECT_NEAR(s.at("low").back(), -60, 1e-8) << opens << method[0];
      EXPECT_NEAR(s.at("impulse").back(), -17.5, 60 * late) << opens << method[0];
      EXPECT_EQ(s.at("open").back(), 1) << opens << method[0];
      EXPECT_EQ(s.at("n").back(), 2) << opens << method[0];
      EXPECT_NEAR(s.at("held").back(), 0.4, late) << opens << method[0];
    }
}

// A mass on the slide of a driven arm. The slide opens where it bears 100.8 N, in a step at a weak choice of
// coordinates, which is taken as one past a singular configuration. The rows before show the closed slide: along it
// nothing acts, so that s'' = s phi'^2, and it bears m (d phi'' + 2 s' phi' + ...), which grows by 0.65 N in a
// millisecond there.
TEST(RunHistory, RowsBeforeAnEventShowTheJointAsItWas) {
  for (const auto& method : methods) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies:
    arm: {mass: 3.498 kg, inertia: 0.9213 kg m^2, at: 1.864 -0.625 m, angle: -2.575 rad, velocity is: about}
    load: {mass: 4.991 kg, inertia: 1.4875 kg m^2, at: 5.238 -0.83 m, angle: 1.765 rad, velocity is: about}
  joints:
    pivot: {revolute: [ground, arm], at: 2.221 -0.535 m}
    slide: {translational: [arm, load], at: 5.314 -0.482 m, along: -0.73 0.71}
  drivers: {turn: {angle: [ground, arm], position: {expression: -2.575 - 2.56*t + 0.35*sin(t)^3, unit: rad}}}
  events: {shear: {opens: slide, reaction above: 100.8 N}}
time: {end: 0.4 s}
output: {series every: 1 ms, monitor: {bears: {formula: sqrt(x^2 + y^2), of: {x: slide.fx, y: slide.fy}, unit: N}, peak: {maximum: bears}}}
)"),
                           dir / "out", method),
              exit_ok);
    const Series s = read_series(dir / "out/series.csv");
    const std::vector<double> open = s.at("slide.open"), bears = s.at("bears"), t = s.at("time");
    ASSERT_EQ(open.back(), 1) << method[0];
    std::size_t last = 0;
    while (open[last + 1] == 0) ++last;
    EXPECT_NEAR(t[last], 0.311, 1e-9) << method[0];
    EXPECT_NEAR(bears[last], 100.8, 0.65) << method[0];
    for (std::size_t k = 1; k <= last; ++k)
      EXPECT_NEAR(bears[k], bears[k - 1], 1) << method[0] << ": continuous while it is closed, " << t[k];
    EXPECT_NEAR(s.at("peak").back(), 100.8, 1e-4) << method[0];
  }
}

// Formulas jump where no event says so.
TEST(RunHistory, OfAFormulaThatJumpsStaysWithinIt) {
  for (const char* force : {"10", "0.001"}) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {{b: {{mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}}}}
  forces: {{f: {{force: b, along x: {{expression: {}*sign(sin(7*t)), unit: N}}}}}}
time: {{end: 2 s}}
output: {{series every: 10 ms, monitor: {{most: {{maximum: f.fx}}, least: {{minimum: f.fx}}, push: {{integral: f.fx}}}}}}
)",
                                                    force)),
                           dir / "out"),
              exit_ok);
    const Series s = read_series(dir / "out/series.csv");
    const double size = std::stod(force), rest = 2 - 4 * pi / 7;
    EXPECT_NEAR(s.at("most").back(), size, 1e-9 * size);
    EXPECT_NEAR(s.at("least").back(), -size, 1e-9 * size);
    EXPECT_NEAR(s.at("push").back(), rest * size, 1e-6 * size);
  }
}

/// A ball of 1 kg falls 0.3 m on k = 1 GN/m^1.5; they touch for some 0.7 ms.
std::string struck(const std::string& output, const std::string& stop = {}) {
  return "subsoil: 1\nmachine:\n  bodies: {b: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0.3 m}}\n"
         "  forces: {c: {line contact: [ground, b], ends: [0 0 m, 0 0.3 m], along: 1 0, stiffness: 1 GN/m^1.5}}\n"
         "time: {end: 0.4 s" +
         stop + "}\noutput: {" + output + "}\n";
}

// Deepest where k d^2.5/2.5 = m v^2/2 + m g d, found by iteration; its impulse turns the speed and bears the weight.
TEST(RunHistory, OfAContactWithinAStepIsItsImpact) {
  constexpr double g = 9.81, k = 1e9, v2 = 2 * g * 0.3;
  double d = 0;
  for (int turn = 0; turn < 30; ++turn) d = std::pow(2.5 * (v2 / 2 + g * d) / k, 0.4);
  const double peak = k * std::pow(d, 1.5);
  for (const char* method : {"cvode", "ida"}) {
    const std::vector<std::string> set{fmt::format("time.machine.integrator={}", method)};
    const RunDirectory dir;
    const std::string output =
        "monitor: {impulse: {integral: c.normal force}, peak: {maximum: c.normal force}, touch: {time below: c.gap, "
        "at: "
        "0 "
        "m}, n: {count: c.gap, at: 0 m}}, crossings: {up: {column: c.normal force, at: 10 kN}}";
    ASSERT_EQ(run_scenario(dir.scenario(struck(output)), dir / "out", set), exit_ok);
    const Series s = read_series(dir / "out/series.csv");
    const auto summary = summary_of(dir / "out");
    const double touched = s.at("touch").back();
    EXPECT_NEAR(s.at("peak").back(), peak, 1e-6 * peak) << method;
    EXPECT_NEAR(s.at("impulse").back(), 2 * std::sqrt(v2) + g * touched, 1e-4) << method;
    EXPECT_NEAR(touched, 2.9432 * d / std::sqrt(v2), 1e-3 * touched) << "of Hertz, the weight is 1/1350 of the peak";
    EXPECT_EQ(s.at("n").back(), 2) << method;
    EXPECT_EQ(summary["crossings"]["up"]["count"], 2) << method;
    ASSERT_EQ(run_scenario(dir.scenario(struck("series every: 10 ms",
                                               ", stop when: {hit: {column: c.normal force, "
                                               "above: 10 kN}}")),
                           dir / "stopped", set),
              exit_ok);
    EXPECT_NEAR(read_series(dir / "stopped/series.csv").at("c.normal force").back(), 1e4, 1) << method;
  }
}

// Fine rows of a motion with events, of which something is followed: the ball comes back to where it fell from.
TEST(RunHistory, OfFineRowsEndsWithTheRun) {
  for (const char* every : {"0.05 ms", "0.02 ms"}) {
    const RunDirectory dir;
    const std::string output =
        fmt::format("series every: {}, monitor: {{top: {{maximum: b.y, within: 0.3 s}}}}", every);
    ASSERT_EQ(run_scenario(dir.scenario(struck(output)), dir / "out", {"time.end=0.6 s"}), exit_ok) << every;
    EXPECT_NEAR(read_series(dir / "out/series.csv").at("top").back(), 0.3, 1e-7);
  }
}

TEST(RunHistory, ConditionsEndARunWhereTheyAreMet) {
  struct Case {
    const char* stop;
    double at;
  };
  // x comes below 0.95 m at 10 t = 2 pi/3 and is there for a third of a turn, 0.209 s.
  for (const Case& c : {Case{"low: {column: mass.x, below: 950 mm}", 2 * pi / 30},
                        Case{"low: {column: mass.x, below: 0.95 m, for: 0.2 s}", 2 * pi / 30 + 0.2},
                        Case{"low: {column: way, below: -0.15 m}", 2 * pi / 30},
                        Case{"never: {column: mass.x, below: 0.95 m, for: 0.22 s}", 2},
                        Case{"at once: {column: mass.x, above: 1 m}", 0},
                        Case{"later: {column: mass.x, above: 1.05 m, for: 0.15 s}, low: {column: mass.vx, above: 0.5 "
                             "m/s}",
                             7 * pi / 60}})
    for (const auto& method : methods) {
      const RunDirectory dir;
      ASSERT_EQ(run_scenario(dir.scenario(oscillator("way: {integral: mass.vx}", c.stop)), dir / "out", method),
                exit_ok);
      const Series s = read_series(dir / "out/series.csv");
      EXPECT_NEAR(s.at("time").back(), c.at, 1e-6) << c.stop << method[0];
      EXPECT_NEAR(s.at("mass.x").back(), 1 + 0.1 * std::cos(10 * s.at("time").back()), 1e-8) << c.stop;
      EXPECT_NEAR(s.at("way").back(), s.at("mass.x").back() - 1.1, 2e-6) << "of the row's time, too";
      const auto run = summary_of(dir / "out")["run"];
      EXPECT_EQ(run["end"], "reached");
      EXPECT_EQ(run.contains("stopped by"), c.at < 2);
      if (c.at < 2) {
        EXPECT_EQ(run["stopped at [s]"], s.at("time").back());
      }
    }
}

// Frames every 7.5 ms (a 200th of the end) and rows every 1 ms: steps of the method end beside rows by rounding, and
// over that no difference is a derivative. At the end of a parabola over 0.5 ms it errs by (0.5 ms)^2/12 of the third
// derivative, up to 1.5 g/L times 5.4 rad/s: 1.7e-6 rad/s.
// x = cos(2 pi t) below -0.9 for 0.14 s, with a second condition on what is followed: all that is followed ends where
// the run does. The maximum of the speed is the speed there, int |x| = (2 - sin 2 pi t)/(2 pi), to the parabolas of 1
// ms.
TEST(RunHistory, WhatIsFollowedEndsAtAConditionOfAnother) {
  const std::string text = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {m: {mass: 1 kg, inertia: 1 kg m^2, at: 1 0 m}}
  joints: {g: {translational: [ground, m], at: 0 0 m, along: 1 0}}
  forces: {k: {spring-damper: [ground, m], ends: [-2 0 m, 1 0 m], stiffness: 39.47841760435743 N/m, free length: 2 m}}
time: {end: 5 s, stop when: {s1: {column: m.x, below: -0.9 m, for: 0.14 s}, s2: {column: cnt, above: 3.5}}}
output:
  series every: 0.3 s
  monitor: {cnt: {count: m.x, at: 0 m, direction: falling}, mx: {maximum: m.vx}, ab: {formula: abs(x), of: {x: m.x}, unit: m},
          iab: {integral: ab}}
)";
  const double t = std::acos(-0.9) / (2 * pi) + 0.14, speed = -2 * pi * std::sin(2 * pi * t);
  for (const auto& method : methods) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out", method), exit_ok);
    const Series s = read_series(dir / "out/series.csv");
    EXPECT_NEAR(s.at("time").back(), t, 1e-7) << method[0];
    EXPECT_NEAR(s.at("mx").back(), s.at("m.vx").back(), 1e-12) << method[0];  // the same instant, read twice
    EXPECT_NEAR(s.at("mx").back(), speed, 1e-5) << method[0];
    EXPECT_NEAR(s.at("iab").back(), (2 - std::sin(2 * pi * t)) / (2 * pi), 1e-7) << method[0];
    EXPECT_EQ(summary_of(dir / "out")["columns"]["mx"]["steps in window"]["max"], s.at("mx").back()) << method[0];
  }
  // By what is followed itself: the count passes between 3 and 4 where x falls through 0 for the fourth time.
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out", {"time.stop when.s1.below=-2 m"}), exit_ok);
  const Series s = read_series(dir / "out/series.csv");
  EXPECT_NEAR(s.at("time").back(), 3.25, 1e-7);
  EXPECT_EQ(s.at("cnt").back(), 4);
}

TEST(RunHistory, ADerivativeIsTakenOverPartsThatAreNotRounding) {
  const RunDirectory dir;
  const std::string rod = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {rod: {mass: 1 kg, inertia: 0.0833333333333333 kg m^2, at: 0.5 0 m}}
  joints: {pin: {revolute: [ground, rod], at: 0 0 m}}
time: {end: 1.5 s, stop when: {never: {column: rate, above: 6 rad/s}}}
output: {monitor: {rate: {derivative: rod.angle}}}
)";
  for (const char* method : {"time.machine.integrator=cvode", "time.machine.integrator=ida"}) {
    const auto out = dir / std::string(method).substr(24);
    ASSERT_EQ(run_scenario(dir.scenario(rod), out, {method}), exit_ok);
    const Series series = read_series(out / "series.csv");
    ASSERT_EQ(series.rows(), 1501U) << "sqrt(3 g/L) = 5.42 rad/s is the fastest it turns";
    for (std::size_t i = 1; i < series.rows(); ++i)
      EXPECT_NEAR(series.at("rate")[i], series.at("rod.spin")[i], 1e-5) << method << ' ' << series.at("time")[i];
  }
}

// The run ends within a step, and so does what is followed: on parabolas of 1 ms as everywhere, no line (1e-6).
TEST(RunHistory, EndsWithTheRunWithinAStep) {
  const std::string file_text = oscillator("way: {integral: mass.vx}, lately: {mean: mass.x, within: 50 ms}",
                                           "there: {column: mass.x, below: 1.03 m}");
  for (const auto& method : methods) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(file_text), dir / "out", method), exit_ok);
    const Series s = read_series(dir / "out" / "series.csv");
    const double t = s.at("time").back();
    EXPECT_NEAR(t, std::acos(0.3) / 10, 1e-8) << method[0];
    EXPECT_NEAR(s.at("way").back(), -0.07, 1e-9) << method[0];
    EXPECT_NEAR(s.at("lately").back(), 1 + 0.1 * (std::sin(10 * t) - std::sin(10 * t - 0.5)) / 0.5, 1e-9) << method[0];
  }
}

/// A ball of 1 kg that falls on a wall.
std::string bouncing(double end, const std::string& stop = {}) {
  return fmt::format(R"(subsoil: 1
materials: {{ball: {{density: 1 kg/(4/3*pi*(0.1 m)^3)}}, wall: {{density: 1000 kg/m^3}}}}
contacts: [{{between: [ball, wall], law: linear, k_n: 10 kN/m, restitution: 0.8, mu: 0}}]
soil: {{bed: {{fill: particles, material: ball, particles: [{{position: 0 0.15 0 m, radius: 0.1 m}}]}}}}
boundaries: [{{name: wall, shape: {{plane: {{}}}}, material: wall}}]
time: {{end: {} s, soil step: 0.1 ms{}}}
output:
  series every: 7 ms
  series digits: all
  monitor:
    impulse: {{integral: wall.Fy}}
    hardest: {{minimum: wall.Fy}}
    fastest: {{maximum: soil.fastest, within: 10 ms}}
)",
                     end, stop.empty() ? "" : ", stop when: {" + stop + "}");
}

// Forces act over a step as they are at its start: the integral is that of the means in the rows to rounding, and the
// momentum that the ball has changed by. It leaves with what restitution leaves of its speed.
TEST(RunHistory, OfSoilIsTheImpulse) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(bouncing(0.2)), dir / "out"), exit_ok);
  const Series s = read_series(dir / "out/series.csv");
  EXPECT_EQ(unit(s, "impulse"), "N s");
  double sum = 0;
  for (std::size_t i = 1; i < s.at("time").size(); ++i) {
    sum += s.at("wall.Fy")[i] * (s.at("time")[i] - s.at("time")[i - 1]);
    ASSERT_NEAR(s.at("impulse")[i], sum, 1e-9) << s.at("time")[i];
  }
  const double down = std::sqrt(2 * 9.81 * 0.05);
  EXPECT_NEAR(-s.at("impulse").back(), 1.8 * down + 9.81 * pi / 100, 0.02 * down)
      << "restitution 0.8, gravity over the half period pi sqrt(m/k)";
  EXPECT_LT(s.at("hardest").back(), -90) << "some v sqrt(k m)";
}

TEST(RunHistory, ConditionsEndARunWithSoil) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(bouncing(0.2)), dir / "stopped",
                         {"time.stop when.hit={column: wall.Fy, below: -20 N}"}),
            exit_ok);
  const auto run = summary_of(dir / "stopped")["run"];
  EXPECT_EQ(run["stopped by"], "hit");
  const double t = run["stopped at [s]"];
  // 20 N after the fall of 0.05 m: 2 mm deep, reached at 1 m/s after sqrt(0.1/g) s, slower by nothing to speak of.
  EXPECT_NEAR(t, std::sqrt(0.1 / 9.81), 0.003);
  EXPECT_NEAR(read_series(dir / "stopped/series.csv").at("time").back(), t, 2.1e-4) << "the next step";
}

TEST(RunHistory, RefusalsSayWhatIsWrong) {
  const auto refusal = [](const std::string& watch, const std::string& stop = {}) {
    const RunDirectory dir;
    return subsoil::test::message_of<ScenarioError>(
        [&] { run_scenario(dir.scenario(oscillator(watch, stop)), dir / "out"); });
  };
  const auto says = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  says(refusal("a: {integral: mass.vz}"), "no column 'mass.vz'; did you mean");
  says(refusal("a: {count: mass.x, at: 3 kg}"), "needed is a length");
  says(refusal("a: {integral: mass.x, within: 1 s}"), "unknown key");
  says(refusal("a: mass.x", "s: {column: mass.x}"), "needs either `above` or `below`");
  says(refusal("a: mass.x", "s: {above: 3 m}"), "a column of the series, such as soil.draft");
  says(refusal("a: mass.x", "s: {column: mass.x, above: 3 N}"), "needed is a length");
}

}  // namespace
}  // namespace subsoil::sim::run_history
