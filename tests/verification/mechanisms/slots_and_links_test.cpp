// A pin in a slot, a massless link, a cylinder with a pin at each end, against closed forms.

#include <gtest/gtest.h>

#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>
#include <numbers>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/drivers/distance_driver.hpp"
#include "libmbd/joints/distance.hpp"
#include "libmbd/joints/point_on_line.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::slots_and_links_test {
namespace {

void run(Machine& machine, double end, double h) {
  for (long i = 0; i < std::lround(end / h); ++i) machine.advance(h);
}

// Scotch yoke: a crank pin of 0.3 m in the slot across a yoke makes x = 0.3 cos(w t). The slot pushes the yoke, the
// motor brings its power.
TEST(PointOnLine, ScotchYoke) {
  constexpr double r = 0.3, w = 4, mass = 2.5;
  Model m;
  m.gravity = {0, 0};
  const int crank = m.add({.name = "crank", .mass = 1, .inertia = 0.1});
  const int yoke = m.add({.name = "yoke", .mass = mass, .inertia = 1, .pose = {r, 0, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = crank});
  m.add("guide", Translational{.body_a = ground, .body_b = yoke});
  m.add("slot", PointOnLine{.body_a = yoke, .body_b = crank, .p_b = {r, 0}, .angle_a = std::numbers::pi / 2});
  m.add("motor", AngleDriver{.first = ground, .second = crank, .motion = {.velocity = w}});
  Machine machine(m);
  machine.start_from_pose();
  for (int i = 0; i < 20; ++i) {
    run(machine, 0.1, 1e-2);
    const double c = std::cos(w * machine.time()), s = std::sin(w * machine.time());
    EXPECT_NEAR(machine.body(yoke).r.x, r * c, 1e-12);
    EXPECT_NEAR(machine.body(yoke).v.x, -r * w * s, 1e-11);
    EXPECT_NEAR(machine.joint_reaction("slot").fx, -mass * r * w * w * c, 1e-10);
    EXPECT_NEAR(machine.joint_reaction("slot").fy, 0, 1e-10);
    EXPECT_NEAR(machine.joint_reaction("slot").moment, 0, 1e-10);
    EXPECT_NEAR(machine.driver_force("motor"), mass * r * r * w * w * s * c, 1e-10);
  }
}

// A body hung by its centre of gravity on a link swings as a point mass, and turns on as it was: released at 1.2 rad,
// sin(q/2) = k cd(w t, k), k = sin(0.6). Order 4 at 1 ms: some 1e-9 after two swings (see pendulum_test).
TEST(Distance, PendulumOnALink) {
  constexpr double l = 0.8, mass = 2, g = 9.81, start = 1.2;
  Model m;
  m.add({.name = "bob",
         .mass = mass,
         .inertia = 0.3,
         .pose = {l * std::sin(start), -l * std::cos(start), 0},
         .velocity = {0, 0, 2}});
  m.add("link", Distance{.body_a = ground, .body_b = 1});
  Machine machine(m);
  machine.start_from_pose();
  run(machine, 4, 1e-3);
  const double k = std::sin(start / 2), omega = std::sqrt(g / l);
  double cn = 0, dn = 0;
  boost::math::jacobi_elliptic(k, 4 * omega, &cn, &dn);
  const double q = 2 * std::asin(k * cn / dn);
  const BodyState& bob = machine.body(1);
  EXPECT_NEAR(std::atan2(bob.r.x, -bob.r.y), q, 1e-8);
  EXPECT_NEAR(bob.angle, 8, 1e-10);
  // Energy gives the speed; the link pulls the ground towards the bob.
  const double pull = mass * g * (3 * std::cos(q) - 2 * std::cos(start));
  EXPECT_NEAR(machine.joint_reaction("link").fx, pull * std::sin(q), 1e-6);
  EXPECT_NEAR(machine.joint_reaction("link").fy, -pull * std::cos(q), 1e-6);
  EXPECT_NEAR(machine.joint_reaction("link").moment, 0, 1e-12);
}

// A cylinder from (0.5, -0.4) to a point 0.6 m along a boom lifts it at 50 mm/s. The law of cosines with psi, the angle
// between boom and base seen from the boom's pin, gives the motion, inverse dynamics the force.
TEST(DistanceDriver, CylinderLiftsABoom) {
  constexpr double along = 0.6, centre = 0.9, mass = 12, inertia = 3, g = 9.81, speed = 0.05;
  const double base = std::hypot(0.5, 0.4), below = std::atan2(0.4, 0.5), ab = along * base;
  Model m;
  const int boom = m.add({.name = "boom", .mass = mass, .inertia = inertia, .pose = {centre, 0, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = boom, .p_b = {-centre, 0}});
  m.add("cylinder", DistanceDriver{.first = ground,
                                   .second = boom,
                                   .p_a = {0.5, -0.4},
                                   .p_b = {along - centre, 0},
                                   .motion = {.velocity = speed}});
  Machine machine(m);
  machine.start_from_pose();
  const double start = std::sqrt(along * along + base * base - 2 * ab * std::cos(below));
  for (int i = 0; i < 10; ++i) {
    run(machine, 0.3, 1e-2);
    const double length = start + speed * machine.time();
    const double cosine = (along * along + base * base - length * length) / (2 * ab), psi = std::acos(cosine);
    const double lever = ab * std::sin(psi) / length;  // dL/dq
    const double spin = speed / lever, turn = (speed * speed - ab * cosine * spin * spin) / (ab * std::sin(psi));
    EXPECT_NEAR(machine.body(boom).angle, psi - below, 1e-12);
    EXPECT_NEAR(machine.body(boom).omega, spin, 1e-11);
    const double moment = (inertia + mass * centre * centre) * turn + mass * g * centre * std::cos(psi - below);
    EXPECT_NEAR(machine.driver_force("cylinder"), moment / lever, 1e-9);
  }
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
}

// The same lift by acceleration from a start with speed: length = start + v t + a t^2/2.
TEST(DistanceDriver, ByAccelerationFromAMovingStart) {
  Model m;
  const int block = m.add({.name = "block", .mass = 2, .inertia = 1, .pose = {0.7, 0, 0}, .velocity = {0.3, 0, 0}});
  m.add("guide", Translational{.body_a = ground, .body_b = block});
  m.add("cylinder", DistanceDriver{.first = ground, .second = block, .motion = {.acceleration = 0.8}});
  m.start_time = 2;
  Machine machine(m);
  machine.start_from_pose();
  run(machine, 1.5, 1e-2);
  EXPECT_NEAR(machine.body(block).r.x, 0.7 + 0.3 * 1.5 + 0.4 * 1.5 * 1.5, 1e-13);
  EXPECT_NEAR(machine.body(block).v.x, 0.3 + 0.8 * 1.5, 1e-13);
  EXPECT_NEAR(machine.driver_force("cylinder"), 2 * 0.8, 1e-12);
}

}  // namespace
}  // namespace subsoil::mbd::slots_and_links_test
