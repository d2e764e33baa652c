#include <gtest/gtest.h>

#include <cmath>

#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/forces/wheel_on_soil.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::wheel_test {
namespace {

constexpr double radius = 0.20, width = 0.12, n = 1.3126, k_c = 1434.81e3, k_phi = 165.79e3;
WheelOnSoil wheel() { return {.body = 1, .radius = radius, .width = width, .n = n, .k_c = k_c, .k_phi = k_phi}; }

struct Felt {
  double fx, fy, moment;
  ForceValues values;
  ForcePower power;
};
Felt feel(const WheelOnSoil& w, const std::vector<Rut>& ruts, double x, double z, double vx, double vy = 0) {
  std::array<std::array<double, 3>, 2> wrench{};
  const std::array<BodyState, 2> bodies{BodyState{}, BodyState{{x, radius + w.surface - z}, 0, {vx, vy}, 0}};
  Loads loads(wrench);
  Felt felt{};
  felt.power = w.evaluate({bodies, 0, ruts}, loads, felt.values);
  felt.fx = wrench[1][0], felt.fy = wrench[1][1], felt.moment = wrench[1][2];
  return felt;
}

double virgin_n(double z) {
  return width * (k_c / width + k_phi) * std::sqrt(2 * radius) * (3 - n) / 3 * std::pow(z, n + 0.5);
}
double virgin_r(double z) { return width * (k_c / width + k_phi) * std::pow(z, n + 1) / (n + 1); }

TEST(WheelOnSoil, VirginCurve) {
  const std::vector<Rut> ruts(1);
  const Felt f = feel(wheel(), ruts, 0, 0.03, 0.5);
  EXPECT_NEAR(f.fy, virgin_n(0.03), 1e-9);
  EXPECT_NEAR(f.fx, -virgin_r(0.03), 1e-9);
  EXPECT_EQ(f.moment, 0);
  EXPECT_NEAR(feel(wheel(), ruts, 0, 0.03, -0.5).fx, virgin_r(0.03), 1e-9);  // opposes the velocity
  const Felt above = feel(wheel(), ruts, 0, 0.0, 0.5);
  EXPECT_EQ(above.fy, 0);
  EXPECT_EQ(above.fx, 0);
}

TEST(WheelOnSoil, ResistanceFadesBelowOneMillimetrePerSecond) {
  const std::vector<Rut> ruts(1);
  EXPECT_NEAR(feel(wheel(), ruts, 0, 0.03, 1e-3).fx, -virgin_r(0.03), 1e-9);
  EXPECT_NEAR(feel(wheel(), ruts, 0, 0.03, 0.5e-3).fx, -virgin_r(0.03) / 2, 1e-9);
  EXPECT_EQ(feel(wheel(), ruts, 0, 0.03, 0).fx, 0);
}

TEST(WheelOnSoil, SurfaceIsTheDatum) {
  const std::vector<Rut> ruts(1);
  WheelOnSoil low = wheel();
  low.surface = -0.4;
  EXPECT_NEAR(feel(low, ruts, 0, 0.02, 0.5).fy, virgin_n(0.02), 1e-9);
}

TEST(WheelOnSoil, RutUnderTheFrontOfThePatchTakesTheLoadAway) {
  std::vector<Rut> ruts(1);
  ruts[0].press(0, 0.03, 1, 0.03);
  const double reach = std::sqrt(2 * radius * 0.02);
  EXPECT_EQ(feel(wheel(), ruts, 0.5, 0.02, 0.5).fy, 0);  // 20 mm in a rut of 30 mm
  EXPECT_EQ(feel(wheel(), ruts, 0.5, 0.02, 0.5).fx, 0);
  EXPECT_EQ(feel(wheel(), ruts, -reach + 0.01, 0.02, 0.5).fy, 0);                       // its front is in the rut
  EXPECT_NEAR(feel(wheel(), ruts, -reach - 0.01, 0.02, 0.5).fy, virgin_n(0.02), 1e-9);  // and here not yet
  const Felt deeper = feel(wheel(), ruts, 0.5, 0.04, 0.5);
  EXPECT_NEAR(deeper.fy, virgin_n(0.04), 1e-9);
  EXPECT_NEAR(deeper.fx, -(virgin_r(0.04) - virgin_r(0.03)), 1e-9);
}

TEST(WheelOnSoil, FrontIsInTheDirectionOfTravel) {
  std::vector<Rut> ruts(1);
  ruts[0].press(0, 0.03, 1, 0.03);
  WheelOnSoil back = wheel();
  back.direction = -1;
  const double reach = std::sqrt(2 * radius * 0.02);
  EXPECT_EQ(feel(back, ruts, 1 + reach - 0.01, 0.02, -0.5).fy, 0);
  EXPECT_NEAR(feel(back, ruts, -reach / 2, 0.02, -0.5).fy, virgin_n(0.02), 1e-9);
}

Model lone_wheel(const std::string& track, double x, double z, double vx) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = track + std::to_string(x),
         .mass = 25,
         .inertia = 0.5,
         .pose = {x, radius - z, 0},
         .velocity = {vx, 0, 0}});
  WheelOnSoil w = wheel();
  w.track = track;
  m.add("w" + std::to_string(x), w);
  return m;
}

// A wheel held at a depth is driven forward and back: it loads on the way out, and finds its own rut on the way home.
TEST(WheelOnSoil, ComesBackInItsOwnRut) {
  Model m = lone_wheel("", 0, 0.03, 0.5);
  m.add("path", CoordinateDriver{.body = 1,
                                 .coordinate = Coordinate::x,
                                 .motion = {.velocity = HarmonicFunction{
                                                .amplitude = 0.5, .frequency = 0.25, .phase = std::acos(-1.0) / 2}}});
  m.add("height", CoordinateDriver{.body = 1, .coordinate = Coordinate::y, .motion = {.position = radius - 0.03}});
  const std::string name = m.forces[0].name;
  Machine machine(m);
  machine.start_from_pose();
  for (int i = 0; i < 500; ++i) machine.advance(1e-3);
  EXPECT_NEAR(machine.force_value(name, "N"), virgin_n(0.03), 1e-6);
  // v = 0.5 cos(omega t), so the driver also brakes the wheel's mass.
  const double omega = std::acos(-1.0) / 2, braking = 25 * 0.5 * omega * std::sin(omega * machine.time());
  EXPECT_NEAR(machine.driver_force("path"), virgin_r(0.03) - braking, 1e-6);
  for (int i = 0; i < 1200; ++i) machine.advance(1e-3);  // turned at 1 s, on the way back
  EXPECT_LT(machine.body(1).v.x, -0.3);
  EXPECT_NEAR(machine.force_value(name, "rut"), 0.03, 1e-12);
  EXPECT_EQ(machine.force_value(name, "N"), 0);
  // R_c over the 0.318 m of the way out; what the turn into the rut swallows comes on top.
  EXPECT_GT(machine.energy().lost, 0.318 * virgin_r(0.03));
}

TEST(WheelOnSoil, WheelsOfOneTrackShareTheRut) {
  Model m;
  m.gravity = {0, 0};
  for (const auto& [name, x] : {std::pair{"front", 1.0}, {"rear", 0.0}, {"beside", 0.5}}) {
    const int body =
        m.add({.name = name, .mass = 25, .inertia = 0.5, .pose = {x, radius - 0.03, 0}, .velocity = {1, 0, 0}});
    WheelOnSoil w = wheel();
    w.body = body;
    if (std::string(name) != "beside") w.track = "left";
    m.add(std::string(name) + " wheel", w);
    m.add(std::string(name) + ".x",
          CoordinateDriver{.body = body, .coordinate = Coordinate::x, .motion = {.velocity = 1.0}});
    m.add(std::string(name) + ".y",
          CoordinateDriver{.body = body, .coordinate = Coordinate::y, .motion = {.position = radius - 0.03}});
  }
  Machine machine(m);
  machine.start_from_pose();
  for (int i = 0; i < 1500; ++i) machine.advance(1e-3);
  EXPECT_NEAR(machine.force_value("front wheel", "N"), virgin_n(0.03), 1e-6);
  EXPECT_EQ(machine.force_value("rear wheel", "N"), 0);
  EXPECT_NEAR(machine.force_value("beside wheel", "N"), virgin_n(0.03), 1e-6);
}

/// Bekker's pressure on the part of the arc that presses deeper, dz/dt + x v/R > 0, than a rut, by the midpoint rule;
/// vertical force scaled by (3 - n)/3 over the integral of a wheel that is neither rising nor sinking on flat ground.
struct Pressed {
  double bearing = 0, resistance = 0;
};
Pressed by_the_arc(double z, double v, double sinking, double exponent, double rut = 0) {
  const double front = std::sqrt(2 * radius * z), b_k = k_c + width * k_phi;
  constexpr int parts = 2000000;
  double all = 0;
  Pressed out;
  for (int i = 0; i < parts; ++i) {
    const double x = -front + 2 * front * (i + 0.5) / parts, dx = 2 * front / parts;
    const double depth = z - x * x / (2 * radius), p = b_k * std::pow(depth, exponent) * dx;
    if (x > 0) all += p;
    if (sinking + x * v / radius > 0 && depth > rut) out.bearing += p, out.resistance += p * x / radius;
  }
  out.bearing *= b_k * std::sqrt(2 * radius) * (3 - exponent) / 3 * std::pow(z, exponent + 0.5) / all;
  return out;
}

TEST(WheelOnSoil, PlasticHeaveIsBekkersPressureWhereTheArcPresses) {
  const std::vector<Rut> ruts(1);
  for (const double exponent : {0.5, 1.0, n}) {
    WheelOnSoil w = wheel();
    w.n = exponent, w.heave = WheelOnSoil::Heave::plastic;
    for (const double sinking : {-0.3, -0.1, -0.01, 0.0, 0.02, 0.1, 0.3}) {
      const Felt f = feel(w, ruts, 0, 0.03, 0.5, -sinking);
      const Pressed p = by_the_arc(0.03, 0.5, sinking, exponent);
      // The rule's error at an end in the middle of a part, 5e-7 of the arc, and where p begins as a root: 1e-8.
      const double scale = virgin_n(0.03);
      EXPECT_NEAR(f.fy, p.bearing, 3e-6 * std::max(scale, p.bearing)) << exponent << ' ' << sinking;
      EXPECT_NEAR(-f.fx, p.resistance, 3e-6 * scale) << exponent << ' ' << sinking;
      EXPECT_EQ(f.power.stored, 0);
      EXPECT_NEAR(f.power.lost, f.fy * sinking - f.fx * 0.5, 1e-12 * scale);
      if (exponent >= 1) {
        EXPECT_GE(f.power.lost, 0) << exponent << ' ' << sinking;
      }
    }
    EXPECT_EQ(feel(w, ruts, 0, 0.03, 0.5, 0.51 * std::sqrt(2 * 0.03 / radius)).fy, 0) << "rises off the arc";
  }
}

TEST(WheelOnSoil, InARutPlasticHeaveIsThePressureOfWhatIsDeeper) {
  std::vector<Rut> ruts(1);
  ruts[0].press(-1, 0.02, 1, 0.02);
  for (const double exponent : {0.5, n}) {
    WheelOnSoil w = wheel();
    w.n = exponent, w.heave = WheelOnSoil::Heave::plastic;
    for (const double z : {0.0202, 0.03})
      for (const double sinking : {-0.05, -0.01, 0.0, 0.02, 0.3}) {
        const Felt f = feel(w, ruts, 0, z, 0.5, -sinking);
        const Pressed p = by_the_arc(z, 0.5, sinking, exponent, 0.02);
        // At each end of what bears the rule errs by half a part, 5e-7 of the arc, at a pressure of up to 2.4 times
        // the mean of flat ground.
        const double scale = w.load(z);
        EXPECT_NEAR(f.fy, p.bearing, 3e-6 * scale) << exponent << ' ' << z << ' ' << sinking;
        EXPECT_NEAR(-f.fx, p.resistance, 3e-6 * scale) << exponent << ' ' << z << ' ' << sinking;
      }
    EXPECT_EQ(feel(w, ruts, 0, 0.02, 0.5, -0.02).fy, 0) << "not deeper than the rut";
  }
}

/// Two wheels on one track: the front one rides at the depth where N of unrutted ground is its load, the rear one at
/// the depth where the pressure of what is deeper than its rut is. In a second with default settings; N that jumps at
/// the rut's depth took cvode 250 times as long as a wheel on unrutted ground.
TEST(WheelOnSoil, PlasticHeaveCarriesARearWheelInTheRut) {
  const double mass = virgin_n(0.028) / 9.81, v = 0.5;
  Model m;
  for (const auto& [name, x] : {std::pair{"front", 1.0}, {"rear", 0.0}}) {
    const int body =
        m.add({.name = name, .mass = mass, .inertia = 0.5, .pose = {x, radius - 0.028, 0}, .velocity = {v, 0, 0}});
    WheelOnSoil w = wheel();
    w.body = body, w.heave = WheelOnSoil::Heave::plastic, w.track = "both";
    m.add(std::string(name) + " wheel", w);
    m.add(std::string(name) + ".x",
          CoordinateDriver{.body = body, .coordinate = Coordinate::x, .motion = {.velocity = v}});
  }
  MachineOptions options;
  options.integrator = IntegratorKind::cvode;
  Machine machine(m, options);
  machine.start_from_pose();
  for (int i = 0; i < 4000; ++i) machine.advance(1e-3);
  const double z = radius - machine.body(2).r.y;
  EXPECT_NEAR(machine.force_value("rear wheel", "rut"), 0.028, 1e-5);
  EXPECT_NEAR(machine.force_value("rear wheel", "N"), mass * 9.81, 1e-3 * mass * 9.81);
  EXPECT_NEAR(by_the_arc(z, v, 0, n, 0.028).bearing, mass * 9.81, 1e-2 * mass * 9.81);
}

TEST(WheelOnSoil, PlasticHeaveIsTheReversibleLawWhenTowedSteadilyAndTwiceItWhenPushedDownAtRest) {
  const std::vector<Rut> ruts(1);
  WheelOnSoil w = wheel();
  w.heave = WheelOnSoil::Heave::plastic;
  EXPECT_NEAR(feel(w, ruts, 0, 0.03, 0.5).fy, virgin_n(0.03), 1e-9);
  EXPECT_NEAR(feel(w, ruts, 0, 0.03, -0.5).fx, virgin_r(0.03), 1e-9);
  EXPECT_NEAR(feel(w, ruts, 0, 0.03, 0, -0.01).fy, 2 * virgin_n(0.03), 1e-9);
  EXPECT_EQ(feel(w, ruts, 0, 0.03, 0, 0.01).fy, 0);
}

/// A wheel that rolls 0.1 mm above its equilibrium comes back as m z'' + c z' + k z = 0 with the c of the header and
/// k = (n + 1/2) N/z: to terms of second order in the displacement, 0.1/28 of it times n + 1/2.
TEST(WheelOnSoil, PlasticHeaveDampsWhatRolls) {
  const double z = 0.028, mass = virgin_n(z) / 9.81, start = 1e-4, v = 0.5;
  Model m;
  const int body =
      m.add({.name = "wheel", .mass = mass, .inertia = 0.5, .pose = {0, radius - z + start, 0}, .velocity = {v, 0, 0}});
  WheelOnSoil w = wheel();
  w.body = body, w.heave = WheelOnSoil::Heave::plastic;
  m.add("soil", w);
  m.add("x", CoordinateDriver{.body = body, .coordinate = Coordinate::x, .motion = {.velocity = v}});
  Machine machine(m);
  machine.start_from_pose();
  const double beta = 0.5 * std::tgamma(0.5) * std::tgamma(n + 1) / std::tgamma(n + 1.5);
  const double c = virgin_n(z) * radius / (v * std::sqrt(2 * radius * z) * beta) / mass, k = (n + 0.5) * 9.81 / z;
  const double half = c / 2, root = std::sqrt(half * half - k);  // more than critically damped
  ASSERT_GT(half * half, k);
  for (int i = 1; i <= 300; ++i) {
    machine.advance(1e-3);
    const double t = 1e-3 * i, slow = half - root, fast = half + root;
    const double closed = start * (fast * std::exp(-slow * t) - slow * std::exp(-fast * t)) / (fast - slow);
    EXPECT_NEAR(machine.body(body).r.y - (radius - z), closed, 6e-3 * start) << t;
  }
  EXPECT_GT(machine.energy().lost, 0);
}

TEST(Rut, KeepsTheDeepestAndIsLinearBetween) {
  Rut rut;
  EXPECT_EQ(rut.at(0.3).z, 0);
  rut.press(0.0105, 0.01, 0.0135, 0.04);
  EXPECT_NEAR(rut.at(0.011).z, 0.015, 1e-15);
  EXPECT_NEAR(rut.at(0.0115).z, 0.020, 1e-15);
  EXPECT_NEAR(rut.at(0.0115).slope, 10, 1e-10);
  rut.press(0.013, 0.001, 0.011, 0.001);  // shallower, the other way
  EXPECT_NEAR(rut.at(0.012).z, 0.025, 1e-15);
  rut.press(-7.0, 0.02, -6.9, 0.02);  // far away: the storage grows, the old marks stay
  EXPECT_NEAR(rut.at(-6.95).z, 0.02, 1e-15);
  EXPECT_NEAR(rut.at(0.012).z, 0.025, 1e-15);
  EXPECT_EQ(rut.at(-3).z, 0);
}

}  // namespace
}  // namespace subsoil::mbd::wheel_test
