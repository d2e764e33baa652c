// What single joints and drivers promise in their cards beside their equations: refusals, start values, validity.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/drivers/distance_driver.hpp"
#include "libmbd/joints/cam_follower.hpp"
#include "libmbd/joints/distance.hpp"
#include "libmbd/joints/flat_faced_cam.hpp"
#include "libmbd/joints/gear_pair.hpp"
#include "libmbd/joints/gear_ratio.hpp"
#include "libmbd/joints/point_on_curve.hpp"
#include "libmbd/joints/rolling_on_line.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::mbd::joints_test {
namespace {

/// Two bodies, the first at the origin, the second at (1, 0), and a joint or driver between them.
std::string refusal(auto element) {
  Model m;
  m.add({.name = "first", .mass = 1, .inertia = 1});
  m.add({.name = "second", .mass = 1, .inertia = 1, .pose = {1, 0, 0}});
  m.add("it", element);
  return test::message_of<std::invalid_argument>([&] { System system(m); });
}

std::vector<double> full_turn(int points) {
  std::vector<double> angles;
  for (int i = 0; i < points; ++i) angles.push_back(2 * std::numbers::pi * i / points);
  return angles;
}

TEST(Joints, RefuseWithRuleAndCure) {
  EXPECT_EQ(refusal(Distance{.body_a = 1, .body_b = 2, .length = 0}),
            "joint 'it': length = 0.000000 m: must be in (0, inf); for two points on each other use a revolute joint");
  EXPECT_EQ(
      refusal(Distance{.body_a = 1, .body_b = 2, .p_a = {1, 0}}),
      "joint 'it': the two points lie on each other in the start pose, so the link has no length; give `length`, or "
      "use a revolute joint");
  EXPECT_EQ(refusal(RollingOnLine{{.body_a = 1, .body_b = 2}}), "joint 'it': radius must be given and above 0 m");
  EXPECT_EQ(
      refusal(RollingOnLine{{.body_a = 1, .body_b = 2, .radius = 1}}),
      "joint 'it': the disk's centre lies on the line in the start pose, so its side is not known; start it on its "
      "side of the line");
  EXPECT_EQ(refusal(GearPair{{.body_a = 1, .body_b = 2, .radius_a = 1, .radius_b = 1, .inside = true}}),
            "joint 'it': a disk inside one of the same radius cannot move in it; make one smaller, or use a revolute "
            "joint");
  EXPECT_EQ(
      refusal(GearPair{{.body_a = 1, .body_b = 2, .p_a = {1, 0}, .radius_a = 1, .radius_b = 2}}),
      "joint 'it': the two centres lie on each other in the start pose, so their line has no direction; start them "
      "apart");
  EXPECT_EQ(refusal(GearRatio{.body_a = 1, .body_b = 2, .ratio = 0}),
            "joint 'it': ratio must be given and not 0; to hold the second body's angle use an angle driver");
  EXPECT_EQ(refusal(GearRatio{.body_a = 1, .body_b = 2, .body_c = 2, .ratio = 2}),
            "joint 'it' names 'second' twice; its third body must be another one, or the ground");
  EXPECT_EQ(refusal(DistanceDriver{.first = 1, .second = 2, .p_a = {1, 0}, .motion = {.velocity = 1.0}}),
            "driver 'it': its two ends lie on each other in the start pose, so it has no direction; start them apart");
  EXPECT_EQ(
      refusal(AngleDriver{.first = 1, .second = 2, .motion = {.velocity = 1.0, .acceleration = 1.0}}),
      "driver 'it': needs exactly one of position, velocity and acceleration as a function of time; give one, leave "
      "the others out");
}

// An ellipse of half axes 2 and 1 in polar form, and the same with a hollow: r = 1 + 0.5 cos(2 a) is hollow at 90 deg,
// where its curvature (r^2 + 2 r'^2 - r r'') / r^3 is (0.25 - 1) / 0.125 = -6.
TEST(Joints, CamsRefuseWhatTheyCannotFollow) {
  CamFollower cam{.body_a = 1, .body_b = 2, .angles = full_turn(720)};
  for (const double a : cam.angles) cam.radii.push_back(1 + 0.5 * std::cos(2 * a));
  cam.roller = 0.16;
  EXPECT_EQ(refusal(cam), "accepted");
  cam.roller = 0.17;
  const std::string too_large = refusal(cam);
  EXPECT_TRUE(
      too_large.starts_with("joint 'it': a roller of 0.170000 m does not fit into the profile's hollow of radius "
                            "0.1666"))
      << too_large;
  EXPECT_TRUE(too_large.ends_with("deg; take a smaller roller, or widen the hollow")) << too_large;
  const std::string hollow = refusal(FlatFacedCam{.body_a = 1, .body_b = 2, .angles = cam.angles, .radii = cam.radii});
  EXPECT_TRUE(hollow.starts_with("joint 'it': the profile is not convex at ")) << hollow;
  std::vector<double> ellipse;
  for (const double a : cam.angles) ellipse.push_back(2 / std::hypot(std::cos(a), 2 * std::sin(a)));
  EXPECT_EQ(refusal(FlatFacedCam{.body_a = 1, .body_b = 2, .p_b = {0, 2}, .angles = cam.angles, .radii = ellipse}),
            "accepted");
  EXPECT_EQ(refusal(CamFollower{.body_a = 1, .body_b = 2, .angles = {0, 1, 2}, .radii = {1, 0, 1}}),
            "joint 'it': the profile's radii must be above 0 m; take a centre inside the profile");
  EXPECT_EQ(refusal(CamFollower{.body_a = 1, .body_b = 2, .angles = {0, 2, 1}, .radii = {1, 1, 1}}),
            "joint 'it': angles must increase; point 3 does not come after the one before");
}

TEST(Joints, PathsRefuseWhatTheyCannotFollow) {
  const auto path = [](std::vector<std::array<double, 2>> points) {
    return refusal(PointOnCurve{.body_a = 1, .body_b = 2, .points = std::move(points)});
  };
  EXPECT_EQ(path({{0, 0}, {1, 0}}), "joint 'it': a path needs at least three points");
  EXPECT_EQ(path({{0, 0}, {1, 0}, {1, 0}}), "joint 'it': point 3 of the path lies on the one before; leave it out");
  EXPECT_TRUE(path({{0, 0}, {2, 2}, {0, 2}, {2, 0}}).starts_with("joint 'it': the curve crosses itself near "));
  EXPECT_EQ(path({{0, 0}, {2, 2}, {0, 3}}), "accepted");
}

// A circle of radius 2 about (0.5, 0), by points every 3 deg: distance, normal and curvature of points inside and
// outside against the circle itself. The spline misses it by R h^4/384 = 4e-8, its slope by h^3/24 R = 1e-5.
TEST(Curve, NearestPointOfACircle) {
  std::vector<std::array<double, 2>> points;
  for (int i = 0; i < 120; ++i)
    points.push_back({0.5 + 2 * std::cos(i * std::numbers::pi / 60), 2 * std::sin(i * std::numbers::pi / 60)});
  const Curve circle = Curve::through(points, true);
  for (const double far : {0.3, 1.9, 2.0, 2.7, 40.0})
    for (double a = 0.01; a < 6.3; a += 0.37) {
      const Curve::Nearest c = circle.nearest({0.5 + far * std::cos(a), far * std::sin(a)});
      EXPECT_NEAR(c.distance, 2 - far, 1e-7) << far << " at " << a;  // counter-clockwise: the inside is on its left
      EXPECT_NEAR(dot(c.normal, {std::cos(a), std::sin(a)}), -1, 1e-8);
      EXPECT_NEAR(c.curvature, 0.5, 1e-3);
    }
  Vec2 where;
  EXPECT_FALSE(circle.crosses_itself(where));
}

// An open curve 1 km from the origin, and points far beside it: the distance is that of the same curve at the origin,
// to the rounding of the coordinates, some 2e-13 m at 1 km. Newton's steps do not become shorter than that.
TEST(Curve, NearestPointFarFromTheOrigin) {
  const std::vector<std::array<double, 2>> points{
      {-0.2, 0}, {-0.1, 0.04546}, {0, -0.03784}, {0.1, -0.01397}, {0.2, 0.04947}};
  const Curve here = Curve::through(points, false);
  for (const double way : {1.0, 1024.0, 1e5}) {
    std::vector<std::array<double, 2>> moved = points;
    for (auto& p : moved) p[0] += way, p[1] -= 0.25 * way;
    const Curve there = Curve::through(moved, false);
    for (const double x : {-0.5, -0.2, -0.13, 0.016, 0.1, 0.2, 0.31})
      for (const double y : {-0.2, 0.01, 0.3}) {
        const Vec2 w{x, y}, far{x + way, y - 0.25 * way};
        EXPECT_NEAR(there.nearest(far).distance, here.nearest(w).distance, 1e-14 + 1e-15 * way)
            << way << " " << x << " " << y;
      }
  }
  // Beside a straight end the distance is the way to it, however long.
  const Curve line = Curve::through({{0, 0}, {0.1, 0}, {0.2, 0}}, false);
  for (const double y : {1.0, 1e3, 1e6}) EXPECT_NEAR(line.nearest({0.15, y}).distance, y, 1e-15 * y);
}

// The support function of an ellipse of half axes 2 and 1 is sqrt(4 cos^2 + sin^2). Polar points every degree: errors
// of h^4/384 of derivatives up to some 30 are 1e-8 in the value.
TEST(Curve, SupportFunctionOfAnEllipse) {
  std::vector<double> angles = full_turn(360), radii;
  for (const double a : angles) radii.push_back(2 / std::hypot(std::cos(a), 2 * std::sin(a)));
  const Curve ellipse = Curve::polar(angles, radii, true);
  for (double b = -3; b < 3; b += 0.31) {
    const double h = std::sqrt(4 * std::cos(b) * std::cos(b) + std::sin(b) * std::sin(b));
    const double first = -3 * std::sin(b) * std::cos(b) / h;
    const double second = (-3 * std::cos(2 * b) - first * first) / h;
    const Curve::Support s = ellipse.support(b);
    EXPECT_NEAR(s.value, h, 1e-7);
    EXPECT_NEAR(s.first, first, 1e-5);
    EXPECT_NEAR(s.second, second, 5e-3);
    EXPECT_NEAR(dot(s.point, {std::cos(b), std::sin(b)}), h, 1e-7);
  }
}

// Position, rate and second rate of each way to give a motion, against the same motion by hand from t_0 = 1.5 on.
TEST(Motion, FromPositionVelocityAndAcceleration) {
  const double w = 2 * std::numbers::pi * 0.5, phase = 0.2, amplitude = 3, t_0 = 1.5, x_0 = 0.1, v_0 = 0.7;
  const HarmonicFunction swing{.amplitude = amplitude, .frequency = 0.5, .phase = phase};
  Motion by_velocity{.velocity = swing}, by_acceleration{.acceleration = swing};
  by_velocity.initialise_from_pose(x_0, v_0, t_0);
  by_acceleration.initialise_from_pose(x_0, v_0, t_0);
  const auto s = [&](double t) { return std::sin(w * t + phase); };
  const auto c = [&](double t) { return std::cos(w * t + phase); };
  for (const double t : {0.2, 1.5, 1.7, 4.0}) {
    EXPECT_NEAR(by_velocity.value(t), x_0 + amplitude / w * (c(t_0) - c(t)), 1e-14);
    EXPECT_NEAR(by_velocity.rate(t), amplitude * s(t), 1e-14);
    EXPECT_NEAR(by_velocity.second(t), amplitude * w * c(t), 1e-13);
    const double since = t - t_0;
    EXPECT_NEAR(by_acceleration.value(t),
                x_0 + v_0 * since + amplitude / w * c(t_0) * since - amplitude / (w * w) * (s(t) - s(t_0)), 1e-14);
    EXPECT_NEAR(by_acceleration.rate(t), v_0 + amplitude / w * (c(t_0) - c(t)), 1e-14);
    EXPECT_NEAR(by_acceleration.second(t), amplitude * s(t), 1e-14);
  }
}

// A driver by acceleration keeps its start over a restart: saved and restored, the machine runs on with the same bits.
TEST(Motion, AccelerationSurvivesARestart) {
  Model m;
  m.gravity = {0, 0};
  m.add({.name = "block", .mass = 1, .inertia = 1, .velocity = {0.4, 0, 0}});
  m.add("guide", Translational{.body_a = ground, .body_b = 1});
  m.add("drive", CoordinateDriver{.body = 1, .motion = {.acceleration = HarmonicFunction{.amplitude = 2}}});
  Machine machine(m), again(m);
  machine.start_from_pose();
  for (int i = 0; i < 30; ++i) machine.advance(0.01);
  again.restore(machine.snapshot());
  for (int i = 0; i < 30; ++i) machine.advance(0.01), again.advance(0.01);
  EXPECT_EQ(machine.body(1).r.x, again.body(1).r.x);
  EXPECT_EQ(machine.body(1).v.x, again.body(1).v.x);
}

}  // namespace
}  // namespace subsoil::mbd::joints_test
