#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "libsim/post/disturbance.hpp"
#include "libsim/run/surface_report.hpp"
#include "libsim/run/wall_watch.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/unit/apps/trench.hpp"

/// When the means are taken, and what a run says of itself.
namespace subsoil::sim::run_window {
namespace {

using namespace test;

/// First millisecond at which the farthest travel so far has reached length + depth = 50 mm.
template <class Path>
double opens(Path path) {
  double farthest = 0;
  for (int k = 0;; ++k) {
    farthest = std::max(farthest, path(k * 1e-3));
    if (farthest >= 0.05) return k * 1e-3;
  }
}

double soil_end(const std::filesystem::path& out) {
  double end = 0;
  for (const dem::Vec3& p : test::frame_positions(out, 0)) end = std::max(end, p.x + 0.01);
  return end;
}

TEST(RunWindow, OfABoundaryThatStartsInSoilOpensByItsTravelAndClosesBeforeTheSoilEnds) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(trench), dir / "out"), exit_ok);
  const nlohmann::json window = summary_of(dir / "out")["window"];
  // Tools are looked at every ms, a step late at most.
  EXPECT_NEAR(window["from [s]"].get<double>(), opens([](double t) { return 0.4 * t; }), 1.5e-3);
  const double closes = (soil_end(dir / "out") - 0.03 - 0.07) / 0.4;  // its front starts at 70 mm and is one depth off
  EXPECT_NEAR(window["until [s]"].get<double>(), closes, 1.5e-3);
  const nlohmann::json tool = summary_of(dir / "out")["tools"]["tool"];
  EXPECT_NEAR(tool["greatest depth [m]"].get<double>(), 0.03, 1e-9);
  EXPECT_EQ(tool["touched soil"], true);
  EXPECT_GT(tool["draft [N]"]["interval, 95 %"].get<double>(), 0);
  EXPECT_DOUBLE_EQ(tool["draft [N]"]["mean"].get<double>(),
                   summary_of(dir / "out")["columns"]["draft"]["mean in window"].get<double>());
}

/// The trench with a second boundary that travels with the tool.
std::string trench_beside(const std::string& boundary) {
  std::string text = trench;
  const std::string behind = "time: {end: 0.8 s}";
  return text.insert(text.find(behind), "  - " + boundary + "\n");
}

/// A guard that travels above the soil is in no soil: grains that touch it change nothing.
TEST(RunWindow, IsThatOfTheToolsThatAreInTheSoil) {
  const RunDirectory dir;
  const std::string guard =
      "{name: guard, material: steel, shape: {box: 20 60 60 mm}, at: 100 36 0 mm, moves: [{velocity: 0.4 0 0 m/s}]}";
  ASSERT_EQ(run_scenario(dir.scenario(trench_beside(guard)), dir / "out"), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out");
  EXPECT_NEAR(summary["window"]["from [s]"].get<double>(), opens([](double t) { return 0.4 * t; }), 1.5e-3);
  EXPECT_TRUE(summary["tools"]["tool"]["draft [N]"]["mean"].is_number());
  EXPECT_EQ(summary["tools"]["guard"]["greatest depth [m]"], 0);
}

/// A second tool is let down to 5 mm below the surface and reaches it at 0.3 s; it is 20 mm long.
TEST(RunWindow, OpensAgainWhenAnotherToolEnters) {
  const RunDirectory dir;
  const std::string second =
      "{name: second, material: steel, shape: {box: 20 80 20 mm}, at: 20 55 0 mm, moves: [{velocity: 0.4 0 0 m/s}, "
      "{velocity: 0 -0.1 0 m/s, from: 0.15 s, until: 0.35 s}]}";
  ASSERT_EQ(run_scenario(dir.scenario(trench_beside(second)), dir / "out"), exit_ok);
  const double from = summary_of(dir / "out")["window"]["from [s]"].get<double>();
  // Its mean surface is some millimetres off; from the entry on it travels 20 mm and its depth.
  EXPECT_GT(from, 0.3 + 0.02 / 0.4 - 0.03);
  EXPECT_LT(from, 0.3 + 0.03 / 0.4 + 0.03);
}

// The motion is the same, and so are the steps that means are of.
TEST(RunWindow, AndItsMeansDoNotDependOnRows) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(trench), dir / "fine"), exit_ok);
  ASSERT_EQ(run_scenario(dir.scenario(trench), dir / "coarse", {"output.series every=90 ms"}), exit_ok);
  const nlohmann::json fine = summary_of(dir / "fine"), coarse = summary_of(dir / "coarse");
  EXPECT_EQ(coarse["window"], fine["window"]);
  EXPECT_EQ(coarse["tools"]["tool"]["draft [N]"], fine["tools"]["tool"]["draft [N]"]);
}

TEST(RunWindow, OfAVibratingToolCountsItsWayOnceAndHoldsWholePeriods) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(trench), dir / "out",
                         {"boundaries.tool.moves=[{velocity: 0.3 0 0 m/s}, {velocity: 0.5 0 0 m/s, profile: {harmonic: "
                          "{amplitude: 1, frequency: 10 Hz}}}]"}),
            exit_ok);
  const nlohmann::json window = summary_of(dir / "out")["window"];
  const double w = 2 * 3.141592653589793 * 10;
  const double from = opens([&](double t) { return 0.3 * t + 0.5 / w * (1 - std::cos(w * t)); });
  EXPECT_NEAR(window["from [s]"].get<double>(), from, 1.5e-3);
  const double periods = window["covered [s]"].get<double>() / 0.1;
  EXPECT_GE(std::lround(periods), 4);
  EXPECT_NEAR(periods, std::round(periods), 2e-3) << "a step of 0.1 ms";
}

/// Where the means are of more than the work along the tool's way, the run says so; at even speed to the end it does
/// not.
TEST(RunWindow, SaysAToolThatStandsOrComesBackInIt) {
  const auto warnings = [](const char* moves, const std::vector<std::string>& more = {}) {
    const RunDirectory dir;
    std::vector<std::string> sets{fmt::format("boundaries.tool.moves={}", moves)};
    sets.insert(sets.end(), more.begin(), more.end());
    EXPECT_EQ(run_scenario(dir.scenario(trench), dir / "out", sets), exit_ok);
    return summary_of(dir / "out")["warnings"].dump();
  };
  const auto says = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  const std::string even = warnings("[{velocity: 0.4 0 0 m/s}]");
  EXPECT_FALSE(says(even, "comes back by")) << even;
  EXPECT_FALSE(says(even, "stood still")) << even;
  const std::string stands = warnings("[{velocity: 0.4 0 0 m/s, until: 0.3 s}]");
  EXPECT_TRUE(says(stands, "tool has stood still for the last 7")) << stands;
  const std::string back =
      warnings("[{velocity: 0.4 0 0 m/s, until: 0.3 s}, {velocity: -0.4 0 0 m/s, from: 0.3 s, until: 0.5 s}]");
  EXPECT_TRUE(says(back, "tool comes back by 0.08 m in the window")) << back;
  const std::string nowhere = warnings("[{velocity: 0.4 0 0 m/s}, {velocity: 0.4 0 0 m/s, from: 2 s}]",
                                       {"output.region={at: 5 5 5 m, size: 1 1 1 m}"});
  EXPECT_TRUE(says(nowhere, "a motion begins at 2 s, when the run has ended at 0.8 s")) << nowhere;
  EXPECT_TRUE(says(nowhere, "output.region: none of the spheres is in it")) << nowhere;
}

/// A list of functions is their sum, a shaft that has come to its speed turns steadily however that is written, and a
/// force that repeats itself drives a motion as a driver does. Formulas say nothing.
TEST(RunWindow, HoldsWholePeriodsOfWhateverIsGiven) {
  struct Case {
    const char *driver, *force, *window;
    double period;  // s; 0: none
  };
  const Case cases[] = {
      {"[{constant: {value: 1 rad/s}}, {harmonic: {amplitude: 1 rad/s, frequency: 2 Hz}}]", "0 N", "", 0},
      {"[{constant: {value: 0 rad/s}}, {harmonic: {amplitude: 1 rad/s, frequency: 2 Hz}}]", "0 N", "", 0.5},
      {"{ramp: {from: 0 rpm, to: 120 rpm, end: 0.1 s}}", "0 N", "window: {from: 0.15 s},", 0.5},
      {"{ramp: {from: 0 rpm, to: 120 rpm, end: 0.1 s}}", "0 N", "window: {from: 0.05 s},", 0},
      {"{polynomial: {c0: 120 rpm}}", "0 N", "", 0.5},
      {"{table: {points: [[0 s, 120 rpm], [1 s, 120 rpm]]}}", "0 N", "", 0.5},
      {"{harmonic: {mean: 120 rpm, amplitude: 1 rad/s, frequency: 4 Hz}}", "0 N", "", 0.5},
      {"{expression: 4*pi, unit: rad/s}", "0 N", "", 0},
      {"0 rad/s", "{harmonic: {amplitude: 3 N, frequency: 2 Hz}}", "", 0.5},
      {"0 rad/s", "{table: {points: [[0 s, 0 N], [0.2 s, 3 N], [0.5 s, 0 N]], periodic: yes}}", "", 0.5}};
  for (const Case& c : cases) {
    const RunDirectory dir;
    const std::string text = fmt::format(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {{m: {{mass: 2 kg, inertia: 1 kg m^2, at: 0 0 m}}, k: {{mass: 2 kg, inertia: 1 kg m^2, at: 0 1 m, velocity is: about}}}}
  joints: {{g: {{translational: [ground, m], at: 0 0 m, along: 1 0}}, h: {{revolute: [ground, k], at: 0 1 m}}}}
  forces: {{f: {{force: m, along x: {}}}}}
  drivers: {{d: {{angle: [ground, k], velocity: {}}}}}
time: {{end: 1.3 s}}
output: {{{} monitor: {{x: m.x}}}}
)",
                                         c.force, c.driver, c.window);
    ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok) << text;
    const nlohmann::json window = summary_of(dir / "out")["window"];
    EXPECT_NEAR(window.value("whole periods of [s]", 0.0), c.period, 1e-12) << text;
    if (c.period == 0) continue;
    const double periods = window["covered [s]"].get<double>() / c.period;
    EXPECT_NEAR(periods, std::round(periods), 5e-3) << text;
    EXPECT_EQ(std::lround(periods), 2) << text;
  }
}

/// 1.5 Hz and 1 Hz repeat after 2 s; 1 Hz and the golden ratio of it never.
TEST(RunWindow, HoldsWholeCommonPeriodsOfSeveralDrivers) {
  const RunDirectory dir;
  const auto window = [&](const std::string& frequency) {
    const std::string file = dir.scenario(R"(subsoil: 1
gravity: 0 m/s^2
machine:
  bodies: {m: {mass: 2 kg, inertia: 1 kg m^2, at: 0 0 m, velocity is: about}, k: {mass: 2 kg, inertia: 1 kg m^2, at: 0 1 m, velocity is: about}}
  joints: {g: {translational: [ground, m], at: 0 0 m, along: 1 0}, h: {translational: [ground, k], at: 0 1 m, along: 1 0}}
  drivers:
    d: {coordinate: m.x, position: {harmonic: {amplitude: 0.1 m, frequency: )" +
                                          frequency + R"( Hz}}}
    e: {coordinate: k.x, position: {harmonic: {amplitude: 0.1 m, frequency: 1 Hz}}}
time: {end: 5.3 s}
output: {series every: 10 ms, monitor: {x: m.x, y: k.x}}
)");
    EXPECT_EQ(run_scenario(file, dir / frequency), exit_ok);
    return summary_of(dir / frequency);
  };
  const nlohmann::json common = window("1.5");
  EXPECT_NEAR(common["window"]["until [s]"].get<double>() - common["window"]["from [s]"].get<double>(), 4, 1e-9);
  for (const char* column : {"x", "y"})
    EXPECT_NEAR(common["columns"][column]["mean in window"].get<double>(), 0, 1e-9) << column;
  EXPECT_NEAR(window("1.6180339887")["window"]["until [s]"].get<double>(), 5.3, 1e-9);
}

/// A plate wider than its bed that bears it on a spring passes through nothing: its means are of the whole run, and its
/// force is the weight of what lies on it.
TEST(RunWindow, OfAPlateThatBearsSoilIsTheWholeRun) {
  const RunDirectory dir;
  const char* const bearing = R"(subsoil: 1
materials: {ball: {density: 2600 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - {between: [ball, ball], law: linear, k_n: 20 kN/m, restitution: 0.3, mu: 0.4}
  - {between: [ball, steel], law: linear, k_n: 20 kN/m, restitution: 0.3, mu: 0}
soil:
  container: {size: 80 200 80 mm, at: -40 -100 -40 mm, material: steel}
  bed: {fill: lattice, material: ball, radius: 10 mm, pitch: 20 mm, region: {size: 60 40 60 mm, at: -30 0 -30 mm}}
machine:
  bodies: {plate: {mass: 5 kg, inertia: 0.05 kg m^2, at: 0 -10 mm}}
  joints: {guide: {translational: [ground, plate], at: 0 0 m, along: 0 1}}
  forces: {leg: {spring-damper: [ground, plate], ends: [0 -80 mm, 0 -10 mm], stiffness: 200 kN/m, damping: 500 N s/m}}
  surfaces: {top: {body: plate, material: steel, box: 78 20 78 mm}}
time: {end: 0.4 s}
output: {every: 0.2 s}
)";
  ASSERT_EQ(run_scenario(dir.scenario(bearing), dir / "out"), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out"), &window = summary["window"];
  EXPECT_EQ(window["from [s]"], 0);
  EXPECT_NEAR(window["until [s]"].get<double>(), 0.4, 1e-3);
  EXPECT_EQ(window["rule"], "no tool passed through soil: the whole run");
  const nlohmann::json& plate = summary["tools"]["plate"];
  const double weight = 18 * 2600 * 4.0 / 3 * M_PI * 1e-6 * 9.81;
  EXPECT_NEAR(plate["lift [N]"]["mean"].get<double>(), -weight, 0.05 * weight) << "it bounces at first";
  EXPECT_GT(plate["greatest depth [m]"].get<double>(), 0.039) << "below the surface of two layers";
  EXPECT_EQ(summary["warnings"].dump().find("no tool came"), std::string::npos);
}

TEST(RunWindow, AToolAboveTheSoilIsSaidAndStrictFails) {
  const RunDirectory dir;
  const std::vector<std::string> high{"boundaries.tool.at=60 100 0 mm", "time.end=20 ms"};
  ASSERT_EQ(run_scenario(dir.scenario(trench), dir / "out", high), exit_ok);
  const std::string warnings = summary_of(dir / "out")["warnings"].dump();
  EXPECT_NE(warnings.find("tool touched no soil in the whole run"), std::string::npos) << warnings;
  EXPECT_NE(warnings.find("tool comes no nearer than"), std::string::npos) << warnings;
  EXPECT_EQ(run({.scenario = dir.scenario(trench), .out = dir / "strict", .sets = high, .threads = 1, .strict = true}),
            exit_failed);
  EXPECT_EQ(summary_of(dir / "strict")["run"]["end"], "reached");
}

TEST(RunWindow, WarningsArePrintedOnceWhenTheyArise) {
  const RunDirectory dir;
  const std::string command = subsoil::test::program() + " run " + dir.scenario(trench) + " --threads 1 --out " +
                              (dir / "out").string() +
                              " --set \"boundaries.tool.at=60 100 0 mm\" --set time.end=5ms 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string said;
  for (int c; (c = fgetc(pipe)) != EOF;) said += static_cast<char>(c);
  EXPECT_EQ(pclose(pipe), 0);
  const std::string nearer = "warning: tool comes no nearer";
  const std::size_t first = said.find(nearer), end = said.find("warning: tool touched no soil");
  ASSERT_NE(first, std::string::npos) << said;
  EXPECT_EQ(said.find(nearer, first + 1), std::string::npos) << "a second time\n" << said;
  EXPECT_NE(end, std::string::npos) << said;
  EXPECT_NE(said.find(" warnings in all: see summary.json"), std::string::npos) << said;
}

TEST(RunWindow, WallsAreReachedByWhatMovesAtThemAndNotByWhatMovesElsewhere) {
  const World world = build_world(load_scenario_text(trench), {.threads = 1, .settle = false});
  WallWatch watch;
  watch.begin(world);
  EXPECT_TRUE(watch.look(world).empty()) << "nothing has moved";
  dem::Bed::State state = world.bed->save();
  // Spheres of the first column, at wall -x, go up by 0.6 of a radius; they are below 5 % at the other walls.
  for (dem::Sphere& s : state.spheres)
    if (s.x.x < 0.02) s.x.y += 0.006;
  world.bed->restore(state);
  EXPECT_EQ(watch.look(world), std::vector<std::string>{"wall -x"});
  EXPECT_TRUE(watch.look(world).empty()) << "each wall once";
}

std::string warnings_of(const std::string& text) {
  const Loaded loaded = load_scenario_text(text, subsoil::test::source_dir() + "/configs/templates/x.yaml");
  const World world = build_world(loaded, {.threads = 1, .settle = false});
  std::string out;
  for (const std::string& w : surface_warnings(surface_facts(world, loaded.scenario, 1), world)) out += w + "\n";
  return out;
}

std::string with_mesh(const std::string& file, const std::string& unit) {
  std::string text = trench;
  const std::string box = "box: 20 80 20 mm}, at: 60 10 0 mm";
  return text.replace(text.find(box), box.size(), "mesh: " + file + ", unit: " + unit + "}, at: 0.1 -0.02 0 m");
}

/// A box says its unit, and a wide one is none to ask about: 40 m against a soil of less than 1 m.
TEST(RunWindow, ABoxIsAsLargeAsItSays) {
  std::string text = trench;
  const std::string box = "box: 20 80 20 mm";
  text.replace(text.find(box), box.size(), "box: 20 80 40000 mm");
  EXPECT_EQ(warnings_of(text).find("is the unit"), std::string::npos) << warnings_of(text);
}

TEST(RunWindow, AMeshInTheWrongUnitOrOpenIsSaid) {
  EXPECT_EQ(warnings_of(with_mesh("chisel.stl", "mm")), "");
  EXPECT_NE(warnings_of(with_mesh("chisel.stl", "um")).find("is the unit of its numbers right?"), std::string::npos);
  EXPECT_NE(warnings_of(with_mesh("chisel.stl", "m")).find("is the unit of its numbers right?"), std::string::npos);
  const RunDirectory dir;
  std::string stl = test::text_of(subsoil::test::source_dir() + "/configs/templates/chisel.stl");
  const std::size_t from = stl.find(" facet"), to = stl.find("endfacet\n") + 9;
  test::write_file(dir / "open.stl", stl.erase(from, to - from));
  EXPECT_NE(warnings_of(with_mesh((dir / "open.stl").string(), "mm")).find("its mesh is open"), std::string::npos);
}

std::string refusal(const std::vector<std::string>& sets, const RunDirectory& dir) {
  try {
    run_scenario(dir.scenario(trench), dir / "out", sets);
  } catch (const ScenarioError& error) {
    EXPECT_FALSE(std::filesystem::exists(dir / "out")) << "a refused run writes nothing";
    return error.what();
  }
  return "taken";
}

TEST(RunWindow, SpheresInsideAGivenSolidAndBedsBeyondTheBinAreRefused) {
  const RunDirectory dir;
  EXPECT_NE(refusal({"soil.bed.inside machine=refuse"}, dir).find("lie inside or overlap `tool` at the start"),
            std::string::npos);
  EXPECT_NE(refusal({"soil.bed.depth=0.3 m"}, dir).find("is more than the 0.1 m that the container"),
            std::string::npos);
  try {
    run_scenario(dir.scenario(trench), "/proc/no/results");
    FAIL() << "taken";
  } catch (const ScenarioError& error) {
    EXPECT_NE(std::string(error.what()).find("cannot be made"), std::string::npos) << error.what();
  }
}

// 300 spheres of 8 mm are poured to 0.11 m above the floor and lie 0.07 m deep: a box from 0.075 m on is in the way of
// the former only. `check` looks at those and may not refuse what the run accepts.
TEST(RunWindow, SpheresThatHangWhereABoxStandsAreNoFaultBeforeTheyHaveSettled) {
  const std::string text = R"(subsoil: 1
materials: {a: {density: 2500 kg/m^3}}
contacts: [{between: [a, a], law: linear, k_n: 10 kN/m, restitution: 0.5, mu: 0.4}]
soil:
  container: {size: 150 200 120 mm, at: -75 0 -60 mm, material: a}
  bed: {fill: random, material: a, radius: 8 mm, count: 300}
boundaries: [{name: tool, material: a, shape: {box: 60 20 40 mm}, at: 0 85 0 mm}]
time: {end: 5 ms}
)";
  const Loaded loaded = load_scenario_text(text, "x.yaml");
  const World poured = build_world(loaded, {.threads = 1, .settle = false});
  EXPECT_GT(poured.soil.unsettled_inside, 0U);
  EXPECT_EQ(poured.bed->spheres().size() + poured.soil.unsettled_inside, 300U);
  const World settled = build_world(loaded, {.threads = 1});
  EXPECT_EQ(settled.soil.unsettled_inside, 0U);
  EXPECT_EQ(settled.bed->spheres().size(), 300U);
}

/// Lifted at 0.5 m/s from 0.2 s on, put back from 0.45 s on: what it goes in the air is no travel in soil, and the
/// means of both have no specific draft.
TEST(RunWindow, TravelInSoilLeavesOutTheAir) {
  const RunDirectory dir;
  const std::string moves =
      "boundaries.tool.moves=[{velocity: 0.4 0 0 m/s}, {velocity: 0 0.5 0 m/s, from: 0.2 s, until: 0.4 s}, {velocity: "
      "0 -0.5 0 m/s, from: 0.45 s, until: 0.65 s}]";
  const std::string text = dir.scenario(trench);
  ASSERT_EQ(run_scenario(text, dir / "out", {moves, "time.end=0.7 s", "output.every=20 ms"}), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out"), tool = summary["tools"]["tool"];
  const double surface = summary["soil"]["mean surface [m]"];
  // Its lower edge starts at -30 mm and comes to 70 mm.
  const double in_air = 0.45 + (0.07 - surface) / 0.5 - (0.2 + (0.03 + surface) / 0.5);
  ASSERT_GT(in_air, 0.3);
  // Up to a diameter above the surface it may still touch grains.
  const double travel = tool["travelled in soil [m]"];
  EXPECT_GT(travel, 0.4 * (0.7 - in_air) - 1.5e-3);
  EXPECT_LT(travel, 0.4 * (0.7 - in_air + 2 * 0.02 / 0.5) + 1.5e-3);
  const double window = summary["window"]["until [s]"].get<double>() - summary["window"]["from [s]"].get<double>();
  const double share = tool["share of the window out of the soil"];
  EXPECT_LT(share, in_air / window + 0.01);
  EXPECT_GT(share, (in_air - 2 * 0.02 / 0.5) / window - 0.01);
  EXPECT_NE(summary["warnings"].dump().find("tool was out of the soil in "), std::string::npos) << summary["warnings"];
  EXPECT_TRUE(summary["disturbance"]["specific draft [N/m2]"].is_null()) << summary["disturbance"];
  // Frames know the places alone, in numbers of 7 digits.
  const auto path = disturbance_of(dir / "out").tool;
  ASSERT_TRUE(path);
  EXPECT_NEAR(path->travel, 0.4 * (0.7 - in_air), 1e-5);
  EXPECT_NEAR(path->speed, 0.4, 1e-5);
  EXPECT_NEAR(path->share_out(0.3, 0.5), 1, 1e-12);
  EXPECT_NEAR(path->share_out(0.1, 0.2), 0, 1e-12);
}

/// By 3 mm, less than a grain's radius, and back: the draft is against the direction in which it began, as that of the
/// whole soil is.
TEST(RunWindow, DraftOfAStrokeBelowARadius) {
  constexpr const char* stroke = R"(subsoil: 1
materials: {soil: {density: 2600 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 30 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.1}
  - {<<: *dry, between: [soil, steel]}
soil:
  container: {size: 0.2 0.2 0.1 m, at: 0 -0.08 -0.05 m, material: steel}
  surface: 0 m
  bed: {fill: random, material: soil, radius: 8 mm, depth: 60 mm, inside machine: carve}
machine:
  bodies: {b: {mass: 3 kg, inertia: 1 kg m^2, at: 100 40 mm}}
  joints: {g: {translational: [ground, b], at: 100 40 mm, along: 1 0}}
  drivers:
    d: {coordinate: b.x, position: {table: {points: [[0 s, 100 mm], [0.1 s, 100 mm + A], [0.2 s, 100 mm]], between: monotone}}}
  surfaces: {t: {body: b, material: steel, box: 20 150 80 mm}}
parameters: {A: 3 mm}
time: {end: 0.2 s}
output: {monitor: {mean: {mean: soil.draft}}}
)";
  for (const char* const set : {"parameters.A=3 mm", "parameters.A=-3 mm"}) {
    const RunDirectory dir;
    ASSERT_EQ(run_scenario(dir.scenario(stroke), dir / "out", {set}), exit_ok);
    const double draft = summary_of(dir / "out")["tools"]["b"]["draft [N]"]["mean"];
    EXPECT_GT(std::abs(draft), 0.1) << set;
    EXPECT_NEAR(draft, read_series(dir / "out/series.csv").at("mean").back(), 1e-3 * std::abs(draft)) << set;
  }
}

/// Back by 12 mm, more than a grain's radius, then 150 mm the other way: that is its travel, and the window opens in
/// it.
TEST(RunWindow, TravelOfAToolThatBacksFirst) {
  const RunDirectory dir;
  const std::string moves =
      "boundaries.tool.moves=[{velocity: -0.12 0 0 m/s, until: 0.1 s}, {velocity: 0.4 0 0 m/s, from: 0.1 s}]";
  ASSERT_EQ(run_scenario(dir.scenario(trench), dir / "out", {moves, "time.end=0.505 s"}), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out"), tool = summary["tools"]["tool"];
  EXPECT_EQ(tool["direction"], "+x");
  EXPECT_NEAR(tool["travelled in soil [m]"], 0.15, 1e-3);
  // Its length, 20 mm, and its depth, about 30 mm, behind where it entered.
  EXPECT_NEAR(summary["window"]["from [s]"], 0.1 + (0.012 + 0.02 + 0.03) / 0.4, 0.02);
}

/// Back by 60 mm, in which the window opens, then forward by 240 mm: the window is that of the way forward.
TEST(RunWindow, OpensAgainWhenAToolTurnsToItsWay) {
  const RunDirectory dir;
  const std::string moves =
      "boundaries.tool.moves=[{velocity: -0.4 0 0 m/s, until: 0.2 s}, {velocity: 0.4 0 0 m/s, from: 0.2 s}]";
  ASSERT_EQ(
      run_scenario(dir.scenario(trench), dir / "out", {moves, "boundaries.tool.at=160 10 0 mm", "time.end=0.8 s"}),
      exit_ok);
  const nlohmann::json summary = summary_of(dir / "out"), tool = summary["tools"]["tool"];
  EXPECT_EQ(tool["direction"], "+x");
  EXPECT_NEAR(tool["travelled in soil [m]"], 0.16, 1e-3);
  // It turns to its way where it has come a tenth farther than the 80 mm back.
  EXPECT_NEAR(summary["window"]["from [s]"], 0.4 + 1.1 * 0.08 / 0.4, 0.003);
}

/// Poured at first, 3 kg on 0.4 x 0.12 m, or on a layer; a blade that stands there goes through it from 0.8 s on.
TEST(RunWindow, OfSoilThatIsPoured) {
  constexpr const char* pour = R"(subsoil: 1
materials: {soil: {density: 2600 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 20 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.2}
  - {<<: *dry, between: [soil, steel]}
soil:
  container: {size: 0.4 0.25 0.12 m, at: 0 -0.06 -0.06 m, material: steel}
  inlets:
    feed: {box: {at: 60 100 -50 mm, size: 300 60 100 mm}, rate: 5 kg/s, material: soil, radius: 8 mm,
           velocity: 0 -1 0 m/s, until: 0.6 s}
boundaries:
  - {name: blade, material: steel, shape: {box: 10 200 60 mm}, at: 40 70 0 mm,
     moves: [{velocity: 0.4 0 0 m/s, from: 0.8 s}]}
time: {end: 1.5 s}
output: {every: 0.1 s}
)";
  for (const double layer : {0.0, 0.016}) {
    const RunDirectory dir;
    std::string text = pour;
    if (layer > 0) {
      const std::string bed = "  bed: {fill: rest-lattice, material: soil, radius: 8 mm, depth: 20 mm}\n";
      text.insert(text.find("boundaries:"), bed);
    }
    ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok);
    const nlohmann::json summary = summary_of(dir / "out"), tool = summary["tools"]["blade"];
    EXPECT_EQ(tool["direction"], "+x");
    EXPECT_NEAR(tool["travelled in soil [m]"], 0.28, 2e-3);
    // The blade's lower edge is at -30 mm; 3 kg at some 1500 kg/m3 are 42 mm on a floor at -60 mm.
    const double surface = summary["soil"]["mean surface [m]"];
    EXPECT_NEAR(surface, -0.06 + 0.042 + layer, 0.015);
    EXPECT_NEAR(tool["greatest depth [m]"], surface + 0.03, 1e-9);
    EXPECT_GT(summary["window"]["from [s]"], 0.8);
    EXPECT_GT(tool["draft [N]"]["mean"], 1);
  }
}

}  // namespace
}  // namespace subsoil::sim::run_window
