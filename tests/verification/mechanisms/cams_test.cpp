// Cams of an eccentric circle, whose followers have closed forms, and beads on wires.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/joints/cam_follower.hpp"
#include "libmbd/joints/flat_faced_cam.hpp"
#include "libmbd/joints/point_on_curve.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/reference_ode.hpp"

namespace subsoil::mbd::cams_test {
namespace {

constexpr double g = 9.81, radius = 0.05, eccentricity = 0.012, spin = 6, mass = 1.5;

void run(Machine& machine, double end, double h) {
  for (long i = 0; i < std::lround(end / h); ++i) machine.advance(h);
}

/// A circle about (eccentricity, 0), seen from the origin, at every degree.
void eccentric_circle(std::vector<double>& angles, std::vector<double>& radii) {
  for (int i = 0; i < 360; ++i) {
    const double a = i * std::numbers::pi / 180, s = eccentricity * std::sin(a);
    angles.push_back(a), radii.push_back(eccentricity * std::cos(a) + std::sqrt(radius * radius - s * s));
  }
}

/// A cam turned about the origin from 0.2 rad on, and a follower guided along y above it, its joint still to come.
Model cam_and_follower(double height) {
  Model m;
  m.add({.name = "cam", .mass = 1, .inertia = 0.01, .pose = {0, 0, 0.2}});
  m.add({.name = "follower", .mass = mass, .inertia = 0.1, .pose = {0, height, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1});
  m.add("guide", Translational{.body_a = ground, .body_b = 2, .angle_a = std::numbers::pi / 2});
  m.add("motor", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = spin}});
  return m;
}

struct Lift {
  double y, v, a;
};
/// Compares the follower and the force on the cam, whose normal goes along (across, 1).
void expect_lift(const Machine& machine, const Lift& lift, double across) {
  EXPECT_NEAR(machine.body(2).r.y, lift.y, 1e-10);
  EXPECT_NEAR(machine.body(2).v.y, lift.v, 1e-7);
  EXPECT_NEAR(machine.integrator().state().acceleration[4], lift.a, 1e-4);
  const Reaction on_cam = machine.joint_reaction("contact");
  EXPECT_NEAR(on_cam.fy, -mass * (g + lift.a), 2e-4);
  EXPECT_NEAR(on_cam.fx, across * on_cam.fy, 1e-6);
  EXPECT_NEAR(on_cam.moment, 0, 1e-12);
}

// The roller's centre is radius + roller from the circle's centre: y = e sin q + sqrt((R + r)^2 - e^2 cos^2 q). A cubic
// spline through points 1 deg apart misses the radius by h^4/384 of its fourth derivative, 1e-12 m, its slope by
// h^3/24, its bend by h^2/12: 2e-8 m/s and 3e-5 m/s^2 at this spin.
TEST(Cam, RollerOnAnEccentricCircle) {
  for (const double roller : {0.01, 0.0}) {
    const double reach = radius + roller;
    const auto lift = [&](double q) {
      const double s = eccentricity * std::sin(q), c = eccentricity * std::cos(q),
                   root = std::sqrt(reach * reach - c * c);
      const double root_q = c * s / root, root_qq = (c * c - s * s - root_q * root_q) / root;
      return Lift{s + root, (c + root_q) * spin, (-s + root_qq) * spin * spin};
    };
    Model m = cam_and_follower(lift(0.2).y);
    CamFollower cam{.body_a = 1, .body_b = 2, .roller = roller};
    eccentric_circle(cam.angles, cam.radii);
    m.add("contact", cam);
    Machine machine(m);
    machine.start_from_pose();
    for (int i = 0; i < 12; ++i) {
      run(machine, 0.1, 1e-2);
      const double q = 0.2 + spin * machine.time();
      const Lift now = lift(q);
      expect_lift(machine, now, -eccentricity * std::cos(q) / (now.y - eccentricity * std::sin(q)));
    }
  }
}

// A flat face across the guide is one radius above the circle's centre: y = R + e sin q.
TEST(Cam, FlatFaceOnAnEccentricCircle) {
  Model m = cam_and_follower(radius + eccentricity * std::sin(0.2));
  FlatFacedCam cam{.body_a = 1, .body_b = 2};
  eccentric_circle(cam.angles, cam.radii);
  m.add("contact", cam);
  Machine machine(m);
  machine.start_from_pose();
  for (int i = 0; i < 12; ++i) {
    run(machine, 0.1, 1e-2);
    const double q = 0.2 + spin * machine.time(), s = eccentricity * std::sin(q), c = eccentricity * std::cos(q);
    expect_lift(machine, {radius + s, c * spin, -s * spin * spin}, 0);
  }
}

// A face that turns with a swinging lever: the lever's pin at (-a, 0) and its face through the pin touch the circle
// when a sin-distance of the circle's centre from the face is the radius.
TEST(Cam, FlatFaceOfASwingingLever) {
  constexpr double pin = 0.2;
  Model m;
  m.add({.name = "cam", .mass = 1, .inertia = 0.01, .pose = {0, 0, 0.2}});
  m.add({.name = "lever", .mass = mass, .inertia = 0.1, .pose = {-pin, 0, 0.3}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1});
  m.add("hinge", Revolute{.body_a = ground, .body_b = 2, .p_a = {-pin, 0}});
  m.add("motor", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = spin}});
  FlatFacedCam cam{.body_a = 1, .body_b = 2};
  eccentric_circle(cam.angles, cam.radii);
  m.add("contact", cam);
  Machine machine(m);
  machine.start_from_pose();
  for (int i = 0; i < 12; ++i) {
    run(machine, 0.1, 1e-2);
    const double q = 0.2 + spin * machine.time();
    const double dx = pin + eccentricity * std::cos(q), dy = eccentricity * std::sin(q);
    EXPECT_NEAR(machine.body(2).angle, std::atan2(dy, dx) + std::asin(radius / std::hypot(dx, dy)), 1e-10);
    EXPECT_NEAR(machine.joint_reaction("contact").moment, 0, 1e-11);
  }
}

// A bead on a circular wire is a pendulum. The spline through points 2 deg apart misses the circle by R h^4/384 = 2e-9
// m and its slope by R h^3/24 = 1e-6, alternating from point to point, which averages out over a swing. Where
// the third derivative jumps, at every point, a step is of order 3 only: 1e-6 J is seen of the 5 J that swing, and 2e-7
// of the energy is as much of the way: some 1e-7 m of the 3 m that the bead travels.
TEST(PointOnCurve, BeadOnACircle) {
  constexpr double r = 0.5, start = 1.1;
  Model m;
  m.add({.name = "bead", .mass = 1, .inertia = 0.1, .pose = {r * std::sin(start), -r * std::cos(start), 0}});
  PointOnCurve wire{.body_a = ground, .body_b = 1, .closed = true};
  for (int i = 0; i < 180; ++i)
    wire.points.push_back({r * std::sin(i * std::numbers::pi / 90), -r * std::cos(i * std::numbers::pi / 90)});
  m.add("wire", wire);
  Machine machine(m);
  machine.start_from_pose();
  run(machine, 3, 1e-3);
  const auto y = test::solve_ode(
      [](const auto& s, auto& rate, double) {
        rate = {s[1], -g / r * std::sin(s[0])};
      },
      {start, 0}, 0, 3);
  EXPECT_NEAR(machine.body(1).r.x, r * std::sin(y[0]), 6e-7);
  EXPECT_NEAR(machine.body(1).r.y, -r * std::cos(y[0]), 6e-7);
  EXPECT_NEAR(machine.energy().balance(), 0, 5e-6);
}

// Points on a straight line are that line, also beyond the last of them: constant acceleration down a slope of 0.5.
TEST(PointOnCurve, GoesOnStraightBeyondItsEnd) {
  Model m;
  m.add({.name = "bead", .mass = 1, .inertia = 0.1, .pose = {0.2, -0.1, 0}});
  m.add("wire", PointOnCurve{.body_a = ground, .body_b = 1, .points = {{0, 0}, {0.4, -0.2}, {0.5, -0.25}, {1, -0.5}}});
  Machine machine(m);
  machine.start_from_pose();
  run(machine, 1, 1e-2);
  const double x = 0.2 + g * 0.5 / 1.25 / 2;  // sin cos of the slope: 0.5/1.25
  EXPECT_GT(x, 1.5);
  EXPECT_NEAR(machine.body(1).r.x, x, 1e-11);
  EXPECT_NEAR(machine.body(1).r.y, -x / 2, 1e-11);
}

}  // namespace
}  // namespace subsoil::mbd::cams_test
