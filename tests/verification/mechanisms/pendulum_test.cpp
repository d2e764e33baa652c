// Simple and double pendulum against the elliptic-integral solution and against minimal coordinates.

#include <gtest/gtest.h>

#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>
#include <numbers>

#include "libmbd/joints/revolute.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/reference_ode.hpp"

namespace subsoil::mbd::pendulum_test {
namespace {

constexpr double g = 9.81, mass = 2.0, inertia = 0.3, arm = 0.8;

/// A bar hung at the origin, released at rest at an angle from hanging. The body's angle is that from hanging.
Model pendulum(double angle) {
  Model m;
  const int bar = m.add({.name = "bar",
                         .mass = mass,
                         .inertia = inertia,
                         .pose = {arm * std::sin(angle), -arm * std::cos(angle), angle}});
  m.add("pin", Revolute{.body_a = ground, .body_b = bar, .p_a = {0, 0}, .p_b = {0, arm}});
  return m;
}

/// theta(t) after release at rest at theta_0: sin(theta/2) = k cd(omega t, k), k = sin(theta_0/2).
double exact_angle(double theta_0, double t) {
  const double omega = std::sqrt(mass * g * arm / (inertia + mass * arm * arm)), k = std::sin(theta_0 / 2);
  double cn = 0, dn = 0;
  boost::math::jacobi_elliptic(k, omega * t, &cn, &dn);
  return 2 * std::asin(k * cn / dn);
}

double run(Model model, double end, double h, MachineOptions options, Machine** keep = nullptr) {
  auto machine = std::make_unique<Machine>(std::move(model), options);
  machine->start_from_pose();
  for (long i = 0; i < std::lround(end / h); ++i) machine->advance(h);
  const double angle = machine->body(1).angle;
  if (keep) *keep = machine.release();
  return angle;
}

class Swing : public testing::TestWithParam<double> {};

// Global error of order 4 is about (251/720)(omega h)^4 omega t times higher derivatives of the motion (some ten at
// 90 deg): (3.1e-3)^4 * 31 * 10 = 3e-8; at h/1 below that. Ten times less is seen; 1e-7 rules out any wrong term.
TEST_P(Swing, FollowsEllipticSolutionForTenSeconds) {
  const double theta_0 = GetParam();
  Machine* machine = nullptr;
  const double angle = run(pendulum(theta_0), 10, 1e-3, {}, &machine);
  const std::unique_ptr<Machine> owner(machine);
  EXPECT_NEAR(angle, exact_angle(theta_0, 10), 1e-7);
  EXPECT_NEAR(machine->energy().balance(), 0, 1e-7 * mass * g * arm);
  EXPECT_LT(machine->integrator().partition().residual(), 1e-12 * arm);
}

// IDA controls the local error: 10 s are some 3000 steps of rtol each.
TEST_P(Swing, IdaFollowsIt) {
  const double theta_0 = GetParam();
  const MachineOptions options{.integrator = IntegratorKind::ida, .ida = {.rtol = 1e-10, .atol = 1e-10}};
  EXPECT_NEAR(run(pendulum(theta_0), 10, 0.1, options), exact_angle(theta_0, 10), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(SmallAndLarge, Swing, testing::Values(0.05, std::numbers::pi / 2));

TEST(Pendulum, ReactionAtTheLowestPointCarriesWeightAndCentripetalForce) {
  Machine machine(pendulum(0));
  machine.start_from_pose();
  EXPECT_NEAR(machine.joint_reaction("pin").fy, -mass * g, 1e-12 * mass * g);  // on the ground, its first body
  Model moving = pendulum(0);
  moving.bodies[0].velocity = {2.0 * arm, 0, 2.0};
  Machine swung(moving);
  swung.start_from_pose();
  EXPECT_NEAR(swung.joint_reaction("pin").fy, -mass * (g + 4.0 * arm), 1e-11 * mass * g);
  EXPECT_NEAR(swung.joint_reaction("pin").moment, 0, 1e-12);
}

struct DoublePendulum {
  double m1 = 1.5, j1 = 0.05, l1 = 0.6, a1 = 0.35, m2 = 0.9, j2 = 0.02, a2 = 0.25;

  Model model(double t1, double t2) const {
    Model m;
    const int upper =
        m.add({.name = "upper", .mass = m1, .inertia = j1, .pose = {a1 * std::sin(t1), -a1 * std::cos(t1), t1}});
    const int lower =
        m.add({.name = "lower",
               .mass = m2,
               .inertia = j2,
               .pose = {l1 * std::sin(t1) + a2 * std::sin(t2), -l1 * std::cos(t1) - a2 * std::cos(t2), t2}});
    m.add("shoulder", Revolute{.body_a = ground, .body_b = upper, .p_a = {0, 0}, .p_b = {0, a1}});
    m.add("elbow", Revolute{.body_a = upper, .body_b = lower, .p_a = {0, a1 - l1}, .p_b = {0, a2}});
    return m;
  }

  /// Lagrange's equations in the two angles from hanging.
  void right(const test::OdeState& y, test::OdeState& d) const {
    const double c = std::cos(y[0] - y[1]), s = std::sin(y[0] - y[1]), b = m2 * l1 * a2;
    const double m11 = j1 + m1 * a1 * a1 + m2 * l1 * l1, m12 = b * c, m22 = j2 + m2 * a2 * a2;
    const double f1 = -b * s * y[3] * y[3] - (m1 * a1 + m2 * l1) * g * std::sin(y[0]);
    const double f2 = b * s * y[2] * y[2] - m2 * a2 * g * std::sin(y[1]);
    const double det = m11 * m22 - m12 * m12;
    d = {y[2], y[3], (m22 * f1 - m12 * f2) / det, (m11 * f2 - m12 * f1) / det};
  }
};

class TwoBars : public testing::TestWithParam<std::array<double, 3>> {};

// Order 6 at h = 0.2 ms has (omega h)^6 = 1e-14 for omega up to 20 rad/s; the motion of the large swing is sensitive
// and magnifies rounding by some 1e3 in 3 s. The tolerance stays a hundred times above both.
TEST_P(TwoBars, FollowMinimalCoordinates) {
  const auto [t1, t2, tolerance] = GetParam();
  const DoublePendulum p;
  Machine machine(p.model(t1, t2), {.adams_moulton = {.order = 6}});
  machine.start_from_pose();
  for (int i = 0; i < 15000; ++i) machine.advance(2e-4);
  const auto y = test::solve_ode([&](const auto& s, auto& d, double) { p.right(s, d); }, {t1, t2, 0, 0}, 0, 3.0);
  EXPECT_NEAR(machine.body(1).angle, y[0], tolerance);
  EXPECT_NEAR(machine.body(2).angle, y[1], tolerance);
  EXPECT_NEAR(machine.body(1).omega, y[2], 20 * tolerance);
  EXPECT_NEAR(machine.body(2).omega, y[3], 20 * tolerance);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(SmallAndLarge, TwoBars,
                         testing::Values(std::array{0.05, -0.03, 1e-11}, std::array{1.6, 2.3, 1e-8}));

}  // namespace
}  // namespace subsoil::mbd::pendulum_test
