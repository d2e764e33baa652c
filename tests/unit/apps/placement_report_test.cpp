#include "libsim/run/placement_report.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "libsim/run/input_report.hpp"
#include "libsim/run/overlap_advice.hpp"
#include "libsim/run/surface_report.hpp"
#include "libsim/setup/approach_speed.hpp"
#include "libsim/setup/travel_direction.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// What is odd about places and sizes of tools, seen before a run: each fault is named, and the scenario without it is
/// not.
namespace subsoil::sim::placement_report_test {
namespace {

using namespace test;
using subsoil::test::message_of;

/// A tine of 20 x 180 x 40 mm, 60 mm deep in a bin of 0.3 x 0.2 x 0.14 m, towed by 0.125 m.
constexpr const char* towed = R"(subsoil: 1
materials: {soil: {density: 2500 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 60 kN/m, restitution: 0.4, mu: 0.5}
  - {<<: *dry, between: [soil, steel]}
soil:
  container: {size: 0.3 0.2 0.14 m, at: 0 -0.08 -0.07 m, material: steel}
  surface: 0 m
  bed: {fill: rest-lattice, material: soil, radius: 10 mm, depth: 75 mm, inside machine: carve}
machine:
  bodies:
    frame: {mass: 10 kg, inertia: 0.3 kg m^2, at: 0.05 0.15 m, outline: [-0.02 -0.02 m, 0.02 -0.02 m, 0.02 0.02 m]}
    tine: {mass: 5 kg, inertia: 0.05 kg m^2, at: 0.05 0.06 m}
  joints:
    rail: {translational: [ground, frame], at: 0.05 0.15 m, along: 1 0}
    pin: {revolute: [frame, tine], at: 0.05 0.14 m}
  drivers: {tow: {coordinate: frame.x, velocity: 0.5 m/s}}
  forces: {torsion: {rotational spring-damper: [frame, tine], stiffness: 300 N m/rad, damping: 3 N m s/rad}}
  surfaces: {blade: {body: tine, material: steel, box: 20 180 40 mm, at: 0 -30 0 mm}}
time: {end: 0.25 s, accuracy: 0.05}
)";

struct Seen {
  std::string start, way, sizes, inputs;
  std::vector<std::string> free;
};
Seen look(const std::vector<std::string>& sets, const std::string& text = towed) {
  const RunDirectory dir;
  const std::string file = dir.scenario(text);
  const Loaded loaded = load_scenario(file, sets);
  const World world = build_world(loaded, {.threads = 1, .settle = false, .restored = {}, .progress = {}});
  const auto joined = [](const std::vector<std::string>& all) {
    std::string out;
    for (const std::string& one : all) out += one + "\n";
    return out;
  };
  const Scenario& s = loaded.scenario;
  return {joined(placement_warnings(s, world)), joined(travel_warnings(s, world)),
          joined(surface_warnings(surface_facts(world, s, s.time.end), world)),
          joined(input_warnings(loaded, world, file, sets)), free_bodies(s, world)};
}

TEST(PlacementReport, AToolThatFitsIsNotNamed) {
  const Seen seen = look({});
  EXPECT_EQ(seen.start, "");
  EXPECT_EQ(seen.way, "");
  EXPECT_EQ(seen.sizes, "");
  EXPECT_EQ(seen.inputs, "");
  EXPECT_TRUE(seen.free.empty());
}

TEST(PlacementReport, AToolThroughTheFloorOrBothSideWallsIsNamed) {
  EXPECT_NE(look({"machine.surfaces.blade.box=20 380 40 mm"}).start.find("tine reaches"), std::string::npos);
  EXPECT_NE(look({"machine.surfaces.blade.box=20 380 40 mm"}).start.find("below the floor of the container"),
            std::string::npos);
  const std::string wide = look({"machine.surfaces.blade.box=20 180 240 mm"}).start;
  EXPECT_NE(wide.find("tine is 0.24 m wide along z and passes through both walls of the container, 0.14 m apart"),
            std::string::npos)
      << wide;
  EXPECT_EQ(look({"machine.surfaces.blade.box=20 180 240 mm", "soil.container.open after settling=[-z, +z]"}).start, "")
      << "walls that are gone in the run";
}

/// At 0.5 m/s from x = 0.06 m to the wall at 0.3 m: 0.24 m, at 0.48 s.
TEST(PlacementReport, AToolThatComesToTheEndOfTheBinIsNamed) {
  const std::string said = look({"time.end=1 s"}).way;
  EXPECT_NE(said.find("tine comes to the wall +x of the container at t = 0.48 s, 0.24 m from its start"),
            std::string::npos)
      << said;
  EXPECT_EQ(look({"time.end=0.4 s"}).way, "");
}

/// 20 mm long and 60 mm deep: means begin after 80 mm.
TEST(PlacementReport, AWayTooShortForMeansIsNamed) {
  const std::string said = look({"time.end=0.1 s"}).way;
  EXPECT_NE(said.find("tine travels 0.05 m in soil, less than its length there plus its depth, 0.08 m"),
            std::string::npos)
      << said;
  EXPECT_EQ(look({"time.end=0.1 s", "output.window.from=0.05 s"}).way, "");
}

TEST(PlacementReport, ABodyOnNoJointAndAPinFarAwayAreNamed) {
  std::string loose = towed;
  loose.erase(loose.find("    pin: {revolute"),
              std::string("    pin: {revolute: [frame, tine], at: 0.05 0.14 m}\n").size());
  EXPECT_EQ(look({}, loose).free, (std::vector<std::string>{"tine"}));
  const std::string said = look({"machine.joints.pin.at=0.05 1.4 m"}).start;
  EXPECT_NE(said.find("machine.joints.pin: its pin at (0.05, 1.4) m lies 1.23 m from both bodies"), std::string::npos)
      << said;
}

/// A box of metres where millimetres were meant takes every sphere away: nothing is left to simulate.
TEST(PlacementReport, AToolInAWrongUnitIsRefusedOrNamed) {
  const std::string all = message_of<ScenarioError>([] { look({"machine.surfaces.blade.box=20 180 40 m"}); });
  EXPECT_NE(all.find("no sphere is left: all "), std::string::npos) << all;
  EXPECT_NE(all.find("is the unit of its numbers right?"), std::string::npos) << all;
  const std::string large =
      look({"machine.surfaces.blade.box=20 180 40 m", "machine.surfaces.blade.at=0 91 0 m"}).sizes;
  EXPECT_NE(large.find("blade is 180 m large"), std::string::npos) << large;
  const std::string small = look({"machine.surfaces.blade.box=0.02 0.18 0.04 mm"}).sizes;
  EXPECT_NE(small.find("its smallest sphere has a diameter of 0.02 m"), std::string::npos) << small;
  const std::string half =
      look({"machine.surfaces.blade.box=200 180 120 mm", "machine.surfaces.blade.at=60 -60 0 mm"}).inputs;
  EXPECT_NE(half.find("lay inside tools or boundaries and were removed"), std::string::npos) << half;
  std::string outline = towed;
  outline.replace(outline.find("-0.02 -0.02 m, 0.02 -0.02 m, 0.02 0.02 m"), 40, "-20 -20 m, 20 -20 m, 20 20 m");
  EXPECT_NE(look({}, outline).inputs.find("outline is 56.6 m large"), std::string::npos) << look({}, outline).inputs;
}

/// `check` looks at a lattice of spheres of mean size; the smallest is that of the distribution.
TEST(PlacementReport, TheSmallestSphereIsThatOfTheDistribution) {
  std::string drawn = towed;
  const std::string lattice = "fill: rest-lattice, material: soil, radius: 10 mm";
  drawn.replace(drawn.find(lattice), lattice.size(), "fill: random, material: soil, radius: {uniform: 8 12 mm}");
  const std::string said = look({"machine.surfaces.blade.box=0.02 0.18 0.04 mm"}, drawn).sizes;
  EXPECT_NE(said.find("its smallest sphere has a diameter of 0.016 m"), std::string::npos) << said;
}

/// Grains that fall along x fall through the container's length: the scenario that is turned by 90 degrees has the same
/// step to the bit.
TEST(PlacementReport, ImpactsAreThoseOfAFallAlongGravity) {
  const auto step = [](const char* gravity, const char* size, const char* at, const char* open) {
    const Loaded loaded = load_scenario_text(fmt::format(R"(subsoil: 1
gravity: {} m/s^2
materials: {{soil: {{density: 2500 kg/m^3}}}}
contacts: [{{between: [soil, soil], law: linear, k_n: 60 kN/m, restitution: 0.4, mu: 0.5}}]
soil:
  container: {{size: {} m, at: 0 0 0 m, material: soil, open: [{}]}}
  bed: {{fill: particles, material: soil, particles: [{{position: {} m, radius: 10 mm}}]}}
time: {{end: 1 s}}
)",
                                                         gravity, size, open, at));
    return build_world(loaded, {.threads = 1, .settle = false, .restored = {}, .progress = {}}).step;
  };
  const StepReport down = step("0 -10 0", "0.3 0.2 0.1", "0.1 0.1 0.05", "+y"),
                   along = step("10 0 0", "0.2 0.3 0.1", "0.1 0.1 0.05", "-x");
  EXPECT_EQ(down.expected_speed, 2);  // sqrt(2 g 0.2 m)
  EXPECT_EQ(along.expected_speed, 2);
  EXPECT_EQ(along.soil_step, down.soil_step);
}

/// Counted before the first one, which would run for years.
TEST(PlacementReport, StepsWithoutNumberAreRefused) {
  const auto refused = [](const char* radius, const std::vector<std::string>& sets) {
    const Loaded loaded = load_scenario_text(fmt::format(R"(subsoil: 1
materials: {{soil: {{density: 2500 kg/m^3}}}}
contacts: [{{between: [soil, soil], law: linear, k_n: 60 kN/m, restitution: 0.4, mu: 0.5}}]
soil:
  container: {{size: 0.3 0.2 0.1 m, at: 0 0 0 m, material: soil}}
  bed: {{fill: particles, material: soil, particles: [{{position: 0.1 0.1 0.05 m, radius: {} m}}]}}
time: {{end: 1 s}}
)",
                                                         radius),
                                             "case.yaml", sets);
    return message_of<ScenarioError>(
        [&] { build_world(loaded, {.threads = 1, .settle = false, .restored = {}, .progress = {}}); });
  };
  EXPECT_EQ(refused("0.01", {}), "accepted");
  const std::string tiny = refused("1e-12", {});  // its columns of diameters would take the memory, too
  EXPECT_TRUE(tiny.starts_with("case.yaml:7:13 time.end: the soil step of ")) << tiny;
  EXPECT_NE(tiny.find(" steps until 1 s; at most 1e+10: it follows from the smallest sphere, of radius 1e-12 m"),
            std::string::npos)
      << tiny;
  EXPECT_EQ(refused("0.01", {"time.soil step=0.01 ns"}),
            "--set time.soil step = 1e-11 s makes 1e+11 steps until 1 s; at most 1e+10: make it longer, or leave it "
            "out for a step by the impacts");
}

/// Mirrored in x the draft is the same force against the travel.
TEST(PlacementReport, DraftIsAgainstTheTravel) {
  const Loaded plain = load_scenario_text(towed, "case.yaml"),
               back = load_scenario_text(towed, "case.yaml", {"machine.drivers.tow.velocity=-0.5 m/s"});
  const BuildOptions options{.threads = 1, .settle = false, .restored = {}, .progress = {}};
  EXPECT_EQ(travel_direction(plain.scenario, build_world(plain, options)), 1);
  EXPECT_EQ(travel_direction(back.scenario, build_world(back, options)), -1);
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(towed), dir / "out",
                         {"machine.drivers.tow.velocity=-0.2 m/s", "machine.bodies.frame.at=0.2 0.15 m",
                          "machine.bodies.tine.at=0.2 0.06 m", "machine.joints.rail.at=0.2 0.15 m",
                          "machine.joints.pin.at=0.2 0.14 m", "time.end=0.2 s"}),
            exit_ok);
  const Series series = read_series(dir / "out/series.csv");
  double draft = 0;
  for (std::size_t i = 0; i < series.rows(); ++i) {
    EXPECT_EQ(series.at("soil.draft")[i], series.at("tine.soil.Fx")[i]);
    draft += series.at("soil.draft")[i];
  }
  EXPECT_GT(draft, 0);
}

/// A tool wholly below the floor touches no soil: no travel in it, and no stiffness that its pressure would take.
TEST(PlacementReport, AToolBelowTheFloorIsNamed) {
  const std::vector<std::string> below = {"machine.surfaces.blade.at=0 -300 0 mm"};
  const Seen seen = look(below);
  EXPECT_EQ(
      seen.start.rfind("tine lies wholly below the floor of the container at the start, by 0.09 m, and touches no "
                       "soil there; start it higher",
                       0),
      0U)
      << seen.start << "its upper edge is at 60 - 300 + 90 = -150 mm, the floor three rows of 20 mm below the surface";
  EXPECT_EQ(seen.way.find("in soil"), std::string::npos) << seen.way;
  const auto expected = [](const std::vector<std::string>& sets) {
    const Loaded loaded = load_scenario_text(towed, "case.yaml", sets);
    return expected_overlap(build_world(loaded, {.threads = 1, .settle = false}), loaded.scenario);
  };
  EXPECT_EQ(expected(below).tool, "");
  EXPECT_EQ(expected({}).tool, "blade");
  EXPECT_EQ(look({}).start.find("wholly below"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::placement_report_test
