// Forces in motion, each against a closed form: springs, bushings and drag.

#include <gtest/gtest.h>

#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>

#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/forces/bushing.hpp"
#include "libmbd/forces/drag.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::forces_test {
namespace {

class ForcesInMotion : public testing::TestWithParam<IntegratorKind> {
 protected:
  MachineOptions options() const { return {.integrator = GetParam(), .ida = {.rtol = 1e-11, .atol = 1e-12}}; }
};

/// A block of 2 kg on a slide along x at `x`, with nothing but a spring to the ground's origin.
Model block_on_spring(SpringDamper spring, double x) {
  Model m;
  m.add({.name = "block", .mass = 2, .inertia = 1, .pose = {x, 0, 0}});
  m.add("slide", Translational{.body_a = ground, .body_b = 1});
  spring.body_a = ground, spring.body_b = 1;
  m.add("spring", std::move(spring));
  return m;
}

// Duffing's spring k x + k_3 x^3 from rest at amplitude X: x = X cn(w t | modulus), w^2 = (k + k_3 X^2)/m,
// modulus^2 = k_3 X^2 / (2 (k + k_3 X^2)). With h = 1 ms, w h = 0.02: (w h)^4 0.35 per radian over 40 radians 2e-6 of
// the amplitude at the worst; fourth order in practice stays below 1e-6. IDA is held to the same.
TEST_P(ForcesInMotion, CubicSpringIsJacobisCosine) {
  constexpr double mass = 2, k = 300, k_3 = 20000, amplitude = 0.15, free = 1;
  Machine machine(
      block_on_spring({.free_length = free, .spring_curve = PolynomialCharacteristic{{.c = {0, k, 0, k_3}}}},
                      free + amplitude),
      options());
  machine.start_from_pose();
  const double hard = k + k_3 * amplitude * amplitude, w = std::sqrt(hard / mass);
  const double modulus = std::sqrt(k_3 * amplitude * amplitude / (2 * hard));
  for (int i = 1; i <= 2000; ++i) {
    machine.advance(1e-3);
    const double exact = amplitude * boost::math::jacobi_cn(modulus, w * machine.time());
    ASSERT_NEAR(machine.body(1).r.x - free, exact, 1e-6 * amplitude) << "t = " << machine.time();
  }
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6 * 0.5 * hard * amplitude * amplitude);
  EXPECT_EQ(machine.energy().lost, 0);
}

// A table of the cubic with points every 15 mm is the same motion but for the spline's error: a clamped cubic would be
// exact, the natural ends bend it by a quarter of h^2 f'' there, which the motion below half of the range does not see
// (an end's bend fades by 3.7 per point: 1e-6 of it after ten points).
TEST_P(ForcesInMotion, TableOfTheCubicMovesTheSame) {
  constexpr double k = 300, k_3 = 20000, free = 1, amplitude = 0.15;
  TableCharacteristic table;
  for (int i = -20; i <= 20; ++i) {
    const double x = 0.015 * i;
    table.law.times.push_back(x), table.law.values.push_back(k * x + k_3 * x * x * x);
  }
  Machine curve(block_on_spring({.free_length = free, .spring_curve = PolynomialCharacteristic{{.c = {0, k, 0, k_3}}}},
                                free + amplitude),
                options());
  Machine points(block_on_spring({.free_length = free, .spring_curve = table}, free + amplitude), options());
  curve.start_from_pose(), points.start_from_pose();
  for (int i = 1; i <= 1000; ++i) {
    curve.advance(1e-3), points.advance(1e-3);
    ASSERT_NEAR(points.body(1).r.x, curve.body(1).r.x, 1e-5 * amplitude) << "t = " << curve.time();
  }
}

// An actuator moves a free block: x'' = (f_0 + f_1 t)/m. A fourth-order method is exact for this cubic but for
// rounding; IDA keeps its tolerance.
TEST_P(ForcesInMotion, ActuatorAcceleratesAndIsAccumulated) {
  Machine machine(block_on_spring({.stiffness = 0, .actuator = PolynomialFunction{{3, 5}}}, 1), options());
  machine.start_from_pose();
  for (int i = 0; i < 500; ++i) machine.advance(2e-3);
  const double t = machine.time(), v = (3 * t + 2.5 * t * t) / 2;
  EXPECT_NEAR(machine.body(1).r.x, 1 + (1.5 * t * t + 5.0 / 6 * t * t * t) / 2, 1e-9);
  EXPECT_NEAR(machine.body(1).v.x, v, 1e-9);
  EXPECT_NEAR(machine.energy().force_work, 0.5 * 2 * v * v, 1e-8);
}

// Small swings of a bar on a bushing at arm l from its centre, no gravity, bushing's axes x along the bar:
//   along: w^2 = k_x / m;   across and turning: det(K - w^2 M) = 0 with
//   M = diag(m, I),  K = [[k_y, -k_y l], [-k_y l, k_t + k_y l^2]]
// modes() linearises by differences of 1e-6: 1e-8 of the frequency with its rounding.
TEST(Bushing, FrequenciesOfAPendulumOnIt) {
  constexpr double mass = 3, inertia = 0.4, arm = 0.7, k_x = 900, k_y = 400, k_t = 60;
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "bar", .mass = mass, .inertia = inertia, .pose = {arm, 0, 0}});
  m.add("bushing", Bushing{.body_a = ground,
                           .body_b = 1,
                           .p_b = {-arm, 0},
                           .stiffness_x = k_x,
                           .stiffness_y = k_y,
                           .stiffness_turn = k_t});
  System system(m);
  const Equilibrium at = towing_equilibrium(system, 0, system.start_position(), 0);
  const auto found = modes(system, 0, at);
  ASSERT_EQ(found.size(), 3U);
  const double a = mass * inertia, b = mass * (k_t + k_y * arm * arm) + inertia * k_y, c = k_y * k_t;
  const double low = (b - std::sqrt(b * b - 4 * a * c)) / (2 * a), high = c / a / low;
  std::array<double, 3> exact{std::sqrt(low), std::sqrt(high), std::sqrt(k_x / mass)};
  std::sort(exact.begin(), exact.end());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(2 * std::acos(-1.0) * found[i].frequency, exact[i], 1e-7 * exact[i]);
    EXPECT_NEAR(found[i].damping, 0, 1e-7);
  }
}

// Two free bodies on a soft bushing, far from small motion: what no force between them can change stays, and the energy
// balance closes. 1e-7 of the momenta and energies of order 1 to 100: the error of the fixed step, (w h)^4 with w h =
// 0.02.
TEST_P(ForcesInMotion, FreePairOnABushingKeepsMomentaAndEnergy) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "a", .mass = 2, .inertia = 0.5, .pose = {0, 0, 0.3}, .velocity = {0.4, -0.2, 3}});
  m.add({.name = "b", .mass = 1, .inertia = 0.2, .pose = {0.8, 0.1, -0.4}, .velocity = {-0.5, 1, -2}});
  m.add("bushing", Bushing{.body_a = 1,
                           .body_b = 2,
                           .p_a = {0.4, 0.1},
                           .p_b = {-0.3, 0},
                           .turn = 0.5,
                           .stiffness_x = 200,
                           .stiffness_y = 50,
                           .stiffness_turn = 5,
                           .damping_x = 0.6,
                           .damping_turn = 0.1,
                           .preload_y = 4});
  Machine machine(m, options());
  machine.start_from_pose();
  const auto momenta = [&] {
    const BodyState &a = machine.body(1), &b = machine.body(2);
    return std::array<double, 3>{2 * a.v.x + b.v.x, 2 * a.v.y + b.v.y,
                                 0.5 * a.omega + 0.2 * b.omega + 2 * cross(a.r, a.v) + cross(b.r, b.v)};
  };
  const auto start = momenta();
  double farthest = 0;
  for (int i = 0; i < 3000; ++i) {
    machine.advance(1e-3);
    farthest = std::max(farthest, machine.force_value("bushing", "offset"));
  }
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(momenta()[k], start[k], 1e-7);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
  EXPECT_GT(machine.energy().lost, 0.5);
  EXPECT_GT(farthest, 0.2);
}

// Fall against quadratic drag in an updraught u from rest: v = u - v_t tanh(...) with the air's frame as the inertial
// one: w = v - u, w' = -g - (c_2/m) |w| w. From w_0 = -u (below v_t): w = -v_t tanh(g t/v_t + atanh(u/v_t)).
TEST_P(ForcesInMotion, FallsAtTerminalVelocityThroughAnUpdraught) {
  constexpr double mass = 0.5, c_2 = 0.02, g = 9.81, up = 3;
  Model m;
  m.add({.name = "ball", .mass = mass, .inertia = 1});
  m.add("air", Drag{.body = 1, .quadratic = c_2, .wind_y = up});
  Machine machine(m, options());
  machine.start_from_pose();
  const double v_t = std::sqrt(mass * g / c_2), phase = std::atanh(up / v_t);
  for (int i = 1; i <= 2000; ++i) {
    machine.advance(5e-3);
    const double t = machine.time(), at = g * t / v_t + phase;
    ASSERT_NEAR(machine.body(1).v.y, up - v_t * std::tanh(at), 1e-8 * v_t) << "t = " << t;
    const double y = up * t - v_t * v_t / g * std::log(std::cosh(at) / std::cosh(phase));
    ASSERT_NEAR(machine.body(1).r.y, y, 1e-7 * v_t) << "t = " << t;
  }
  EXPECT_NEAR(machine.body(1).v.y, up - v_t, 1e-4);  // terminal after 10 s
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6 * machine.energy().lost);
}

// A spinning rotor run down by linear and quadratic moments: I w' = -(b_1 + b_2 w) w, a logistic:
// w = b_1 / ((b_1/w_0 + b_2) exp(b_1 t/I) - b_2).
TEST_P(ForcesInMotion, RotorRunsDown) {
  constexpr double inertia = 0.3, b_1 = 0.02, b_2 = 0.01, w_0 = 40;
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "rotor", .mass = 1, .inertia = inertia, .velocity = {0, 0, w_0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1});
  m.add("air", Drag{.body = 1, .linear_turn = b_1, .quadratic_turn = b_2});
  Machine machine(m, options());
  machine.start_from_pose();
  for (int i = 1; i <= 2000; ++i) {
    machine.advance(2e-3);
    const double exact = b_1 / ((b_1 / w_0 + b_2) * std::exp(b_1 * machine.time() / inertia) - b_2);
    ASSERT_NEAR(machine.body(1).omega, exact, 1e-7) << "t = " << machine.time();
  }
  const double w = machine.body(1).omega;
  EXPECT_NEAR(machine.energy().lost, 0.5 * inertia * (w_0 * w_0 - w * w), 1e-6);
}

// A wheel of 300 N that is driven at 0.4 m/s with a slip: its traction is the shear stress over its patch,
// (c + p tan phi)(1 - exp(-i x/K)) under the uniform pressure p, by Simpson's rule; braked, j = i x/(1 - i). The
// drivers bear the drawbar pull and the torque.
TEST_P(ForcesInMotion, ADrivenWheelShearsTheSoilUnderItsPatch) {
  constexpr double radius = 0.3, width = 0.12, speed = 0.4, weight = 300, k = 4e5, c = 2e3, phi = 0.5, K = 0.015;
  for (const double slip : {-0.3, 0.05, 0.2, 0.7}) {
    SCOPED_TRACE(slip);
    const double z = std::pow(weight / (width * k * std::sqrt(2 * radius) * 2. / 3), 1 / 1.5);
    const double rim = slip > 0 ? speed / (1 - slip) : speed * (1 + slip);
    Model m;
    m.add({.name = "wheel",
           .mass = weight / 9.81,
           .inertia = 0.5,
           .pose = {0, radius - z, 0},
           .velocity = {speed, 0, -rim / radius}});
    m.add("tow", CoordinateDriver{.body = 1, .motion = {.velocity = speed}});
    m.add("drive", CoordinateDriver{.body = 1, .coordinate = Coordinate::angle, .motion = {.velocity = -rim / radius}});
    m.add("soil", WheelOnSoil{.body = 1,
                              .radius = radius,
                              .width = width,
                              .n = 1,
                              .k_c = 0,
                              .k_phi = k,
                              .shear_displacement = K,
                              .cohesion = c,
                              .internal_friction = phi});
    Machine machine(m, options());
    machine.start_from_pose();
    for (int i = 0; i < 100; ++i) machine.advance(1e-3);
    const double patch = std::sqrt(2 * radius * z), p = weight / (width * patch);
    const double per_x = slip > 0 ? slip : -slip / (1 + slip);
    const auto stress = [&](double x) { return (c + p * std::tan(phi)) * -std::expm1(-per_x * x / K); };
    double traction = 0;
    constexpr int n = 1000;
    for (int i = 0; i <= n; ++i)
      traction += (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) * width * stress(patch * i / n) * patch / (3 * n);
    if (slip < 0) traction = -traction;
    // The regularised speed of the rim, 10 mm/s beside 0.28 m/s, takes 6e-4 of the shear displacement.
    EXPECT_NEAR(machine.force_value("soil", "traction"), traction, 1e-3 * std::abs(traction));
    EXPECT_NEAR(machine.force_value("soil", "slip"), slip, 1e-9);
    const double resistance = width * k * z * z / 2;
    EXPECT_NEAR(machine.driver_force("tow"), resistance - traction, 2e-3 * std::abs(traction));
    EXPECT_NEAR(machine.driver_force("drive"), -radius * traction, 1e-3 * radius * std::abs(traction));
    EXPECT_LT(machine.energy().closure(), 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(Both, ForcesInMotion, testing::Values(IntegratorKind::adams_moulton, IntegratorKind::ida));

}  // namespace
}  // namespace subsoil::mbd::forces_test
