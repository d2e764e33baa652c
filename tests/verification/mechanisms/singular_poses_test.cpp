// Poses in which Phi_q loses rank for an instant: the motion must go on smoothly or the run must stop and say where.
// It must never come out on another branch.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/reference_ode.hpp"

namespace subsoil::mbd::singular_poses_test {
namespace {

constexpr double pi = std::numbers::pi;

/// Links of a parallelogram with cranks of 1 and a base of 1, at the crank angle phi; cranks 1 ... n+1, couplers after.
Model parallelograms(int cells, double phi, double spin) {
  Model m;
  const Vec2 e{std::cos(phi), std::sin(phi)};
  for (int i = 0; i <= cells; ++i) {
    const int crank = m.add({.name = "crank " + std::to_string(i),
                             .mass = 1,
                             .inertia = 1. / 12,
                             .pose = {i + e.x / 2, e.y / 2, phi},
                             .velocity = {-spin * e.y / 2, spin * e.x / 2, spin}});
    m.add("base " + std::to_string(i),
          Revolute{.body_a = ground, .body_b = crank, .p_a = {1.0 * i, 0}, .p_b = {-0.5, 0}});
  }
  for (int i = 0; i < cells; ++i) {
    const std::string n = std::to_string(i);
    const int coupler = m.add({.name = "coupler " + n,
                               .mass = 1,
                               .inertia = 1. / 12,
                               .pose = {i + 0.5 + e.x, e.y, 0},
                               .velocity = {-spin * e.y, spin * e.x, 0}});
    m.add("left " + n, Revolute{.body_a = i + 1, .body_b = coupler, .p_a = {0.5, 0}, .p_b = {-0.5, 0}});
    m.add("right " + n, Revolute{.body_a = i + 2, .body_b = coupler, .p_a = {0.5, 0}, .p_b = {0.5, 0}});
  }
  return m;
}

/// Runs until `end`, asks `check` after every step; returns what stopped it, or nothing.
template <class Check>
std::string run(Machine& machine, double h, double end, Check check) {
  try {
    while (machine.time() < end - h / 2) {
      machine.advance(h);
      check();
      if (testing::Test::HasFailure()) return "wrong branch";
    }
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// A stop is honest when it says when, where and between which joints. CVODE may stop: its dense output knows only the
/// independent coordinates, and exactly on the pose the others do not follow from them.
void expect_passed_or_honest(const std::string& text, IntegratorKind by, double at_least) {
  if (text.empty()) return;
  EXPECT_EQ(by, IntegratorKind::cvode) << text;
  ASSERT_EQ(text.find("singular pose at t = "), 0U) << text;
  EXPECT_NE(text.find("joint '"), std::string::npos) << text;
  EXPECT_GT(std::stod(text.substr(21)), at_least) << text;
}

/// A speed of the crank and who integrates.
class Crank : public testing::TestWithParam<std::tuple<double, IntegratorKind>> {
 protected:
  double speed() const { return std::get<0>(GetParam()); }
  MachineOptions options() const { return {.integrator = std::get<1>(GetParam()), .ida = {1e-8, 1e-8}}; }
};

// The driven crank passes the flat pose, over it and (speed 1) exactly on it. Beyond it the crossed linkage closes as
// well: there the other crank would turn back. One constraint is lost over the singular pose to second order only, so
// poses keep rounding at a distance from it, and 1e-6 in it.
TEST_P(Crank, ParallelogramThroughTheFlatPose) {
  Model m = parallelograms(1, -0.5, speed());
  m.add("motor", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = speed()}});
  Machine machine(m, options());
  machine.start_from_pose();
  const std::string stop = run(machine, 1e-3, 1.0, [&] {
    const double phi = -0.5 + speed() * machine.time(), bound = std::abs(phi) > 0.01 ? 1e-9 : 1e-6;
    EXPECT_NEAR(machine.body(2).angle, phi, bound) << "t = " << machine.time();
    EXPECT_NEAR(machine.body(3).angle, 0, bound) << "t = " << machine.time();
  });
  expect_passed_or_honest(stop, options().integrator, 0.49 / speed());
}

/// Crank and rod of equal lengths: with the crank upright the slider is under the crank's pin and could stay there.
Model equal_slider_crank(double r, double phi, double speed) {
  Model m;
  const Vec2 e{std::cos(phi), std::sin(phi)};
  m.add({.name = "crank", .mass = 1, .inertia = 0.01, .pose = {r / 2 * e.x, r / 2 * e.y, phi}});
  m.add({.name = "rod", .mass = 1, .inertia = 0.01, .pose = {1.5 * r * e.x, r / 2 * e.y, -phi}});
  m.add({.name = "slider", .mass = 1, .inertia = 0.01, .pose = {2 * r * e.x, 0, 0}});
  m.add("A", Revolute{.body_a = ground, .body_b = 1, .p_b = {-r / 2, 0}});
  m.add("B", Revolute{.body_a = 1, .body_b = 2, .p_a = {r / 2, 0}, .p_b = {-r / 2, 0}});
  m.add("C", Revolute{.body_a = 2, .body_b = 3, .p_a = {r / 2, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = 3});
  m.add("motor", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = speed}});
  return m;
}

TEST_P(Crank, EqualSliderCrankThroughTheUprightPose) {
  constexpr double r = 0.3;
  const double phi0 = pi / 2 - 0.5;
  const Model m = equal_slider_crank(r, phi0, speed());
  Machine machine(m, options());
  machine.start_from_pose();
  const std::string stop = run(machine, 1e-3, 1.0, [&] {
    const double phi = phi0 + speed() * machine.time(), bound = std::abs(phi - pi / 2) > 0.01 ? 1e-9 : 1e-6;
    EXPECT_NEAR(machine.body(3).r.x, 2 * r * std::cos(phi), bound) << "t = " << machine.time();
    EXPECT_NEAR(machine.body(2).angle, -phi, bound) << "t = " << machine.time();
  });
  expect_passed_or_honest(stop, options().integrator, 0.49 / speed());
}

// About the rod's upper pin, which turns evenly: the slider pin's vertical force on it is g/2 - 3 r w^2 sin(phi),
// finite in the upright pose as well. What watches look at between the ends of steps is that, to a hundredth of its
// largest.
TEST(SingularPoses, ReactionsBetweenStepsAreThoseOfThePose) {
  constexpr double r = 0.3, w = 7;
  const double phi0 = pi / 2 - 0.5;
  for (const IntegratorKind kind : {IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida}) {
    Machine machine(equal_slider_crank(r, phi0, w), {.integrator = kind});
    machine.keep_dense_output();
    machine.start_from_pose();
    Evaluation between = machine.evaluation();
    for (int i = 0; i < 200; ++i) {
      machine.advance(1e-3);
      for (const double share : {0.999, 0.76, 0.5, 0.23, 0.001}) {
        const double t = (i + share) * 1e-3;
        const Instant at = between.evaluate(machine.dense_output(), t);
        EXPECT_NEAR(machine.joint_reaction("C", at).fy, 9.81 / 2 - 3 * r * w * w * std::sin(phi0 + w * t), 0.44) << t;
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Speeds, Crank,
                         testing::Combine(testing::Values(1.0, 0.97, 1.31, 7.03),
                                          testing::Values(IntegratorKind::adams_moulton, IntegratorKind::cvode,
                                                          IntegratorKind::ida)));

// The N four-bar mechanism of the IFToMM benchmark library (A02): rods of 1 m and 1 kg, cranks upright, 1 m/s to the
// left at their tips, gravity; it swings through flat poses. All cranks turn alike, so one angle describes it:
//   ((n + 1)/3 + n) phi'' = -g cos(phi) ((n + 1)/2 + n)
test::OdeState turned(int cells, double end, double spin = 1) {
  const double n = cells;
  return test::solve_ode(
      [n](const auto& s, auto& d, double) {
        d = {s[1], -9.81 * std::cos(s[0]) * ((n + 1) / 2 + n) / ((n + 1) / 3 + n)};
      },
      {pi / 2, spin}, 0, end, 1e-13);
}

/// Largest energy error on the way (J); expects the cranks parallel and the angle of the end within `bound`.
double swing(int cells, double end, const MachineOptions& options, double bound) {
  Machine machine(parallelograms(cells, pi / 2, 1), options);
  machine.start_from_pose();
  EXPECT_EQ(machine.assembly().freedom, 1);
  double energy = 0;
  const std::string stop = run(machine, 1e-3, end, [&] {
    energy = std::max(energy, std::abs(machine.energy().balance()));
    for (int i = 2; i <= cells + 1; ++i)
      EXPECT_NEAR(machine.body(i).angle, machine.body(1).angle, 1e-6) << "t = " << machine.time();
  });
  EXPECT_EQ(stop, "");
  EXPECT_NEAR(machine.body(1).angle, turned(cells, end)[0], bound);
  return energy;
}

// Order 6 at 1 ms errs by some (w h)^6 = 1e-14 of its rates w of 5/s over 50 radian; what is left is rounding beside
// the flat poses, where each cell loses a rank: at 5e-3 rad, a step from them, 1e-16 of position is 1e-9 rad/s^2. The
// upright pose, passed at 1 rad/s where the speed below is 8 rad/s, magnifies errors with each of up to eight turns.
// The variable steps ask for 1e-10; they may leave a hundred times that in the energy of 47 J, and IDA a thousand
// times.
TEST(SingularPoses, FreeParallelogramsKeepTheirBranchAndTheirEnergy) {
  for (const int cells : {1, 2, 5}) {
    SCOPED_TRACE(cells);
    EXPECT_LT(swing(cells, 10, {.adams_moulton = {.order = 6}}, 1e-7), 1e-8 * cells);
    EXPECT_LT(swing(cells, 5, {.integrator = IntegratorKind::cvode, .cvode = {1e-10, 1e-10}}, 1e-6), 1e-7 * cells);
    EXPECT_LT(swing(cells, 5, {.integrator = IntegratorKind::ida, .ida = {1e-10, 1e-10}}, 1e-5), 1e-6 * cells);
  }
}

/// Two cranks of 0.2 m, or three, 1 kg each, under a coupler of 3 kg; upright at first. One angle describes it:
///   (n (0.01 + 0.01) + 0.12) phi'' = -9.81 (0.1 n + 0.6) cos(phi)
Model cranks_under_a_coupler(int n, double spin) {
  Model m;
  for (int i = 0; i < n; ++i) {
    const std::string name = "crank " + std::to_string(i);
    m.add({.name = name, .mass = 1, .inertia = 0.01, .pose = {0.25 * i, 0.1, 0}, .velocity = {-0.1 * spin, 0, spin}});
    m.add("base " + std::to_string(i),
          Revolute{.body_a = ground, .body_b = i + 1, .p_a = {0.25 * i, 0}, .p_b = {0, -0.1}});
  }
  const int coupler =
      m.add({.name = "coupler", .mass = 3, .inertia = 0.3, .pose = {0.25, 0.2, 0}, .velocity = {-0.2 * spin, 0, 0}});
  for (int i = 0; i < n; ++i)
    m.add("pin " + std::to_string(i),
          Revolute{.body_a = i + 1, .body_b = coupler, .p_a = {0, 0.1}, .p_b = {0.25 * i - 0.25, 0}});
  return m;
}

// Ten speeds, at which the automatic step falls on the flat poses in another way each: it must not shrink there, where
// it would begin again without its past. The upright pose magnifies what a pass leaves, at -4.5 rad/s the most.
TEST(SingularPoses, TurningParallelogramsGoOnByAdamsMoulton) {
  constexpr double end = 3;
  const auto expect = [&](int n, double spin) {
    SCOPED_TRACE(testing::Message() << n << " cranks at " << spin);
    Machine machine(cranks_under_a_coupler(n, spin), {.adams_moulton = {.error_per_second = 1e-6 / end}});
    machine.start_from_pose();
    EXPECT_EQ(run(machine, 1e-3, end, [] {}), "");
    const double inertia = 0.02 * n + 0.12, moment = 9.81 * (0.1 * n + 0.6);
    const auto exact = test::solve_ode(
        [&](const auto& s, auto& d, double) {
          d = {s[1], -moment / inertia * std::cos(s[0])};
        },
        {pi / 2, spin}, 0, end, 1e-13);
    EXPECT_NEAR(machine.body(1).angle, exact[0] - pi / 2, 3e-6);
  };
  for (const double spin : {-3.0, -4.5, -6.0, -7.3, -8.0, -9.0, -11.0, -14.0, -20.0, -45.0}) expect(2, spin);
  for (const double spin : {-3.0, -6.0, -8.0, -11.0, -14.0, -20.0}) expect(3, spin);
}

// Turning over, through a flat pose some twenty times, from speeds at which its steps fall on the poses in another way
// each. ida keeps some 1e-8 of angle a step; passes magnify nothing at these speeds.
TEST(SingularPoses, TurningParallelogramsGoOnByIda) {
  for (const double spin : {-9.5, -11.0, -13.0, -15.0, -17.0, -19.0, -21.0, -23.0, -25.0}) {
    SCOPED_TRACE(spin);
    Machine machine(parallelograms(1, pi / 2, spin), {.integrator = IntegratorKind::ida});
    machine.start_from_pose();
    EXPECT_EQ(run(machine, 1e-3, 2, [] {}), "");
    EXPECT_NEAR(machine.body(1).angle, turned(1, 2, spin)[0], 1e-5);
  }
}

// The right crank's upper pin bears half of the coupler's vertical force; about its base, J phi'' = -m g/2 cos(phi) -
// Fx sin(phi) + Fy cos(phi), so Fx grows as one over the sine: rows that fall between both ends of the step over a flat
// pose have that too, to a hundredth down to a sine of 1e-3.
TEST(SingularPoses, ReactionsBesideAFlatPoseAreThoseOfThePose) {
  constexpr double g = 9.81;
  for (const IntegratorKind kind : {IntegratorKind::cvode, IntegratorKind::ida}) {
    Machine machine(parallelograms(1, pi / 2, -15), {.integrator = kind});
    machine.start_from_pose();
    int near = 0;
    EXPECT_EQ(run(machine, 1e-3, 3,
                  [&] {
                    const double phi = machine.body(2).angle, spin = machine.body(2).omega;
                    const double c = std::cos(phi), s = std::sin(phi), turning = -1.2 * g * c;
                    if (std::abs(s) < 1e-3) return;
                    near += std::abs(s) < 0.02;
                    const double fy = -(turning * c - spin * spin * s + g) / 2;
                    const double fx = (fy * c - 0.5 * g * c - turning / 3) / s;
                    EXPECT_NEAR(machine.joint_reaction("right 0").fx, fx, 1e-2 * (10 + std::abs(fx)))
                        << machine.time() << " s, sine " << s;
                  }),
              "");
    EXPECT_GT(near, 10);
  }
}

/// Two cranks of 0.5 m and 0.5 kg, a coupler of 1 m and 1 kg, upright at 100 rad/s; `torque` (N m) on the first crank.
Model spinning(double torque) {
  Model m;
  const auto crank = [&](const char* name, double x) {
    return m.add({.name = name, .mass = 0.5, .inertia = 0.125 / 12, .pose = {x, 0.25, 0}, .velocity = {-25, 0, 100}});
  };
  const int first = crank("crank", 0), second = crank("rocker", 1);
  const int coupler =
      m.add({.name = "coupler", .mass = 1, .inertia = 1. / 12, .pose = {0.5, 0.5, 0}, .velocity = {-50, 0, 0}});
  m.add("A0", Revolute{.body_a = ground, .body_b = first, .p_b = {0, -0.25}});
  m.add("A", Revolute{.body_a = first, .body_b = coupler, .p_a = {0, 0.25}, .p_b = {-0.5, 0}});
  m.add("B", Revolute{.body_a = coupler, .body_b = second, .p_a = {0.5, 0}, .p_b = {0, 0.25}});
  m.add("B0", Revolute{.body_a = ground, .body_b = second, .p_a = {1, 0}, .p_b = {0, -0.25}});
  if (torque != 0) m.add("motor", AppliedForce{.body = first, .moment = torque});
  return m;
}

/// Its speed at the angle phi from upright by its energy: J spin^2/2 + G cos(phi) - torque phi, J = 1/3 kg m^2,
/// G = 0.75 kg m g.
double spin_at(double phi, double torque) {
  return std::sqrt(1e4 + 6 * (0.75 * 9.81 * (1 - std::cos(phi)) + torque * phi));
}

// Steps of 1/8 and 1/128 s are sums without rounding, so the instants are the same. Rows, what is looked at between
// them, and steps that are kept leave every bit of the motion as it is.
TEST(SingularPoses, WhatIsReadChangesNoBitOfTheMotion) {
  for (const IntegratorKind kind : {IntegratorKind::cvode, IntegratorKind::ida}) {
    const MachineOptions options{.integrator = kind, .ida = {1e-6, 1e-6}, .cvode = {1e-8, 1e-8}};
    std::vector<std::vector<double>> seen;
    for (const double h : {1. / 8, 1. / 128, 1. / 1024}) {
      Machine machine(spinning(0), options);
      if (h < 0.1) machine.keep_dense_output();
      machine.start_from_pose();
      Evaluation between = machine.evaluation();
      std::vector<double> eighths;
      for (int i = 1; i <= std::lround(1 / h); ++i) {
        machine.advance(h);
        if (h < 0.1) between.evaluate(machine.dense_output(), machine.time() - 0.3 * h);
        if (std::fmod(machine.time(), 0.125) == 0) eighths.push_back(machine.body(1).angle);
      }
      seen.push_back(eighths);
    }
    ASSERT_EQ(seen[0].size(), 8U);
    EXPECT_EQ(seen[0], seen[1]);
    EXPECT_EQ(seen[0], seen[2]);
  }
}

// The speed by the energy, whatever the tolerance. A step is held to a hundredth of the tolerance, of velocities of 50
// m/s; some 3000 steps in 95 passes of the flat pose add up to less than 300 times the tolerance of the spin. At 1e-12
// rounding over the square of the distance of 0.1 rad is what is left of 100 rad/s.
TEST(SingularPoses, ASpinningParallelogramKeepsItsSpeedAtEveryTolerance) {
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    Machine machine(spinning(0), {.integrator = IntegratorKind::cvode, .cvode = {tolerance, tolerance}});
    machine.start_from_pose();
    EXPECT_EQ(run(machine, 0.0371, 3,
                  [&] {
                    EXPECT_NEAR(machine.body(1).omega, spin_at(machine.body(1).angle, 0), 300 * tolerance + 1e-7)
                        << "tolerance " << tolerance << ", t = " << machine.time();
                  }),
              "");
  }
}

// Under 1000 N m to 3000 rad/s, by default: 1.5 MJ, to the warning's limit over a thousand.
TEST(SingularPoses, ADrivenParallelogramKeepsItsEnergyUpTo3000RadiansPerSecond) {
  Machine machine(spinning(1000), {.integrator = IntegratorKind::cvode, .cvode = {1e-12, 1e-12}});
  machine.start_from_pose();
  EXPECT_EQ(run(machine, 0.01, 0.9667, [&] {}), "");
  const double spin = machine.body(1).omega;
  EXPECT_GT(spin, 2900);
  EXPECT_NEAR(spin, spin_at(machine.body(1).angle, 1000), 1e-6 * spin);
}

// The same by ida from 600 rad/s on, where steps collapse by rounding up to half a radian behind a flat pose: 6 turns,
// 12 of them. A step is held to 1e-8 of the speed; a thousand add up.
TEST(SingularPoses, IdaPassesTheFlatPosesOfADrivenParallelogramAt600RadiansPerSecond) {
  Model m = spinning(1000);
  for (Body& body : m.bodies)
    for (double& v : body.velocity) v *= 6;
  Machine machine(m, {.integrator = IntegratorKind::ida, .ida = {1e-6, 1e-8}});
  machine.start_from_pose();
  EXPECT_EQ(run(machine, 0.01, 0.06, [&] {}), "");
  EXPECT_LT(machine.energy().closure(), 1e-4);
}

// A pose that is passed at a located place, by one step that no tolerance chooses: errors fall with the tolerance over
// nine decades, to the rounding that the pass leaves, some 1e-9 of the energy of 72 J. Each decade brings half a decade
// at least from the one two before.
TEST(SingularPoses, ErrorsFallWithTheTolerance) {
  for (const IntegratorKind kind : {IntegratorKind::cvode, IntegratorKind::ida}) {
    std::vector<double> errors;
    for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11}) {
      if (kind == IntegratorKind::ida && tolerance < 1e-10) break;  // backward differences of order 5: minutes
      Machine machine(parallelograms(2, pi / 2, 1),
                      {.integrator = kind, .ida = {tolerance, tolerance}, .cvode = {tolerance, tolerance}});
      machine.start_from_pose();
      double energy = 0;
      ASSERT_EQ(run(machine, 1e-2, 5, [&] { energy = std::max(energy, std::abs(machine.energy().balance())); }), "")
          << tolerance;
      errors.push_back(energy);
    }
    for (std::size_t i = 2; i < errors.size(); ++i)
      EXPECT_LT(errors[i], std::max(0.3 * errors[i - 2], 1e-7)) << "tolerance 1e-" << i + 4;
    EXPECT_LT(errors.back(), 1e-4 * errors.front());
  }
}

// The benchmark's own size and duration: forty windows, 10 s, energy within 0.1 J. Forty ranks are lost at once.
TEST(SingularPoses, FortyWindowsAreFarWithinTheBenchmark) {
  EXPECT_LT(swing(40, 10, {.adams_moulton = {.order = 6}}, 1e-4), 1e-4);
}

}  // namespace
}  // namespace subsoil::mbd::singular_poses_test
