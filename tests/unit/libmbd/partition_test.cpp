// The sparse partition against the dense equations of motion.

#include "libmbd/assembly/partition.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <string>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/drivers/angle_driver.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/machine.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/rig.hpp"

namespace subsoil::mbd::partition_test {
namespace {

/// Two driven arms of any size: an angle is rounded to 2e-16 rad, which in a machine of millimetres is no open joint.
TEST(Partition, ClosesAnglesOfAMachineOfAnySize) {
  for (const double size : {1e-4, 1e-3, 2e-3, 0.02, 1.0, 100.0}) {
    Model m;
    m.gravity = {0, 0};
    m.add({.name = "crank", .mass = 1, .inertia = size * size, .pose = {0, 0, 0}});
    m.add({.name = "arm", .mass = 1, .inertia = size * size, .pose = {size, 0, 0}});
    m.add("pin", Revolute{.body_a = ground, .body_b = 1});
    m.add("knee", Revolute{.body_a = 1, .body_b = 2, .p_a = {0.5 * size, 0}, .p_b = {-0.5 * size, 0}});
    m.add("turn", AngleDriver{.first = ground, .second = 1, .motion = {.velocity = 10.0}});
    m.add("fold", AngleDriver{.first = 1, .second = 2, .motion = {.velocity = 7.3}});
    Machine machine(m);
    machine.start_from_pose();
    for (int k = 0; k < 300; ++k) ASSERT_NO_THROW(machine.advance(0.01)) << size;
    EXPECT_NEAR(machine.body(2).angle, 51.9, 1e-9) << size;
  }
}

/// A chain of bars listed from the tip to the ground, closed to the ground by a last pin: open order and a loop.
Model loop(int bars) {
  Model m;
  const double bend = 2.5 / bars;
  Vec2 end{};
  for (int i = 0; i < bars; ++i) {
    const double angle = 1.2 - i * bend;
    const Vec2 e{std::cos(angle), std::sin(angle)};
    m.add({.name = "bar " + std::to_string(i),
           .mass = 1 + 0.1 * i,
           .inertia = 0.1,
           .pose = {end.x + e.x / 2, end.y + e.y / 2, angle},
           .velocity = {0.1, 0.2, 0.3 * i}});
    end = end + e;
  }
  m.add("last", Revolute{.body_a = bars, .body_b = ground, .p_a = {0.5, 0}, .p_b = {end.x, end.y}});
  for (int i = bars; i-- > 0;)
    m.add("pin " + std::to_string(i),
          Revolute{.body_a = i, .body_b = i + 1, .p_a = {i == 0 ? 0.0 : 0.5, 0}, .p_b = {-0.5, 0}});
  return m;
}

TEST(BlowUp, SaysBeyondWhat) {
  const System system(loop(3));
  MotionState m;
  m.q = system.start_position(), m.velocity = system.start_velocity();
  EXPECT_NO_THROW(refuse_blow_up(system, m));
  Model far = loop(3);
  for (Body& b : far.bodies) b.pose[0] += 2e6;
  const System elsewhere(std::move(far));
  MotionState there = m;
  there.q = elsewhere.start_position();
  EXPECT_NO_THROW(refuse_blow_up(elsewhere, there)) << "far from the origin is no motion";
  MotionState shaft = m;  // 300 rad/s for two hours, and what turns a thousand times as fast at the end
  shaft.t = 7200, shaft.q[2] += 300 * shaft.t, shaft.velocity[2] = 300;
  EXPECT_NO_THROW(refuse_blow_up(system, shaft));
  shaft.velocity[2] = 3e5;
  EXPECT_THROW(refuse_blow_up(system, shaft), BlowUp);
  shaft.q[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(refuse_blow_up(system, shaft), BlowUp);
  m.velocity[2] = 1e9;
  const std::string text = test::message_of<BlowUp>([&] { refuse_blow_up(system, m); });
  EXPECT_NE(text.find("body 'bar 0'"), std::string::npos) << text;
  EXPECT_NE(text.find("beyond a million lengths of the machine from its start within a tenth of the time, or ten "
                      "million in a second"),
            std::string::npos)
      << text;
}

void compare_with_dense(Model model) {
  System system(std::move(model));
  MotionState m;
  m.q = system.start_position(), m.velocity = system.start_velocity();
  assemble(system, 0, m.q, m.velocity);
  const auto n = system.coordinates(), r = system.equations();
  m.acceleration.setZero(n), m.lambda.setZero(r);
  m.rates.setZero(static_cast<Eigen::Index>(2 * system.model().forces.size() + system.model().drivers.size()));
  Partition partition(system);
  partition.choose(m);
  ASSERT_EQ(partition.rank(), r);
  const Eigen::VectorXd q = m.q, velocity = m.velocity;
  for (const int i : partition.dependent()) m.q[i] += 1e-3, m.velocity[i] *= 0.5;  // a guess only
  partition.evaluate(m);
  EXPECT_LT((m.q - q).cwiseAbs().maxCoeff(), 1e-13 * r);
  EXPECT_LT((m.velocity - velocity).cwiseAbs().maxCoeff(), 1e-13 * r);

  Constraints c;
  Eigen::VectorXd load(n);
  system.set_state(0, q, velocity);
  system.constraints(c);
  system.loads(load);
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n + r, n + r);
  k.topLeftCorner(n, n) = system.mass().asDiagonal();
  k.topRightCorner(n, r) = c.jacobian.transpose(), k.bottomLeftCorner(r, n) = c.jacobian;
  Eigen::VectorXd right(n + r);
  right << load, c.gamma;
  const Eigen::VectorXd exact = k.fullPivLu().solve(right);
  // The dense matrix mixes masses of 1e-1 to 1e5 with levers of 1: its condition, some 1e6, is the tolerance.
  const double most = exact.cwiseAbs().maxCoeff();
  EXPECT_LT((m.acceleration - exact.head(n)).cwiseAbs().maxCoeff(), 1e-10 * most);
  EXPECT_LT((m.lambda - exact.tail(r)).cwiseAbs().maxCoeff(), 1e-10 * most);
}

TEST(Partition, AgreesWithTheDenseEquationsOfMotion) {
  {
    SCOPED_TRACE("rig");
    compare_with_dense(test::make_rig({.raise = 0.125, .rearward = 500}).model);
  }
  for (const int bars : {3, 5, 12}) {
    SCOPED_TRACE(bars);
    compare_with_dense(loop(bars));
  }
}

// Angles are independent in an open chain: the one choice that no pose makes singular.
TEST(Partition, ChainChoosesItsAnglesOnce) {
  Model m = loop(8);
  m.joints.erase(m.joints.begin());  // opens the loop
  Machine machine(m);
  machine.start_from_pose();
  for (const int i : machine.integrator().partition().independent()) EXPECT_EQ(i % 3, 2);
  for (int i = 0; i < 5000; ++i) machine.advance(2e-4);
  EXPECT_EQ(machine.partition_choices(), 1);
  // Links whip at some 30 rad/s: order 4 at 0.2 ms errs by (6e-3)^4 per radian.
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-6 * machine.energy().kinetic);
}

}  // namespace
}  // namespace subsoil::mbd::partition_test
