// Joints, drivers and functions of time as a scenario writes them: what is read, that it reads back, what is refused.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/drivers/distance_driver.hpp"
#include "libmbd/elements.hpp"
#include "libmbd/joints/cam_follower.hpp"
#include "libmbd/joints/distance.hpp"
#include "libmbd/joints/flat_faced_cam.hpp"
#include "libmbd/joints/gear_ratio.hpp"
#include "libmbd/joints/point_on_curve.hpp"
#include "libmbd/joints/point_on_line.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim::scenario_elements_test {
namespace {

/// Two turned bodies and a third one; the element stands in line 9, column 8.
std::string machine_with(const std::string& list, const std::string& element) {
  return "subsoil: 1\ntime: {end: 1 s}\nmachine:\n  bodies:\n"
         "    a: {mass: 1 kg, inertia: 1 kg m^2, at: 1 0 m, angle: 90 deg, velocity: 0.5 0 m/s}\n"
         "    b: {mass: 1 kg, inertia: 1 kg m^2, at: 3 1 m}\n"
         "    c: {mass: 1 kg, inertia: 1 kg m^2, at: 0 0 m}\n  " +
         list + ":\n    e: " + element + "\n";
}

/// Reads the element and checks that the explicit copy of the scenario reads back to the same copy.
Scenario read(const std::string& list, const std::string& element) {
  const Scenario scenario = load_scenario_text(machine_with(list, element), "m.yaml").scenario;
  const std::string copy = write_scenario(scenario);
  EXPECT_EQ(write_scenario(load_scenario_text(copy, "copy.yaml").scenario), copy);
  return scenario;
}
template <class Joint>
Joint joint(const std::string& text) {
  return read("joints", text).machine->joints.at(0).element.template get<Joint>();
}
template <class Driver>
Driver driver(const std::string& text) {
  return read("drivers", text).machine->drivers.at(0).element.template get<Driver>();
}

std::string refusal(const std::string& list, const std::string& element) {
  try {
    load_scenario_text(machine_with(list, element), "m.yaml");
  } catch (const ScenarioError& e) {
    return e.lines.front();
  }
  return "accepted";
}

void expect_point(const std::array<double, 2>& p, double x, double y) {
  EXPECT_NEAR(p[0], x, 1e-15);
  EXPECT_NEAR(p[1], y, 1e-15);
}

// Body a stands at (1, 0), a quarter turn ahead: the world point (x, y) is (y, 1 - x) in its axes.
TEST(ScenarioJoints, SlotsAndLinks) {
  const auto slot = joint<mbd::PointOnLine>("{point on line: [a, b], at: 3 1 m, along: 0 1}");
  expect_point(slot.p_a, 1, -2);
  expect_point(slot.p_b, 0, 0);
  EXPECT_NEAR(slot.angle_a, 0, 1e-15);
  const auto link = joint<mbd::Distance>("{distance: [a, b], ends: [1 1 m, 3 2 m], length: 80 cm}");
  expect_point(link.p_a, 1, 0);
  expect_point(link.p_b, 0, 1);
  EXPECT_EQ(link.length, 0.8);
  EXPECT_TRUE(std::isnan(joint<mbd::Distance>("{distance: [a, b], ends: [1 1 m, 3 2 m]}").length));
}

TEST(ScenarioJoints, RollingAndGears) {
  for (const char* word : {"disk on line", "rolling on line", "rack and pinion"}) {
    const std::string text = std::string("{") + word + ": [ground, b], ends: [0 0 m, 3 1 m], along: 1 0, radius: 1 m}";
    const Scenario s = read("joints", text);
    visit(
        [&](const auto& j) {
          if constexpr (requires { j.along(); }) {
            EXPECT_EQ(j.radius, 1);
            expect_point(j.p_b, 0, 0);
          } else {
            ADD_FAILURE() << word;
          }
        },
        s.machine->joints.at(0).element);
  }
  for (const char* word : {"disk on disk", "rolling on disk", "gear pair"}) {
    const std::string text = std::string("{") + word +
                             ": [ground, b], ends: [0 1 m, 3 1 m], first radius: 4 m, second radius: 1 m, inside: yes}";
    const Scenario s = read("joints", text);
    visit(
        [&](const auto& j) {
          if constexpr (requires { j.span(); }) {
            EXPECT_EQ(j.span(), 3);
            expect_point(j.p_a, 0, 1);
          } else {
            ADD_FAILURE() << word;
          }
        },
        s.machine->joints.at(0).element);
  }
  const auto train = joint<mbd::GearRatio>("{gear ratio: [a, b], ratio: -2.5, carrier: c}");
  EXPECT_EQ(train.ratio, -2.5);
  EXPECT_EQ(train.body_c, 3);
  EXPECT_EQ(joint<mbd::GearRatio>("{gear ratio: [a, b], ratio: 2}").body_c, mbd::ground);
}

TEST(ScenarioJoints, CamsAndPaths) {
  const std::string profile = "profile: [[0 deg, 40 mm], [90 deg, 42 mm], [180 deg, 44 mm], [270 deg, 42 mm]]";
  const auto cam = joint<mbd::CamFollower>("{cam: [a, b], ends: [1 0 m, 3 1 m], roller: 5 mm, " + profile + "}");
  EXPECT_EQ(cam.radii, (std::vector<double>{0.04, 0.042, 0.044, 0.042}));
  EXPECT_NEAR(cam.angles[1], std::numbers::pi / 2, 1e-15);
  EXPECT_EQ(cam.roller, 0.005);
  EXPECT_TRUE(cam.closed);
  const auto flat =
      joint<mbd::FlatFacedCam>("{flat-faced cam: [a, b], ends: [1 0 m, 3 1 m], face: 0 1, " + profile + "}");
  EXPECT_NEAR(flat.angle_b, std::numbers::pi / 2, 1e-15);  // of body b, which is not turned
  const auto path = joint<mbd::PointOnCurve>(
      "{point on curve: [ground, b], at: 3 2 m, curve: [0 0 m, 1 2 m, 300 200 cm], closed: yes}");
  expect_point(path.p_b, 0, 1);
  EXPECT_EQ(path.points, (std::vector<Vec2>{{0, 0}, {1, 2}, {3, 2}}));
  EXPECT_TRUE(path.closed);
}

TEST(ScenarioDrivers, DistanceAndAcceleration) {
  const auto cylinder = driver<mbd::DistanceDriver>("{distance: [a, b], ends: [1 1 m, 3 2 m], velocity: 20 mm/s}");
  expect_point(cylinder.p_b, 0, 1);
  EXPECT_EQ(cylinder.motion.velocity.value(1), 0.02);
  const auto push = driver<mbd::CoordinateDriver>("{coordinate: a.x, acceleration: 2 m/s^2}");
  EXPECT_EQ(push.motion.acceleration.value(0), 2);
}

TEST(ScenarioFunctions, ExpressionsWithTheirUnit) {
  const auto position = [](const std::string& function) {
    return driver<mbd::CoordinateDriver>("{coordinate: a.x, position: " + function + "}").motion.position;
  };
  EXPECT_NEAR(position("{expression: '0.1*sin(20*t)', unit: m}").second(0.3), -40 * std::sin(6), 1e-12);
  EXPECT_NEAR(position("{expression: 't^2', unit: mm}").value(3), 0.009, 1e-17);
  EXPECT_NEAR(position("[1 m, {expression: 2*t, unit: m}]").value(3), 7, 1e-14);
  const auto turn = driver<mbd::AngleDriver>("{angle: [a, b], velocity: {expression: 180*cos(t), unit: deg/s}}");
  EXPECT_NEAR(turn.motion.velocity.integral(1), std::numbers::pi * std::sin(1), 1e-13);
  const auto table = position("{table: {points: [[0 s, 0 m], [1 s, 1 m], [2 s, 0 m]], periodic: yes}}");
  EXPECT_NEAR(table.value(5), 1, 1e-14);
}

TEST(ScenarioFunctions, RefuseWithPlaceAndCure) {
  const auto position = [](const std::string& function) {
    return refusal("drivers", "{coordinate: a.x, position: " + function + "}");
  };
  EXPECT_EQ(position("{expression: 'sine(t)', unit: m}"),
            "m.yaml:9:49 machine.drivers.e.position.expression = sine(t): `sine` is no name of a formula in t; did you "
            "mean `sin`?");
  EXPECT_EQ(
      position("{expression: 't', unit: s}"),
      "m.yaml:9:60 machine.drivers.e.position.unit = s: `s` is a time (s), but needed is a length (m), such as m");
  EXPECT_EQ(position("{expression: 't'}"),
            "m.yaml:9:36 machine.drivers.e.position.unit: is missing: the unit of the formula's value, such as m");
  EXPECT_EQ(position("{expression: 't', unit: m, amplitude: 2}"),
            "m.yaml:9:63 machine.drivers.e.position.amplitude = 2: unknown key; it belongs at "
            "`function.harmonic.amplitude`");
}

TEST(ScenarioJoints, RefuseWithPlaceAndCure) {
  const auto joint = [](const std::string& text) { return refusal("joints", text); };
  EXPECT_EQ(joint("{distance: [a, b], ends: [1 1 m, 3 2 m], length: 0 m}"),
            "m.yaml:9:57 machine.joints.e.length = 0 m: must be in (0, inf) m");
  EXPECT_EQ(joint("{gear pair: [a, b], first radius: 1 m, second radius: 2 m}"),
            "m.yaml:9:8 machine.joints.e.ends: is missing: the centres of the two circles, in m");
  EXPECT_EQ(joint("{gear ratio: [a, b], ratio: 0}"),
            "m.yaml:9:8 machine.joints.e: ratio must be given and not 0; to hold the second body's angle use an angle "
            "driver");
  EXPECT_EQ(joint("{gear ratio: [a, b], ratio: 2, carrier: d}"),
            "m.yaml:9:48 machine.joints.e.carrier = d: there is no body of this name; did you mean `a`?");
  EXPECT_EQ(joint("{cam: [a, b], ends: [1 0 m, 3 1 m], profile: [[0 deg, 4 cm], [2 deg, 0 cm], [9 deg, 4 cm]]}"),
            "m.yaml:9:8 machine.joints.e: the profile's radii must be above 0 m; take a centre inside the profile");
  // The points mirror each other about x = 1, so the crossing is there.
  const std::string crossing = joint("{point on curve: [a, b], curve: [0 0 m, 2 2 m, 0 2 m, 2 0 m]}");
  EXPECT_TRUE(crossing.starts_with("m.yaml:9:8 machine.joints.e: the curve crosses itself near 1.000000 ")) << crossing;
  EXPECT_EQ(refusal("drivers", "{distance: [a, b], ends: [1 1 m, 3 2 m]}"),
            "m.yaml:9:8 machine.drivers.e: needs exactly one of position, velocity and acceleration as a function of "
            "time; give one, leave the others out");
}

}  // namespace
}  // namespace subsoil::sim::scenario_elements_test
