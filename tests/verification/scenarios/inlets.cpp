#include <algorithm>
#include <cmath>
#include <map>

#include "libdem/particles/particles.hpp"
#include "libsim/post/frames_file.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/soil_runs.hpp"

/// Spheres and clumps that are poured in during a run. Oracles: the rate, what is neither in the bed nor removed, the
/// balance of energy, a run that was not continued from a state.
namespace subsoil::sim::inlets {
namespace {

using namespace test;

constexpr double kRate = 0.5, kEnd = 1.2;                               // kg/s, s
constexpr double kMass = 2500 * 4.0 / 3.0 * M_PI * 5e-3 * 5e-3 * 5e-3;  // of a sphere, kg

/// Two plates at 45 degrees over a slot; what falls through is removed.
constexpr const char* kHopper = R"(subsoil: 1
title: a hopper that is fed
gravity: 9.81 m/s^2
materials:
  grain: {density: 2500 kg/m^3}
  steel: {density: 7850 kg/m^3}
contacts:
  - &dry {between: [grain, grain], law: linear, k_n: 5 kN/m, restitution: 0.5, mu: 0.4, mu_r: 0.05}
  - {<<: *dry, between: [grain, steel], mu: 0.3}
soil:
  container: {size: 200 250 60 mm, at: -100 0 -30 mm, material: steel, open: [-y, +y], periodic: [z]}
  remove below: 50 mm
  inlets:
    feed: {box: {at: -40 190 -30 mm, size: 80 50 60 mm}, rate: 0.5 kg/s, material: grain, radius: 5 mm, velocity: 0 -1 0 m/s}
boundaries:
  - {name: left, material: steel, shape: {box: 140 10 180 mm}, at: -70 70 0 mm, rotation: {angle: -45 deg}}
  - {name: right, material: steel, shape: {box: 140 10 180 mm}, at: 70 70 0 mm, rotation: {angle: 45 deg}}
time: {end: 1.2 s}
output: {every: 50 ms, series every: 10 ms, monitor: {fed: feed.poured}}
)";

TEST(Inlets, AHopperThatIsFedComesToTheRateOfItsInlet) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(kHopper), dir / "out"), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out"), feed = summary["inlets"]["feed"];
  const double step = summary["run"]["soil step [s]"].get<double>(), interval = 50 * step;
  // The last instant lies less than a step behind the end, and the step that begins there is taken.
  EXPECT_NEAR(feed["mass asked for [kg]"], kRate * kEnd, 2 * kRate * step);
  // Half a sphere, and what has become due since the last interval began.
  EXPECT_NEAR(feed["mass [kg]"], kRate * kEnd, 0.5 * kMass + kRate * interval);
  EXPECT_NEAR(feed["mass [kg]"], feed["spheres"].get<double>() * kMass, 1e-12);
  EXPECT_EQ(feed["intervals without room"], 0);

  // Mass: what came is there or was removed, each sphere once, in every frame.
  const FramesFile frames(dir / "out" / "run.h5");
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_EQ(series.at("fed"), series.at("feed.poured")) << "a monitor reads any column";
  std::vector<double> there;
  for (std::size_t f = 0; f < frames.times().size(); ++f)
    there.push_back(static_cast<double>(frames.spheres(f, false).index.size()));
  const double removed = summary["soil"]["fallen out and removed"];
  EXPECT_GT(removed, 100);
  EXPECT_NEAR(there.back() + removed, feed["spheres"].get<double>(), 1e-9);

  // Steady: over its last 0.4 s as many leave as come. 0.4 s bring 153 spheres; what is in the hopper, some 100 of
  // them, fluctuates by less than ten.
  const std::size_t last = there.size() - 1, before = last - 8;
  ASSERT_NEAR(frames.times()[last] - frames.times()[before], 0.4, 1e-9);
  EXPECT_NEAR(there[last] - there[before], 0, 0.15 * kRate * 0.4 / kMass);

  // Energy, at every row.
  const double moved = feed["kinetic [J]"].get<double>() + std::abs(feed["gravity [J]"].get<double>());
  for (std::size_t row = 0; row < series.rows(); ++row)
    EXPECT_NEAR(conserved_energy(series, row), conserved_energy(series, 0), 5e-3 * moved) << row;
  EXPECT_LT(std::abs(summary["energy"]["bed closure [J]"].get<double>()), 5e-3 * moved);
}

/// No step follows the last instant of a run, and nothing is poured there: the last row is the summary. Steps of 0.1 ms
/// pour every 5 ms, 1.9 spheres at a time; the last instant is the 40th of these times.
TEST(Inlets, TheLastRowIsTheSummary) {
  const RunDirectory dir;
  const std::string file = dir.scenario(kHopper);
  for (const char* end : {"0.2 s", "0.19997 s"}) {
    SCOPED_TRACE(end);
    ASSERT_EQ(run_scenario(file, dir / end, {"time.soil step=0.1 ms", std::string("time.end=") + end}), exit_ok);
    const nlohmann::json feed = summary_of(dir / end)["inlets"]["feed"];
    const Series series = read_series(dir / end / "series.csv");
    // Sphere k is due at the rate times the time of (k - 1/2) m; the last ones came at 0.195 s.
    EXPECT_EQ(feed["spheres"].get<double>(), std::floor(kRate * 0.195 / kMass + 0.5));
    EXPECT_EQ(series.at("feed.spheres").back(), feed["spheres"].get<double>());
    const double digits = 5e-9;  // rows have nine digits
    EXPECT_NEAR(series.at("feed.poured").back(), feed["mass [kg]"].get<double>(), digits * 0.1);
    EXPECT_NEAR(series.at("feed.energy").back(), feed["kinetic [J]"].get<double>() + feed["gravity [J]"].get<double>(),
                digits * 0.3);
  }
}

/// A run that continues from a state in its middle pours the same spheres at the same places.
TEST(Inlets, ARestartPoursTheSameSpheres) {
  const RunDirectory dir;
  const std::string file = dir.scenario(kHopper);
  ASSERT_EQ(run_scenario(file, dir / "whole", {"time.end=0.2 s", "output.state every=90 ms"}), exit_ok);
  std::filesystem::path state;
  for (const auto& entry : std::filesystem::directory_iterator(dir / "whole"))
    if (entry.path().filename().string().rfind("state-0.0", 0) == 0) state = entry.path();
  ASSERT_FALSE(state.empty());
  ASSERT_EQ(run_scenario(file, dir / "again", {"time.end=0.2 s"}, state), exit_ok);
  const nlohmann::json whole = summary_of(dir / "whole"), again = summary_of(dir / "again");
  EXPECT_EQ(whole["inlets"], again["inlets"]);
  const FramesFile a(dir / "whole" / "run.h5"), b(dir / "again" / "run.h5");
  const FrameSpheres one = a.spheres(a.times().size() - 1, false), other = b.spheres(b.times().size() - 1, false);
  EXPECT_GT(one.index.size(), 60U);
  EXPECT_EQ(one.index, other.index);
  const auto x = frame_positions(dir / "whole", a.times().size() - 1),
             y = frame_positions(dir / "again", b.times().size() - 1);
  ASSERT_EQ(x.size(), y.size());
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT(dem::norm(x[i] - y[i]), 2e-6) << i;  // a quantum of the frames
}

/// Beans of two balls and spheres, poured into a cup with two beans in it.
constexpr const char* kCup = R"(subsoil: 1
materials: {seed: {density: 1200 kg/m^3}, husk: {density: 800 kg/m^3}}
contacts:
  - &dry {between: [seed, seed], law: linear, k_n: 5 kN/m, restitution: 0.4, mu: 0.4}
  - {<<: *dry, between: [seed, husk]}
  - {<<: *dry, between: [husk, husk]}
soil:
  container: {size: 80 120 80 mm, at: 0 0 0 m, material: seed}
  clumps:
    bean: {spheres: [{at: 0 0 0 mm, radius: 3 mm}, {at: 4 0 0 mm, radius: 3 mm}]}
    small: {spheres: [{at: 0 0 0 mm, radius: 3 mm}, {at: 4 0 0 mm, radius: 3 mm}], scale: 0.8}
  bed:
    fill: particles
    material: seed
    placed: [{shape: bean, position: 20 3 20 mm}, {shape: bean, position: 60 3 60 mm}]
  inlets:
    left: {box: {at: 5 90 5 mm, size: 30 25 70 mm}, rate: 0.1 kg/s, clumps: [{shape: bean, share: 0.5}, {shape: small, share: 0.5}]}
    right: {box: {at: 45 90 5 mm, size: 30 25 70 mm}, rate: 300 1/s, radius: 3 mm, clumps: [{shape: bean, share: 0.5}]}
time: {end: 0.4 s}
output: {precision: double, every: 0.1 s, series every: 10 ms, monitor: {fed: left.poured}}
)";

/// A bean is two balls but for the lens that they share, pi (4 r + d)(2 r - d)^2/12 (d apart).
double bean(double scale) {
  const double r = 3e-3 * scale, d = 4e-3 * scale;
  return 1200 * (2 * 4.0 / 3.0 * M_PI * r * r * r - M_PI * (4 * r + d) * (2 * r - d) * (2 * r - d) / 12);
}

/// Frames hold each grain that came with its mass, the spheres of a clump with its number, as far apart as in its
/// shape.
TEST(Inlets, ClumpsAreInTheBooksAndInTheFrames) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(kCup), dir / "out"), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out"), left = summary["inlets"]["left"],
                       right = summary["inlets"]["right"];
  const double step = summary["run"]["soil step [s]"].get<double>(), interval = 50 * step;
  EXPECT_NEAR(left["mass [kg]"], 0.1 * 0.4, 0.5 * bean(1) + 0.1 * (interval + step));
  EXPECT_NEAR(right["spheres"], 300 * 0.4, 0.5 + 300 * (interval + step));
  const Series series = read_series(dir / "out" / "series.csv");
  EXPECT_EQ(series.at("fed"), series.at("left.poured"));

  const FramesFile frames(dir / "out" / "run.h5");
  const std::size_t last = frames.times().size() - 1;
  const FrameSpheres there = frames.spheres(last, false);
  const auto file = h5::open_file(dir / "out" / "run.h5");
  const auto radius = h5::read<double>(file, "/particles/radius"),
             density = h5::read<double>(file, "/particles/density");
  const auto at = frame_positions(dir / "out", last);
  double mass = 0;
  std::map<std::int32_t, std::vector<std::size_t>> clumps;  // places in the frame
  for (std::size_t i = 0; i < there.index.size(); ++i) {
    const std::size_t k = there.index[i];
    mass += density[k] * dem::sphere_volume(radius[k]);
    if (const std::int32_t clump = frames.clump()[k]; clump >= 0) clumps[clump].push_back(i);
  }
  const double came = left["mass [kg]"].get<double>() + right["mass [kg]"].get<double>();
  EXPECT_NEAR(mass, came + 2 * bean(1), 1e-9 * mass);
  ASSERT_GT(clumps.size(), 100U);
  for (const auto& [clump, spheres] : clumps) {
    ASSERT_EQ(spheres.size(), 2U) << clump;
    const double r = radius[there.index[spheres[0]]];
    EXPECT_NEAR(dem::norm(at[spheres[1]] - at[spheres[0]]), 4.0 / 3.0 * r, 1e-9);
  }
  EXPECT_LT(std::abs(summary["energy"]["closure over energy there or put in"].get<double>()), 5e-3);
}

TEST(Inlets, ARestartPoursTheSameClumps) {
  const RunDirectory dir;
  const std::string file = dir.scenario(kCup);
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "first", {"time.end=0.2 s"}), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "on", {}, state_in(dir / "first")), exit_ok);
  EXPECT_EQ(summary_of(dir / "whole")["inlets"], summary_of(dir / "on")["inlets"]);
  const FramesFile whole(dir / "whole" / "run.h5"), on(dir / "on" / "run.h5");
  const std::size_t end = whole.times().size() - 1, last = on.times().size() - 1;
  EXPECT_EQ(whole.spheres(end, false).index, on.spheres(last, false).index);
  EXPECT_EQ(whole.clump(), on.clump());
  EXPECT_EQ(frame_positions(dir / "whole", end), frame_positions(dir / "on", last));
}

TEST(Inlets, RefusalsOfClumpsNamePlaceRuleAndCure) {
  const RunDirectory dir;
  const std::string file = dir.scenario(kCup);
  const auto refused = [&](const std::string& set, const char* part) {
    const std::string text = subsoil::test::message_of([&] { run_scenario(file, dir / "out", {set}); });
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  refused("soil.inlets.left.clumps=[{shape: been, share: 1}]", "there is no clump of this name; did you mean `bean`?");
  refused("soil.inlets.left.clumps=[{shape: bean, share: 1}, {shape: small, share: 0.5}]",
          "soil.inlets.left.clumps: have shares of 1.5 together; at most 1");
  refused("soil.inlets.left.radius=3 mm", "soil.inlets.left.radius: has no effect: all grains are clumps");
  refused("soil.inlets.right.radius=50 mm", "less than the diameter 100 mm of its largest sphere");
  refused("soil.inlets.left.box.size=8 25 70 mm", "the box is 8 mm long in x, less than the diameter 10 mm");
  refused("soil.inlets.left.material=husk",
          "soil.clumps.bean: is of materials of 1200 and 800 kg/m^3; give it `density`");
}

TEST(Inlets, WarnsOfARateThatHasNoRoomAndRefusesWhatCannotBe) {
  const RunDirectory dir;
  const std::string file = dir.scenario(kHopper);
  ASSERT_EQ(run_scenario(file, dir / "full", {"soil.inlets.feed.rate=100 kg/s", "time.end=0.05 s"}), exit_ok);
  EXPECT_NE(summary_of(dir / "full")["warnings"].dump().find("a sphere that was due found no room"), std::string::npos);
  const auto refusal = [&](const std::string& set) {
    return subsoil::test::message_of([&] { run_scenario(file, dir / "out", {set}); });
  };
  const auto holds = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  EXPECT_PRED2(holds, refusal("soil.inlets.feed.rate=5 m/s"),
               "needs a mass (2 kg/s) or a number of grains (500 1/s) per time");
  EXPECT_PRED2(holds, refusal("soil.inlets.feed.rate=0 kg/s"), "must be above zero");
  EXPECT_PRED2(holds, refusal("soil.inlets.feed.disk={at: 0 0 0 m, radius: 50 mm}"), "has `box` and `disk`");
  EXPECT_PRED2(holds, refusal("soil.inlets.feed.radius=26 mm"), "less than the diameter 52 mm of its largest sphere");
  EXPECT_PRED2(holds, refusal("soil.inlets.feed.material=mud"), "mud");
  EXPECT_PRED2(holds, refusal("soil.inlets.feed.from=2 s"), "is not before the end of the run");
  EXPECT_PRED2(holds, refusal("soil.active={within: 0.1 m}"), "stands beside `soil.active`");
  EXPECT_PRED2(holds, refusal("engine=liggghts"), "cannot do spheres that come during the run");
}

}  // namespace
}  // namespace subsoil::sim::inlets
