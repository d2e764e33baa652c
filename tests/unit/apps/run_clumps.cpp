#include <gtest/gtest.h>

#include <cmath>

#include "libdem/particles/particles.hpp"
#include "libsim/document/document.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/soil_runs.hpp"

/// Scenarios with clumps: places, shares, frames, restarts, refusals.
namespace subsoil::sim::run_clumps {
namespace {

using namespace test;

/// A dumbbell leans beside a loose sphere and falls over.
const std::string skittle = R"(subsoil: 1
materials: {wood: {density: 700 kg/m^3}}
contacts: [{between: [wood, wood], law: linear, k_n: 20 kN/m, restitution: 0.5, mu: 0.4}]
soil:
  container: {size: 200 200 200 mm, at: 0 0 0 m, material: wood}
  clumps:
    pin: {spheres: [{at: 0 0 0 mm, radius: 10 mm}, {at: 30 0 0 mm, radius: 10 mm}]}
  bed:
    fill: particles
    material: wood
    particles: [{position: 150 10 150 mm, radius: 10 mm}]
    placed: [{shape: pin, position: 100 25 100 mm, rotation: {axis: 0 0 1, angle: 70 deg}}]
time: {end: 0.4 s}
output: {precision: double, every: 50 ms, series every: 10 ms}
)";

/// Half of the grains are clumps.
const std::string mixture = R"(subsoil: 1
materials: {seed: {density: 1200 kg/m^3}}
contacts: [{between: [seed, seed], law: linear, k_n: 5 kN/m, restitution: 0.4, mu: 0.4}]
soil:
  container: {size: 60 60 60 mm, at: 0 0 0 m, material: seed}
  clumps:
    bean: {spheres: [{at: 0 0 0 mm, radius: 3 mm}, {at: 4 0 0 mm, radius: 3 mm}], density: 1300 kg/m^3}
  bed: {fill: random, material: seed, radius: 3 mm, count: 200, clumps: [{shape: bean, share: 0.5}]}
time: {end: 20 ms}
output: {precision: double, every: 10 ms, series every: 10 ms}
)";

std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::vector<std::int32_t> clumps_of(const std::filesystem::path& out) {
  return h5::read<std::int32_t>(h5::open_file(out / "run.h5"), "/particles/clump");
}

TEST(RunClumps, APinFallsOver) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(skittle), dir / "out"), exit_ok);
  EXPECT_EQ(clumps_of(dir / "out"), (std::vector<std::int32_t>{-1, 0, 0}));
  const auto first = frame_positions(dir / "out", 0), last = frame_positions(dir / "out", 8);
  EXPECT_NEAR(first[2].y - first[1].y, 0.03 * std::sin(70 * M_PI / 180), 1e-12);
  EXPECT_NEAR(0.5 * (first[1].x + first[2].x), 0.1, 1e-12);
  for (const auto& at : {first, last}) EXPECT_NEAR(dem::norm(at[2] - at[1]), 0.03, 1e-12);
  EXPECT_LT(last[2].y, 0.011) << "it lies";
  const Series series = read_series(dir / "out" / "series.csv");
  const double fell = series.at("soil.gravity").front() - series.at("soil.gravity").back();
  const double mass = 2 * 700 * 4.0 / 3 * M_PI * 1e-6;
  EXPECT_NEAR(fell, mass * 9.81 * 0.015, 0.02 * fell);
  EXPECT_NEAR(conserved_energy(series, series.rows() - 1), conserved_energy(series, 0), 0.01 * fell);
}

TEST(RunClumps, ARestartEndsWithTheSameBits) {
  const RunDirectory dir;
  const std::string file = dir.scenario(skittle);
  ASSERT_EQ(run_scenario(file, dir / "whole"), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "first", {"time.end=0.2 s"}), exit_ok);
  ASSERT_EQ(run_scenario(file, dir / "on", {}, state_in(dir / "first")), exit_ok);
  const auto whole = frame_positions(dir / "whole", 8);
  const auto on = frame_positions(dir / "on", frame_times(dir / "on").size() - 1);
  ASSERT_EQ(on.size(), 3u);
  for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_TRUE(whole[i] == on[i]) << i;
  EXPECT_EQ(clumps_of(dir / "on"), clumps_of(dir / "whole"));
}

/// Density times volume of the spheres in the file is the bed's mass, clumps included.
TEST(RunClumps, AMixtureHasItsMassInTheFrames) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(mixture), dir / "out"), exit_ok);
  const nlohmann::json soil = summary_of(dir / "out")["soil"];
  const auto clumps = soil["clumps"].get<std::size_t>();
  EXPECT_NEAR(static_cast<double>(clumps), 100, 25) << "3.5 standard deviations of 200 draws";
  EXPECT_EQ(soil["spheres"].get<std::size_t>(), 200 + clumps);
  const auto file = h5::open_file(dir / "out" / "run.h5");
  const auto radius = h5::read<double>(file, "/particles/radius"),
             density = h5::read<double>(file, "/particles/density");
  double mass = 0;
  for (std::size_t i = 0; i < radius.size(); ++i) mass += density[i] * dem::sphere_volume(radius[i]);
  EXPECT_NEAR(mass, soil["mass [kg]"].get<double>(), 1e-9 * mass);
  // A bean is two balls of 3 mm but for the lens that they share, pi (4 r + d)(2 r - d)^2/12 (d apart).
  const double ball = dem::sphere_volume(3e-3), lens = M_PI * 16e-3 * 4e-6 / 12;
  EXPECT_NEAR(mass,
              static_cast<double>(200 - clumps) * 1200 * ball + static_cast<double>(clumps) * 1300 * (2 * ball - lens),
              1e-9 * mass);
}

/// Half of the lower layer's grains are clumps; the lowest spheres and clumps are a rough floor, which bears all weight
/// but that of its own, and there are no walls along x.
TEST(RunClumps, LieInALayerOnARoughFloorBetweenPeriodicSides) {
  const RunDirectory dir;
  std::string text = with(mixture, "material: seed}\n  clumps", "material: seed, periodic: [x]}\n  clumps");
  text = with(
      text, "material: seed, radius: 3 mm, count: 200, clumps: [{shape: bean, share: 0.5}]",
      "radius: 3 mm, depth: 30 mm, rough floor: 4 mm, layers: [{material: seed, thickness: 12 mm}, {material: seed, "
      "clumps: [{shape: bean, share: 0.5}]}]");
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out", {"time.end=0.15 s"}), exit_ok);
  const nlohmann::json soil = summary_of(dir / "out")["soil"];
  const std::vector<std::int32_t> clumps = clumps_of(dir / "out");
  const auto members =
      static_cast<std::size_t>(std::count_if(clumps.begin(), clumps.end(), [](int c) { return c >= 0; }));
  EXPECT_EQ(members, 2 * soil["clumps"].get<std::size_t>());
  ASSERT_EQ(soil["layers"].size(), 2u);
  // A third of the lower layer is loose: of two grains one is a clump of two spheres.
  const std::size_t upper = soil["layers"][0]["spheres"], lower = soil["layers"][1]["spheres"];
  EXPECT_EQ(upper + lower, clumps.size());
  EXPECT_LT(members, lower);
  EXPECT_GT(members, lower / 4);
  const Series series = read_series(dir / "out" / "series.csv");
  double weight = 0;
  for (const char* column : {"rough floor.Fy", "floor.Fy", "wall -z.Fy", "wall +z.Fy"})
    weight -= series.at(column).back();
  const double mass = soil["mass [kg]"];
  EXPECT_LT(weight, 9.81 * mass);
  EXPECT_GT(weight, 0.6 * 9.81 * mass) << "but for the rough floor's own";
  EXPECT_LT(std::abs(series.at("rough floor.Fx").back()), 0.05 * weight);
  EXPECT_GT(-series.at("rough floor.Fy").back(), 0.5 * weight);
}

/// Spheres and clumps with the numbers and places that they had.
TEST(RunClumps, ASavedBedHasThem) {
  const RunDirectory dir;
  const std::string saved = (dir / "bed.h5").string();
  ASSERT_EQ(run_scenario(dir.scenario(mixture), dir / "made", {"soil.bed.save=" + saved}), exit_ok);
  const std::string text =
      with(mixture, "fill: random, material: seed, radius: 3 mm, count: 200, clumps: [{shape: bean, share: 0.5}]",
           "fill: file, material: seed, file: " + saved);
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "read"), exit_ok);
  EXPECT_EQ(clumps_of(dir / "read"), clumps_of(dir / "made"));
  const auto made = frame_positions(dir / "made", 0), read = frame_positions(dir / "read", 0);
  ASSERT_EQ(made.size(), read.size());
  for (std::size_t i = 0; i < made.size(); ++i) EXPECT_LT(dem::norm(made[i] - read[i]), 1e-12) << i;
  const auto refused = [&](const std::string& from, const std::string& to) {
    return subsoil::test::message_of<ScenarioError>(
        [&] { run_scenario(dir.scenario(with(text, from, to)), dir / "out"); });
  };
  EXPECT_NE(
      refused("bean: {spheres", "pea: {spheres").find("holds clumps of the shape `bean`; describe it in `soil.clumps`"),
      std::string::npos);
  EXPECT_NE(
      refused("density: 1300", "density: 1250").find("give `soil.clumps.bean` the `density` or `mass` that it was"),
      std::string::npos);
  EXPECT_NE(
      refused("at: 4 0 0 mm, radius: 3 mm", "at: 4 0 0 mm, radius: 2 mm").find("with other spheres than those of"),
      std::string::npos);
}

std::string refusal(const std::string& text, const std::string& from, const std::string& to) {
  const RunDirectory dir;
  const std::string file = dir.scenario(with(text, from, to));
  std::string message = subsoil::test::message_of<ScenarioError>([&] { run_scenario(file, dir / "out"); });
  if (const auto at = message.find(file + ":"); at == 0) message.erase(0, file.size() + 1);
  return message;
}

TEST(RunClumps, RefusalsNamePlaceRuleAndCure) {
  const auto expect = [](const std::string& message, const char* part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect(refusal(mixture, "shape: bean", "shape: been"),
         "soil.bed.clumps[0].shape = been: there is no clump of this name; did you mean `bean`?");
  expect(refusal(mixture, "share: 0.5}", "share: 0.6}, {shape: bean, share: 0.6}"),
         "soil.bed.clumps: have shares of 1.2 together; at most 1");
  expect(refusal(mixture, "share: 0.5", "share: 1"), "soil.bed.radius: has no effect: all grains are clumps");
  expect(refusal(mixture, "fill: random", "fill: rest-lattice"),
         "soil.bed.clumps: need `fill: random` or `lattice`; with `fill: particles` list them as `placed`");
  expect(refusal(mixture, "count: 200", "count: 200, save: bed.csv"),
         "bed.csv: a table has spheres one by one, and this bed has clumps; name an .h5 file");
  expect(refusal(mixture, "count: 200,", "layers: [{thickness: 20 mm, material: seed}],"),
         "soil.bed.clumps: stand beside `layers`; name them in `clumps` of each layer that has them");
  expect(refusal(mixture, "density: 1300 kg/m^3", "mass: 1 g, density: 1300 kg/m^3"),
         "soil.clumps.bean.density: stands beside `mass`; keep one of them");
  expect(refusal(mixture, "density: 1300 kg/m^3", "inertia: 1 1 1 g mm^2"),
         "soil.clumps.bean.inertia: needs `mass`, as measured");
  expect(refusal(mixture, "density: 1300 kg/m^3", "mass: 1 g, inertia: 1 1 5 g mm^2"),
         "soil.clumps.bean: no body has this inertia");
  expect(refusal(mixture, "density: 1300 kg/m^3", "mass: 1 g, inertia: [400 500 600 g mm^2]"),
         "soil.clumps.bean.inertia = [400 500 600 g mm^2]: is a list of one entry, which holds several numbers; leave "
         "the brackets out: 400 500 600 g mm^2; or write each number with its unit");
  expect(refusal(mixture, ", clumps: [{shape: bean, share: 0.5}]", ""),
         "soil.clumps: are used nowhere; name them in `soil.bed.clumps`");
  expect(refusal(skittle, "fill: particles", "fill: lattice\n    radius: 10 mm\n    pitch: 20 mm"),
         "soil.bed.placed: needs `fill: particles`; shares of a filled bed are `clumps`");
}

/// A bean of two balls of 3 mm, 4 mm apart, whose spheres come from a file.
const std::string imported =
    with(mixture, "{spheres: [{at: 0 0 0 mm, radius: 3 mm}, {at: 4 0 0 mm, radius: 3 mm}], density: 1300 kg/m^3}",
         "{import: {file: bean.txt, unit: mm}, density: 1300 kg/m^3}");

std::string in_metres() { return with(imported, "unit: mm", "unit: m"); }

dem::ClumpShape bean_of(const Loaded& loaded) {
  return build_world(loaded, {.threads = 1, .settle = false}).bed->clump_shapes().at(0);
}

/// Mass and axial moment of two balls that share a lens, in closed form.
void expect_bean(const dem::ClumpShape& bean) {
  ASSERT_EQ(bean.members.size(), 2U);
  const double r = 3, half = 2;  // mm; of slices at z the integral of pi (r^2 - z^2) and pi/2 (r^2 - z^2)^2
  const auto volume = [&](double z) { return M_PI * (r * r * z - z * z * z / 3); };
  const auto axial = [&](double z) {
    return 0.5 * M_PI * (r * r * r * r * z - 2 * r * r * z * z * z / 3 + std::pow(z, 5) / 5);
  };
  const double mass = 2 * 1300e-9 * (volume(half) - volume(-r)), moment = 2 * 1300e-15 * (axial(half) - axial(-r));
  EXPECT_NEAR(bean.mass, mass, 1e-9 * mass);
  EXPECT_NEAR(std::min({bean.inertia.x, bean.inertia.y, bean.inertia.z}), moment, 1e-9 * moment);
  EXPECT_NEAR(dem::norm(bean.members[1].at - bean.members[0].at), 4e-3, 1e-15);
}

TEST(RunClumps, FilesOfOtherProgramsAreRead) {
  const struct {
    const char *program, *content;
    bool metres;
  } files[] = {
      {"LIGGGHTS", "# bean\n0 0 0 3\n\n 4.0 0 0\t3.0 # second\n", false},
      {"LIGGGHTS, a sphere that stands twice", "0 0 0 3\n4 0 0 3\n-0 0 0 3\n", false},
      {"YADE text", "#format x_y_z_r\n0\t0\t0\t0.003\n0.004\t0\t0\t0.003\n", true},
      {"YADE textExt", "#format id_x_y_z_r_matId\n5 0 0 0 3e-3 0\n6 4e-3 0 0 3e-3 0\n", true},
      {"YADE textClumps", "#format x_y_z_r_clumpId\n0 0 0 0.003 17\n0.004 0 0 0.003 17\n", true},
      {"CLUMP, Matlab", "  0.000000,  0.000000, -0.000000,  3.000000\n  4.000000,  0.000000,  0.000000,  3.000000\n",
       false},
      {"CLUMP, numpy", "0.000e+00,0.000e+00,0.000e+00,3.000e+00\n4.000e+00,0.000e+00,0.000e+00,3.000e+00\n", false},
      {"with a byte order mark", "\xEF\xBB\xBF#format x_y_z_r\n0 0 0 3\n4 0 0 3\n", false},
      {"DEME", "x,y,z,r\r\n0,0,0,3\r\n4,0,0,3\r\n", false}};
  for (const auto& f : files) {
    SCOPED_TRACE(f.program);
    const RunDirectory dir;
    write_file(dir / "bean.txt", f.content);
    const Loaded loaded = load_scenario(dir.scenario(f.metres ? in_metres() : imported));
    expect_bean(bean_of(loaded));
    // The explicit copy needs no file.
    std::filesystem::remove(dir / "bean.txt");
    expect_bean(bean_of(load_scenario_text(write_scenario(loaded.scenario), "copy.yaml")));
  }
}

TEST(RunClumps, FaultsOfAFileNameItsLine) {
  const auto refused = [](const std::string& content, const std::string& text = imported) {
    const RunDirectory dir;
    write_file(dir / "bean.txt", content);
    const std::string file = dir.scenario(text);
    const std::string message = subsoil::test::message_of<ScenarioError>([&] { load_scenario(file); });
    EXPECT_NE(message.find("soil.clumps.bean.import"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << "one fault, one line: " << message;
    return message;
  };
  const auto expect = [](const std::string& message, const char* part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect(refused("0 0 0 3\n\n4 0 zero 3\n"), "bean.txt:3: z = 'zero': must be a finite number below 1e30");
  expect(refused("0 0 0 3\n4 0 0 -3\n"), "bean.txt:2: r = -3: must be in (0, inf)");
  expect(refused("0 0 0 3\n4 0 3\n"), "bean.txt:2: has 3 columns: must be x y z r");
  expect(refused("0 0 0 3 1\n"), "has 5 columns: must be x y z r; name them in a first line, such as `#format");
  expect(refused("0;0;0;3\n"), "bean.txt:1: has its fields separated by `;`");
  expect(refused("#format x_y_z_r_clumpId\n0 0 0 3 1\n4 0 0 3 2\n"),
         "bean.txt:3: is of clump 2, and the lines before of clump 1");
  expect(refused("x,y,z,radius\n0,0,0,3\n"), "bean.txt:1: names the columns x, y, z, radius, of which `r` is missing");
  expect(refused("# nothing\n"), "bean.txt: holds no sphere");
  expect(refused("0 0 0 3\n", with(imported, "bean.txt", "been.txt")), "been.txt: there is no file");
  expect(refused("0 0 0 3\n", with(imported, ", unit: mm", "")), "soil.clumps.bean.import.unit: is missing");
  expect(refused("0 0 0 3\n", with(imported, "{import:", "{spheres: [{at: 0 0 0 mm, radius: 3 mm}], import:")),
         "stands beside `spheres`; keep one of them");
}

}  // namespace
}  // namespace subsoil::sim::run_clumps
