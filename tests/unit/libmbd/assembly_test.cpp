// Assembly from rough guesses; redundant, inconsistent and over-determined constraints are named.

#include "libmbd/assembly/assembly.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "libmbd/drivers/coordinate_driver.hpp"
#include "libmbd/joints/fixed.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/message_of.hpp"

namespace subsoil::mbd::assembly_test {
namespace {

/// A beam of length 2 between two posts at x = -1 and 1, the second pin off by `gap`.
Model beam(double gap) {
  Model m;
  m.add({.name = "beam", .mass = 3, .inertia = 1});
  m.add("left", Revolute{.body_a = ground, .body_b = 1, .p_a = {-1, 0}, .p_b = {-1, 0}});
  m.add("right", Revolute{.body_a = ground, .body_b = 1, .p_a = {1 + gap, 0}, .p_b = {1, 0}});
  return m;
}

std::string refusal(const Model& model) {
  return test::message_of<std::invalid_argument>([&] { Machine(model).start_from_pose(); });
}

TEST(Assembly, RedundantConstraintsAreNamedAndShareTheReactionWithLeastNorm) {
  Machine machine(beam(0));
  const auto& report = machine.start_from_pose();
  EXPECT_EQ(report.equations, 4);
  EXPECT_EQ(report.rank, 3);
  EXPECT_EQ(report.freedom, 0);
  ASSERT_EQ(report.redundant.size(), 1U);
  EXPECT_EQ(report.redundant[0], "the constraints of joint 'left' and joint 'right' depend on each other");
  EXPECT_NEAR(machine.joint_reaction("left").fy, -3 * 9.81 / 2, 1e-12);  // on the ground
  EXPECT_NEAR(machine.joint_reaction("right").fy, -3 * 9.81 / 2, 1e-12);
  EXPECT_NEAR(machine.joint_reaction("left").fx, 0, 1e-12);  // the undetermined thrust is zero, not arbitrary
  for (int i = 0; i < 10; ++i) machine.advance(1e-2);
  EXPECT_NEAR(machine.body(1).r.y, 0, 1e-14);
}

TEST(Assembly, RedundantConstraintsAreRefusedOnWish) {
  Model model = beam(0);
  model.redundancy = Redundancy::refuse;
  EXPECT_EQ(refusal(model),
            "the machine has redundant constraints: the constraints of joint 'left' and joint 'right' depend on each "
            "other. Free one of each group, or let redundant be minimum-norm");
}

TEST(Assembly, ContradictionIsRefusedWithJointsAndResiduals) {
  // The least-squares pose leaves half of the 20 mm at either pin.
  EXPECT_EQ(
      refusal(beam(0.02)),
      "the machine cannot be assembled: joint 'left' by -0.01 m, joint 'right' by 0.01 m open. Over-determined by "
      "joint 'left' and joint 'right': drop one or correct its points.");
}

TEST(Assembly, LinkThatIsTooShortIsRefused) {
  Model m;
  m.add({.name = "link", .mass = 1, .inertia = 1, .pose = {0.1, 0.2, 0.3}});
  m.add("hook", Revolute{.body_a = ground, .body_b = 1, .p_a = {0, 0}, .p_b = {-0.5, 0}});
  m.add({.name = "far", .mass = 1, .inertia = 1, .pose = {3, 0, 0}});
  m.add("post", Fixed{.body_a = ground, .body_b = 2, .p_a = {3, 0}});
  m.add("pin", Revolute{.body_a = 1, .body_b = 2, .p_a = {0.5, 0}});
  const std::string text = refusal(m);
  EXPECT_EQ(text.find("the machine cannot be assembled: "), 0U) << text;
  EXPECT_NE(text.find("joint 'pin'"), std::string::npos) << text;
}

TEST(Assembly, OverDeterminedDriversAreNamed) {
  Model m;
  m.add({.name = "cart", .mass = 1, .inertia = 1});
  m.add("rail", Translational{.body_a = ground, .body_b = 1});
  m.add("slow", CoordinateDriver{.body = 1, .coordinate = Coordinate::x, .motion = {.velocity = 0.5}});
  m.add("fast", CoordinateDriver{.body = 1, .coordinate = Coordinate::x, .motion = {.velocity = 0.7}});
  const std::string text = refusal(m);
  EXPECT_EQ(
      text,
      "the velocities asked of the machine contradict each other: driver 'slow' by 0.1 m/s, driver 'fast' by -0.1 "
      "m/s off. Over-determined by driver 'slow' and driver 'fast': drop a driver or free a joint.");
}

TEST(Assembly, LeastChange) {
  // A pinned bar, its pin pulled 0.3 m off: least change of (x, y, L angle) with L = 1 shares the gap between the
  // translation and the turn; moving only the body would change more.
  Model m;
  m.add({.name = "bar", .mass = 1, .inertia = 1, .pose = {1, 0.01, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-1, 0}});
  System system(m);
  Eigen::VectorXd q = system.start_position(), v = system.start_velocity();
  const auto report = assemble(system, 0, q, v);
  EXPECT_LT(report.residual, 1e-14);
  EXPECT_NEAR(q[1], 0.005, 1e-4);
  EXPECT_NEAR(q[2], 0.005, 1e-4);
}

/// A four-bar whose guess is some lengths off, the whole of it turned about the world's origin.
Model rough_four_bar(double turn) {
  Model m;
  const auto turned = [&](double x, double y) -> std::array<double, 2> {
    return {std::cos(turn) * x - std::sin(turn) * y, std::sin(turn) * x + std::cos(turn) * y};
  };
  const auto add = [&](const char* name, double x, double y, double angle) {
    const auto at = turned(x, y);
    m.add({.name = name, .mass = 1, .inertia = 1, .pose = {at[0], at[1], angle + turn}, .pose_is = StartMark::about});
  };
  add("crank", 1.7, 0.9, 0.4), add("coupler", -0.8, 2.1, 1.3), add("rocker", 2.2, -1.1, 2.5);
  m.add("a", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.5, 0}});
  m.add("b", Revolute{.body_a = 1, .body_b = 2, .p_a = {0.5, 0}, .p_b = {-1, 0}});
  m.add("c", Revolute{.body_a = 2, .body_b = 3, .p_a = {1, 0}, .p_b = {0.75, 0}});
  m.add("d", Revolute{.body_a = ground, .body_b = 3, .p_a = turned(2, 0), .p_b = {-0.75, 0}});
  return m;
}

// The pose found from a guess turns with machine and guess. A step shortened by its largest coordinate does not: it
// depends on the axes. Rounding of some ten Newton steps is what may differ.
TEST(Assembly, ThePoseFromAGuessTurnsWithTheMachine) {
  const auto assembled = [](double turn) {
    System system(rough_four_bar(turn));
    Eigen::VectorXd q = system.start_position(), v = system.start_velocity();
    EXPECT_GT(assemble(system, 0, q, v).moved, 0.5);
    return q;
  };
  const Eigen::VectorXd plain = assembled(0);
  for (const double turn : {0.3, 0.785, 1.7, 3.9}) {
    const Eigen::VectorXd q = assembled(turn);
    for (int i = 0; i < q.size(); i += 3) {
      EXPECT_NEAR(q[i], std::cos(turn) * plain[i] - std::sin(turn) * plain[i + 1], 1e-12) << turn;
      EXPECT_NEAR(q[i + 1], std::sin(turn) * plain[i] + std::cos(turn) * plain[i + 1], 1e-12) << turn;
      EXPECT_NEAR(q[i + 2], plain[i + 2] + turn, 1e-12) << turn;
    }
  }
}

TEST(Assembly, VelocitiesBecomeConsistent) {
  Model m;
  m.add({.name = "bar", .mass = 1, .inertia = 1, .pose = {1, 0, 0}, .velocity = {0.3, 2, 2}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-1, 0}});
  Machine machine(m);
  machine.start_from_pose();
  EXPECT_NEAR(machine.body(1).v.x, 0, 1e-15);  // along the bar the pin allows nothing
  EXPECT_NEAR(machine.body(1).v.y, 2, 1e-14);
  EXPECT_NEAR(machine.body(1).omega, 2, 1e-14);
}

}  // namespace
}  // namespace subsoil::mbd::assembly_test
