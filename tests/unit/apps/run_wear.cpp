#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "libdem/geometry/mesh_builders.hpp"
#include "libsim/io/series.hpp"
#include "libsim/io/state_file.hpp"
#include "libsim/run/surface_report.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/shown_area.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Loads and wear of surfaces, forces of contacts in frames and servos, as `subsoil run` leaves them.
namespace subsoil::sim::run_wear {
namespace {

using namespace test;

/// A sphere that slides without friction along a strip at 0.5 m/s under its weight.
constexpr const char* slider = R"(subsoil: 1
materials: {stone: {density: 2500 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - {between: [stone, stone], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0}
  - {between: [stone, steel], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0}
soil:
  bed:
    fill: particles
    material: stone
    particles: [{position: 100 9.999 3 mm, velocity: 0.5 0 0 m/s, radius: 10 mm}]
boundaries:
  - name: strip
    material: steel
    shape: {box: 0.6 0.02 0.1 m}
    at: 0.3 -0.01 0 m
    wear: {coefficient: 1e-4, hardness: 2 GPa, finnie: 1e-12 1/Pa}
time: {end: 0.4 s}
output: {every: 0.1 s, contact forces: yes}
)";

constexpr double weight = 2500 * 4.0 / 3 * 3.141592653589793 * 1e-6 * 9.81;

std::vector<double> numbers(const std::filesystem::path& out, const std::string& path) {
  return h5::read<double>(h5::open_file(out / "run.h5"), path);
}

/// Archard: volume K F s/H with F = m g and s = v t.
TEST(RunWear, ArchardsVolumeIsLoadTimesPath) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(slider), dir / "out"), exit_ok);
  const nlohmann::json wear = summary_of(dir / "out").at("wear").at("strip");
  const double path = 0.5 * 0.4, volume = 1e-4 / 2e9 * weight * path;
  // It begins within 3e-8 m of rest: the mean of what oscillates is the weight.
  EXPECT_NEAR(wear.at("Archard").at("worn volume [m3]").get<double>(), volume, 2e-3 * volume);
  EXPECT_NEAR(wear.at("mean normal force [N]").get<double>(), weight, 2e-3 * weight);
  EXPECT_NEAR(wear.at("area [m2]").get<double>(), 2 * (0.6 * 0.02 + 0.6 * 0.1 + 0.02 * 0.1), 1e-9);
  // By triangle in the last frame: depth times area adds up to the volume; only the top's two bear anything.
  const std::vector<double> depth = numbers(dir / "out", "/frames/000004/loads/strip/Archard wear depth");
  ASSERT_EQ(depth.size(), 12U);
  double sum = 0;
  int worn = 0;
  for (const double x : depth) sum += x * 0.03, worn += x > 0;
  EXPECT_LE(worn, 2);
  EXPECT_NEAR(sum, volume, 2e-3 * volume);
  const std::vector<double> pressure = numbers(dir / "out", "/frames/000003/loads/strip/mean pressure");
  double force = 0;
  for (const double p : pressure) force += p * 0.03;
  EXPECT_NEAR(force, weight, 2e-3 * weight) << "since the frame before";
}

// The weight of a sphere at rest, at intervals of 2.7 and of 0.4 steps. It begins at the depth m g/k_n.
TEST(RunWear, PressureIsOfTheStepsThatWereSummed) {
  for (const char* every : {"0.2 ms", "0.03 ms"}) {
    SCOPED_TRACE(every);
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(
                  dir.scenario(slider), dir / "out",
                  {"soil.bed.particles=[{position: 0.1 0.00999897271 0.003 m, radius: 10 mm}]", "time.soil step=75 us",
                   "time.end=3 ms", "output.precision=double", std::string("output.every=") + every}),
              exit_ok);
    for (int frame = 4; frame < 15; ++frame) {
      double force = 0;
      for (const double p : numbers(dir / "out", fmt::format("/frames/{:06}/loads/strip/mean pressure", frame)))
        force += p * 0.03;
      EXPECT_NEAR(force, weight, 1e-4 * weight) << frame;
    }
  }
}

TEST(RunWear, ContactForcesAreLinesOfFrames) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(slider), dir / "out"), exit_ok);
  const std::vector<double> ends = numbers(dir / "out", "/frames/000002/contact forces/ends"),
                            force = numbers(dir / "out", "/frames/000002/contact forces/force"),
                            normal = numbers(dir / "out", "/frames/000002/contact forces/normal force");
  ASSERT_EQ(ends.size(), 6U);
  EXPECT_NEAR(ends[0], 0.2, 1e-5);
  EXPECT_NEAR(ends[1], 0.01, 1e-5);
  EXPECT_NEAR(ends[3], 0.2, 1e-5);
  EXPECT_NEAR(ends[4], 0, 1e-5);
  EXPECT_NEAR(force.at(1), weight, 1e-3 * weight);
  EXPECT_NEAR(normal.at(0), weight, 1e-3 * weight);
  std::ifstream xdmf(dir / "out" / "run.xdmf");
  const std::string text((std::istreambuf_iterator<char>(xdmf)), {});
  EXPECT_NE(text.find("<Grid Name=\"contact forces\""), std::string::npos);
  EXPECT_NE(text.find("Name=\"Archard wear depth\" AttributeType=\"Scalar\" Center=\"Cell\""), std::string::npos);
}

/// A tool's loads through a state: the run that goes on ends with the numbers of the one that went straight.
TEST(RunWear, GoesOnFromAState) {
  const RunDirectory dir;
  const std::string text = dir.scenario(small_pass);
  const std::vector<std::string> sets{"machine.surfaces.blade.wear.coefficient=1e-4",
                                      "machine.surfaces.blade.wear.hardness=2 GPa", "output.contact forces=yes",
                                      "output.state every=60 ms"};
  ASSERT_EQ(run_scenario(text, dir / "straight", sets), exit_ok);
  const auto states = states_in(dir / "straight");
  ASSERT_GE(states.size(), 2U);
  ASSERT_EQ(run_scenario(text, dir / "on", sets, states.back()), exit_ok);
  const nlohmann::json a = summary_of(dir / "straight").at("wear").at("blade"),
                       b = summary_of(dir / "on").at("wear").at("blade");
  EXPECT_GT(a.at("shear work [J]").get<double>(), 0);
  // Not the same bits, for the machine is taken up anew: rounding.
  for (const char* key : {"normal work [J]", "shear work [J]", "normal force times sliding distance [N m]"})
    EXPECT_NEAR(a.at(key).get<double>(), b.at(key).get<double>(), 1e-9 * a.at(key).get<double>()) << key;
  const char* depth = "greatest depth of a triangle [m]";
  EXPECT_NEAR(a.at("Archard").at(depth).get<double>() / b.at("Archard").at(depth).get<double>(), 1, 1e-9);
  // The pressure of its second frame is that since its first: of the same steps as in the run that went straight.
  const std::vector<double> whole = frame_times(dir / "straight"), rest = frame_times(dir / "on");
  const auto at = std::find_if(whole.begin(), whole.end(), [&](double t) { return std::abs(t - rest.at(1)) < 1e-9; });
  ASSERT_NE(at, whole.end());
  ASSERT_NEAR(*(at - 1), rest[0], 1e-4) << "of one interval";
  const auto pressure = [&](const char* run, std::size_t frame) {
    double sum = 0;
    for (const double p : numbers(dir / run, fmt::format("/frames/{:06}/loads/blade/mean pressure", frame))) sum += p;
    return sum;
  };
  const double straight = pressure("straight", static_cast<std::size_t>(at - whole.begin()));
  ASSERT_GT(straight, 0);
  EXPECT_NEAR(pressure("on", 1) / straight, 1, 0.05) << "a step more or less of some twenty";
}

/// A run without wear and one with have the same bits.
TEST(RunWear, ChangesNothingOfTheRun) {
  const RunDirectory dir;
  const std::string text = dir.scenario(small_pass);
  ASSERT_EQ(run_scenario(text, dir / "with", {"machine.surfaces.blade.wear.finnie=1e-12 1/Pa"}), exit_ok);
  ASSERT_EQ(run_scenario(text, dir / "without"), exit_ok);
  const auto rows = [&](const char* name) {
    std::ifstream file(dir / name / "series.csv");
    return std::string((std::istreambuf_iterator<char>(file)), {});
  };
  EXPECT_EQ(rows("with"), rows("without"));
}

std::string refusal(const RunDirectory& dir, const std::string& text) {
  return subsoil::test::message_of([&] { run_scenario(dir.scenario(text), dir / "refused"); });
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(RunWear, RefusesHalfAnArchardAndAPlane) {
  const RunDirectory dir;
  const std::string half = refusal(dir, replaced(slider, "hardness: 2 GPa, ", ""));
  EXPECT_NE(half.find("case.yaml:16:"), std::string::npos) << half;
  EXPECT_NE(half.find("give both or neither"), std::string::npos) << half;
  const std::string plane = refusal(dir, replaced(slider, "{box: 0.6 0.02 0.1 m}", "{plane: {normal: 0 1 0}}"));
  EXPECT_NE(plane.find("needs triangles"), std::string::npos) << plane;
}

/// 75 spheres in a bin under a plate with 2 kPa on its 80 by 80 mm.
constexpr const char* press = R"(subsoil: 1
materials: {stone: {density: 2500 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [stone, stone], law: linear, k_n: 50 kN/m, restitution: 0.3, mu: 0.4}
  - {<<: *dry, between: [stone, steel]}
soil:
  container: {size: 100 100 100 mm, at: 0 0 0 m, material: steel}
  bed: {fill: rest-lattice, material: stone, radius: 10 mm, depth: 62 mm}
boundaries:
  - name: plate
    material: steel
    shape: {box: 80 10 80 mm}
    at: 50 75 50 mm
    servo: {pressure: 2 kPa, along: 0 -1 0, speed limit: 0.1 m/s, lag: 1 ms}
time: {end: 0.5 s, accuracy: 1}
output: {every: 0.25 s, state every: 0.25 s}
)";

TEST(RunServo, PlateSettlesAtItsLoad) {
  const RunDirectory dir;
  const std::string text = dir.scenario(press);
  ASSERT_EQ(run_scenario(text, dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const double load = 2000 * 0.08 * 0.08;
  const std::size_t last = series.rows() - 1;
  EXPECT_NEAR(series.at("plate.load")[last], load, 1e-6 * load);
  EXPECT_NEAR(series.at("plate.resistance")[last], load, 5e-3 * load) << "settled";
  EXPECT_NEAR(series.at("plate.Fy")[last], load, 5e-3 * load);
  // Until it touches it goes at its limit, but for the lag.
  EXPECT_NEAR(series.at("plate.y")[10], 0.075 - 0.1 * (0.010 - 0.001), 1e-5);
  const nlohmann::json summary = summary_of(dir / "out");
  const nlohmann::json& servo = summary.at("servos").at("plate");
  EXPECT_NEAR(servo.at("gain [m/(N s)]").get<double>(), 0.1 / load, 1e-9);
  EXPECT_GT(servo.at("work on the soil [J]").get<double>(), 0);
  EXPECT_LT(std::abs(summary.at("energy").at("closure over energy there or put in").get<double>()), 0.02);
  ASSERT_EQ(run_scenario(text, dir / "on", {}, states_in(dir / "out").back()), exit_ok);
  const Series on = read_series(dir / "on" / "series.csv");
  EXPECT_EQ(on.at("plate.y")[on.rows() - 1], series.at("plate.y")[last]);
  EXPECT_EQ(on.at("plate.resistance")[on.rows() - 1], series.at("plate.resistance")[last]);
}

/// The gain that is left out is the speed limit over the maximum load of the run that begins, 5 N until 0.25 s; a run
/// that continues it until the load is 12.5 N keeps it.
TEST(RunServo, AContinuedRunKeepsTheDefaultGain) {
  const RunDirectory dir;
  const std::string rising =
      replaced(press, "pressure: 2 kPa", "load: {ramp: {from: 5 N, to: 20 N, begin: 0.25 s, end: 0.75 s}}");
  const auto gain = [&](const std::string& run) {
    return summary_of(dir / run).at("servos").at("plate").at("gain [m/(N s)]").get<double>();
  };
  const std::string text = dir.scenario(rising);
  ASSERT_EQ(run_scenario(text, dir / "first", {"time.end=0.25 s"}), exit_ok);
  const auto state = states_in(dir / "first").back();
  ASSERT_EQ(run_scenario(text, dir / "second", {}, state), exit_ok);
  EXPECT_NEAR(gain("first"), 0.1 / 5, 1e-12);
  EXPECT_EQ(gain("second"), gain("first"));
}

dem::Boundary shaped(dem::Shape shape, const dem::Pose& pose = {}) {
  dem::Boundary out;
  out.shape = std::move(shape), out.pose = pose;
  return out;
}

double area(const dem::Boundary& b, const dem::Vec3& along, const dem::PeriodicCell& cell = {}) {
  return shown_area(b, along, cell);
}

/// A plate that spans a period reaches beyond both sides: of 0.2 by 0.2 m what lies between sides 0.1 m apart counts.
TEST(RunServo, PressureActsOnTheAreaBetweenPeriodicSides) {
  const dem::Boundary lid = shaped(dem::MeshSurface({dem::box_mesh({0.2, 0.02, 0.2})}), {{0.05, 0.1, 0.05}, {}});
  const dem::Vec3 down{0, -1, 0};
  EXPECT_NEAR(area(lid, down), 0.04, 1e-15);
  EXPECT_NEAR(area(lid, down, {{0, 0, 0}, {0.1, 0, 0.1}}), 0.01, 1e-15);
  EXPECT_NEAR(area(lid, down, {{0, 0, 0}, {0.1, 0, 0}}), 0.02, 1e-15);
  EXPECT_NEAR(area(lid, down, {{0.05, 0, 0}, {0.5, 0, 0}}), 0.02, 1e-15) << "its half";
  EXPECT_EQ(area(lid, down, {{1, 0, 0}, {0.1, 0, 0}}), 0);
  // An endless beam has no ends: aslant it shows its top and its side.
  const dem::Boundary beam = shaped(dem::MeshSurface({dem::box_mesh({0.06, 0.01, 0.4})}));
  const dem::Vec3 aslant = dem::normalized({1, -1, 1});
  EXPECT_NEAR(area(beam, aslant, {{0, 0, -0.1}, {0, 0, 0.2}}), (0.06 + 0.01) * 0.2 / std::sqrt(3.0), 1e-14);
  EXPECT_NEAR(area(beam, aslant), ((0.06 + 0.01) * 0.4 + 0.06 * 0.01) / std::sqrt(3.0), 1e-14);
  const RunDirectory dir;
  const std::string periodic = replaced(press, "material: steel}", "material: steel, periodic: [x, z]}");
  ASSERT_EQ(run_scenario(dir.scenario(replaced(periodic, "{box: 80 10 80 mm}", "{box: 300 10 200 mm}")), dir / "out",
                         {"time.end=1 ms"}),
            exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_NEAR(series.at("plate.load").back(), 2000 * 0.1 * 0.1, 1e-9);
}

/// Cylinders are round: end on pi R^2, across 2 R L, aslant their sum by cosine and sine; a bore is seen through where
/// its ends still overlap, by two segments of a circle.
TEST(RunServo, PressureActsOnTheRoundArea) {
  constexpr double R = 0.05, L = 0.02, r = 0.03;
  const dem::Boundary solid = shaped(dem::Cylinder({}, {0, 0, 1}, R, L)),
                      tube = shaped(dem::Cylinder({}, {0, 0, 1}, R, L, r));
  EXPECT_NEAR(area(solid, {0, 0, 1}), M_PI * R * R, 1e-15);
  EXPECT_NEAR(area(solid, {1, 0, 0}), 2 * R * L, 1e-15);
  EXPECT_NEAR(area(solid, {0.6, 0, 0.8}), 0.8 * M_PI * R * R + 0.6 * 2 * R * L, 1e-15);
  EXPECT_NEAR(area(tube, {0, 0, 1}), M_PI * (R * R - r * r), 1e-15);
  EXPECT_NEAR(area(tube, {1, 0, 0}), 2 * R * L, 1e-15);
  // At tan = 3/4 the ends of the bore are 15 mm apart: each segment has the half angle acos(1/4).
  const double half = std::acos(0.25), through = 0.8 * 2 * r * r * (half - 0.25 * std::sin(half));
  EXPECT_NEAR(area(tube, {0.6, 0, 0.8}), 0.8 * M_PI * R * R + 0.6 * 2 * R * L - through, 1e-15);
  // Half of it beyond a periodic side.
  EXPECT_NEAR(area(solid, {0, 0, 1}, {{0, 0, 0}, {1, 0, 0}}), 0.5 * M_PI * R * R, 1e-15);
}

/// What stands behind something else bears no more: of an I-beam and of two sheets the shadow counts once, of two
/// triangles that cross to a star, each of height 3 m, 4/3 of one.
TEST(RunServo, PressureActsOnTheShadow) {
  const dem::Vec3 down{0, -1, 0};
  const std::vector<dem::Point2> section{{-0.09, 0},   {0.09, 0},    {0.09, 0.02},  {0.01, 0.02},
                                         {0.01, 0.1},  {0.09, 0.1},  {0.09, 0.12},  {-0.09, 0.12},
                                         {-0.09, 0.1}, {-0.01, 0.1}, {-0.01, 0.02}, {-0.09, 0.02}};
  const dem::Boundary beam = shaped(dem::MeshSurface({dem::extruded_mesh(section, 0.18)}));
  EXPECT_NEAR(area(beam, down), 0.18 * 0.18, 1e-14);
  EXPECT_NEAR(area(beam, {1, 0, 0}), 0.12 * 0.18, 1e-14);
  EXPECT_NEAR(area(beam, {0, 0, 1}), 2 * 0.18 * 0.02 + 0.02 * 0.08, 1e-14);
  const auto sheet = [](double y) { return dem::rectangle_mesh({0, y, 0}, {0, 0, 0.2}, {0.1, 0, 0}); };
  const std::vector<dem::TriangleMesh> sheets{sheet(0), sheet(0.05)};
  EXPECT_NEAR(area(shaped(dem::MeshSurface(sheets)), down), 0.02, 1e-15);
  const double half = std::sqrt(3.0), one = 3 * half;
  const dem::TriangleMesh star({{-half, 0, -1}, {half, 0, -1}, {0, 0, 2}, {-half, 1, 1}, {half, 1, 1}, {0, 1, -2}},
                               {{0, 1, 2}, {3, 4, 5}});
  EXPECT_NEAR(area(shaped(dem::MeshSurface({star})), down), 4 * one / 3, 1e-6);
}

/// What `check` says of its path: the farthest that the speed limit allows.
TEST(RunServo, CheckFollowsItAtItsSpeedLimit) {
  const auto facts = [](const std::string& text) {
    const Loaded loaded = load_scenario_text(text, "case.yaml");
    const World world = build_world(loaded, {.threads = 1, .settle = false});
    const std::vector<SurfaceFacts> all = surface_facts(world, loaded.scenario, 0.5);
    std::string out = surface_text(all.at(0), world) + "\n";
    for (const std::string& w : surface_warnings(all, world)) out += w + "\n";
    return out;
  };
  const std::string fast = facts(press), slow = facts(replaced(press, "speed limit: 0.1 m/s", "speed limit: 1 mm/s"));
  EXPECT_NE(fast.find("in reach of the soil, where its servo goes at its speed limit\n"), std::string::npos) << fast;
  EXPECT_EQ(fast.find("comes no nearer"), std::string::npos) << fast;
  EXPECT_NE(slow.find("plate comes no nearer than 0.0"), std::string::npos) << slow;
  EXPECT_NE(slow.find("even where its servo goes at its speed limit throughout"), std::string::npos) << slow;
}

TEST(RunServo, RefusesNoLoadTwoLoadsAndAPlanesPressure) {
  const RunDirectory dir;
  EXPECT_NE(refusal(dir, replaced(press, "pressure: 2 kPa, ", "")).find("needs a `load` (N) or a `pressure` (Pa)"),
            std::string::npos);
  EXPECT_NE(refusal(dir, replaced(press, "pressure: 2 kPa", "pressure: 2 kPa, load: 1 N")).find("give one of them"),
            std::string::npos);
  EXPECT_NE(refusal(dir, replaced(press, "{box: 80 10 80 mm}", "{plane: {normal: 0 -1 0}}")).find("a plane has no end"),
            std::string::npos);
  EXPECT_NE(refusal(dir, replaced(press, "pressure: 2 kPa", "load: 0 N")).find("give `gain`"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::sim::run_wear
