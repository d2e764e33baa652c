#include <gtest/gtest.h>

#include "libsim/run/exchange_advice.hpp"
#include "libsim/scenario/load.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/scratch.hpp"

/// `time.coupling`: what is refused, and when `check` advises the iterated exchange.
namespace subsoil::sim::scenario_coupling_test {
namespace {

using subsoil::test::message_of;

constexpr const char* machine = R"(subsoil: 1
materials: {a: {density: 2500 kg/m^3}}
machine:
  bodies: {b: {mass: 2 kg, inertia: 1 kg m^2, at: 50 50 mm}}
  joints: {slide: {translational: [ground, b], at: 50 50 mm, along: 0 1}}
  surfaces: {plate: {body: b, material: a, box: 60 10 60 mm}}
time: {end: 1 ms}
)";
const std::string soil = R"(gravity: 9.81 m/s^2
contacts: [{between: [a, a], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0.3}]
soil:
  container: {size: 100 100 100 mm, at: 0 0 -50 mm, material: a}
  bed: {fill: lattice, material: a, radius: 5 mm, pitch: 10 mm, depth: 20 mm}
)";

std::string refusal(const std::string& text, const std::vector<std::string>& sets) {
  return message_of<ScenarioError>([&] { load_scenario_text(text, "s.yaml", sets); });
}

TEST(Coupling, IsRefusedWhereNothingIsCoupled) {
  EXPECT_EQ(refusal(machine, {"time.coupling=iterated"}),
            "--set time.coupling: has no effect: there is no machine in soil; leave it out");
  EXPECT_EQ(refusal(machine + soil, {"time.coupling tolerance=1 nm"}),
            "--set time.coupling tolerance: has no effect: it is of `time.coupling: iterated`; leave it out");
  EXPECT_NE(refusal(machine + soil, {"time.coupling=iterated", "engine=liggghts"}).find("from a checkpoint"),
            std::string::npos);
  EXPECT_EQ(
      refusal(machine + soil, {"time.coupling=iterated", "time.coupling tolerance=1 nm", "time.coupling iterations=5"}),
      "accepted");
}

/// The explicit copy of a run is read again by whoever continues it.
TEST(Coupling, IsInTheExplicitCopy) {
  for (const char* word : {"explicit", "iterated"}) {
    const Loaded loaded = load_scenario_text(machine + soil, "s.yaml", {std::string("time.coupling=") + word});
    const std::string copy = write_scenario(loaded.scenario);
    EXPECT_NE(copy.find(std::string("coupling: ") + word), std::string::npos) << copy;
    EXPECT_EQ(refusal(copy, {}), "accepted") << copy;
  }
}

std::vector<std::string> advice(const std::vector<std::string>& sets) {
  const Loaded loaded = load_scenario_text(machine + soil, "s.yaml", sets);
  return exchange_warnings(loaded, build_world(loaded, {.settle = false}));
}

TEST(Coupling, IsAdvisedWhereTheExplicitExchangeIsUnstable) {
  EXPECT_TRUE(advice({}).empty()) << "a body of hundreds of spheres' mass, exchanged in every soil step";
  const std::vector<std::string> long_steps{"time.soil step=10 us", "time.machine.soil steps per machine step=400"};
  const auto found = advice(long_steps);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NE(found[0].find("the explicit exchange is unstable for `b`, effective mass 2 kg, where "), std::string::npos);
  EXPECT_NE(found[0].find("take `time.coupling: iterated`"), std::string::npos);
  std::vector<std::string> iterated = long_steps, heavy = long_steps;
  iterated.push_back("time.coupling=iterated");
  EXPECT_TRUE(advice(iterated).empty());
  heavy.push_back("machine.bodies.b.mass=1 t");
  EXPECT_TRUE(advice(heavy).empty());
}

}  // namespace
}  // namespace subsoil::sim::scenario_coupling_test
