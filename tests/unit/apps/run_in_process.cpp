#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>

#include "libsim/base/problems.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/run/restart.hpp"
#include "libsim/run/simulation.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/unit/apps/trench.hpp"

/// A simulation in process: the bits of the program, states, and what acts from outside.
namespace subsoil::sim::run_in_process {
namespace {

using namespace test;

/// x v w of every sphere and its id, in rising id.
struct Numbers {
  std::uint32_t id;
  double of[9];
  bool operator==(const Numbers& b) const { return id == b.id && std::memcmp(of, b.of, sizeof of) == 0; }
};
std::vector<Numbers> in_rising_id(std::vector<Numbers> all) {
  std::sort(all.begin(), all.end(), [](const Numbers& a, const Numbers& b) { return a.id < b.id; });
  return all;
}
std::vector<Numbers> numbers_of(std::span<const dem::Sphere> spheres) {
  std::vector<Numbers> all;
  for (const dem::Sphere& s : spheres)
    all.push_back({s.id, {s.x.x, s.x.y, s.x.z, s.v.x, s.v.y, s.v.z, s.w.x, s.w.y, s.w.z}});
  return in_rising_id(std::move(all));
}
std::vector<Numbers> numbers_of(const Simulation& simulation) { return numbers_of(simulation.spheres()); }

class SameBits : public testing::TestWithParam<const char*> {};

/// Soil with a machine, soil with a given path, and a window that advances.
TEST_P(SameBits, AsTheProgram) {
  const RunDirectory dir;
  const std::vector<std::string> sets{"time.end=60 ms", "output.state=full"};
  ASSERT_EQ(run_scenario(dir.scenario(GetParam()), dir / "out", sets), exit_ok);
  const SavedRun saved = read_run(latest_state(dir / "out").value());
  Simulation simulation =
      Simulation::from_file(dir.scenario(GetParam()), {.sets = sets, .threads = 1, .energies = true});
  int calls = 0;
  simulation.observe(1e-3, [&](Simulation&) { return ++calls, true; });
  while (simulation.time() < 30e-3) simulation.step();  // calls of any length
  ASSERT_TRUE(simulation.run_until(60e-3));
  EXPECT_EQ(simulation.time(), saved.time);
  EXPECT_TRUE(numbers_of(simulation) == numbers_of(saved.bed.spheres));
  EXPECT_EQ(calls, 60) << "at 0, 1, ... 59 ms";
}

INSTANTIATE_TEST_SUITE_P(All, SameBits, testing::Values(trench, small_pass, moving_pass));

/// The test of the test: another gravity is seen in the bits.
TEST(InProcess, TheComparisonSeesOneParameter) {
  const auto after = [](const char* gravity) {
    Simulation simulation =
        Simulation::from_text(trench, "case.yaml", {.sets = {std::string("gravity=") + gravity}, .threads = 1});
    simulation.run_until(20e-3);
    return numbers_of(simulation);
  };
  EXPECT_TRUE(after("9.8 m/s^2") == after("9.8 m/s^2"));
  EXPECT_FALSE(after("9.8 m/s^2") == after("9.800000001 m/s^2"));
}

/// What follows a state is the same bits, in this simulation, and in another one that takes it as bytes.
TEST(InProcess, AStateIsExact) {
  const SimulationOptions options{.threads = 1, .forces_on = {"tine"}};
  Simulation simulation = Simulation::from_text(small_pass, "case.yaml", options);
  simulation.run_until(0.05);
  simulation.set_force("tine", 3, -2);
  const Simulation::State state = simulation.save();
  ASSERT_TRUE(state.is_exact());
  simulation.step(300);
  const std::vector<Numbers> first = numbers_of(simulation);
  const mbd::BodyState tine = simulation.body("tine");
  simulation.set_force("tine", 50, 0);
  simulation.step(100);
  EXPECT_FALSE(numbers_of(simulation) == first);
  simulation.restore(state);
  EXPECT_EQ(simulation.time(), state.time());
  simulation.step(300);
  EXPECT_TRUE(numbers_of(simulation) == first);
  EXPECT_EQ(simulation.body("tine").r.x, tine.r.x);
  EXPECT_EQ(simulation.body("tine").v.y, tine.v.y);

  Simulation other = Simulation::from_text(small_pass, "case.yaml", options);
  other.restore(Simulation::State::from_bytes(state.bytes()));
  other.step(300);
  EXPECT_TRUE(numbers_of(other) == first);
  const std::vector<std::byte> bytes = state.bytes();
  for (const std::size_t part : {std::size_t{3}, bytes.size() / 2})
    EXPECT_THROW(Simulation::State::from_bytes(std::span(bytes).first(part)), std::invalid_argument) << part;
}

/// A machine without soil, integrated by CVODE: what follows a state is the same bits in another simulation.
TEST(InProcess, AStateOfAMachineAloneIsExact) {
  constexpr const char* cart = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies:
    cart: {mass: 3 kg, inertia: 0.1 kg m^2, at: 0 0 m}
    bob: {mass: 2 kg, inertia: 0.05 kg m^2, at: 0.5 0 m}
    arm: {mass: 1 kg, inertia: 0.2 kg m^2, at: 2 0 m}
  joints:
    gc: {translational: [ground, cart], at: 0 0 m, along: 1 0}
    gb: {translational: [ground, bob], at: 0.5 0 m, along: 1 0}
    ga: {revolute: [ground, arm], at: 2 0 m}
  drivers:
    tow: {coordinate: cart.x, velocity: 0.2 m/s}
    swing: {angle: [ground, arm], velocity: 30 deg/s}
  forces:
    s: {spring-damper: [cart, bob], ends: [0 0 m, 0.5 0 m], stiffness: 2 kN/m, damping: 10 N s/m}
time: {end: 2 s}
)";
  const SimulationOptions options{.threads = 1, .inputs = {"machine.drivers.tow.velocity"}};
  Simulation simulation = Simulation::from_text(cart, "case.yaml", options);
  simulation.set_input("machine.drivers.tow.velocity", 0.2, 30);
  simulation.run_until(0.01);
  simulation.set_input("machine.drivers.tow.velocity", 0.5);
  const Simulation::State state = simulation.save();
  const auto continued = [](Simulation& of) {
    std::vector<double> places;
    for (int k = 1; k <= 20; ++k) of.run_until(0.01 + 0.01 * k), places.push_back(of.body("bob").r.x);
    return places;
  };
  const std::vector<double> first = continued(simulation);
  simulation.restore(state);
  EXPECT_EQ(continued(simulation), first);
  Simulation other = Simulation::from_text(cart, "case.yaml", options);
  other.restore(Simulation::State::from_bytes(state.bytes()));
  EXPECT_EQ(continued(other), first);
}

TEST(InProcess, AStateTakesMotionsBack) {
  Simulation simulation = Simulation::from_text(trench, "case.yaml", {.threads = 1});
  simulation.run_until(60e-3);
  const double t = simulation.time();
  const Simulation::State given = simulation.save();
  const dem::Pose at = simulation.pose("tool");
  simulation.set_motion("tool", {.position = at.position, .velocity = {0, 0.5, 0}});
  const Simulation::State raised = simulation.save();
  simulation.step(200);
  const std::vector<Numbers> up = numbers_of(simulation);
  simulation.restore(given);
  simulation.step(200);
  const std::vector<Numbers> along = numbers_of(simulation);
  EXPECT_FALSE(along == up);
  EXPECT_NEAR(simulation.pose("tool").position.x, 0.06 + 0.4 * simulation.time(), 1e-12);
  simulation.restore(raised);
  simulation.step(200);
  EXPECT_TRUE(numbers_of(simulation) == up);
  EXPECT_NEAR(simulation.pose("tool").position.y, at.position.y + 0.5 * (simulation.time() - t), 1e-12);
}

/// Against a wall at rest that is set in motion: a sphere rebounds from a wall of speed u with -e v + (1 + e) u.
TEST(InProcess, ASetMotionStrikes) {
  constexpr const char* sphere = R"(subsoil: 1
gravity: 0 m/s^2
materials: {glass: {density: 2500 kg/m^3}}
contacts: [{between: [glass, glass], law: linear, k_n: 100 kN/m, restitution: 0.6, mu: 0}]
soil:
  container: {size: 1 1 1 m, at: -0.5 -0.5 -0.5 m, material: glass}
  bed: {fill: particles, particles: [{position: 0 0 0 m, radius: 10 mm, material: glass}]}
boundaries: [{name: wall, material: glass, shape: {box: 20 100 100 mm}, at: 40 0 0 mm}]
time: {end: 1 s}
)";
  Simulation simulation = Simulation::from_text(sphere, "case.yaml", {.threads = 1});
  simulation.step(10);
  const double u = -0.5;
  simulation.set_motion("wall", {.position = {0.04, 0, 0}, .velocity = {u, 0, 0}});
  dem::Vec3 impulse;
  while (simulation.time() < 0.1) {
    const double t = simulation.time();
    simulation.step(7);
    impulse += simulation.mean_wrench("wall", {}).force * (simulation.time() - t);
  }
  const dem::Sphere& s = simulation.spheres()[0];
  // To the law's own restitution, which steps of the default accuracy keep to 0.01.
  EXPECT_NEAR(s.v.x, 1.6 * u, 0.01 * std::abs(u));
  // What the wall took is the sphere's momentum: sums over steps are exact to rounding.
  EXPECT_NEAR(impulse.x, -s.m * s.v.x, 1e-9 * std::abs(s.m * s.v.x));
}

/// A wall at rest does not meet fixed spheres; one that is set in motion presses with k times its overlap, and so does
/// the same wall after a state of it was read by another simulation.
TEST(InProcess, ASetMotionMeetsFixedSpheres) {
  constexpr const char* stone = R"(subsoil: 1
gravity: 0 m/s^2
materials: {glass: {density: 2500 kg/m^3}}
contacts: [{between: [glass, glass], law: linear, k_n: 20 kN/m, restitution: 1, mu: 0}]
soil:
  bed: {fill: particles, particles: [{position: 0 0 0 m, radius: 10 mm, material: glass, fixed: stone}]}
boundaries: [{name: wall, material: glass, shape: {box: 20 100 100 mm}, at: 21 0 0 mm}]
time: {end: 1 s, soil step: 10 us}
)";
  Simulation simulation = Simulation::from_text(stone, "case.yaml", {.threads = 1});
  const double speed = -0.1, gap = 0.001;
  simulation.set_motion("wall", {.position = {0.021, 0, 0}, .velocity = {speed, 0, 0}});
  simulation.run_until(15e-3);
  const auto force_of = [&](const Simulation& of) { return of.wrench("wall", {}).force.x; };
  // Forces are those of the beginning of the last step.
  const auto expected = [&] { return 20e3 * (-speed * (simulation.time() - simulation.step_length()) - gap); };
  EXPECT_NEAR(force_of(simulation), expected(), 1e-6) << "N, of 10 N";
  Simulation other = Simulation::from_text(stone, "case.yaml", {.threads = 1});
  other.restore(Simulation::State::from_bytes(simulation.save().bytes()));
  simulation.run_until(20e-3), other.run_until(20e-3);
  EXPECT_EQ(force_of(other), force_of(simulation));
  EXPECT_NEAR(force_of(simulation), expected(), 1e-6);
}

/// x = F t^2/(2 m), and after a second force of the other sign the velocity of both impulses.
TEST(InProcess, AForceAcceleratesABody) {
  constexpr const char* slider = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {cart: {mass: 2 kg, inertia: 1 kg m^2, at: 0 0 m}}
  joints: {rail: {translational: [ground, cart], along: 1 0}}
time: {end: 10 s}
)";
  for (const char* method : {"cvode", "ida", "adams-moulton"}) {
    Simulation simulation = Simulation::from_text(
        slider, "case.yaml",
        {.sets = {std::string("time.machine.integrator=") + method, "time.machine.step=1 ms"}, .forces_on = {"cart"}});
    simulation.set_force("cart", 4, 7);  // the rail takes the second
    simulation.run_until(1);
    EXPECT_NEAR(simulation.body("cart").r.x, 1, 1e-6) << method;
    EXPECT_NEAR(simulation.value("rail.fy"), 7, 1e-6) << method;
    simulation.set_force("cart", -2, 0);
    simulation.run_until(2);
    EXPECT_NEAR(simulation.body("cart").v.x, 1, 1e-6) << method;
    EXPECT_NEAR(simulation.body("cart").r.x, 1 + 2 - 0.5, 1e-6) << method;
  }
}

/// A driver by its velocity keeps its position where the acceleration jumps.
TEST(InProcess, AnInputDrives) {
  Simulation simulation =
      Simulation::from_text(small_pass, "case.yaml", {.threads = 1, .inputs = {"machine.drivers.tow.velocity"}});
  ASSERT_EQ(simulation.inputs().size(), 1u);
  EXPECT_EQ(simulation.inputs()[0].value, 0.5) << "until it is set, as the scenario has it";
  const double start = simulation.body("trolley").r.x;
  simulation.run_until(0.02);
  EXPECT_NEAR(simulation.body("trolley").r.x, start + 0.5 * simulation.time(), 1e-9);
  const double t = simulation.time(), x = simulation.body("trolley").r.x;
  simulation.set_input("machine.drivers.tow.velocity", 0.5, -10);
  simulation.run_until(0.04);
  const double s = simulation.time() - t;
  EXPECT_NEAR(simulation.body("trolley").r.x, x + 0.5 * s - 5 * s * s, 1e-9);
  EXPECT_NEAR(simulation.body("trolley").v.x, 0.5 - 10 * s, 1e-9);
}

// x = cos(2 pi t) to 0.6 s, in calls of 0.3 s: what is followed over time does not depend on the calls.
TEST(InProcess, MonitorsAreFollowedBetweenCalls) {
  constexpr const char* swing = R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {b: {mass: 1 kg, inertia: 1 kg m^2, at: 1 0 m}}
  joints: {g: {translational: [ground, b], at: 1 0 m, along: 1 0}}
  forces: {s: {bushing: [ground, b], points: [0 0 m, 0 0 m], stiffness x: 39.47841760435743 N/m, stiffness y: 0 N/m}}
time: {end: 0.7 s}
output:
  series every: 0.3 s
  monitor:
    sum: {integral: b.x}
    low: {minimum: b.x}
    above: {time above: b.x, at: 0.5 m}
    slope: {derivative: b.x}
)";
  constexpr double pi = std::numbers::pi, end = 0.6;
  for (const char* method : {"cvode", "ida", "adams-moulton"}) {
    Simulation simulation =
        Simulation::from_text(swing, "swing.yaml", {.sets = {std::string("time.machine.integrator=") + method}});
    for (const double t : {0.3, end}) simulation.run_until(t);
    const double x = simulation.time();
    EXPECT_NEAR(simulation.value("sum"), std::sin(2 * pi * x) / (2 * pi), 1e-6) << method;
    EXPECT_NEAR(simulation.value("low"), -1, 1e-6) << method;
    EXPECT_NEAR(simulation.value("above"), 1.0 / 6, 1e-6) << method;
    EXPECT_NEAR(simulation.value("slope"), -2 * pi * std::sin(2 * pi * x), 1e-4) << method;
  }
}

TEST(InProcess, AnObserverEndsACall) {
  Simulation simulation = Simulation::from_text(trench, "case.yaml", {.threads = 1});
  int calls = 0;
  const int number = simulation.observe(0, [&](Simulation& at) { return ++calls, at.steps() < 10; });
  EXPECT_FALSE(simulation.step(50));
  EXPECT_EQ(simulation.steps(), 10);
  EXPECT_EQ(calls, 11);
  simulation.stop_observing(number);
  EXPECT_TRUE(simulation.step(50));
  EXPECT_EQ(simulation.steps(), 60);
}

/// What an observer reads is of the instant at which it is called.
TEST(InProcess, AnObserverReadsValuesOfItsInstant) {
  Simulation simulation = Simulation::from_text(trench, "case.yaml", {.threads = 1});
  int calls = 0;
  simulation.observe(10e-3, [&](Simulation& s) {
    if (s.steps() == 0) return true;  // no step, no value
    EXPECT_TRUE(std::isfinite(s.value("draft")));
    return ++calls, true;
  });
  simulation.run_until(0.05);
  EXPECT_GE(calls, 4);
  simulation.observe(0, [](Simulation& s) { return s.step(); });
  EXPECT_THROW(simulation.step(), std::exception) << "an observer must not step";
}

TEST(InProcess, RefusalsNameTheCure) {
  EXPECT_NE(subsoil::test::message_of([] {
              Simulation::from_text(small_pass, "case.yaml", {.inputs = {"machine.drivers.tow.velocty"}});
            }).find("did you mean `machine.drivers.tow.velocity`"),
            std::string::npos);
  Simulation simulation = Simulation::from_text(trench, "case.yaml", {.threads = 1});
  EXPECT_NE(subsoil::test::message_of([&] { simulation.pose("tol"); }).find("did you mean `tool`"), std::string::npos);
  EXPECT_NE(subsoil::test::message_of([&] {
              simulation.set_motion("tool", {.position = {}, .attitude = {2, 0, 0, 0}});
            }).find("norm"),
            std::string::npos);
  EXPECT_NE(subsoil::test::message_of([&] { simulation.set_input("load", 1); }).find("name it in `inputs`"),
            std::string::npos);
  EXPECT_NE(subsoil::test::message_of([&] { simulation.set_force("shovel", 1, 0); }).find("no such body"),
            std::string::npos);
  // Ten radii in a step.
  simulation.run_until(5e-3);
  simulation.set_motion("tool", {.position = {0.16, 0.01, 0}});
  try {
    simulation.step(2);
    FAIL() << "a surface jumps into spheres";
  } catch (const SimulationFault& fault) {
    EXPECT_NE(std::string(fault.what()).find("t = "), std::string::npos) << fault.what();
    EXPECT_NEAR(fault.time, 5e-3, 1e-3);
  }
}

}  // namespace
}  // namespace subsoil::sim::run_in_process
