// The start that a user gives is the start that is run, or a refusal lists what the joints would make of it.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::mbd::start_test {
namespace {

/// A rod of 1 m, pinned to the ground by its left end at `pin`, its centre of gravity given at x = 0.5 m.
Model rod(double spin, std::array<double, 2> pin = {0, 0}) {
  Model m;
  m.add({.name = "rod", .mass = 3, .inertia = 0.25, .pose = {0.5, 0, 0}, .velocity = {0, 0, spin}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_a = pin, .p_b = {-0.5, 0}});
  return m;
}

constexpr MachineOptions held{.hold_start = true};

std::string refusal(const Model& model) {
  return test::message_of<std::invalid_argument>([&] { Machine(model, held).start_from_pose(); });
}

// Least change of all velocities would leave 8 rad/s and 4 m/s of 10 rad/s and 0 (5 rad/s with lengths of 1 m).
TEST(Start, VelocitiesThatAreGivenStayAndTheOthersFollow) {
  Machine machine(rod(10), held);
  machine.start_from_pose();
  EXPECT_NEAR(machine.body(1).omega, 10, 1e-12);
  EXPECT_NEAR(machine.body(1).v.y, 5, 1e-12);
  EXPECT_NEAR(machine.body(1).v.x, 0, 1e-12);
}

TEST(Start, VelocitiesThatContradictTheJointsAreRefused) {
  Model m = rod(10);
  m.bodies[0].velocity = {0, 4, 10};  // 5 m/s at 10 rad/s
  const std::string text = refusal(m);
  EXPECT_NE(text.find("body 'rod' velocity y: given 4, assembled "), std::string::npos) << text;
  EXPECT_NE(text.find("body 'rod' spin: given 10, assembled "), std::string::npos) << text;
  EXPECT_NE(text.find("velocity is: about"), std::string::npos) << text;
  m.bodies[0].velocity_is = StartMark::about;
  Machine machine(m, held);
  machine.start_from_pose();
  EXPECT_NEAR(machine.body(1).v.y, 0.5 * machine.body(1).omega, 1e-12);
}

TEST(Start, ADriverDoesNotOverruleAGivenVelocity) {
  Model m = rod(10);
  m.add("motor", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = 4.0}});
  EXPECT_NE(refusal(m).find("body 'rod' spin: given 10, assembled 4, difference -6 rad/s"), std::string::npos)
      << refusal(m);
}

// Zeros that are exact count as given.
TEST(Start, ExactVelocitiesStayZeroToo) {
  Model m = rod(10);
  m.bodies[0].velocity_is = StartMark::exact;
  EXPECT_NE(refusal(m).find("velocity y: given 0, assembled "), std::string::npos) << refusal(m);
}

// A slip of the pen in a pin: the body would be carried 20 m away.
TEST(Start, ABodyIsNotCarriedAway) {
  const std::string text = refusal(rod(0, {-20, 0}));
  EXPECT_NE(text.find("body 'rod' x: given 0.5, assembled -19.5"), std::string::npos) << text;
  EXPECT_NE(text.find("pose is: about"), std::string::npos) << text;
  Model about = rod(0, {-20, 0});
  about.bodies[0].pose_is = StartMark::about;
  Machine machine(about, held);
  EXPECT_NEAR(machine.start_from_pose().moved, 20, 1e-9);
  EXPECT_EQ(machine.assembly().moved_body, "rod");
}

// What rounding of a drawing's numbers leaves is taken up: 1 % of the rod's arm of 0.5 m is 5 mm.
TEST(Start, RoundedPosesAreClosed) {
  Machine machine(rod(0, {0.004, 0}), held);
  machine.start_from_pose();
  EXPECT_NEAR(machine.body(1).r.x, 0.504, 1e-12);
  EXPECT_NE(refusal(rod(0, {0.006, 0})), "");
}

// Of two rods on a common pin the exact one stays, and the other comes to it.
TEST(Start, AnExactPoseIsNotMoved) {
  Model m;
  m.add({.name = "first", .mass = 1, .inertia = 0.1, .pose = {0.5, 0, 0}});
  m.add({.name = "second", .mass = 1, .inertia = 0.1, .pose = {1.53, 0, 0}});
  m.add("pin", Revolute{.body_a = 1, .body_b = 2, .p_a = {0.5, 0}, .p_b = {-0.5, 0}});
  m.bodies[0].pose_is = StartMark::exact;
  m.bodies[1].pose_is = StartMark::about;
  Machine machine(m, held);
  machine.start_from_pose();
  EXPECT_EQ(machine.body(1).r.x, 0.5);
  EXPECT_NEAR(machine.body(2).r.x, 1.5, 1e-12);
  m.bodies[0].pose_is = StartMark::given;
  m.bodies[1].pose_is = StartMark::exact;
  Machine other(m);
  other.start_from_pose();
  EXPECT_EQ(other.body(2).r.x, 1.53);
}

/// Crank 100 mm and rod 200 mm, stretched along x; the slider is driven.
Model stretched_slider_crank(double angle) {
  Model m;
  const double x = 0.1 * std::cos(angle), y = 0.1 * std::sin(angle), fall = std::asin(y / 0.2),
               slider = x + 0.2 * std::cos(fall);
  m.add({.name = "crank", .mass = 1, .inertia = 0.01, .pose = {x / 2, y / 2, angle}});
  m.add({.name = "rod", .mass = 1, .inertia = 0.02, .pose = {(x + slider) / 2, y / 2, -fall}});
  m.add({.name = "slider", .mass = 1, .inertia = 0.01, .pose = {slider, 0, 0}});
  m.add("main", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.05, 0}});
  m.add("crankpin", Revolute{.body_a = 1, .body_b = 2, .p_a = {0.05, 0}, .p_b = {-0.1, 0}});
  m.add("wrist", Revolute{.body_a = 2, .body_b = 3, .p_a = {0.1, 0}});
  m.add("guide", Translational{.body_a = ground, .body_b = 3});
  m.add("push", CoordinateDriver{.body = 3, .coordinate = Coordinate::x, .motion = {.velocity = -0.1}});
  return m;
}

// At dead centre the slider cannot move; beside it, it can. Nothing is over-determined: 9 equations, 9 coordinates.
TEST(Start, ASingularConfigurationIsNamedSo) {
  const std::string text = refusal(stretched_slider_crank(0));
  EXPECT_NE(text.find("the start pose is a singular configuration"), std::string::npos) << text;
  EXPECT_NE(text.find("driver 'push'"), std::string::npos) << text;
  EXPECT_EQ(text.find("Over-determined"), std::string::npos) << text;
  EXPECT_EQ(refusal(stretched_slider_crank(0.1)), "accepted");
}

// Two drivers of one freedom contradict each other in every pose.
TEST(Start, TwoDriversOfOneFreedomAreOverDetermined) {
  Model m = stretched_slider_crank(0.5);
  m.add("turn", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = 3.0}});
  const std::string text = refusal(m);
  EXPECT_NE(text.find("Over-determined"), std::string::npos) << text;
  EXPECT_EQ(text.find("singular configuration"), std::string::npos) << text;
}

}  // namespace
}  // namespace subsoil::mbd::start_test
