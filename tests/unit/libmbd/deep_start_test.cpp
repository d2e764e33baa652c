// Starts beyond the range of a law: what a stop stores there the motion begins with.

#include "libmbd/system/deep_start.hpp"

#include <gtest/gtest.h>

#include "libmbd/forces/hydraulic_cylinder.hpp"
#include "libmbd/forces/line_contact.hpp"
#include "libmbd/forces/rotational_stop.hpp"
#include "libmbd/joints/revolute.hpp"
#include "libmbd/joints/translational.hpp"
#include "libmbd/machine.hpp"

namespace subsoil::mbd::deep_start_test {
namespace {

std::vector<DeepStart> of(const Model& m) {
  Machine machine(m);
  machine.start_from_pose();
  return deep_starts(machine.system(), machine.integrator().state().acceleration);
}

// 0.3 m beyond the stroke on 1e8 N/m: 4.5 MJ.
TEST(DeepStart, OfACylinderBeyondItsStroke) {
  Model m;
  m.add({.name = "mass", .mass = 100, .inertia = 1, .pose = {0, 1, 0}});
  m.add("rail", Translational{.body_a = ground, .body_b = 1, .angle_a = std::acos(0.0)});
  HydraulicCylinder c{.body_a = ground, .body_b = 1, .bore = 0.05, .closed = 0.3, .stroke = 0.4};
  c.flow = 1e-3;
  m.add("lift", c);
  const auto found = of(m);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].force, "lift");
  EXPECT_NEAR(found[0].depth, 0.3, 1e-12);
  EXPECT_NEAR(found[0].energy, 4.5e6, 1e-3);
  EXPECT_NEAR(found[0].push, 3e7, 1e-2);
  EXPECT_FALSE(found[0].angular);
  m.bodies[0].pose[1] = 0.5;
  EXPECT_TRUE(of(m).empty());
}

// A block on a floor: at the depth of its weight, and at twice that, as if it were set down at once, nothing is odd.
TEST(DeepStart, WeightExplainsTheDepthThatItMakes) {
  constexpr double stiffness = 1e5, rest = 2 * 9.81 / stiffness;
  for (const auto& [depths, count] : {std::pair{0.0, 0U}, {1.0, 0U}, {2.0, 0U}, {10.0, 1U}, {1000.0, 1U}}) {
    Model m;
    m.add({.name = "block", .mass = 2, .inertia = 1, .pose = {0, -depths * rest, 0}});
    m.add("floor", LineContact{.body_a = ground, .body_b = 1, .law = {.normal = {.n = 1, .stiffness = stiffness}}});
    EXPECT_EQ(of(m).size(), count) << depths;
  }
}

TEST(DeepStart, OfAnArmBeyondItsStop) {
  Model m;
  m.add({.name = "arm", .mass = 2, .inertia = 0.2, .pose = {0.5, 0, 0}});
  m.add("pin", Revolute{.body_a = ground, .body_b = 1, .p_b = {-0.5, 0}});
  m.add("stop",
        RotationalStop{.body_a = ground, .body_b = 1, .limits = {.least = 0.1, .law = {.n = 1, .stiffness = 1e6}}});
  const auto found = of(m);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].angular);
  EXPECT_NEAR(found[0].energy, 0.5 * 1e6 * 0.01, 1e-9);
}

}  // namespace
}  // namespace subsoil::mbd::deep_start_test
