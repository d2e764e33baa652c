#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "libsim/document/document.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/soil_runs.hpp"

/// Spheres that a scenario fixes: columns, frames, restarts, refusals.
namespace subsoil::sim::run_fixed {
namespace {

using namespace test;

/// Two fixed spheres of 10 mm carry a third one between them.
constexpr const char* nest = R"(subsoil: 1
materials: {steel: {density: 7850 kg/m^3}}
contacts: [{between: [steel, steel], law: linear, k_n: 100 kN/m, restitution: 0.3, mu: 0}]
soil:
  bed:
    fill: particles
    material: steel
    particles:
      - {position: -12 0 0 mm, radius: 10 mm, fixed: nest}
      - {position: 12 0 0 mm, radius: 10 mm, fixed: nest}
      - {position: 1 17 0 mm, radius: 10 mm}
time: {end: 0.4 s}
output: {precision: double, at: [0.1 s], series every: 10 ms, monitor: {load: {soil force: nest, along: 0 -1}}}
)";
const double weight = 7850 * 4.0 / 3 * M_PI * 1e-6 * 9.81;

TEST(RunFixed, TheyCarryWhatLiesOnThem) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(nest), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_NEAR(series.at("load").back(), weight, 0.01 * weight);
  EXPECT_NEAR(series.at("nest.Fx").back(), 0, 0.02 * weight);
  EXPECT_NEAR(series.at("nest.Fy").back(), -weight, 0.01 * weight);
  const std::vector<dem::Vec3> places = frame_positions(dir / "out", 1);
  EXPECT_EQ(places[0].x, -0.012);
  EXPECT_EQ(places[0].y, 0);
  EXPECT_EQ(places[1].x, 0.012);
  // The balance closes: what the third one has lost in height is damped or stored.
  const double fell = series.at("soil.gravity").front() - series.at("soil.gravity").back();
  EXPECT_GT(fell, 0);
  EXPECT_NEAR(conserved_energy(series, series.rows() - 1), conserved_energy(series, 0), 0.01 * fell);
}

TEST(RunFixed, ARestartKeepsThem) {
  const RunDirectory dir;
  const std::string file = dir.scenario(nest);
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "first", {"time.end=0.2 s"}), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "on", {}, state_in(dir / "first")), exit_ok);
  const Series whole = read_series(dir / "whole" / "series.csv"), on = read_series(dir / "on" / "series.csv");
  EXPECT_NEAR(on.at("load").back(), whole.at("load").back(), 1e-8 * weight);
  EXPECT_EQ(frame_positions(dir / "on", 0)[0].x, -0.012);
}

std::string refusal(const std::string& from, const std::string& to) {
  const RunDirectory dir;
  std::string text = nest;
  return subsoil::test::message_of<ScenarioError>(
      [&] { run_scenario(dir.scenario(text.replace(text.find(from), from.size(), to)), dir / "out"); });
}

TEST(RunFixed, RefusalsSayWhy) {
  EXPECT_NE(refusal("fixed: nest", "fixed: a.b").find("leave out dots and commas"), std::string::npos);
  EXPECT_NE(refusal("fixed: nest", "fixed: soil").find("is the name of the soil's sums too"), std::string::npos);
  EXPECT_NE(refusal("    particles:\n      - {position: -12 0 0 mm,",
                    "    settle: {until: 1 mm/s}\n    particles:\n      - {velocity: 1 0 0 m/s, position: -12 0 0 mm,")
                .find("moves while the bed settles"),
            std::string::npos);
  EXPECT_NE(refusal("    fill: particles\n    material: steel\n    particles:\n      - {position: -12 0 0 mm,",
                    "    fill: random\n    material: steel\n    radius: 4 mm\n    region: {size: 80 40 80 mm}\n    "
                    "particles:\n      - {spin: 0 1 0 rad/s, position: -12 0 0 mm,")
                .find("as every random one does"),
            std::string::npos);
}

/// 64 spheres that touch in a box of whole diameters, 16 of them fixed at the floor: pi/6 of their density, and the
/// mass of all, as without the key. They stand a rest overlap deep in the floor, below 1e-3 of the height.
TEST(RunFixed, ARoughFloorBelongsToTheBedThatIsMeasured) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {soil: {density: 2000 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 50 kN/m, restitution: 0.4, mu: 0.3}
  - {<<: *dry, between: [soil, steel]}
soil:
  container: {size: 80 100 80 mm, at: 0 0 0 mm, material: steel}
  bed: {fill: lattice, pitch: 20 mm, material: soil, radius: 10 mm, depth: 80 mm, rough floor: 12 mm}
time: {end: 1 ms}
)"),
                         dir / "out"),
            exit_ok);
  const nlohmann::json soil = summary_of(dir / "out")["soil"];
  const double mass = 64 * 2000 * 4.0 / 3 * M_PI * 1e-6;
  EXPECT_EQ(soil["spheres"], 64);
  EXPECT_NEAR(soil["mass [kg]"], mass, 1e-9 * mass);
  EXPECT_NEAR(soil["bulk density [kg/m3]"], 2000 * M_PI / 6, 2e-3 * 2000 * M_PI / 6);
}

/// A plate that is driven into a stone: k delta + c v of the linear law, on both with opposite signs.
constexpr const char* pressed = R"(subsoil: 1
gravity: 0 0 0 m/s^2
materials: {stone: {density: 2500 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - {between: [stone, steel], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0}
  - {between: [stone, stone], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0}
soil:
  bed:
    fill: particles
    material: stone
    particles:
      - {position: 0 0 0 m, radius: 30 mm, fixed: stone}
      - {position: 0.2 0 0 m, radius: 10 mm}
boundaries:
  - {name: plate, material: steel, shape: {box: 10 40 40 mm}, at: -36 0 0 mm, moves: [{velocity: 0.1 0 0 m/s}]}
time: {end: 20 ms}
output: {series every: 1 ms, series digits: all, forces: instant}
)";

TEST(RunFixed, ABoundaryThatMovesPressesOnThem) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(pressed), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const double m = 2500 * 4.0 / 3 * M_PI * 2.7e-5, loss = std::log(2), beta = loss / std::hypot(loss, M_PI);
  const double depth = 0.1 * 0.02 - 1e-3, force = 1e5 * depth + 2 * beta * std::sqrt(m * 1e5) * 0.1;
  EXPECT_NEAR(series.at("stone.Fx").back(), force, 1e-6 * force);
  EXPECT_NEAR(series.at("plate.Fx").back(), -force, 1e-6 * force);
}

TEST(RunFixed, ABoundaryAtRestAndWallsDoNotMeetThem) {
  const RunDirectory dir;
  std::string text = pressed;
  text.replace(text.find(", moves: [{velocity: 0.1 0 0 m/s}]"), 34, "").replace(text.find("at: -36"), 7, "at: -34");
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
  EXPECT_EQ(read_series(dir / "out" / "series.csv").at("stone.Fx").back(), 0);
}

/// A stone of 30 mm in a bed of 12 mm grains that rain around it: none lies in it, it bears some, and the bed is as
/// deep as it is asked to be.
constexpr const char* buried = R"(subsoil: 1
materials: {soil: {density: 2000 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 20 kN/m, restitution: 0.4, mu: 0.3}
  - {<<: *dry, between: [soil, steel]}
soil:
  container: {size: 120 100 120 mm, at: 0 0 0 mm, material: steel}
  bed:
    fill: random
    material: soil
    radius: 6 mm
    depth: 70 mm
    particles: [{position: 60 20 60 mm, radius: 15 mm, fixed: stone}]
time: {end: 5 ms}
output: {at: [5 ms], precision: double, series every: 1 ms}
)";

TEST(RunFixed, AStoneInARandomBed) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(buried), dir / "out"), exit_ok);
  const std::vector<dem::Vec3> places = frame_positions(dir / "out", 0);
  EXPECT_EQ(places[0], (dem::Vec3{0.06, 0.02, 0.06}));
  const double overlap = 2e-4;  // of the weight of the bed above one contact on 20 kN/m, and ten times that
  for (std::size_t i = 1; i < places.size(); ++i) EXPECT_GT(dem::norm(places[i] - places[0]), 0.021 - overlap) << i;
  EXPECT_GT(places.size(), 300U);
  const Series series = read_series(dir / "out" / "series.csv");
  // Stone, floor and walls bear the weight of the grains; what moves of them yet is below a hundredth of it. The stone
  // alone may be lifted: stresses grow with depth, as under buoyancy.
  double borne = 0;
  for (const char* of : {"stone.Fy", "floor.Fy", "wall -x.Fy", "wall +x.Fy", "wall -z.Fy", "wall +z.Fy"})
    borne += series.at(of).back();
  const double weight = static_cast<double>(places.size() - 1) * 2000 * 4.0 / 3 * M_PI * 2.16e-7 * 9.81;
  EXPECT_NEAR(borne, -weight, 0.01 * weight);
  EXPECT_GT(std::abs(series.at("stone.Fy").back()), 0.01);
}

// A stone that reaches near the depth asked for takes its own volume from the grains, no more: 224 lie in the bin
// without it, and 0.58 of its volume is 9 of them, 21 of the larger one. Tops of grains differ by a radius or so.
TEST(RunFixed, AStoneAsHighAsTheBedLeavesItsDepth) {
  const auto filled = [](double radius) {
    const RunDirectory dir;
    const std::string stone =
        fmt::format("{{position: 50 {0} 50 mm, radius: {0} mm, material: soil, fixed: stone}}", radius);
    const std::string text = fmt::format(R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {{soil: {{density: 2000 kg/m^3}}}}
contacts: [{{between: [soil, soil], law: linear, k_n: 5 kN/m, restitution: 0.5, mu: 0.5, mu_r: 0.1}}]
soil:
  container: {{size: 100 100 100 mm, at: 0 0 0 mm, material: soil}}
  bed: {{fill: random, radius: 6 mm, material: soil, depth: 40 mm, particles: [{}]}}
time: {{end: 1 ms, accuracy: 1}}
)",
                                         stone);
    const World w = build_world(load_scenario(dir.scenario(text)), {.threads = 1, .restored = {}, .progress = {}});
    EXPECT_NEAR(w.soil.surface_mean, 0.04, 0.006) << radius;
    return w.bed->spheres().size() - 1;
  };
  EXPECT_NEAR(static_cast<double>(filled(15)), 224 - 9, 15);
  EXPECT_NEAR(static_cast<double>(filled(20)), 224 - 21, 15);
}

TEST(RunFixed, StonesInABedAreFixedAndNotSaved) {
  const auto of = [](const std::string& from, const std::string& to) {
    const RunDirectory dir;
    std::string text = buried;
    return subsoil::test::message_of<ScenarioError>(
        [&] { run_scenario(dir.scenario(text.replace(text.find(from), from.size(), to)), dir / "out"); });
  };
  EXPECT_NE(of(", fixed: stone", "").find("moves: beside a bed that is made particles are fixed"), std::string::npos);
  EXPECT_NE(of("    depth", "    save: bed.h5\n    depth").find("would keep fixed particles as spheres that move"),
            std::string::npos);
}

TEST(RunFixed, ListedOnesAreNotSavedEither) {
  const RunDirectory dir;
  std::string text = nest;
  text.replace(text.find("    particles:"), 0, "    save: bed.h5\n");
  EXPECT_NE(subsoil::test::message_of<ScenarioError>([&] {
              run_scenario(dir.scenario(text), dir / "out");
            }).find("soil.bed.save: would keep fixed particles as spheres that move"),
            std::string::npos);
}

/// Of a lattice the grains in its place are left out.
TEST(RunFixed, AStoneInALattice) {
  const RunDirectory dir;
  std::string text = buried;
  text.replace(text.find("fill: random"), 12, "fill: lattice\n    pitch: 12 mm");
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
  const std::vector<dem::Vec3> places = frame_positions(dir / "out", 0);
  EXPECT_EQ(places[0], (dem::Vec3{0.06, 0.02, 0.06}));
  EXPECT_LT(places.size(), 501U) << "10 x 10 x 5 sites";
  for (std::size_t i = 1; i < places.size(); ++i) EXPECT_GT(dem::norm(places[i] - places[0]), 0.0209) << i;
}

/// A tool of the machine that is driven through a boundary, which neither feels.
TEST(RunFixed, AToolThatComesIntoABoundaryStops) {
  const std::string text = R"(subsoil: 1
materials: {soil: {density: 2000 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - {between: [soil, soil], law: linear, k_n: 20 kN/m, restitution: 0.4, mu: 0.3}
  - {between: [soil, steel], law: linear, k_n: 20 kN/m, restitution: 0.4, mu: 0.3}
soil:
  bed: {fill: particles, material: soil, particles: [{position: 1 -1 0 m, radius: 10 mm, fixed: far}]}
machine:
  bodies:
    frame: {mass: 10 kg, inertia: 0.3 kg m^2, at: 0 0 m, velocity: [0.5 m/s, 0 m/s]}
  joints:
    rail: {translational: [ground, frame], at: 0 0 m, along: 1 0}
  drivers:
    tow: {coordinate: frame.x, velocity: 0.5 m/s}
  surfaces:
    blade: {body: frame, material: steel, box: 20 180 40 mm}
boundaries: [{name: rock, material: steel, shape: {cylinder: {radius: 20 mm, length: 60 mm}}, at: 0.1 -0.08 0 m}]
time: {end: 0.25 s}
)";
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_failed);
  const nlohmann::json summary = summary_of(dir / "out");
  const std::string failure = summary["run"]["failure"];
  EXPECT_NE(failure.find("the machine's surface `blade` has come into the boundary `rock`"), std::string::npos)
      << failure;
  EXPECT_NE(failure.find("`fixed: NAME`"), std::string::npos);
  // The blade's front is at 10 mm and the rock's back at 80: they meet at 0.14 s, looked at every millisecond.
  const double t = std::stod(failure.substr(4));
  EXPECT_NEAR(t, 0.14, 2.1e-3);
  EXPECT_NE(summary["warnings"].dump().find("may come into the boundary `rock`"), std::string::npos);
  // Beside it, nothing is said.
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "beside", {"boundaries.rock.at=0.1 -0.2 0 m"}), exit_ok);
  EXPECT_EQ(summary_of(dir / "beside")["warnings"].dump().find("may come"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::run_fixed
