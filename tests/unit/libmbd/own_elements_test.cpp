// Joints and forces of a user's program: those of the library, put into OwnJoint and OwnForce, move a machine as
// before.
#include <gtest/gtest.h>

#include <cmath>

#include "libmbd/forces/drag.hpp"
#include "libmbd/forces/own_force.hpp"
#include "libmbd/joints/own_joint.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::own_elements_test {
namespace {

MachineOptions by_cvode() { return {.integrator = IntegratorKind::cvode}; }

/// A pendulum with drag at its tip.
template <bool own>
std::vector<double> swung() {
  Model model;
  const int rod = model.add({.name = "rod", .mass = 2, .inertia = 0.2, .pose = {0.5, 0, 0}});
  const Revolute pin{.body_a = ground, .body_b = rod, .p_a = {0, 0}, .p_b = {-0.5, 0}};
  const Drag drag{.body = rod, .point = {0.5, 0}, .linear = 3};
  if constexpr (own) {
    model.add("pin", OwnJoint(pin));
    model.add("drag", OwnForce(drag));
  } else {
    model.add("pin", pin);
    model.add("drag", drag);
  }
  Machine machine(model, by_cvode());
  machine.start_from_pose();
  for (int i = 1; i <= 10; ++i) machine.advance_to(0.1 * i);
  std::vector<double> out(machine.column_names().size());
  machine.columns(out);
  return out;
}

TEST(OwnElements, MoveAsTheLibrarysOwn) {
  const std::vector<double> given = swung<false>(), own = swung<true>();
  ASSERT_EQ(given.size(), own.size());
  // The pin's rows have no block of zeros left out, which changes the order of a sum; tolerance 1e-8 of cvode.
  for (std::size_t i = 0; i < given.size(); ++i) EXPECT_NEAR(own[i], given[i], 1e-6 * (1 + std::abs(given[i]))) << i;
}

/// F = -c z on a body, z' = (v - z)/tau: a damper behind a lag, with the state z.
struct LaggedDamper {
  static constexpr ForceMembers has{.check = true, .states = true};
  static constexpr std::array<ForceColumn, 1> columns{{{"force", "N"}}};
  static constexpr std::size_t state_count = 1;
  int body = -1;
  double c = 0, tau = 0;
  std::size_t first_state = 0;

  void check() const {
    if (!(tau > 0)) throw std::invalid_argument("tau must be above 0");
  }
  std::array<double, 1> start_states(const Scene&) const { return {0}; }
  std::array<double, 1> state_scales() const { return {1}; }
  std::array<double, 1> state_rates(const Scene& scene) const {
    return {(scene.bodies[static_cast<std::size_t>(body)].v.x - scene.states[first_state]) / tau};
  }
  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const double z = scene.states[first_state], v = scene.bodies[static_cast<std::size_t>(body)].v.x;
    loads.add(body, {0, 0}, {-c * z, 0});
    values = {-c * z};
    return {.lost = c * z * v};
  }
};

// m v' = -c z, tau z' = v - z: with c/m = 5, tau = 0.1 the roots of tau s^2 + s + c/m are -5 +- 5i, so that
// v = v0 e^(-5t) (cos 5t + sin 5t). Two of them: each has a state of its own.
TEST(OwnElements, AForceHasItsStates) {
  Model model;
  model.gravity = {0, 0};
  const int slow = model.add({.name = "slow", .mass = 2, .inertia = 1, .velocity = {3, 0, 0}});
  const int fast = model.add({.name = "fast", .mass = 2, .inertia = 1, .velocity = {-1, 0, 0}});
  model.add("one", OwnForce(LaggedDamper{.body = slow, .c = 10, .tau = 0.1}));
  model.add("other", OwnForce(LaggedDamper{.body = fast, .c = 10, .tau = 0.1}));
  Machine machine(model, by_cvode());
  machine.start_from_pose();
  for (int i = 1; i <= 4; ++i) {
    const double t = 0.1 * i, share = std::exp(-5 * t) * (std::cos(5 * t) + std::sin(5 * t));
    machine.advance_to(t);
    EXPECT_NEAR(machine.body(slow).v.x, 3 * share, 1e-6);
    EXPECT_NEAR(machine.body(fast).v.x, -share, 1e-6);
    EXPECT_NEAR(machine.energy().balance(), 0, 1e-6);
  }
}

/// A floor without damping: F = k d, d = depth of the centre of gravity below y = 0.
struct Floor {
  static constexpr ForceMembers has{.gap = true};
  static constexpr std::array<ForceColumn, 1> columns{{{"force", "N"}}};
  int body = -1;
  double k = 0;

  double gap(const Scene& scene) const { return scene.bodies[static_cast<std::size_t>(body)].r.y; }
  double gap_speed(const Scene& scene) const { return length(scene.bodies[static_cast<std::size_t>(body)].v); }
  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const double depth = std::max(0.0, -gap(scene));
    loads.add(body, {0, 0}, {0, k * depth});
    values = {k * depth};
    return {.stored = 0.5 * k * depth * depth};
  }
};

// Without gravity a ball that meets it stays for half a period, pi sqrt(m/k), and comes back with its speed.
TEST(OwnElements, AForceHasItsGap) {
  Model model;
  model.gravity = {0, 0};
  const double speed = 2, mass = 0.5, k = 5e4;
  const int ball =
      model.add({.name = "ball", .mass = mass, .inertia = 1, .pose = {0, 0.1, 0}, .velocity = {0, -speed, 0}});
  model.add("floor", OwnForce(Floor{.body = ball, .k = k}));
  Machine machine(model, by_cvode());
  machine.start_from_pose();
  machine.advance_to(0.2);
  ASSERT_EQ(machine.events().size(), 2U);
  EXPECT_NEAR(machine.events()[0].t, 0.05, 1e-8);
  EXPECT_NEAR(machine.events()[1].t - machine.events()[0].t, M_PI * std::sqrt(mass / k), 1e-7);
  EXPECT_NEAR(machine.body(ball).v.y, speed, 1e-6);
}

TEST(OwnElements, AreCheckedByTheirOwnRules) {
  Model model;
  const int body = model.add({.name = "body", .mass = 2, .inertia = 1});
  model.add("damper", OwnForce(LaggedDamper{.body = body, .c = 10, .tau = 0}));
  try {
    const Machine machine(model);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "force 'damper': tau must be above 0");
  }
}

// One that is put into the model as it is has no place in the lists by type.
TEST(OwnElements, OutsideTheirWrapperAreRefused) {
  Model model;
  const int body = model.add({.name = "body", .mass = 2, .inertia = 1});
  model.add("floor", Floor{.body = body, .k = 1});
  try {
    const Machine machine(model);
    FAIL();
  } catch (const std::logic_error& error) {
    EXPECT_NE(std::string(error.what()).find("OwnForce"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace subsoil::mbd::own_elements_test
