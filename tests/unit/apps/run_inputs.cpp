#include <fmt/format.h>
#include <gtest/gtest.h>

#include "libsim/run/input_report.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// What a scenario asks for and cannot have, said before it runs: gravity that is not down, falls in float, bridges
/// beyond their law, lists without anything in them.
namespace subsoil::sim::run_inputs {
namespace {

using namespace test;

constexpr const char* sideways = R"(subsoil: 1
gravity: 0 0 -9.81 m/s^2
materials: {a: {density: 2500 kg/m^3}}
contacts: [{between: [a, a], law: linear, k_n: 20 kN/m, restitution: 0.5, mu: 0.5}]
soil:
  container: {size: 0.1 0.1 0.1 m, at: 0 0 0 m, material: a, open: [+z]}
  bed: {fill: random, material: a, radius: 6 mm, count: 60, settle: {for: 5 ms}}
time: {end: 1 ms}
)";

constexpr const char* falls = R"(subsoil: 1
precision: mixed
materials: {a: {density: 2500 kg/m^3}}
contacts: [{between: [a, a], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0.5}]
soil: {bed: {fill: particles, material: a, particles: [{position: 0 50 0 mm, radius: 2 mm, velocity: 0.1 0 0 m/s}]}}
boundaries: [{name: floor, material: a, shape: {plane: {}}}]
time: {end: 90 ms}
)";

std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::string warnings(const std::string& text, const std::vector<std::string>& sets = {}) {
  const RunDirectory dir;
  const std::string file = dir.scenario(text);
  const Loaded loaded = load_scenario(file, sets);
  const World world = build_world(loaded, {.threads = 1, .settle = false});
  std::string all;
  for (const std::string& one : input_warnings(loaded, world, file, sets)) all += one + "\n";
  return all;
}

std::string refusal(const std::string& text) {
  return subsoil::test::message_of<ScenarioError>([&] { load_scenario_text(text, "case.yaml"); });
}

/// Density and surface are taken in columns along y: of a bed that lies on the wall -z they would be 160 kg/m3 and
/// half the container's height.
TEST(RunInputs, GravityThatIsNotDownLeavesOutWhatIsMeasuredAlongY) {
  const RunDirectory dir;
  const std::string placed = with(sideways, "fill: random, material: a, radius: 6 mm, count: 60, settle: {for: 5 ms}",
                                  "fill: lattice, material: a, radius: 6 mm, pitch: 12.5 mm, depth: 50 mm");
  ASSERT_EQ(run_scenario(dir.scenario(placed), dir / "out"), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out");
  for (const char* key : {"bulk density [kg/m3]", "mean surface [m]", "spread of the surface [m]"})
    EXPECT_FALSE(summary["soil"].contains(key)) << key;
  EXPECT_NE(summary["warnings"].dump().find("gravity acts along (0, 0, -9.81) m/s2"), std::string::npos);
  const std::string down = with(placed, "0 0 -9.81 m/s^2", "2 -9.81 0 m/s^2");
  ASSERT_EQ(run_scenario(dir.scenario(down), dir / "down"), exit_ok);
  EXPECT_TRUE(summary_of(dir / "down")["soil"].contains("mean surface [m]")) << "12 degrees off are a slope";
  EXPECT_EQ(summary_of(dir / "down")["warnings"].dump().find("gravity"), std::string::npos);
}

TEST(RunInputs, NothingIsPouredToADepthAcrossGravity) {
  const std::string deep = refusal(with(sideways, "count: 60", "depth: 50 mm"));
  EXPECT_NE(deep.find("soil.bed.depth"), std::string::npos) << deep;
  EXPECT_NE(deep.find("give `count` in its place, or turn the scenario"), std::string::npos) << deep;
  EXPECT_EQ(refusal(with(with(sideways, "count: 60", "depth: 50 mm"), "0 0 -9.81 m/s^2", "9.81 m/s^2")), "accepted");
  EXPECT_NE(refusal(with(sideways, "  bed:", "  surface: 0 m\n  bed:")).find("soil.surface"), std::string::npos);
}

TEST(RunInputs, AListWithoutParticlesIsNamed) {
  const std::string said = refusal(with(falls, "[{position: 0 50 0 mm, radius: 2 mm, velocity: 0.1 0 0 m/s}]", "[]"));
  EXPECT_NE(said.find("soil.bed.particles: is empty"), std::string::npos) << said;
}

/// From 50 mm a sphere falls to 0.99 m/s, where floats are 6e-8 m/s apart: a step of 1 us adds 165 of them, one of 20
/// us 3,300.
TEST(RunInputs, FallsThatFloatDoesNotResolve) {
  EXPECT_NE(warnings(falls, {"time.soil step=1 us"}).find("times what float resolves"), std::string::npos);
  EXPECT_EQ(warnings(falls, {"time.soil step=20 us"}), "");
  EXPECT_EQ(warnings(falls, {"time.soil step=1 us", "precision=double"}), "");
  EXPECT_EQ(warnings(falls, {"time.soil step=1 us", "gravity=0 m/s^2"}), "");
}

/// r_eff is 2 mm on the floor: 0.01 of 8 mm3.
TEST(RunInputs, BridgesBeyondTheirLaw) {
  const auto wet = [](const char* volume) {
    return with(with(falls, "precision: mixed\n", ""), "mu: 0.5",
                fmt::format("mu: 0.5, cohesion: liquid-bridge, surface tension: 72 mN/m, contact angle: 20 deg, "
                            "liquid volume: {}",
                            volume));
  };
  // Between spheres, as which the entry counts too, r_eff is 1 mm.
  EXPECT_EQ(warnings(wet("0.0099 mm^3")), "");
  const std::string said = warnings(wet("0.02 mm^3"));
  EXPECT_NE(said.find("a bridge of 0.02 mm3 has 0.02 of r_eff^3"), std::string::npos) << said;
  EXPECT_NE(said.find("its law holds to 0.01, 0.01 mm3"), std::string::npos) << said;
}

/// 0.3 m beyond its stroke on stops of 1e8 N/m; inside it nothing is odd.
TEST(RunInputs, StartsBeyondARangeAreNamedWithTheirEnergy) {
  const std::string lift = R"(subsoil: 1
machine:
  bodies: {m: {mass: 100 kg, inertia: 1 kg m^2, at: 0 1 m}}
  joints: {d: {translational: [ground, m], at: 0 0 m, along: 0 1}}
  forces: {c: {hydraulic cylinder: [ground, m], ends: [0 0 m, 0 1 m], bore: 50 mm, closed length: 0.3 m, stroke: 0.4 m, flow given: 1 l/s}}
time: {end: 1 s}
)";
  const std::string text = warnings(lift);
  EXPECT_NE(text.find("c: the machine starts 0.3 m beyond where its contact or stop begins; that stores 4.5e+06 J"),
            std::string::npos)
      << text;
  EXPECT_EQ(warnings(lift, {"machine.forces.c.stroke=0.8 m"}), "");
}

/// A measure that is beyond its value at the start passes it only when it has returned; a time after the end never
/// comes.
TEST(RunInputs, EventsThatNothingBringsAboutAreNamed) {
  const std::string arm = R"(subsoil: 1
machine:
  bodies: {a: {mass: 1 kg, inertia: 0.1 kg m^2, at: 0.5 0 m}}
  joints: {o: {revolute: [ground, a], at: 0 0 m}}
  measures: {x: {position: a, component: x}}
  events: {e: {opens: o, measure: x, above: 0.2 m}}
time: {end: 1 s}
)";
  const std::string said = warnings(arm);
  EXPECT_NE(said.find("above: `x` starts at 0.5 m, above 0.2 m already"), std::string::npos) << said;
  EXPECT_NE(said.find("`joint starts: open`"), std::string::npos) << said;
  EXPECT_EQ(warnings(arm, {"machine.events.e.above=0.6 m"}), "");
  const std::string late = with(arm, "measure: x, above: 0.2 m", "at: 5 s");
  EXPECT_NE(warnings(late).find("5 s is after the end of the run, 1 s"), std::string::npos) << warnings(late);
  EXPECT_EQ(warnings(late, {"time.end=6 s"}), "");
}

/// A hook that starts closed because another event opens it.
TEST(RunInputs, EventsOfAJointThatIsAsTheyLeaveItAreNamed) {
  const std::string hook = R"(subsoil: 1
gravity: 9.81 m/s^2
machine:
  bodies: {b: {mass: 2 kg, inertia: 0.1 kg m^2, at: 0 1 m}}
  joints:
    g: {translational: [ground, b], at: 0 0 m, along: 0 1}
    hook: {fixed: [ground, b], at: 0 1 m}
  measures: {h: {position: b, component: y}}
  events:
    drop: {opens: hook, at: 0.1 s}
    catch: {closes: hook, measure: h, below: 2 m}
time: {end: 0.5 s}
)";
  const std::string passed = warnings(hook);
  EXPECT_NE(passed.find("below: `h` starts at 1 m, below 2 m already"), std::string::npos) << passed;
  EXPECT_NE(passed.find("After `drop` it comes only then"), std::string::npos) << passed;
  EXPECT_EQ(warnings(hook, {"machine.events.catch.below=0.9 m"}), "");
  const std::string early = warnings(with(hook, "measure: h, below: 2 m", "at: 0.05 s"));
  EXPECT_NE(early.find("at: 'hook' is closed then, so the event changes nothing; `drop` comes later"),
            std::string::npos)
      << early;
  EXPECT_EQ(warnings(with(hook, "measure: h, below: 2 m", "at: 0.2 s")), "");
}

TEST(RunInputs, AnEventAtTheStartIsNotNamedByWhatItHasDone) {
  const std::string held = R"(subsoil: 1
machine:
  bodies: {b: {mass: 2 kg, inertia: 0.1 kg m^2, at: 0 1 m}}
  joints: {hook: {fixed: [ground, b], at: 0 1 m}}
  events: {drop: {opens: hook, at: 0 s}, catch: {closes: hook, at: 0.5 s}}
time: {end: 1 s}
)";
  EXPECT_EQ(warnings(held), "");
  EXPECT_EQ(warnings(held, {"machine.events.drop.at=0.5 s"}), "");
}

/// Radii in another unit gave tooth forces of radii that fit the centres, without a word.
TEST(RunInputs, GearsOutOfMeshAreNamed) {
  const std::string gears = R"(subsoil: 1
machine:
  bodies:
    a: {mass: 1 kg, inertia: 0.1 kg m^2, at: 0 0 m}
    b: {mass: 1 kg, inertia: 0.1 kg m^2, at: 0.5 0 m}
    rack: {mass: 1 kg, inertia: 0.1 kg m^2, at: 0 -0.3 m}
  joints:
    p: {revolute: [ground, a], at: 0 0 m}
    q: {revolute: [ground, b], at: 0.5 0 m}
    slide: {translational: [ground, rack], at: 0 -0.3 m, along: 1 0}
    mesh: {gear pair: [a, b], ends: [0 0 m, 0.5 0 m], first radius: 0.3 m, second radius: 0.2 m}
    line: {rack and pinion: [rack, a], ends: [0 -0.3 m, 0 0 m], along: 1 0, radius: 0.3 m}
time: {end: 1 s}
)";
  EXPECT_EQ(warnings(gears), "");
  const std::string apart = warnings(gears, {"machine.joints.mesh.second radius=20 mm"});
  EXPECT_NE(apart.find("mesh: the pitch lines are 0.18 m apart at the start"), std::string::npos) << apart;
  EXPECT_NE(warnings(gears, {"machine.joints.mesh.second radius=0.3 m"}).find("0.1 m in each other"),
            std::string::npos);
  EXPECT_NE(warnings(gears, {"machine.joints.line.radius=30 mm"}).find("line: the pitch lines are 0.27 m apart"),
            std::string::npos);
}

TEST(RunInputs, GravityAcrossThePlaneOfAMachineIsNamed) {
  const std::string mass = R"(subsoil: 1
gravity: 0 -9.81 3 m/s^2
machine: {bodies: {a: {mass: 1 kg, inertia: 0.1 kg m^2, at: 0 0 m}}}
time: {end: 1 s}
)";
  EXPECT_NE(warnings(mass).find("its z component of 3 m/s^2 acts on spheres alone"), std::string::npos);
  EXPECT_EQ(warnings(mass, {"gravity=0 -9.81 0 m/s^2"}), "");
}

constexpr const char* pushed = R"(subsoil: 1
materials: {a: {density: 2500 kg/m^3}}
contacts: [{between: [a, a], law: linear, k_n: 20 kN/m, restitution: 0.5, mu: 0.5}]
soil:
  container: {size: 0.4 0.1 0.1 m, at: 0 0 0 m, material: a}
  bed: {fill: lattice, material: a, radius: 6 mm, pitch: 12 mm, depth: 36 mm}
machine:
  bodies: {tool: {mass: 20 kg, inertia: 1 kg m^2, at: 0.2 0.1 m}}
  joints: {guide: {translational: [ground, tool], at: 0.2 0.1 m, along: 1 0}}
  forces: {push: {force: tool, along x: -40 N}}
  surfaces: {share: {body: tool, material: a, box: 10 20 50 mm, at: 0 -20 0 mm}}
time: {end: 0.1 s}
)";

/// A draft is against the way of the tool: that of its drivers, of its speed, or of the force that moves it from rest.
TEST(RunInputs, AToolThatIsPushedFromRestHasADirection) {
  const auto travel = [](const std::string& text) {
    return build_world(load_scenario_text(text, "case.yaml"), {.threads = 1, .settle = false}).travel;
  };
  EXPECT_EQ(travel(pushed), -1);
  EXPECT_EQ(travel(with(pushed, "-40 N", "40 N")), 1);
  EXPECT_EQ(travel(with(pushed, "0.2 0.1 m}", "0.2 0.1 m, velocity: 1 0 m/s}")), 1) << "its speed first";
}

/// What comes back to its start has no way, whatever rounding leaves of it: the speed at the start decides. A tool that
/// is driven along a slide goes as its carriage and the slide do together.
TEST(RunInputs, TheWayOfDriversIsNetAndOfTheTool) {
  const auto travel = [](const std::string& text) {
    return build_world(load_scenario_text(text, "case.yaml"), {.threads = 1, .settle = false}).travel;
  };
  const auto driven = [](const std::string& motion) {
    return with(pushed, "forces: {push: {force: tool, along x: -40 N}}",
                "drivers: {tow: {coordinate: tool.x, " + motion + "}}");
  };
  const auto swing = [&](const char* amplitude, const char* end) {
    return with(
        driven(std::string("position: {harmonic: {mean: 200 mm, amplitude: ") + amplitude + ", frequency: 5 Hz}}"),
        "time: {end: 0.1 s}", std::string("time: {end: ") + end + "}");
  };
  for (const char* end : {"0.1 s", "0.2 s", "0.3 s"}) {
    EXPECT_EQ(travel(swing("40 mm", end)), 1) << end;
    EXPECT_EQ(travel(swing("-40 mm", end)), -1) << end;
  }
  EXPECT_EQ(travel(swing("40 mm", "0.15 s")), -1) << "sin(1.5 pi) = -1";
  EXPECT_EQ(travel(driven("velocity: -0.1 m/s")), -1);
  const auto carried = [&](const char* cylinder) {
    std::string text = driven("velocity: 0.2 m/s");
    text = with(text, "bodies: {tool:", "bodies: {frame: {mass: 20 kg, inertia: 1 kg m^2, at: 0.2 0.3 m}, tool:");
    text = with(text, "coordinate: tool.x", "coordinate: frame.x");
    text = with(text,
                "joints: {guide:", "joints: {slide: {translational: [frame, tool], at: 0.2 0.1 m, along: 1 0}, guide:");
    text = with(text, "guide: {translational: [ground, tool], at: 0.2 0.1 m",
                "guide: {translational: [ground, frame], at: 0.2 0.3 m");
    return with(text, "drivers: {",
                std::string("drivers: {cylinder: {slide: [frame, tool], at: 0.2 0.1 m, along: 1 0, velocity: ") +
                    cylinder + "}, ");
  };
  EXPECT_EQ(travel(carried("-1 m/s")), -1);
  EXPECT_EQ(travel(carried("-0.1 m/s")), 1);
  EXPECT_EQ(travel(carried("1 m/s")), 1);
}

/// The window of a moving bed goes one way, which is that of what it follows.
TEST(RunInputs, AMovingBedAgainstItsToolIsNamed) {
  std::string text =
      with(with(pushed, "pitch: 12 mm", "pitch: 12.5 mm"), "forces: {push: {force: tool, along x: -40 N}}",
           "drivers: {tow: {coordinate: tool.x, velocity: -1 m/s}}");
  text = with(text, "size: 0.4 0.1 0.1 m, at: 0 0 0 m, material: a",
              "size: 0.4 0.1 0.1 m, at: 0 0 0 m, material: a, periodic: [z]");
  text = with(text, "depth: 36 mm", "depth: 36 mm, settle: {for: 30 ms}");
  const std::string moving = "  moving: {follows: tool, block: 100 mm, towards: WAY}\n";
  text = with(text, "machine:\n", moving + "machine:\n");
  const std::string said = "soil.moving.towards: what it follows goes the other way";
  EXPECT_NE(warnings(with(text, "WAY", "+x")).find(said), std::string::npos) << warnings(with(text, "WAY", "+x"));
  EXPECT_EQ(warnings(with(text, "WAY", "-x")).find(said), std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::run_inputs
