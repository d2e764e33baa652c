// What comes and goes inside one long step of a machine at rest: friction beyond its limit, a reaction above its value,
// a gap that a driver closes.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/elements.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/forces/joint_friction.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/integrators/adaptive.hpp"
#include "libmbd/joints/fixed.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::hidden_slip_test {
namespace {

constexpr double mass = 10, mu = 0.3;

ExpressionFunction formula(const std::function<double(double)>& value, const std::function<double(double)>& first = {},
                           const std::function<double(double)>& second = {}) {
  const std::function<double(double)> none = [](double) { return 0.0; };
  return {.text = "f",
          .unit = "1",
          .value_ = value,
          .first_ = first ? first : none,
          .second_ = second ? second : none,
          .integral_ = none,
          .double_integral_ = none};
}

/// Half a sine of 1 that begins at `begin`, 0 beside it.
std::function<double(double)> half_sine(double begin, double width) {
  return [=](double t) {
    const double s = (t - begin) / width;
    return s > 0 && s < 1 ? std::sin(std::numbers::pi * s) : 0.0;
  };
}

class HiddenSlip : public testing::TestWithParam<IntegratorKind> {
 protected:
  Machine machine(Model m) const {
    return Machine(std::move(m), {.integrator = GetParam(), .adams_moulton = {.error_per_second = 1e-7}});
  }
  /// Adams-Moulton tests the margins of friction and gaps at the ends of its steps, here of 1 ms.
  bool fixed_steps() const { return GetParam() == IntegratorKind::adams_moulton; }
  void run(Machine& machine, double end) const {
    machine.start_from_pose();
    if (!fixed_steps()) return machine.advance_to(end);
    for (long i = 1; i <= std::lround(end / 1e-3); ++i) machine.advance_to(static_cast<double>(i) * 1e-3);
  }
};
INSTANTIATE_TEST_SUITE_P(All, HiddenSlip,
                         testing::Values(IntegratorKind::cvode, IntegratorKind::ida, IntegratorKind::adams_moulton));

/// A block that friction holds on a slide without gravity, pushed along it by 5 N at least and pressed by 100 N at
/// most.
Model held_block(Function along, Function across) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "block", .mass = mass, .inertia = 0.3});
  m.add("slide", Translational{.body_a = ground, .body_b = 1});
  m.add("friction", JointFriction{.joint = "slide", .guide = 0.5, .mu_s = mu, .mu_k = mu, .stick_stiffness = 1e6});
  m.add("push", AppliedForce{.body = 1, .fx = std::move(along), .fy = std::move(across)});
  return m;
}

struct Slip {
  double begin, end, way;
  double within = 1e-9;  // s
};
/// The same with rigid surfaces, m v' = 5 N - mu N, in steps of 1e-6 of [from, until].
Slip rigid_slip(const std::function<double(double)>& normal, double push, double from, double until) {
  constexpr int parts = 1'000'000;
  const double dt = (until - from) / parts;
  Slip out{NAN, NAN, 0, 1.01 * dt};
  double v = 0;
  for (int k = 0; k < parts; ++k) {
    const double t = from + (k + 0.5) * dt, a = (push - mu * std::abs(normal(t))) / mass;
    if (std::isnan(out.begin) && a > 0) out.begin = t;
    if (std::isnan(out.begin) || !std::isnan(out.end)) continue;
    if (v + a * dt < 0) out.end = t;
    out.way += dt * std::max(v + 0.5 * a * dt, 0.0), v = std::max(v + a * dt, 0.0);
  }
  return out;
}

void expect_slip(const Machine& machine, const Slip& right, const char* what) {
  ASSERT_EQ(machine.events().size(), 2U) << what;
  EXPECT_NEAR(machine.events()[0].t, right.begin, right.within) << what;
  EXPECT_NEAR(machine.events()[1].t, right.end, 2 * right.within) << what;
  // The strain that the surfaces had, 5 N over 1 MN/m, is slid first; ida's tolerance is of 1e-10 m.
  EXPECT_NEAR(machine.body(1).r.x, right.way, 2e-3 * right.way + 1e-11) << what;
}

// |-100 N + 200 N/s t| is below 5 N/mu for 1/6 s. Closed form: a = 0.5 - 6 |t - 0.5|.
TEST_P(HiddenSlip, WhatPressesPassesZero) {
  Machine m = machine(held_block(5, PolynomialFunction{{-100, 200}}));
  run(m, 1);
  const double after = (0.5 + std::sqrt(0.5)) / 6, before = 1.0 / 12;
  const double way =
      0.25 * (after * after - before * before) + std::pow(before, 3) - std::pow(after, 3) + (after + before) / 48;
  expect_slip(m, {0.5 - before, 0.5 + after, way}, "linear");
}

// Formulas, tables, harmonics and polynomials press, whose minimum lies anywhere in the run.
TEST_P(HiddenSlip, WhatPressesComesBack) {
  const auto pulse = [](double width) { return [f = half_sine(5.2, width)](double t) { return 100 * (f(t) - 1); }; };
  const PolynomialFunction quartic{{-100, 100, -35, 5, -0.25}}, parabola{{-100, 39, -3.9}};
  const HarmonicFunction harmonic{.mean = -60, .amplitude = 50, .frequency = 0.1};
  const TableFunction table({0, 5, 5.01, 5.02}, {-100, -100, -3, -100}, false, Between::linear);
  struct Case {
    const char* what;
    Function normal;
    double from, until, push = 5, narrowest = 1e-2;
  };
  const Case cases[] = {{"half-sine of 0.2 s", formula(pulse(0.2)), 5.2, 5.4},
                        {"half-sine of 20 ms", formula(pulse(0.02)), 5.2, 5.22},
                        {"half-sine of 0.5 ms", formula(pulse(5e-4)), 5.2, 5.2005, 5, 5e-4},
                        {"table", table, 4.99, 5.03},
                        {"harmonic", harmonic, 0, 9},
                        {"parabola", parabola, 0, 10},
                        {"quartic", quartic, 0, 10, 2},
                        {"narrow zero", PolynomialFunction{{-100, 20}}, 4.99, 5.01, 0.005, 1e-3}};
  for (const Case& c : cases) {
    if (fixed_steps() && c.narrowest < 5e-3) continue;
    Machine m = machine(held_block(c.push, c.normal));
    run(m, 10);
    expect_slip(m, rigid_slip([&](double t) { return c.normal.value(t); }, c.push, c.from, c.until), c.what);
  }
}

// Pushes that pass the limit: the surfaces give way by their spring first, so the three methods are compared with the
// same in steps of 10 us.
TEST_P(HiddenSlip, PushComesAndGoes) {
  for (const double width : {0.2, 0.02, 0.004}) {
    const auto push = [f = half_sine(5.2, width)](double t) { return 5 + 60 * f(t); };
    Machine m = machine(held_block(formula(push), -100)), fine(held_block(formula(push), -100), {});
    run(m, 6);
    fine.start_from_pose();
    for (int i = 1; i <= 6000; ++i)
      for (int k = 1; k <= (i > 5200 && i < 5500 ? 100 : 1); ++k)
        fine.advance_to(1e-3 * (i > 5200 && i < 5500 ? i - 1 + k / 100.0 : i));
    ASSERT_EQ(fine.events().size(), 2U);
    expect_slip(m, {fine.events()[0].t, fine.events()[1].t, fine.body(1).r.x, 1e-6}, "push");
  }
}

// A weld bears |F|, above 50 N from 1/6 of a half-sine of 100 N on: at rest, without a freedom.
TEST_P(HiddenSlip, ReactionPassesItsLimit) {
  for (const double width : {0.2, 0.02, 0.002}) {
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "block", .mass = mass, .inertia = 0.3});
    m.add("weld", Fixed{.body_a = ground, .body_b = 1});
    m.add("push", AppliedForce{.body = 1, .fx = formula([f = half_sine(5.2, width)](double t) { return 100 * f(t); })});
    m.add("breaks", JointEvent{.joint = "weld", .does = JointEvent::Does::opens, .reaction_above = 50});
    Machine broken = machine(std::move(m));
    run(broken, 10);
    ASSERT_EQ(broken.events().size(), 1U) << width;
    EXPECT_NEAR(broken.events()[0].t, 5.2 + width / 6, 1e-9) << width;
  }
}

// A follower that is driven down by 5 mm and back closes a gap of 3 mm.
TEST_P(HiddenSlip, DrivenFollowerClosesItsGap) {
  constexpr double pi = std::numbers::pi;
  for (const double width : {0.2, 0.02, 0.002}) {
    if (fixed_steps() && width < 5e-3) continue;
    const auto within = [=](double t) { return t > 5.2 && t < 5.2 + width; };
    // 64 p^3 with p = x (1 - x): acceleration without jumps.
    const auto dip = [=](double t) {
      const double x = within(t) ? (t - 5.2) / width : 0, p = x * (1 - x);
      return -5e-3 * 64 * p * p * p;
    };
    const auto rate = [=](double t) {
      const double x = within(t) ? (t - 5.2) / width : 0, p = x * (1 - x);
      return -5e-3 * 192 * p * p * (1 - 2 * x) / width;
    };
    const auto second = [=](double t) {
      const double x = within(t) ? (t - 5.2) / width : 0, p = x * (1 - x);
      return -5e-3 * 384 * p * ((1 - 2 * x) * (1 - 2 * x) - p) / (width * width);
    };
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "follower", .mass = 1, .inertia = 0.1, .pose = {0, 3e-3, 0}});
    m.add("guide", Translational{.body_a = ground, .body_b = 1, .angle_a = pi / 2});
    CoordinateDriver driver{.body = 1, .coordinate = Coordinate::y};
    driver.motion.position = formula([=](double t) { return 3e-3 + dip(t); }, rate, second);
    m.add("cam", driver);
    m.add("floor", LineContact{.body_a = ground, .body_b = 1, .law = {.normal = {.stiffness = 1e4}}});
    Machine closed = machine(std::move(m));
    run(closed, 10);
    ASSERT_EQ(closed.events().size(), 2U) << width;
    const double closes = width * 0.5 * (1 - std::sqrt(1 - 4 * std::cbrt(0.6 / 64)));
    EXPECT_NEAR(closed.events()[0].t, 5.2 + closes, 1e-8) << width;
    EXPECT_NEAR(closed.events()[1].t, 5.2 + width - closes, 1e-8) << width;
  }
}

// Margins are looked at between the ends of steps, which stay as long as they are.
TEST_P(HiddenSlip, RestCostsNoSteps) {
  if (fixed_steps()) GTEST_SKIP() << "steps of a fixed length";
  Machine m = machine(held_block(5, PolynomialFunction{{-100, -1e-3, -1e-6}}));
  run(m, 1e4);
  EXPECT_TRUE(m.events().empty());
  EXPECT_LT(dynamic_cast<const Adaptive&>(m.integrator()).steps(), 500);
}

}  // namespace
}  // namespace subsoil::mbd::hidden_slip_test
