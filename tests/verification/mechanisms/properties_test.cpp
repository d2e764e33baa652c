// What must hold for every mechanism, shown on random ones of known freedom: assembly, partitioning against the dense
// augmented system, symmetry under rotation, shift, reordering and reversal of time, and the energy balance.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>

#include "libmbd/elements.hpp"
#include "libmbd/forces/applied_force.hpp"
#include "tests/tools/random_mechanism.hpp"

namespace subsoil::mbd::properties_test {
namespace {

using test::MechanismDice;
using test::RandomMechanism;

/// Applies `change` to both bodies of an element, whichever way it names them.
template <class Element>
void for_bodies(Element& e, const std::function<void(int&)>& change) {
  if constexpr (requires { e.body_a; }) {
    change(e.body_a), change(e.body_b);
  } else if constexpr (requires { e.body; }) {
    change(e.body);
  }
}

/// Every body in the order of names, so that machines with another order of bodies can be compared.
struct States {
  std::map<std::string, BodyState> of;
  explicit States(const Machine& machine) {
    for (int i = 1; i < machine.system().bodies(); ++i) of[machine.system().body_name(i)] = machine.body(i);
  }
};

double distance(const BodyState& a, const BodyState& b) {
  return std::max(
      {length(a.r - b.r), std::abs(a.angle - b.angle), 0.1 * length(a.v - b.v), 0.1 * std::abs(a.omega - b.omega)});
}

double largest_distance(const States& a, const States& b) {
  double most = 0;
  for (const auto& [name, state] : a.of) most = std::max(most, distance(state, b.of.at(name)));
  return most;
}

constexpr double step = 2e-4;
const MachineOptions accurate{.adams_moulton = {.order = 6}};

States moved(const Model& model, double time) {
  Machine machine(model, accurate);
  machine.start_from_pose();
  for (long i = 0; i < std::lround(time / step); ++i) machine.advance(step);
  return States(machine);
}

class AnyMechanism : public testing::TestWithParam<unsigned> {
 protected:
  RandomMechanism mechanism() const {
    return test::random_mechanism(GetParam(), 2 + static_cast<int>(GetParam() % 3), static_cast<int>(GetParam() % 4));
  }
};
INSTANTIATE_TEST_SUITE_P(Random, AnyMechanism, testing::Range(1U, 17U));

// The generator's pose closes all joints; moved off by 15 mm and 0.05 rad in every body it must come back to some
// closed pose, with the freedom that Gruebler's count gives.
TEST_P(AnyMechanism, AssemblesWithGrueblersFreedom) {
  RandomMechanism given = mechanism();
  MechanismDice dice(GetParam() + 1000);
  for (Body& b : given.model.bodies)
    for (std::size_t k = 0; k < 3; ++k) b.pose[k] += k < 2 ? dice.in(-0.015, 0.015) : dice.in(-0.05, 0.05);
  System system(given.model);
  Eigen::VectorXd q = system.start_position(), velocity = system.start_velocity();
  const AssemblyReport report = assemble(system, 0, q, velocity);
  EXPECT_EQ(report.freedom, given.freedom);
  EXPECT_EQ(report.rank, report.equations);
  EXPECT_TRUE(report.redundant.empty()) << report.redundant.front();
  EXPECT_GT(report.moved, 1e-3);
  Constraints c;
  system.set_state(0, q, velocity);
  system.constraints(c);
  EXPECT_LT(c.phi.cwiseAbs().maxCoeff(), 1e-12 * given.length);
  EXPECT_LT((c.jacobian * velocity).cwiseAbs().maxCoeff(), 1e-12 * (1 + velocity.cwiseAbs().maxCoeff()));
}

// Accelerations and multipliers of the partitioned equations are those of
//   [M  Phi_q^T; Phi_q  0] [q''; lambda] = [F; gamma],
// solved here by full-pivot LU. What both lose to rounding is the condition of Phi_q (up to 1e4 near a stretched dyad).
TEST_P(AnyMechanism, PartitionSolvesTheAugmentedSystem) {
  const RandomMechanism given = mechanism();
  Machine machine(given.model);
  machine.start_from_pose();
  for (int i = 0; i < 5; ++i) machine.set_external_wrench(1, 3, -2, 0.5), machine.advance(1e-3);
  const MotionState& now = machine.integrator().state();
  System& system = machine.system();
  system.set_state(now.t, now.q, now.velocity);
  Constraints c;
  system.constraints(c);
  Eigen::VectorXd load(system.coordinates());
  system.loads(load);
  const Eigen::Index n = system.coordinates(), m = system.equations();
  Eigen::MatrixXd augmented = Eigen::MatrixXd::Zero(n + m, n + m);
  augmented.topLeftCorner(n, n).diagonal() = system.mass();
  augmented.topRightCorner(n, m) = c.jacobian.transpose();
  augmented.bottomLeftCorner(m, n) = c.jacobian;
  Eigen::VectorXd right(n + m);
  right << load, c.gamma;
  const Eigen::VectorXd solved = augmented.fullPivLu().solve(right);
  const double a = 1 + solved.head(n).cwiseAbs().maxCoeff(), force = 1 + solved.tail(m).cwiseAbs().maxCoeff();
  EXPECT_LT((now.acceleration - solved.head(n)).cwiseAbs().maxCoeff(), 1e-9 * a);
  EXPECT_LT((now.lambda - solved.tail(m)).cwiseAbs().maxCoeff(), 1e-9 * force);
}

/// The model turned by `turn` about the origin, then shifted; gravity turns along.
Model carried(Model m, double turn, Vec2 shift) {
  const BodyState frame(shift, turn, {}, 0);
  const auto move = [&](std::array<double, 2>& p) {
    const Vec2 w = frame.vector_in_world(p);
    p = {w.x + shift.x, w.y + shift.y};
  };
  const Vec2 g = frame.vector_in_world(m.gravity);
  m.gravity = {g.x, g.y};
  for (Body& b : m.bodies) {
    std::array<double, 2> at{b.pose[0], b.pose[1]};
    move(at);
    const Vec2 v = frame.vector_in_world({b.velocity[0], b.velocity[1]});
    b.pose = {at[0], at[1], b.pose[2] + turn};
    b.velocity = {v.x, v.y, b.velocity[2]};
  }
  const auto carry = [&](auto& e) {
    if constexpr (requires { e.p_a; }) {
      if (e.body_a == ground) move(e.p_a);
    }
    if constexpr (requires { e.body_a; }) {
      if (e.body_a != ground) return;
      if constexpr (requires { e.angle_a; }) e.angle_a += turn;
      if constexpr (requires { e.relative_angle; }) e.relative_angle += turn;
    }
  };
  for (auto& j : m.joints) visit(carry, j.element);
  for (auto& f : m.forces) visit(carry, f.element);
  return m;
}

// Another orientation makes the partition choose other coordinates, so the two runs share no rounding; order 6 at 0.2
// ms leaves 1e-12 of motions of some 10 rad/s, magnified by the motion's sensitivity over 0.25 s.
TEST_P(AnyMechanism, RotatedAndShiftedMovesTheSame) {
  const Model model = mechanism().model;
  const double turn = 0.7, time = 0.25;
  const Vec2 shift{3, -2};
  const States here = moved(model, time), there = moved(carried(model, turn, shift), time);
  const BodyState frame(shift, turn, {}, 0);
  double most = 0;
  for (const auto& [name, s] : here.of) {
    const Vec2 r = shift + frame.vector_in_world({s.r.x, s.r.y}), v = frame.vector_in_world({s.v.x, s.v.y});
    most = std::max(most, distance(BodyState(r, s.angle + turn, v, s.omega), there.of.at(name)));
  }
  EXPECT_LT(most, 1e-9);
  EXPECT_GT(largest_distance(here, States(Machine(model))), 1e-3) << "nothing moved: the test says nothing";
}

TEST_P(AnyMechanism, OrderOfBodiesAndJointsDoesNotMatter) {
  const Model model = mechanism().model;
  Model other = model;
  const auto n = model.bodies.size();
  std::reverse(other.bodies.begin(), other.bodies.end());
  std::reverse(other.joints.begin(), other.joints.end());
  std::reverse(other.forces.begin(), other.forces.end());
  const auto renumber = [&](auto& e) {
    for_bodies(e, [&](int& body) {
      if (body != ground) body = static_cast<int>(n) + 1 - body;
    });
  };
  for (auto& j : other.joints) visit(renumber, j.element);
  for (auto& f : other.forces) visit(renumber, f.element);
  EXPECT_LT(largest_distance(moved(model, 0.25), moved(other, 0.25)), 1e-9);
}

// Without dampers the motion runs back along its own way; the error of both ways stays below 1e-9.
TEST_P(AnyMechanism, ReversedInTimeItReturns) {
  const Model model = mechanism().model;
  Machine out(model, accurate);
  out.start_from_pose();
  const States start(out);
  for (int i = 0; i < 1000; ++i) out.advance(step);
  Model back = model;
  for (std::size_t i = 0; i < back.bodies.size(); ++i) {
    const BodyState& s = out.body(static_cast<int>(i) + 1);
    back.bodies[i].pose = {s.r.x, s.r.y, s.angle};
    back.bodies[i].velocity = {-s.v.x, -s.v.y, -s.omega};
  }
  // Free lengths and angles that the start pose decided stay those of the first start.
  for (std::size_t i = 0; i < back.forces.size(); ++i) back.forces[i] = out.system().model().forces[i];
  Machine returning(back, accurate);
  returning.start_from_pose();
  for (int i = 0; i < 1000; ++i) returning.advance(step);
  States end(returning);
  for (auto& [name, s] : end.of) s.v = -1.0 * s.v, s.omega = -s.omega;
  EXPECT_LT(largest_distance(start, end), 1e-9);
  EXPECT_GT(largest_distance(start, States(out)), 1e-3) << "nothing moved: the test says nothing";
}

TEST_P(AnyMechanism, EnergyBalanceClosesWithDampersAndADriver) {
  Model model = mechanism().model;
  for (auto& f : model.forces)
    visit(
        [](auto& force) {
          if constexpr (requires { force.damping; }) force.damping = 0.3;
        },
        f.element);
  model.add("push", AppliedForce{.body = 1, .point = {0.1, 0}, .axes = Axes::body, .fx = 4.0, .moment = 0.2});
  Machine machine(model, accurate);
  machine.start_from_pose();
  double turned_over = 1;
  for (int i = 0; i < 1250; ++i) {
    machine.advance(step);
    turned_over = std::max(turned_over, machine.energy().kinetic);
  }
  EXPECT_NEAR(machine.energy().balance(), 0, 1e-9 * turned_over);
  EXPECT_NE(machine.energy().force_work, 0);
}

}  // namespace
}  // namespace subsoil::mbd::properties_test
