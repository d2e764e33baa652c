// Slider-cranks whose slider weighs a million times their crank: at a dead centre the slider rests and the crank alone
// carries the energy, a thousand times as fast as elsewhere.

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <numbers>

#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::mass_ratio_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double r = 0.1, l = 0.3;           // m; crank, rod
constexpr double light = 1e-3, heavy = 1e3;  // kg; crank and rod, slider
constexpr double begin = pi / 3, spin = 5;   // rad, rad/s

double rod_angle(double theta) { return std::asin(-r * std::sin(theta) / l); }
double slider(double theta) { return r * std::cos(theta) + l * std::cos(rod_angle(theta)); }

/// T = J(theta) theta'^2 / 2, from the closed kinematics of the mechanism.
double inertia(double theta) {
  const double phi = rod_angle(theta), turn = -r * std::cos(theta) / (l * std::cos(phi));
  const double x = -r * std::sin(theta) - l * std::sin(phi) * turn;  // of the slider, per theta
  const double gx = -r * std::sin(theta) - l / 2 * std::sin(phi) * turn, gy = r * std::cos(theta) / 2;
  return light * (r * r / 12 + r * r / 4) + light * (gx * gx + gy * gy + l * l / 12 * turn * turn) + heavy * x * x;
}

Model slider_crank() {
  Model m;
  m.gravity = {0, 0};
  const Vec2 a{r * std::cos(begin), r * std::sin(begin)};
  const double phi = rod_angle(begin), x = slider(begin);
  m.add({.name = "crank",
         .mass = light,
         .inertia = light * r * r / 12,
         .pose = {a.x / 2, a.y / 2, begin},
         .velocity = {-spin * a.y / 2, spin * a.x / 2, spin}});
  m.add({.name = "rod", .mass = light, .inertia = light * l * l / 12, .pose = {(a.x + x) / 2, a.y / 2, phi}});
  m.add({.name = "slider", .mass = heavy, .inertia = 1, .pose = {x, 0, 0}});
  m.add("o", Revolute{.body_a = ground, .body_b = 1, .p_b = {-r / 2, 0}});
  m.add("a", Revolute{.body_a = 1, .body_b = 2, .p_a = {r / 2, 0}, .p_b = {-l / 2, 0}});
  m.add("b", Revolute{.body_a = 2, .body_b = 3, .p_a = {l / 2, 0}});
  m.add("g", Translational{.body_a = ground, .body_b = 3});
  return m;
}

/// Time from theta = a to b: the integral of sqrt(J/2E), whose valleys of 1e-3 rad lie at the dead centres.
double time_between(double a, double b) {
  const double twice_energy = inertia(begin) * spin * spin;
  double sum = 0;
  for (double from = a; from < b;) {
    const double to = std::min(b, pi * std::floor(from / pi + 1 + 1e-12));
    sum += boost::math::quadrature::gauss_kronrod<double, 61>::integrate(
        [&](double theta) { return std::sqrt(inertia(theta) / twice_energy); }, from, to, 20, 1e-13);
    from = to;
  }
  return sum;
}

// Eleven turns, 22 dead centres. A rounding of 1e-16 m of the slider changes the moment arm dx/dtheta of its weight by
// 1e-15 of r, and J at the edge of the valley by 1e-12; a hundred such changes in each of 22 valleys leave 1e-9 of the
// energy, and half of that in the time. A pose that met the constraints to 1e-14 m only left a hundred times that in
// the accelerations, and steps of 1e-12 s.
TEST(MassRatio, ACrankCarriesAHeavySliderOverItsDeadCentres) {
  Machine machine(slider_crank(), {.integrator = IntegratorKind::cvode, .cvode = {1e-12, 1e-12}});
  machine.start_from_pose();
  const double end = begin + 22 * pi, duration = time_between(begin, end);
  const int parts = 1000;
  for (int i = 0; i < parts; ++i) machine.advance(duration / parts);
  EXPECT_LT(machine.energy().closure(), 1e-8);
  EXPECT_NEAR(machine.body(1).omega, spin, 1e-8 * spin);
  EXPECT_NEAR(machine.body(1).angle, end, 1e-8 * spin * duration);
}

}  // namespace
}  // namespace subsoil::mbd::mass_ratio_test
