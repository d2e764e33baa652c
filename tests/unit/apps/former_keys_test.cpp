#include "libsim/keys/former_keys.hpp"

#include <gtest/gtest.h>

#include "libsim/document/document.hpp"
#include "libsim/scenario/load.hpp"
#include "tests/tools/message_of.hpp"

/// Keys that have another name now are read under either, and `check` can name the present one.
namespace subsoil::sim::former_keys_test {
namespace {

constexpr const char* present = R"(subsoil: 1
materials: {soil: {density: 2000 kg/m^3}}
contacts: [{between: [soil, soil], law: linear, k_n: 20 kN/m, restitution: 0.4, mu: 0.3, moment arm: radius,
            moment arm at surfaces: by-moment-arm, slip moment arm: radius}]
soil:
  container: {size: 100 100 100 mm, at: 0 0 0 mm, material: soil}
  bed: {fill: random, count: 20, material: soil, radius: {normal: 5 mm, deviation: 1 mm, minimum: 4 mm, maximum: 6 mm}}
machine:
  bodies:
    a: {mass: 1 kg, inertia: 1 kg m^2, at: 0 1 m, angular velocity: 3 rad/s}
    b: {mass: 1 kg, inertia: 1 kg m^2, at: 1 1 m}
  forces:
    mount: {bushing: [ground, b], at: 1 1 m, stiffness x: 1 N/m, stiffness y: 1 N/m, rotational stiffness: 5 N m/rad, rotational damping: 1 N m s/rad,
            rotational preload: 2 N m}
    air: {drag: a, linear rotational: 1 N m s/rad, quadratic rotational: 2 N m s^2/rad^2}
    stop: {rotational stop: [ground, a], minimum: -1 rad, maximum: 1 rad, n: 1, stiffness: 9 N m/rad}
boundaries: [{name: drum, material: soil, shape: {box: 5 5 5 mm}, at: 0 1 0 m, moves: [{angular velocity: 0 0 1 rad/s}]}]
time: {end: 1 ms}
output: {monitor: {turn: a.angle}}
)";

std::string with_former_names() {
  std::string text = present;
  const std::pair<const char*, const char*> names[] = {{" moment arm at surfaces:", " lever at surfaces:"},
                                                       {"by-moment-arm", "by-lever"},
                                                       {"slip moment arm:", "slip lever:"},
                                                       {" moment arm:", " lever:"},
                                                       {"minimum: 4", "least: 4"},
                                                       {"maximum: 6", "largest: 6"},
                                                       {"angular velocity: 3", "spin: 3"},
                                                       {"rotational stiffness:", "stiffness in turn:"},
                                                       {"rotational damping:", "damping in turn:"},
                                                       {"rotational preload:", "preload in turn:"},
                                                       {"linear rotational:", "linear in turn:"},
                                                       {"quadratic rotational:", "quadratic in turn:"},
                                                       {"minimum: -1", "least: -1"},
                                                       {"maximum: 1", "largest: 1"},
                                                       {"angular velocity: 0", "spin: 0"},
                                                       {"monitor:", "watch:"}};
  for (const auto& [now, before] : names) text.replace(text.find(now), std::string(now).size(), before);
  return text;
}

TEST(FormerKeys, AreReadLikeThePresentOnesAndListed) {
  const Loaded now = load_scenario_text(present), before = load_scenario_text(with_former_names());
  EXPECT_EQ(write_scenario(before.scenario), write_scenario(now.scenario));
  EXPECT_TRUE(now.former.empty());
  EXPECT_EQ(before.former.size(), 15U) << "each key; the word is no key";
  for (const FormerKey& key : before.former) EXPECT_EQ(present_of(key.former), key.present) << key.path;
  EXPECT_EQ(before.where("machine.bodies.a.angular velocity"), "scenario.yaml:10:57 machine.bodies.a.angular velocity");
}

TEST(FormerKeys, BesideThePresentOneAreRefused) {
  const std::string fault = subsoil::test::message_of<ScenarioError>(
      [] { load_scenario_text(present, "case.yaml", {"machine.bodies.a.spin=2 rad/s"}); });
  EXPECT_NE(fault.find("unknown key; its name is `angular velocity` now, which stands here too"), std::string::npos)
      << fault;
}

TEST(FormerKeys, AreExplainedByThePresentOnes) {
  const std::string text = explain("contacts.linear.lever");
  EXPECT_TRUE(text.starts_with("contacts.linear.lever is called `moment arm` now.\n")) << text;
  EXPECT_NE(text.find("contacts.linear.moment arm"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::former_keys_test
