// No step of the machine may ask for memory.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "libmbd/forces/joint_friction.hpp"
#include "libmbd/joints/revolute.hpp"
#include "tests/tools/counted_heap.hpp"
#include "tests/tools/rig.hpp"

#if defined(SUBSOIL_COUNTS_HEAP)

namespace subsoil::mbd::allocation_test {
namespace {

using test::allocations;

// The tester: what the two kinds of container use must be seen.
TEST(Allocation, CounterSeesEigenAndTheLibrary) {
  const auto keep = [](const double* data) { asm volatile("" : : "r"(data) : "memory"); };
  const long before = allocations;
  const Eigen::VectorXd v = Eigen::VectorXd::Zero(100);
  keep(v.data());
  const long between = allocations;
  const std::vector<double> w(100);
  keep(w.data());
  const long after = allocations;
  EXPECT_EQ(between - before, 1);
  EXPECT_EQ(after - between, 1);
}

/// Heap calls in `steps` steps, after the method has filled its past (six steps) and the rut its first block.
long allocations_in(Machine& machine, int body, int steps) {
  const auto step = [&](int i) {
    machine.set_external_wrench(body, -10.0 * (i % 7), 3, 1);  // a coupled run sets it at every step
    machine.advance(1e-4);
  };
  for (int i = 0; i < 20; ++i) step(i);
  const long before = allocations;
  for (int i = 0; i < steps; ++i) step(i);
  return allocations - before;
}

TEST(Allocation, NoneInAStepOfTheRig) {
  const auto rig = test::make_rig({.raise = 0.125, .rearward = 500, .downward = 100});
  Machine machine(rig.model);
  machine.start_from_towing_equilibrium(0.5);
  const long choices = machine.partition_choices();
  EXPECT_EQ(allocations_in(machine, rig.shovel, 2000), 0);
  EXPECT_EQ(machine.partition_choices(), choices);
}

TEST(Allocation, NoneInAStepOfAChainWithFriction) {
  Model m;
  for (int i = 0; i < 20; ++i) {
    const std::string name = "bar " + std::to_string(i);
    const int bar = m.add({.name = name, .mass = 1, .inertia = 0.1, .pose = {0.5 + i, 0, 0}});
    m.add("pin " + name, Revolute{.body_a = bar - 1, .body_b = bar, .p_a = {i == 0 ? 0.0 : 0.5, 0}, .p_b = {-0.5, 0}});
    m.add("friction " + name, JointFriction{.joint = "pin " + name, .radius = 0.01, .mu_s = 0.2, .mu_k = 0.1});
  }
  Machine machine(m);
  machine.start_from_pose();
  EXPECT_EQ(allocations_in(machine, 20, 500), 0);
}

}  // namespace
}  // namespace subsoil::mbd::allocation_test

#endif
