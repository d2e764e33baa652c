// Four-bar linkage (crank-rocker) at constant crank speed: rocker angle by Freudenstein's equation, crank torque by
// inverse dynamics of the closed form.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::four_bar_test {
namespace {

constexpr double crank = 0.2, coupler = 0.7, rocker = 0.5, base = 0.6, speed = 7.0, g = 9.81;
constexpr double masses[3] = {1.2, 2.5, 1.7}, inertias[3] = {0.01, 0.11, 0.05};

struct Angles {
  double crank, coupler, rocker;
};

/// Freudenstein: K1 cos(psi) - K2 cos(phi) + K3 = cos(phi - psi), open branch.
Angles freudenstein(double phi) {
  const double k1 = base / crank, k2 = base / rocker,
               k3 = (crank * crank - coupler * coupler + rocker * rocker + base * base) / (2 * crank * rocker);
  const double qa = std::cos(phi) - k1 - k2 * std::cos(phi) + k3, qb = -2 * std::sin(phi),
               qc = k1 - (k2 + 1) * std::cos(phi) + k3;
  const double psi = 2 * std::atan2(-qb - std::sqrt(qb * qb - 4 * qa * qc), 2 * qa);
  const double x = base + rocker * std::cos(psi) - crank * std::cos(phi),
               y = rocker * std::sin(psi) - crank * std::sin(phi);
  return {phi, std::atan2(y, x), psi};
}

/// Centre of gravity and angle of the three links (each uniform: its middle).
std::array<std::array<double, 3>, 3> poses(double phi) {
  const Angles t = freudenstein(phi);
  return {{{crank / 2 * std::cos(phi), crank / 2 * std::sin(phi), phi},
           {crank * std::cos(phi) + coupler / 2 * std::cos(t.coupler),
            crank * std::sin(phi) + coupler / 2 * std::sin(t.coupler), t.coupler},
           {base + rocker / 2 * std::cos(t.rocker), rocker / 2 * std::sin(t.rocker), t.rocker}}};
}

/// Torque on the crank from the power of inertia and weight; derivatives by 7-point differences of the closed form
/// (error h^6: 1e-12 at h = 0.01 rad; rounding 1e-16/h^2 = 1e-12).
double inverse_dynamics_torque(double phi) {
  constexpr double h = 0.01, first[3] = {3. / 4, -3. / 20, 1. / 60}, second[3] = {3. / 2, -3. / 20, 1. / 90};
  const auto mid = poses(phi);
  double power = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      double rate = 0, curve = -49. / 18 * mid[i][k];
      for (int s = 1; s <= 3; ++s) {
        const double plus = poses(phi + s * h)[i][k], minus = poses(phi - s * h)[i][k];
        rate += first[s - 1] * (plus - minus);
        curve += second[s - 1] * (plus + minus);
      }
      rate *= speed / h, curve *= speed * speed / (h * h);
      const double inertia = k < 2 ? masses[i] : inertias[i], weight = k == 1 ? masses[i] * g : 0;
      power += (inertia * curve + weight) * rate;
    }
  return power / speed;
}

Model four_bar(double phi) {
  Model m;
  const auto start = poses(phi);
  const char* names[3] = {"crank", "coupler", "rocker"};
  for (std::size_t i = 0; i < 3; ++i)
    m.add({.name = names[i], .mass = masses[i], .inertia = inertias[i], .pose = start[i]});
  m.add("A", Revolute{.body_a = ground, .body_b = 1, .p_a = {0, 0}, .p_b = {-crank / 2, 0}});
  m.add("B", Revolute{.body_a = 1, .body_b = 2, .p_a = {crank / 2, 0}, .p_b = {-coupler / 2, 0}});
  m.add("C", Revolute{.body_a = 2, .body_b = 3, .p_a = {coupler / 2, 0}, .p_b = {rocker / 2, 0}});
  m.add("D", Revolute{.body_a = 3, .body_b = ground, .p_a = {-rocker / 2, 0}, .p_b = {base, 0}});
  m.add("motor", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = speed}});
  return m;
}

// Kinematics is solved to rounding at each output; the torque's oracle carries 1e-11 of differences times forces of
// some 100 N.
TEST(FourBar, FreudensteinAndTorqueOverTwoTurns) {
  Machine machine(four_bar(0.3));
  const auto& report = machine.start_from_pose();
  EXPECT_EQ(report.freedom, 0);
  for (int i = 0; i < 90; ++i) {
    const double phi = 0.3 + speed * machine.time();
    const Angles t = freudenstein(phi);
    ASSERT_NEAR(machine.body(1).angle, phi, 1e-12);
    ASSERT_NEAR(std::remainder(machine.body(3).angle - t.rocker, 2 * std::numbers::pi), 0, 1e-12);
    ASSERT_NEAR(std::remainder(machine.body(2).angle - t.coupler, 2 * std::numbers::pi), 0, 1e-12);
    ASSERT_NEAR(machine.driver_force("motor"), inverse_dynamics_torque(phi), 1e-6) << "crank at " << phi;
    for (int s = 0; s < 20; ++s) machine.advance(1e-3);
  }
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-8);  // the driver's work makes the speed's swing
}

TEST(FourBar, AssemblesFromARoughGuess) {
  Model rough = four_bar(0.3);
  const auto exact = poses(0.3);
  for (std::size_t i = 1; i < 3; ++i)
    rough.bodies[i].pose = {exact[i][0] + 0.04, exact[i][1] - 0.06, exact[i][2] + 0.15};
  Machine machine(rough);
  const auto& report = machine.start_from_pose();
  EXPECT_LT(report.residual, 1e-13);
  EXPECT_GT(report.moved, 0.05);
  EXPECT_NEAR(machine.body(3).angle, exact[2][2], 1e-12);
  EXPECT_NEAR(machine.body(1).omega, speed, 1e-12);
}

/// A triple rocker (shortest + longest link > the other two): no link turns through, each angle has turning points.
Model triple_rocker(double spin) {
  constexpr double base_length = 0.80, a = 0.30, b = 0.35, c = 0.28, phi = 0.4;
  const Vec2 pin_b{a * std::cos(phi), a * std::sin(phi)}, span = Vec2{base_length, 0} - pin_b;
  const double d = length(span), along = (b * b - c * c + d * d) / (2 * d), aside = std::sqrt(b * b - along * along);
  const Vec2 pin_c = pin_b + (along / d) * span + (aside / d) * turned(span);
  const auto middle = [](Vec2 from, Vec2 to) {
    return std::array<double, 3>{(from.x + to.x) / 2, (from.y + to.y) / 2, std::atan2(to.y - from.y, to.x - from.x)};
  };
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "crank",
         .mass = 1,
         .inertia = 0.01,
         .pose = middle({0, 0}, pin_b),
         .velocity = {-spin * pin_b.y / 2, spin * pin_b.x / 2, spin}});
  m.add({.name = "coupler", .mass = 1, .inertia = 0.01, .pose = middle(pin_b, pin_c)});
  m.add({.name = "rocker", .mass = 1, .inertia = 0.01, .pose = middle({base_length, 0}, pin_c)});
  m.add("A", Revolute{.body_a = ground, .body_b = 1, .p_a = {0, 0}, .p_b = {-a / 2, 0}});
  m.add("B", Revolute{.body_a = 1, .body_b = 2, .p_a = {a / 2, 0}, .p_b = {-b / 2, 0}});
  m.add("C", Revolute{.body_a = 2, .body_b = 3, .p_a = {b / 2, 0}, .p_b = {c / 2, 0}});
  m.add("D", Revolute{.body_a = 3, .body_b = ground, .p_a = {-c / 2, 0}, .p_b = {base_length, 0}});
  return m;
}

// At the turning point of an angle everything else is singular in it, and each angle of a triple rocker has two per
// cycle: no choice lasts a cycle. Phi stays at rounding, and no energy is lost where the choice changes hands: order 6
// at 1e-4 s leaves 1e-9 of it.
TEST(FourBar, PartitionSwitchesAtTurningPoints) {
  Machine machine(triple_rocker(10), {.adams_moulton = {.order = 6}});
  machine.start_from_pose();
  ASSERT_EQ(machine.assembly().freedom, 1);
  const int first = machine.integrator().partition().independent()[0];
  double worst = 0, before = machine.body(1).omega;
  int turns = 0, others = 0;
  for (int i = 0; i < 30000; ++i) {
    machine.advance(1e-4);
    worst = std::max(worst, machine.integrator().partition().residual());
    turns += machine.body(1).omega * before < 0;
    others += machine.integrator().partition().independent()[0] != first;
    before = machine.body(1).omega;
  }
  EXPECT_GT(turns, 5);
  EXPECT_GT(machine.partition_choices(), turns / 2);
  EXPECT_GT(others, 100);
  EXPECT_LT(worst, 1e-12 * 0.18);  // of the longest lever
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-9 * machine.energy().kinetic);
}

}  // namespace
}  // namespace subsoil::mbd::four_bar_test
