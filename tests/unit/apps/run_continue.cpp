#include <fmt/format.h>
#include <gtest/gtest.h>

#include "libsim/io/state_file.hpp"
#include "libsim/run/continuation.hpp"
#include "libsim/run/restart.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/unit/apps/trench.hpp"

/// A restart looks at what it continues.
namespace subsoil::sim::run_continue {
namespace {

using namespace test;

class RunContinue : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(run_scenario(dir_.scenario(trench), dir_ / "first", {"time.end=20 ms"}), exit_ok);
    state_ = latest_state(dir_ / "first").value();
  }
  /// What is said against it; "" when it runs.
  std::string refusal(std::vector<std::string> sets, const std::vector<std::string>& changes = {}) {
    if (sets.empty() || sets.back().rfind("time.end", 0) != 0) sets.push_back("time.end=22 ms");
    std::filesystem::remove_all(dir_ / "on");
    try {
      EXPECT_EQ(run({.scenario = dir_.scenario(trench),
                     .out = dir_ / "on",
                     .sets = sets,
                     .threads = 1,
                     .changes = changes,
                     .from = state_}),
                exit_ok);
      return "";
    } catch (const ScenarioError& error) {
      return error.what();
    }
  }
  RunDirectory dir_;
  std::filesystem::path state_;
};

TEST_F(RunContinue, TheSameScenarioAndHarmlessDifferencesPass) {
  EXPECT_EQ(refusal({}), "");
  EXPECT_EQ(refusal({"limits.speed=40 m/s", "output.every=5 ms", "title=other", "time.threads=1"}), "");
}

/// The summary of the second half says what that of the whole run says: works, what gravity gave, losses and closure.
TEST_F(RunContinue, EnergiesOfTheSummaryGoOn) {
  ASSERT_EQ(refusal({}), "");
  ASSERT_EQ(run_scenario(dir_.scenario(trench), dir_ / "whole", {"time.end=22 ms"}), exit_ok);
  const Json whole = summary_of(dir_ / "whole")["energy"], on = summary_of(dir_ / "on")["energy"];
  const double put_in = whole.at("work put in [J]").get<double>();
  ASSERT_GT(put_in, 0);
  ASSERT_EQ(on.size(), whole.size());
  for (const auto& [name, value] : whole.items())
    EXPECT_NEAR(on.at(name).get<double>(), value.get<double>(),
                1e-9 * (name.find("over") == std::string::npos ? put_in : 1))
        << name;
}

/// So does that of a run with a change, here one of 1e-9 that moves nothing; its balance closes from the state on.
TEST_F(RunContinue, EnergiesOfTheSummaryGoOnBehindAChange) {
  ASSERT_EQ(refusal({"contacts.soil-steel.mu=0.5000000005"}, {"contacts.soil-steel.mu"}), "");
  ASSERT_EQ(run_scenario(dir_.scenario(trench), dir_ / "whole", {"time.end=22 ms"}), exit_ok);
  const Json whole = summary_of(dir_ / "whole")["energy"], on = summary_of(dir_ / "on")["energy"];
  const double put_in = whole.at("work put in [J]").get<double>();
  for (const char* name :
       {"work of given motions [J]", "gravity on the soil [J]", "damped [J]", "slid [J]", "work put in [J]"})
    EXPECT_NEAR(on.at(name).get<double>(), whole.at(name).get<double>(), 1e-6 * put_in) << name;
  EXPECT_LT(std::abs(on.at("bed closure [J]").get<double>()),
            std::max(2 * std::abs(whole.at("bed closure [J]").get<double>()), 1e-3 * put_in));
}

TEST_F(RunContinue, PhysicsChangesOnlyWhereItIsSaid) {
  const std::string mu = "contacts.soil-steel.mu=0.1";
  const std::string said = refusal({mu});
  EXPECT_NE(said.find("contacts.soil-steel.mu = 0.5, now 0.1"), std::string::npos) << said;
  EXPECT_NE(said.find("--from and --change contacts.soil-steel.mu"), std::string::npos) << said;
  EXPECT_EQ(refusal({mu}, {"contacts.soil-steel.mu"}), "");
  EXPECT_EQ(refusal({mu}, {"contacts"}), "") << "a section names all below it";
  EXPECT_NE(refusal({mu, "gravity=5 m/s^2"}, {"contacts"}).find("gravity"), std::string::npos);
  EXPECT_NE(refusal({}, {"gravity"}).find("--change gravity: does not differ"), std::string::npos);
}

// A surface of another file is another surface, though the scenario's text is the same.
TEST_F(RunContinue, AMeshMayNotChangeUnderItsName) {
  const auto mesh = [&](double side) {
    test::write_file(dir_ / "tool.obj", fmt::format("v 0 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 2 3\n", side));
  };
  std::string text = trench;
  const std::string box = "{box: 20 80 20 mm}";
  text.replace(text.find(box), box.size(), "{mesh: tool.obj, unit: m}");
  const auto go_on = [&](const std::filesystem::path& out) {
    return run({.scenario = dir_.scenario(text),
                .out = out,
                .sets = {"time.end=4 ms"},
                .threads = 1,
                .from = latest_state(dir_ / "begun").value()});
  };
  mesh(0.02);
  ASSERT_EQ(run_scenario(dir_.scenario(text), dir_ / "begun", {"time.end=2 ms"}), exit_ok);
  EXPECT_EQ(go_on(dir_ / "same"), exit_ok);
  mesh(0.03);
  const std::string refusal = message_of([&] { go_on(dir_ / "other"); });
  EXPECT_NE(refusal.find("tool.obj = crc32"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("the state holds what was made of it"), std::string::npos) << refusal;
}

TEST_F(RunContinue, WhatTheStateHoldsCannotChange) {
  for (const char* set :
       {"soil.bed.radius=9 mm", "soil.container.size=0.5 0.1 0.08 m", "materials.soil.density=2000 kg/m^3"}) {
    const std::string key = std::string(set).substr(0, std::string(set).find('='));
    EXPECT_NE(refusal({set}, {key}).find("the state holds what was made of it"), std::string::npos) << set;
  }
}

TEST_F(RunContinue, AToolThatWouldJumpIsRefused) {
  // At 20 ms a tool at 0.8 m/s stands 8 mm farther than one at 0.4 m/s.
  const std::string said = refusal({"boundaries.tool.moves[0].velocity=0.8 0 0 m/s"}, {"boundaries"});
  EXPECT_NE(said.find("tool would jump by 0.008"), std::string::npos) << said;
  EXPECT_FALSE(std::filesystem::exists(dir_ / "on"));
}

TEST_F(RunContinue, AnEndBeforeTheStateIsRefused) {
  const double time = read_run(state_).time;
  EXPECT_NEAR(time, 0.02, 1e-4) << "the step nearest to the end";
  const std::string said = refusal({"time.end=10 ms"});
  EXPECT_NE(said.find(fmt::format("time.end = 0.01 s: the state is of {:.6g} s; give a later end", time)),
            std::string::npos)
      << said;
}

/// A PI controller holds a block on a spring. What the state has of other gains and stiffnesses must not count: rates
/// of a multistep method's past, and the energy that a deformed spring gets by its stiffness.
TEST(RunContinueChanged, StartsFromTheStateAlone) {
  const std::string held = R"(subsoil: 1
machine:
  bodies: {block: {mass: 2 kg, inertia: 0.1 kg m^2, at: 0.1 0 m}}
  markers: {c: {body: block, at: 0.1 0 m}}
  measures: {place: {position: c, component: x}}
  joints: {guide: {translational: [ground, block], at: 0.1 0 m, along: 1 0}}
  controllers:
    pi: {pid: place, measured in: m, output in: N, set point: 0.05 m, proportional: 100 N/m, integral: 300 N/m/s}
  forces:
    push: {force: block, controller: pi}
    spring: {spring-damper: [ground, block], ends: [-0.5 0 m, 0.1 0 m], stiffness: 400 N/m, free length: 0.5 m, damping: 5 N s/m}
time: {end: 0.5 s}
output: {series every: 5 ms}
)";
  const auto end_of = [&](const std::string& integrator, const std::string& set) {
    const RunDirectory dir;
    const std::string method = "time.machine.integrator=" + integrator;
    EXPECT_EQ(run_scenario(dir.scenario(held), dir / "first", {method}), exit_ok);
    EXPECT_EQ(run({.scenario = dir.scenario(held),
                   .out = dir / "on",
                   .sets = {method, set, "time.end=1 s"},
                   .threads = 1,
                   .changes = {set.substr(0, set.find('='))},
                   .from = latest_state(dir / "first").value()}),
              exit_ok);
    EXPECT_LT(summary_of(dir / "on")["energy"]["machine closure over energy there or moved"].get<double>(), 1e-5);
    EXPECT_EQ(summary_of(dir / "on")["warnings"], Json::array());
    return read_series(dir / "on" / "series.csv").at("block.x").back();
  };
  // adams-moulton errs by 2e-8 m by itself; rates of the past left 1e-5 m.
  for (const char* set : {"machine.controllers.pi.integral=0 N/m/s", "machine.forces.spring.stiffness=3000 N/m"})
    EXPECT_NEAR(end_of("adams-moulton", set), end_of("cvode", set), 2e-7) << set;
}

/// A block of 2 kg slides down a damped guide for 1 s under 10 m/s^2 and then without gravity: v' = g - d v/m. Gravity
/// gives m g s over the way s of the first second; the damper takes that, less what still moves.
TEST(RunContinueChanged, EnergiesCountFromTheFirstStart) {
  const std::string falling = R"(subsoil: 1
gravity: 10 m/s^2
machine:
  bodies: {block: {mass: 2 kg, inertia: 0.1 kg m^2, at: 0 3 m}}
  joints: {guide: {translational: [ground, block], at: 0 3 m, along: 0 1}}
  forces: {damper: {drag: block, linear: 4 N s/m}}
time: {end: 1 s}
output: {series every: 5 ms}
)";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(falling), dir / "first"), exit_ok);
  ASSERT_EQ(run({.scenario = dir.scenario(falling),
                 .out = dir / "on",
                 .sets = {"gravity=0 m/s^2", "time.end=1.5 s"},
                 .threads = 1,
                 .changes = {"gravity"},
                 .from = latest_state(dir / "first").value()}),
            exit_ok);
  constexpr double m = 2, g = 10, rate = 4 / m;
  const double v = g / rate * (1 - std::exp(-rate)), way = (g - v) / rate, at_end = v * std::exp(-0.5 * rate);
  const Json energy = summary_of(dir / "on")["energy"];
  EXPECT_NEAR(energy.at("gravity on the machine [J]").get<double>(), m * g * way, 1e-8);
  EXPECT_NEAR(energy.at("lost in the machine [J]").get<double>(), m * g * way - 0.5 * m * at_end * at_end, 1e-8);
  EXPECT_NEAR(energy.at("machine closure [J]").get<double>(), 0, 1e-8);
}

/// States of before do not keep which gravity their potentials are of.
TEST(RunContinueChanged, ReadsWhereEnergiesOfAnOlderStateCountFrom) {
  double bed = 1, bed_gravity = 2, machine = 3;
  Archive older;
  older("bed", bed)("bed gravity", bed_gravity)("machine potential", machine);
  EnergyStart start{.gravity = dem::Vec3{0, -1, 0}}, again;
  Archive written = older.to_read();
  again.archive(written);
  written.end();
  EXPECT_EQ(again.machine_potential, 3);
  EXPECT_FALSE(again.gravity.has_value());
  Archive newer;
  start.archive(newer);
  Archive read = newer.to_read();
  again.archive(read);
  read.end();
  EXPECT_EQ(again.gravity->y, -1);
}

/// A machine beside a bed, from the state in the middle: comes to the same bits.
void expect_the_same_end(const std::string& scenario) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(scenario), dir / "whole"), exit_ok);
  const std::vector<std::filesystem::path> states = states_in(dir / "whole");
  ASSERT_GT(states.size(), 2U);
  ASSERT_EQ(run_scenario(dir.scenario(scenario), dir / "on", {}, states.at(states.size() / 2)), exit_ok);
  const Series whole = read_series(dir / "whole" / "series.csv"), on = read_series(dir / "on" / "series.csv");
  for (std::size_t i = 0; i < whole.columns.size(); ++i)
    EXPECT_EQ(whole.values[i].back(), on.values[i].back()) << whole.columns[i].name;
}

const std::string far_sphere = R"(subsoil: 1
gravity: 0 -9.81 0 m/s^2
materials: {soil: {density: 2500 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - {between: [soil, soil], law: linear, k_n: 20 kN/m, restitution: 0.5, mu: 0.3}
  - {between: [soil, steel], law: linear, k_n: 20 kN/m, restitution: 0.5, mu: 0.3}
soil:
  bed: {fill: particles, material: soil, particles: [{position: 1 -0.01 0 m, radius: 0.01 m}]}
)";

/// Open, it has no part in the constraints that a state is looked at with.
TEST(RunContinues, WhereAnEventHasOpenedAJoint) {
  expect_the_same_end(far_sphere + R"(machine:
  bodies:
    arm: {mass: 1 kg, inertia: 0.002 kg m^2, at: 0.1 0 m}
  joints:
    pin: {revolute: [ground, arm], at: 0 0 m}
    shear: {distance: [ground, arm], ends: [0.1 0.2 m, 0.1 0 m]}
  events:
    trip: {opens: shear, at: 0.05 s}
  surfaces:
    s: {body: arm, material: steel, box: 0.02 0.02 0.02 m}
time: {end: 0.2 s}
output: {state every: 0.04 s, series every: 10 ms, every: 0.1 s}
)");
}

/// The bed of a state has been worked: its surface is no datum.
TEST(RunContinues, WhereTheSoilsSurfaceHasLeftTheDatumOfAWheelsLaw) {
  expect_the_same_end(far_sphere + R"(machine:
  bodies:
    wheel: {mass: 3 kg, inertia: 0.01 kg m^2, at: 0 0.045 m}
    tool: {mass: 1 kg, inertia: 0.01 kg m^2, at: 0 0.3 m}
  joints:
    hold: {fixed: [ground, tool], at: 0 0.3 m}
    up: {translational: [ground, wheel], at: 0 0 m, along: 0 1}
  forces:
    law: {wheel on soil: wheel, radius: 0.05 m, width: 0.03 m, n: 0.8, k_c: 1 kN/m^(n+1), k_phi: 300 kN/m^(n+2)}
  surfaces:
    s: {body: tool, material: steel, box: 0.02 0.02 0.02 m, at: 0 0.2 0 m}
time: {end: 1 s}
output: {state every: 0.2 s, series every: 10 ms, every: 0.1 s}
)");
}

/// A cart that a driver moves for 1 s, and another function of the driver from the state there on. The spring's free
/// length is that of the start pose, which the first function decides: 5 m.
class DriverChange : public testing::Test {
 protected:
  static std::string cart(const std::string& motion) {
    return "subsoil: 1\ngravity: 0 m/s^2\nmachine:\n"
           "  bodies: {a: {mass: 5 kg, inertia: 1 kg m^2, at: 0.1 0 m, pose is: about, velocity is: about}}\n"
           "  joints: {g: {translational: [ground, a], at: 0 0 m, along: 1 0}}\n"
           "  drivers: {d: {coordinate: a.x, " +
           motion +
           "}}\n"
           "  forces: {s: {spring-damper: [a, ground], ends: [0.1 0 m, 5 0 m], stiffness: 100 N/m}}\n"
           "time: {end: 1 s}\noutput: {series every: 10 ms}\n";
  }
  void start(const std::string& motion) {
    scenario_ = dir_.scenario(cart(motion));
    ASSERT_EQ(run_scenario(scenario_, dir_ / "first"), exit_ok);
    state_ = latest_state(dir_ / "first").value();
  }
  int change(const std::string& key, const std::string& to, const std::string& integrator) {
    std::filesystem::remove_all(dir_ / "on");
    return run(
        {.scenario = scenario_,
         .out = dir_ / "on",
         .sets = {"time.end=2 s", "time.machine.integrator=" + integrator, "machine.drivers.d." + key + "=" + to},
         .threads = 1,
         .changes = {"machine.drivers.d." + key, "time.machine"},
         .from = state_});
  }
  std::string refusal(const std::string& key, const std::string& to) {
    try {
      return fmt::format("exit {}", change(key, to, "ida"));
    } catch (const ScenarioError& error) {
      return error.what();
    }
  }
  double at(const std::string& column, bool first) const {
    const std::vector<double> values = read_series(dir_ / "on" / "series.csv").at(column);
    return first ? values.front() : values.back();
  }
  RunDirectory dir_;
  std::string scenario_;
  std::filesystem::path state_;
};

constexpr double sin_1 = 0.8414709848078965, cos_1 = 0.5403023058681398;

TEST_F(DriverChange, AVelocityContinuesFromThePoseOfTheState) {
  start("velocity: {expression: \"sin(t)\", unit: m/s}");
  for (const char* integrator : {"ida", "adams-moulton"}) {
    const std::string to = "{expression: \"sin(1)+2*(t-1)\", unit: m/s}";
    ASSERT_EQ(change("velocity", to, integrator), exit_ok);
    EXPECT_NEAR(at("a.x", true), 0.1 + 1 - cos_1, 1e-9);
    EXPECT_NEAR(at("a.x", false), 0.1 + 1 - cos_1 + sin_1 + 1, 1e-9);  // the integrals of both, one after the other
  }
}

TEST_F(DriverChange, AnAccelerationContinuesFromPoseAndVelocity) {
  start("acceleration: {expression: \"2*cos(t)\", unit: m/s^2}");
  ASSERT_EQ(change("acceleration", "1 m/s^2", "ida"), exit_ok);
  EXPECT_NEAR(at("a.vx", true), 2 * sin_1, 1e-9);
  EXPECT_NEAR(at("a.x", false), 0.1 + 2 - 2 * cos_1 + 2 * sin_1 + 0.5, 1e-9);
}

TEST_F(DriverChange, APositionHasToAgreeAtTheStateAlone) {
  start("position: {expression: \"0.5*t^2\", unit: m}");
  const std::string to = "{expression: \"t-0.5\", unit: m}";
  ASSERT_EQ(change("position", to, "ida"), exit_ok);
  EXPECT_NEAR(at("a.x", false), 1.5, 1e-9);
  EXPECT_NEAR(at("s.force", false), 100 * (5 - 3.5), 1e-6) << "the start pose is that of the run that wrote the state";
  // The state of the changed run goes back to the same start.
  const std::filesystem::path again = latest_state(dir_ / "on").value();
  const std::vector<std::string> sets{"time.end=3 s", "time.machine.integrator=ida",
                                      "machine.drivers.d.position=" + to};
  ASSERT_EQ(run_scenario(scenario_, dir_ / "again", sets, again), exit_ok);
  EXPECT_NEAR(read_series(dir_ / "again" / "series.csv").at("s.force").back(), 100 * (5 - 2.5), 1e-6);
}

TEST_F(DriverChange, AJumpIsRefusedWithItsSize) {
  start("position: {expression: \"0.5*t^2\", unit: m}");
  const std::string place = refusal("position", "{expression: \"t-0.4\", unit: m}");
  EXPECT_NE(place.find("driver 'd' would jump by 0.1 m: its motion is elsewhere than the state at 1 s"),
            std::string::npos)
      << place;
  const std::string speed = refusal("position", "{expression: \"0.5+0*t\", unit: m}");
  EXPECT_NE(speed.find("driver 'd' would jump by 1 m/s: its motion has another velocity"), std::string::npos) << speed;
  EXPECT_NE(refusal("coordinate", "a.y").find("the state holds what was made of it"), std::string::npos);
}

/// What --change names differs from a state: without one it would be left out silently.
TEST(RunFrom, AChangeNeedsAState) {
  const RunDirectory dir;
  const std::string text = dir.scenario(small_pass);
  EXPECT_EQ(
      message_of<std::invalid_argument>(
          [&] { run({.scenario = text, .out = dir / "out", .sets = {}, .threads = 1, .changes = {"gravity"}}); }),
      "--change gravity: names what differs from the scenario of a state; give --from STATE, or --set for another "
      "value");
  EXPECT_NE(
      message_of([&] { run_scenario(text, dir / "out", {}, dir / "no.h5"); }).find("no.h5: there is no such file"),
      std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::run_continue
