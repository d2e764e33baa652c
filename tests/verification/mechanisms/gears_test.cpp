// Gear trains and a rack against Willis' equation, the balance of power and the statics of teeth and pins.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <string>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "libmbd/joints/coupler.hpp"
#include "libmbd/joints/gear_pair.hpp"
#include "libmbd/joints/gear_ratio.hpp"
#include "libmbd/joints/rack_and_pinion.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::gears_test {
namespace {

void run(Machine& machine, double end, double h) {
  for (long i = 0; i < std::lround(end / h); ++i) machine.advance(h);
}

constexpr double sun_radius = 0.3, planet_radius = 0.2, ring_radius = 0.7, planet_mass = 0.5;

/// Sun driven at 5 rad/s, ring on the ground, a load of -2 N m on the carrier, no gravity.
Model planetary() {
  Model m;
  m.gravity = {0, 0};
  const int sun = m.add({.name = "sun", .mass = 1, .inertia = 0.1});
  const int planet = m.add({.name = "planet", .mass = planet_mass, .inertia = 0.01, .pose = {0.5, 0, 0.7}});
  const int carrier = m.add({.name = "carrier", .mass = 2, .inertia = 0.3});
  m.add("sun pin", Revolute{.body_a = ground, .body_b = sun});
  m.add("carrier pin", Revolute{.body_a = ground, .body_b = carrier});
  m.add("planet pin", Revolute{.body_a = carrier, .body_b = planet, .p_a = {0.5, 0}});
  m.add("sun mesh", GearPair{{.body_a = sun, .body_b = planet, .radius_a = sun_radius, .radius_b = planet_radius}});
  m.add("ring mesh",
        GearPair{
            {.body_a = ground, .body_b = planet, .radius_a = ring_radius, .radius_b = planet_radius, .inside = true}});
  m.add("motor", AngleDriver{.first = ground, .second = sun, .motion = {.velocity = 5.0}});
  m.add("load", AppliedForce{.body = carrier, .moment = -2.0});
  return m;
}

// Every angle is a closed form of the sun's; 10 s are more than two turns of the line of centres, which the remainder
// in the constraint must not notice. Constant speed is exact for the integrator.
TEST(Gears, PlanetaryTrainFollowsWillis) {
  Machine machine(planetary());
  machine.start_from_pose();
  run(machine, 10, 1e-2);
  const double carrier_spin = 5 * sun_radius / (sun_radius + ring_radius);
  const double planet_spin = carrier_spin * (1 - ring_radius / planet_radius);
  EXPECT_NEAR(machine.body(1).angle, 50, 1e-11);
  EXPECT_NEAR(machine.body(3).angle, 10 * carrier_spin, 1e-11);
  EXPECT_NEAR(machine.body(2).angle, 0.7 + 10 * planet_spin, 1e-10);
  EXPECT_NEAR(machine.body(2).omega, planet_spin, 1e-11);
}

// At constant speed the motor's power is the load's. The sun's teeth take its torque; the planet passes the force on to
// the ring and loads its pin with both, and with what keeps it on its circle.
TEST(Gears, TeethAndPinsOfThePlanetaryTrain) {
  Machine machine(planetary());
  machine.start_from_pose();
  run(machine, 1.3, 1e-2);
  const double spin = 1.5, torque = 2 * spin / 5, tooth = torque / sun_radius, c = std::cos(1.95), s = std::sin(1.95);
  EXPECT_NEAR(machine.driver_force("motor"), torque, 1e-11);
  const auto expect = [&](const char* joint, double along, double across) {
    const Reaction r = machine.joint_reaction(joint);  // along the line of centres and across it
    EXPECT_NEAR(r.fx * c + r.fy * s, along, 1e-10) << joint;
    EXPECT_NEAR(r.fy * c - r.fx * s, across, 1e-10) << joint;
    EXPECT_NEAR(r.moment, 0, 1e-10) << joint;
  };
  expect("sun mesh", 0, -tooth);                                     // on the sun, against its turn
  expect("ring mesh", 0, -tooth);                                    // on the ring
  expect("planet pin", planet_mass * spin * spin * 0.5, 2 * tooth);  // on the carrier
}

// A train that is not drawn: b - c = -0.5 (a - c) with a and c driven. Its torques are in balance and do no work.
TEST(Gears, RatioAgainstACarrier) {
  Model m;
  m.gravity = {0, 0};
  for (const char* name : {"a", "b", "carrier"}) m.add({.name = name, .mass = 1, .inertia = 0.2});
  for (int i = 1; i < 4; ++i) m.add("pin " + std::to_string(i), Revolute{.body_a = ground, .body_b = i});
  m.add("train", GearRatio{.body_a = 1, .body_b = 2, .body_c = 3, .ratio = -0.5});
  m.add("motor", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = 5.0}});
  m.add("turner", AngleDriver{.first = ground, .second = 3, .motion = {.velocity = 2.0}});
  m.add("load", AppliedForce{.body = 2, .moment = 4.0});
  Machine machine(m);
  machine.start_from_pose();
  run(machine, 3, 1e-2);
  EXPECT_NEAR(machine.body(2).angle, 3 * (2 - 0.5 * 3), 1e-12);
  // The train holds b with -4 N m, so it puts -2 on a and 6 on the carrier; the drivers hold against these.
  EXPECT_NEAR(machine.joint_reaction("train").moment, -2, 1e-11);
  EXPECT_NEAR(machine.driver_force("motor"), 2, 1e-11);
  EXPECT_NEAR(machine.driver_force("turner"), -6, 1e-11);
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-10);
}

// Without carrier the ground carries both axes: two flywheels, one of them pushed.
TEST(Gears, RatioAgainstTheGround) {
  Model m;
  for (const char* name : {"a", "b"}) m.add({.name = name, .mass = 1, .inertia = 0.2});
  for (int i = 1; i < 3; ++i) m.add("pin " + std::to_string(i), Revolute{.body_a = ground, .body_b = i});
  m.add("belt", GearRatio{.body_a = 1, .body_b = 2, .ratio = 3});
  m.add("push", AppliedForce{.body = 1, .moment = 4.0});
  Machine machine(m);
  machine.start_from_pose();
  run(machine, 1, 1e-2);
  EXPECT_NEAR(machine.body(1).omega, 4 / (0.2 + 9 * 0.2), 1e-12);
  EXPECT_NEAR(machine.body(2).omega, 3 * 4 / (0.2 + 9 * 0.2), 1e-12);
}

// A pushed rack turns a pinion of 0.25 m above it: x'' = F / (m + I / R^2); the tooth force is what turns the pinion.
TEST(Gears, RackTurnsPinion) {
  Model m;
  const int rack = m.add({.name = "rack", .mass = 4, .inertia = 1, .pose = {0.3, -0.1, 0}});
  const int pinion = m.add({.name = "pinion", .mass = 1, .inertia = 0.05, .pose = {0, 0.25, 0}});
  m.add("guide", Translational{.body_a = ground, .body_b = rack, .p_a = {0, -0.1}});
  m.add("pin", Revolute{.body_a = ground, .body_b = pinion, .p_a = {0, 0.25}});
  m.add("mesh", RackAndPinion{{.body_a = rack, .body_b = pinion, .p_a = {0, 0.1}, .radius = 0.25}});
  m.add("push", AppliedForce{.body = rack, .fx = 10.0});
  Machine machine(m);
  machine.start_from_pose();
  run(machine, 1, 1e-2);
  const double acceleration = 10 / (4 + 0.05 / 0.0625);
  EXPECT_NEAR(machine.body(rack).r.x, 0.3 + acceleration / 2, 1e-12);
  EXPECT_NEAR(machine.body(pinion).angle, acceleration / 2 / 0.25, 1e-12);
  const Reaction on_rack = machine.joint_reaction("mesh");
  EXPECT_NEAR(on_rack.fx, -0.05 * acceleration / 0.0625, 1e-11);
  EXPECT_NEAR(on_rack.fy, 0, 1e-11);
  EXPECT_NEAR(on_rack.moment, 0, 1e-11);
}

// Sun, arm, planet and a free ring, of two degrees of freedom: with u of the sun and v of the arm the planet turns at
// v - (u - v) Rs/Rp, the ring at v - (u - v) Rs/Rr, so that the mass matrix of u and v is constant and its inverse
// times the torques, integrated twice, is the motion. The gears have turned by 340 rad in the end: rounding of their
// places, over a short step, is more than the tolerances of the slow ring's velocity.
TEST(Gears, AFreeRingTurnsSlowlyBesideAFastSun) {
  constexpr double rs = 0.1, rp = 0.05, rr = 0.2, arm = 0.15, w = 2 * std::numbers::pi * 1.3, end = 3;
  const Eigen::Vector2d of_planet{-rs / rp, 1 + rs / rp}, of_ring{-rs / rr, 1 + rs / rr};
  Eigen::Matrix2d mass = Eigen::Vector2d(0.02, 0.05 + 1.5 * arm * arm).asDiagonal();
  mass += 0.01 * of_planet * of_planet.transpose() + 0.3 * of_ring * of_ring.transpose();
  const Eigen::Vector2d angles =
      mass.inverse() * Eigen::Vector2d(3 * end * end / 2, -2 * (end / w - std::sin(w * end) / (w * w)));
  for (const IntegratorKind kind : {IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida}) {
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "sun", .mass = 2, .inertia = 0.02});
    m.add({.name = "arm", .mass = 1, .inertia = 0.05});
    m.add({.name = "planet", .mass = 1.5, .inertia = 0.01, .pose = {arm, 0, 0}});
    m.add({.name = "ring", .mass = 4, .inertia = 0.3});
    for (const int body : {1, 2, 4}) m.add("pin " + std::to_string(body), Revolute{.body_a = ground, .body_b = body});
    m.add("planet pin", Revolute{.body_a = 2, .body_b = 3, .p_a = {arm, 0}});
    m.add("sun mesh", GearPair{{.body_a = 1, .body_b = 3, .radius_a = rs, .radius_b = rp}});
    m.add("ring mesh", GearPair{{.body_a = 4, .body_b = 3, .radius_a = rr, .radius_b = rp, .inside = true}});
    m.add("drive", AppliedForce{.body = 1, .moment = 3.0});
    m.add("load", AppliedForce{.body = 2, .moment = HarmonicFunction{.amplitude = -2, .frequency = 1.3}});
    Machine machine(m, {.integrator = kind});
    machine.start_from_pose();
    for (int i = 1; i <= 300; ++i) machine.advance(0.01);
    EXPECT_NEAR(machine.body(1).angle, angles[0], 1e-5 * angles[0]) << static_cast<int>(kind);
    EXPECT_NEAR(machine.body(2).angle, angles[1], 1e-5 * angles[0]) << static_cast<int>(kind);
    EXPECT_NEAR(machine.body(4).angle, of_ring.dot(angles), 1e-5 * angles[0]) << static_cast<int>(kind);
  }
}

// A screw of lead p moves a nut of mass m along x, the nut a rack's shaft: under a torque T on the screw all move as
// one inertia J + (m + I/r^2) (p/2 pi)^2. The generalised force on the nut is what accelerates it.
TEST(Coupler, AScrewMovesItsNutAndWhatFollowsIt) {
  constexpr double inertia = 0.02, mass = 3, torque = 0.5, lead = 0.01, shaft = 0.4, radius = 0.05;
  const double per_turn = lead / (2 * std::numbers::pi);
  for (const IntegratorKind kind : {IntegratorKind::adams_moulton, IntegratorKind::cvode, IntegratorKind::ida}) {
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "screw", .mass = 1, .inertia = inertia, .pose = {0, 0, 0.3}});
    m.add({.name = "nut", .mass = mass, .inertia = 1, .pose = {0.2, 0, 0}});
    m.add({.name = "shaft", .mass = 1, .inertia = shaft, .pose = {0, 1, 0}});
    m.add("bearing", Revolute{.body_a = ground, .body_b = 1});
    m.add("guide", Translational{.body_a = ground, .body_b = 2});
    m.add("axle", Revolute{.body_a = ground, .body_b = 3, .p_a = {0, 1}});
    m.add("thread", Coupler{.body_a = 2,
                            .body_b = 1,
                            .coordinate_a = Coordinate::x,
                            .coordinate_b = Coordinate::angle,
                            .ratio = per_turn});
    m.add("rope", Coupler{.angular = {true},
                          .body_a = 3,
                          .body_b = 2,
                          .coordinate_a = Coordinate::angle,
                          .coordinate_b = Coordinate::x,
                          .ratio = -1 / radius});
    m.add("drive", AppliedForce{.body = 1, .moment = torque});
    Machine machine(m, {.integrator = kind});
    machine.start_from_pose();
    for (int i = 0; i < 100; ++i) machine.advance(0.01);
    const double whole = inertia + (mass + shaft / (radius * radius)) * per_turn * per_turn;
    const double turned = torque / whole / 2;
    EXPECT_NEAR(machine.body(1).angle, 0.3 + turned, 1e-8 * turned);
    EXPECT_NEAR(machine.body(2).r.x, 0.2 + per_turn * turned, 1e-8);
    EXPECT_NEAR(machine.body(3).angle, -per_turn * turned / radius, 1e-8 * turned);
    EXPECT_LT(machine.energy().closure(), 1e-8);
    // On the nut, the first body: what accelerates it and the shaft.
    const double pulled = (mass + shaft / (radius * radius)) * per_turn * torque / whole;
    EXPECT_NEAR(machine.joint_reaction("thread").fx, pulled, 1e-8 * pulled);
  }
}

}  // namespace
}  // namespace subsoil::mbd::gears_test
