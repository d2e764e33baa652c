// Rows and frames stand at the times asked for exactly, between steps too, and are right there to the order of the
// step.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libsim/run/schedule.hpp"
#include "tests/tools/program_runs.hpp"

namespace subsoil::sim::run_times_test {
namespace {

using namespace test;
constexpr double g = 9.81;

/// One sphere of 1 kg and a plane at y = 0, a step of `step` ms.
std::string ball(double y, double step, const std::string& output) {
  return fmt::format(R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {{ball: {{density: 1 kg/(4/3*pi*(0.1 m)^3)}}, wall: {{density: 1000 kg/m^3}}}}
contacts: [{{between: [ball, wall], law: linear, k_n: 10 kN/m, restitution: 1, mu: 0}}]
soil: {{bed: {{fill: particles, material: ball, particles: [{{position: 0 {} 0 m, velocity: 1 0 0 m/s, radius: 0.1 m}}]}}}}
boundaries: [{{name: wall, shape: {{plane: {{}}}}, material: wall}}]
time: {{end: 50 ms, soil step: {} ms}}
output: {{precision: double, state: none, {}}}
)",
                     y, step, output);
}

constexpr double ms = 1e-3;
const std::vector<double> listed{0.3 * ms, 10 * ms, 12.3456 * ms, 33.1 * ms, 33.2 * ms};
constexpr const char* at_listed =
    "series digits: all, forces: instant, series at: [0.3 ms, 33.2 ms, 33.1 ms, 10 ms, 12.3456 ms], "
    "at: [0.3 ms, 33.2 ms, 33.1 ms, 10 ms, 12.3456 ms]";

/// What stands at the listed times and at the end.
void expect_listed(const std::vector<double>& times) {
  ASSERT_EQ(times.size(), listed.size() + 1);
  for (std::size_t i = 0; i < listed.size(); ++i) EXPECT_EQ(times[i], listed[i]);
  EXPECT_EQ(times.back(), 0.05);
}

// A parabola: the leapfrog has it exactly at its instants, the frames' cubic between them. Rows are chords, off by
// g dt^2/8 at most, and in the middle of a step by that.
TEST(Times, FreeFallInRowsAndFrames) {
  const RunDirectory dir;
  for (const double step : {1.0, 0.5}) {
    const auto out = dir / fmt::format("{}", step);
    ASSERT_EQ(run_scenario(dir.scenario(ball(10, step, at_listed)), out), exit_ok);
    const Series series = read_series(out / "series.csv");
    expect_listed(series.at("time"));
    expect_listed(frame_times(out));
    const double chord = g * step * step * 1e-6 / 8;
    for (std::size_t i = 0; i < series.rows(); ++i) {
      const double t = series.at("time")[i], y = 10 - 0.5 * g * t * t, part = std::fmod(t / (1e-3 * step), 1);
      EXPECT_NEAR(frame_positions(out, i)[0].y, y, 1e-13) << t;
      EXPECT_NEAR(frame_positions(out, i)[0].x, t, 1e-13) << t;
      EXPECT_NEAR(series.at("soil.gravity")[i] / g, y - 4 * part * (1 - part) * chord, 1e-10) << t;
    }
  }
}

/// Largest error in y of the frames of a sphere that rides on its spring, k = 10 kN/m, m = 1 kg, from y_0.
double riding_error(const RunDirectory& dir, double step) {
  const auto out = dir / fmt::format("{}", step);
  EXPECT_EQ(run_scenario(dir.scenario(ball(0.0985, step, at_listed)), out), exit_ok);
  const double rest = 0.1 - g / 1e4, w = 100;
  double worst = 0;
  for (std::size_t i = 0; i < listed.size(); ++i)
    worst = std::max(worst, std::abs(frame_positions(out, i)[0].y - rest - (0.0985 - rest) * std::cos(w * listed[i])));
  return worst;
}

// The leapfrog's own error is (w dt)^2/24 of the phase: order 2, so half the step leaves a quarter. The listed times
// lie at other shares of the two steps, hence the room.
TEST(Times, FramesOfAnOscillatorAreOfSecondOrder) {
  const RunDirectory dir;
  const double coarse = riding_error(dir, 0.4), fine = riding_error(dir, 0.2), finest = riding_error(dir, 0.1);
  EXPECT_LT(coarse, 2 * 0.52e-3 * 5 * 0.04 * 0.04 / 24) << "w t = 5 late by (w dt)^2/24";
  EXPECT_NEAR(coarse / fine, 4, 0.4);
  EXPECT_NEAR(fine / finest, 4, 0.4);
}

// Finer than the step, with columns of means: what acts in a step is held over it.
TEST(Times, RowsFinerThanTheStep) {
  const RunDirectory dir;
  const auto out = dir / "out";
  ASSERT_EQ(run_scenario(dir.scenario(ball(0.0985, 1, "series digits: all, series every: 0.1 ms")), out), exit_ok);
  const Series series = read_series(out / "series.csv");
  ASSERT_EQ(series.rows(), 501U);
  const std::vector<double>&t = series.at("time"), &push = series.at("wall.Fy");
  for (std::size_t i = 0; i < t.size(); ++i) EXPECT_EQ(t[i], static_cast<double>(i) / 10000) << i;
  for (std::size_t i = 2; i < t.size(); ++i)
    if (i % 10 != 1) {
      EXPECT_NEAR(push[i], push[i - 1], 1e-9) << "within one step, row " << i;
    }
  // Impulse of the rows is that of the steps: what stopped and turned the sphere.
  double impulse = 0;
  for (std::size_t i = 1; i < t.size(); ++i) impulse -= push[i] * (t[i] - t[i - 1]);
  const double rest = 0.1 - g / 1e4, turned = (rest - 0.0985) * 100 * std::sin(100 * 0.05);
  EXPECT_NEAR(impulse, g * 0.05 + turned, 0.01) << "of 0.5 N s";
}

constexpr const char* rod = R"(subsoil: 1
machine:
  bodies: {rod: {mass: 1 kg, inertia: 0.083333333333333333 kg m^2, at: 0.5 0 m}}
  joints: {pin: {revolute: [ground, rod], at: 0 0 m}}
time: {end: 0.4 s, machine: {rtol: 1e-11, atol: 1e-12}}
output: {series at: [0.3 ms, 0.1234567 s, 0.25 s], at: [0.1234567 s]}
)";

// omega^2 = 3 g sin(angle) / length, whatever the time; the times agree between methods.
TEST(Times, AMachineAloneBetweenItsSteps) {
  const RunDirectory dir;
  Series of[2];
  const char* methods[] = {"time.machine.integrator=adams-moulton", "time.machine.integrator=cvode"};
  for (int k = 0; k < 2; ++k) {
    const auto out = dir / std::to_string(k);
    ASSERT_EQ(run_scenario(dir.scenario(rod), out, {methods[k], "time.machine.step=1 ms"}), exit_ok);
    of[k] = read_series(out / "series.csv");
    EXPECT_EQ(of[k].at("time"), (std::vector<double>{0.3 * ms, 0.1234567, 0.25, 0.4}));
    EXPECT_EQ(frame_times(out), (std::vector<double>{0.1234567, 0.4}));
    for (std::size_t i = 0; i < 4; ++i) {
      const double angle = of[k].at("rod.angle")[i], spin = of[k].at("rod.spin")[i];
      EXPECT_NEAR(spin * spin, -3 * g * std::sin(angle), 1e-7) << methods[k] << ", row " << i;
      EXPECT_NEAR(of[k].at("energy.balance")[i], 0, 1e-8);
    }
  }
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(of[0].at("rod.angle")[i], of[1].at("rod.angle")[i], 1e-9);
  EXPECT_NEAR(of[1].at("rod.angle")[0], -0.75 * g * 9e-8, 1e-14) << "of a rod just let go";
}

TEST(Schedule, TellsEachTimeOnceAndEndsAtTheEnd) {
  Schedule s(0.1, {0.25, 0.3, 0.7}, 0.2, 0.7);
  std::vector<double> told;
  for (double t = s.next(); t < Schedule::never; t = s.next()) told.push_back(t), s.due(t, 1e-9);
  EXPECT_EQ(told, (std::vector<double>{0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7})) << "as decimals, to the last bit";
  Schedule uneven(0.3, {}, 0);
  uneven.due(0.3, 0);
  EXPECT_EQ(uneven.next(), 0.6);
}

// A machine alone with fixed steps of 7 ms, rows every 10 ms. A parabola is its own quintic: to rounding, whatever
// looks into the steps for a measure, a watch or a crossing.
TEST(Times, FreeFallOfAMachineBetweenFixedSteps) {
  const RunDirectory dir;
  for (const char* looked_at : {"", "monitor: {v: a.vy}", "monitor: {most: {maximum: a.y}, sum: {integral: a.y}}",
                                "crossings: {by: {column: a.y, at: -0.5 m}}"}) {
    SCOPED_TRACE(looked_at);
    const std::string fall = fmt::format(R"(subsoil: 1
gravity: 10 m/s^2
machine:
  bodies: {{a: {{mass: 1 kg, inertia: 0.1 kg m^2, at: 0 0 m}}}}
time: {{end: 0.5 s, machine: {{integrator: adams-moulton, step: 7 ms}}}}
output: {{series every: 10 ms, {}}}
)",
                                         looked_at);
    const auto out = dir / std::to_string(std::string(looked_at).size());
    ASSERT_EQ(run_scenario(dir.scenario(fall), out), exit_ok);
    const Series series = read_series(out / "series.csv");
    ASSERT_EQ(series.rows(), 51U);
    for (std::size_t i = 0; i < series.rows(); ++i) {
      const double t = series.at("time")[i];
      EXPECT_NEAR(series.at("a.vy")[i], -10 * t, 1e-12) << t;
      EXPECT_NEAR(series.at("a.y")[i], -5 * t * t, 1e-12) << t;
    }
  }
}

}  // namespace
}  // namespace subsoil::sim::run_times_test
