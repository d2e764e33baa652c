#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numeric>

#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/scenario/shapes/mesh.hpp"
#include "libsim/studies/wear/stl.hpp"
#include "libsim/studies/wear/wear_study.hpp"
#include "tests/tools/grid_box.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// `subsoil wear`: a run with wear, its worn tools, and runs with them.
namespace subsoil::sim::wear_test {
namespace {

using namespace test;

constexpr double blade_volume = 0.02 * 0.09 * 0.03;

/// The small pass whose blade, of the same size as there, has 432 triangles and wears. `wear` empty: it does not.
struct WornPass : RunDirectory {
  std::filesystem::path out = *this / "pass";
  explicit WornPass(const std::string& wear = "wear: {coefficient: 1e-3, hardness: 2 GPa}") {
    write_atomically(*this / "blade.stl", stl_text(subsoil::test::grid_box({0.02, 0.09, 0.03}, 6), "blade"));
    run_with(fmt::format("mesh: {}, unit: m, {}", (*this / "blade.stl").string(), wear));
  }
  void run_with(const std::string& shape_and_wear, const char* end = "0.15 s") {
    EXPECT_EQ(run_scenario(scenario(small_pass), out,
                           {"machine.surfaces.blade={body: tine, material: steel, " + shape_and_wear + "}",
                            std::string("time.end=") + end}),
              exit_ok);
  }
  double volume(const char* law = "Archard") const {
    return summary_of(out).at("wear").at("blade").at(law).at("worn volume [m3]").get<double>();
  }
  /// Runs after which the blade has lost 0.2 of its 54 cm^3, most of it at its lower edge.
  double passes() const { return 2e-7 / volume(); }
  WearRequest request() const { return {.run = out, .out = *this / "worn"}; }
  std::string refusal(const WearRequest& request) const {
    return message_of([&] { wear_study(request); });
  }
};

std::vector<std::vector<std::string>> table(const std::filesystem::path& file) {
  std::istringstream lines(text_of(file));
  std::vector<std::vector<std::string>> out;
  for (std::string line; std::getline(lines, line);) out.push_back(csv::split(line));
  return out;
}

double number(const std::string& text) {
  double value = NAN;
  csv::to_number(text, value);
  return value;
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// wear.csv, STL files and the run's own account are one volume. Volumes of 54 cm^3 are summed to some 1e-15, so that
/// their difference of 0.2 cm^3 is known to 1e-12; the table holds shortest exact numbers.
TEST(Wear, TheVolumeOfTheTableIsThatOfTheRunAndOfTheStlFiles) {
  const WornPass pass;
  WearRequest request = pass.request();
  request.passes = {pass.passes() / 4, pass.passes()};
  const WearResult result = wear_study(request);
  ASSERT_EQ(result.surfaces.size(), 1U);
  EXPECT_NEAR(result.surfaces[0].mesh.volume(), blade_volume, 1e-12 * blade_volume);
  const auto rows = table(request.out / "wear.csv");
  ASSERT_EQ(rows.size(), 3U);
  ASSERT_EQ(rows[0][3], "volume [m3]");
  const double before = result.surfaces[0].mesh.volume();
  for (std::size_t k = 0; k < 2; ++k) {
    const double lost = number(rows[k + 1][3]), passes = request.passes[k];
    EXPECT_NEAR(number(rows[k + 1][1]), passes, 1e-15 * passes);
    EXPECT_EQ(rows[k + 1][2], "blade");
    EXPECT_NEAR(lost, passes * pass.volume(), 1e-15 * lost);
    EXPECT_NEAR(number(rows[k + 1][4]), 7850 * lost, 1e-15 * 7850 * lost);
    const dem::TriangleMesh after = read_mesh(result.steps[k].surfaces[0].file.string(), 1);
    EXPECT_TRUE(after.closed());
    EXPECT_NEAR(before - after.volume(), lost, 1e-10 * lost);
    const double mean = number(rows[k + 1][6]), area = number(rows[k + 1][7]);
    EXPECT_NEAR(mean * area, lost, 1e-12 * lost);
    EXPECT_GT(number(rows[k + 1][5]), mean);
  }
}

/// The front wears and the back does not: each triangle's volume has come to the right place.
TEST(Wear, TheFrontRecedes) {
  const WornPass pass;
  WearRequest request = pass.request();
  request.passes = {pass.passes()};
  const WearResult result = wear_study(request);
  const dem::TriangleMesh &before = result.surfaces[0].mesh,
                          after = read_mesh(result.steps[0].surfaces[0].file.string(), 1);
  double front = 0, all = 0;
  for (std::size_t t = 0; t < before.triangles().size(); ++t) {
    all += result.surfaces[0].volumes[t];
    if (before.normal(t).x > 0.9) front += result.surfaces[0].volumes[t];
    for (int i = 0; i < 3; ++i)
      if (before.corner(t, i).x < -0.0099) {
        EXPECT_NEAR(after.corner(t, i).x, before.corner(t, i).x, 2e-5);
      }
  }
  EXPECT_GT(front, 0.5 * all);
}

TEST(Wear, HectaresArePassesOfTheStrip) {
  const WornPass pass;
  WearRequest request = pass.request();
  const double strip = 0.25 * 0.08 * 1e-4;
  request.width = 0.25, request.length = 0.08, request.hectares = {pass.passes() * strip};
  const WearResult given = wear_study(request);
  EXPECT_NEAR(given.steps[0].passes, pass.passes(), 1e-12 * pass.passes());
  EXPECT_EQ(given.strip->source, "as given");
  // Of the frames: the blade is 30 mm wide, and its way is that of any of its vertices.
  const auto frames = h5::open_file(pass.out / "run.h5");
  const double way = h5::read<double>(frames, "/frames/000006/surfaces/blade")[0] -
                     h5::read<double>(frames, "/frames/000000/surfaces/blade")[0];
  request.width.reset(), request.length.reset(), request.hectares = {1e-9};
  const WearResult found = wear_study(request);
  EXPECT_NEAR(found.strip->width, 0.03, 1e-4);
  EXPECT_GT(way, 0.02);
  EXPECT_NEAR(found.strip->length, way, 1e-5);
  EXPECT_EQ(found.strip->source, "width of the tool in the soil, length of its travel, from the frames");
  request.width = 0.25;
  EXPECT_TRUE(holds(wear_study(request).strip->source, "width as given, length of its travel"));
}

/// The scenario that is written runs with the worn tool, and says the same as values of --set.
TEST(Wear, TheNextPassRunsWithTheWornTool) {
  const WornPass pass;
  WearRequest request = pass.request();
  request.passes = {pass.passes()};
  const WearResult result = wear_study(request);
  const WearStep& step = result.steps[0];
  ASSERT_EQ(run_scenario(step.scenario.string(), pass / "next"), exit_ok);
  const Loaded next = load_scenario(step.scenario.string());
  const Surface& blade = next.scenario.machine->surfaces.at(0);
  ASSERT_TRUE(std::holds_alternative<MeshShape>(blade.shape));
  EXPECT_EQ(std::get<MeshShape>(blade.shape).file, step.surfaces[0].file.string());
  const std::vector<std::string> sets = sets_of_meshes(load_scenario((pass.out / "scenario.yaml").string()).scenario,
                                                       result.surfaces, {step.surfaces[0].file.string()});
  EXPECT_EQ(write_scenario(load_scenario((pass.out / "scenario.yaml").string(), sets).scenario),
            write_scenario(next.scenario));
  // Another shape, another draft; the wear continues.
  const nlohmann::json after = summary_of(pass / "next"), before = summary_of(pass.out);
  EXPECT_GT(after.at("wear").at("blade").at("Archard").at("worn volume [m3]").get<double>(), 0);
  EXPECT_NE(after.at("columns").at("draft").at("mean in window"),
            before.at("columns").at("draft").at("mean in window"));
}

/// A boundary that is a box, and a cylinder, which wears as the prism that draws it.
TEST(Wear, TakesBoundariesAndCylinders) {
  const RunDirectory dir;
  std::string text = moving_pass;
  const auto replace = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
  };
  replace("at: 180 20 0 mm,", "at: 180 20 0 mm, wear: {finnie: 1e-12 1/Pa},");
  replace("{box: 15 100 30 mm}", "{cylinder: {radius: 12 mm, length: 100 mm, axis: 0 1 0}}");
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out", {"time.end=0.2 s"}), exit_ok);
  WearRequest request{.run = dir / "out", .out = dir / "worn"};
  request.passes = {1e-7 /
                    summary_of(dir / "out").at("wear").at("blade").at("Finnie").at("worn volume [m3]").get<double>()};
  const WearResult result = wear_study(request);
  const dem::TriangleMesh& prism = result.surfaces[0].mesh;
  EXPECT_NEAR(prism.volume() / (M_PI * 0.012 * 0.012 * 0.1), 48 / (2 * M_PI) * std::sin(2 * M_PI / 48), 1e-12);
  EXPECT_NEAR(prism.volume() - read_mesh(result.steps[0].surfaces[0].file.string(), 1).volume(), 1e-7, 1e-17);
  double front = 0, rear = 0;  // it goes along +x; most of the wear is that of its lower end
  for (std::size_t t = 0; t < prism.triangles().size(); ++t)
    (prism.normal(t).x > 0.1 ? front : rear) += std::abs(prism.normal(t).x) > 0.1 ? result.surfaces[0].volumes[t] : 0;
  EXPECT_GT(front, 0.05 * result.surfaces[0].volume);
  EXPECT_GT(front, 20 * rear);
  EXPECT_EQ(run_scenario(result.steps[0].scenario.string(), dir / "next", {"time.end=20 ms"}), exit_ok);
}

/// A cylinder that is turned in the axes of its body: its sides are where the run had them.
TEST(Wear, ATurnedCylinderWearsAtItsFront) {
  WornPass pass;
  std::filesystem::remove_all(pass.out);
  pass.run_with(
      "cylinder: {radius: 15 mm, length: 90 mm, axis: 1 0 0}, rotation: {axis: 0 0 1, angle: 90 deg}, "
      "wear: {coefficient: 1e-3, hardness: 2 GPa}",
      "75 ms");
  const WornSurface one = worn_surfaces(read_run_folder(pass.out), {}).at(0);
  double ahead = 0;  // +x of the body is -y of the shape
  for (std::size_t t = 0; t < one.mesh.triangles().size(); ++t) ahead -= one.volumes[t] * one.mesh.normal(t).y;
  EXPECT_GT(ahead, 0.3 * one.volume);
}

int status(const std::string& command) {
  return WEXITSTATUS(std::system((subsoil::test::program() + " " + command + " > /dev/null 2>&1").c_str()));
}

/// Runs with each worn tool: every step wears by the loads of the tool that it begins with.
TEST(Wear, RepeatedRunsGiveDraftOverPasses) {
  const WornPass pass;
  const double half = pass.passes() / 2;
  const std::string command = fmt::format("wear {} --passes {},{} --spread '10 mm' --repeat --pictures png --out {}",
                                          pass.out.string(), half, 2 * half, (pass / "worn").string());
  ASSERT_EQ(status(command), 0);
  const auto rows = table(pass / "worn" / "wear.csv");
  ASSERT_EQ(rows.size(), 4U);
  std::size_t draft = 0;
  while (draft < rows[0].size() && rows[0][draft] != "draft [N]") ++draft;
  ASSERT_LT(draft + 1, rows[0].size());
  EXPECT_EQ(rows[0][draft + 1], "draft half width [N]");
  const auto account = [](const std::filesystem::path& run) {
    return summary_of(run).at("wear").at("blade").at("Archard").at("worn volume [m3]").get<double>();
  };
  double lost = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::filesystem::path run = k == 0 ? pass.out : pass / "worn" / "points" / fmt::format("{:04}", k);
    EXPECT_NEAR(number(rows[k + 1][1]), static_cast<double>(k) * half, 1e-9 * half);
    EXPECT_NEAR(number(rows[k + 1][3]), lost, 1e-14 * lost);
    EXPECT_EQ(number(rows[k + 1][draft]), summary_of(run).at("columns").at("draft").at("mean in window").get<double>());
    lost += half * account(run);
  }
  const double left = read_mesh((pass / "worn" / fmt::format("blade-{:g}passes.stl", 2 * half)).string(), 1).volume();
  EXPECT_NEAR(blade_volume - left, number(rows[3][3]), 1e-10 * blade_volume);
  for (const char* file : {"sweep.csv", "sweep.h5", "sweep.html", "wear.png"})
    EXPECT_TRUE(std::filesystem::exists(pass / "worn" / file)) << file;
  // The same command finds all done; another one is refused and leaves the files alone.
  const auto when = std::filesystem::last_write_time(pass / "worn" / "points" / "0001" / "summary.json");
  EXPECT_EQ(status(command), 0);
  EXPECT_EQ(std::filesystem::last_write_time(pass / "worn" / "points" / "0001" / "summary.json"), when);
  WearRequest other = pass.request();
  other.passes = {half, 2 * half}, other.spread = 0.02, other.repeat = true;
  EXPECT_TRUE(holds(pass.refusal(other), "was worn by another request, and its run is done; name another --out"))
      << pass.refusal(other);
}

TEST(Wear, RefusesRequestsWithoutAMeaning) {
  const WornPass pass;
  WearRequest request = pass.request();
  EXPECT_TRUE(holds(pass.refusal(request), "give one of --hectares and --passes"));
  request.passes = {2, 1};
  EXPECT_TRUE(holds(pass.refusal(request), "--passes 1: comes after 2: steps end above 0, each after the one before"));
  request.passes = {1}, request.law = WearLaw::finnie;
  EXPECT_TRUE(holds(pass.refusal(request),
                    "machine.surfaces.blade has no constants of Finnie's law in `wear`; run with `finnie`"))
      << pass.refusal(request);
  request.law.reset();
  request.passes = {1e3 * pass.passes()};
  EXPECT_TRUE(holds(pass.refusal(request), "nothing is left; wear it for less")) << pass.refusal(request);
  request.passes = {100 * pass.passes()};
  const std::string deep = pass.refusal(request);
  EXPECT_TRUE(holds(deep, "blade after ")) << deep;
  EXPECT_TRUE(holds(deep, ": wear it for less, spread the wear over a length, or mesh")) << deep;
  request.run = pass / "nowhere";
  EXPECT_TRUE(holds(pass.refusal(request), "is no directory")) << pass.refusal(request);
}

/// Wear is that since the start; frames from 0.1 s on show the travel of the rest.
TEST(Wear, RefusesTheTravelOfFramesThatBeginWithAWornTool) {
  const WornPass pass;
  ASSERT_EQ(run_scenario(pass.scenario(small_pass), pass / "late",
                         {fmt::format("machine.surfaces.blade={{body: tine, material: steel, mesh: {}, unit: m, wear: "
                                      "{{coefficient: 1e-3, hardness: 2 GPa}}}}",
                                      (pass / "blade.stl").string()),
                          "time.end=0.15 s", "output={at: [0.1 s]}"}),
            exit_ok);
  WearRequest request = pass.request();
  request.run = pass / "late", request.hectares = {1e-9};
  EXPECT_TRUE(holds(pass.refusal(request), "blade has worn before the first frame, at 0.1 s")) << pass.refusal(request);
  request.length = 0.1;
  EXPECT_NO_THROW(wear_study(request));
}

TEST(Wear, RefusesRunsThatDoNotTell) {
  const WornPass without("wear: {}");
  WearRequest request = without.request();
  request.passes = {1};
  EXPECT_TRUE(
      holds(without.refusal(request), "no surface of this run wears; give one `wear: {coefficient: K, hardness: H}`"))
      << without.refusal(request);
  const WornPass both("wear: {coefficient: 1e-3, hardness: 2 GPa, finnie: 1e-12 1/Pa}");
  WearRequest choose = both.request();
  choose.passes = {1};
  EXPECT_TRUE(holds(both.refusal(choose), "choose one by --law archard or --law finnie")) << both.refusal(choose);
  choose.law = WearLaw::finnie;
  EXPECT_NEAR(wear_study(choose).steps[0].surfaces[0].volume, both.volume("Finnie"), 1e-15 * both.volume("Finnie"));
  // Nothing travels in soil: there is no strip.
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(R"(subsoil: 1
materials: {stone: {density: 2500 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - {between: [stone, stone], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0}
  - {between: [stone, steel], law: linear, k_n: 100 kN/m, restitution: 0.5, mu: 0}
soil: {bed: {fill: particles, material: stone, particles: [{position: 100 9.999 3 mm, velocity: 0.5 0 0 m/s, radius: 10 mm}]}}
boundaries: [{name: strip, material: steel, shape: {box: 0.6 0.02 0.1 m}, at: 0.3 -0.01 0 m, wear: {finnie: 1e-12 1/Pa}}]
time: {end: 20 ms}
output: {every: 10 ms}
)"),
                         dir / "out"),
            exit_ok);
  EXPECT_TRUE(holds(message_of([&] { wear_study({.run = dir / "out", .out = dir / "w", .hectares = {1}}); }),
                    "give --width and --length, or --passes in place of --hectares"));
  // A disk that turns in place under a ball in a pen: its travel is the rounding of its pose.
  ASSERT_EQ(run_scenario(dir.scenario(R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {stone: {density: 2500 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - {between: [stone, stone], law: linear, k_n: 20 kN/m, restitution: 0.3, mu: 0.3}
  - {between: [stone, steel], law: linear, k_n: 20 kN/m, restitution: 0.3, mu: 0.3}
soil: {bed: {fill: particles, material: stone, particles: [{position: 100 9.99 0 mm, radius: 10 mm}]}}
boundaries:
  - {name: disk, material: steel, shape: {cylinder: {radius: 150 mm, length: 20 mm, axis: 0 1 0}}, at: 0 -10 0 mm,
     moves: [{angular velocity: 0 6 0 rad/s}], wear: {coefficient: 1e-3, hardness: 1 GPa}}
  - {name: pen, material: stone, shape: {box: 20 40 20 mm}, at: 100 21 -20 mm}
time: {end: 50 ms}
output: {every: 10 ms}
)"),
                         dir / "turned"),
            exit_ok);
  WearRequest turned{.run = dir / "turned", .out = dir / "wt", .hectares = {1e-3}};
  turned.width = 0.03;
  EXPECT_TRUE(holds(message_of([&] { wear_study(turned); }), "give --width and --length"));
}

}  // namespace
}  // namespace subsoil::sim::wear_test
