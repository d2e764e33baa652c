#include "libsim/post/disturbance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "libdem/geometry/mesh_builders.hpp"
#include "libsim/io/run_writer.hpp"
#include "libsim/plot/furrow_picture.hpp"
#include "libsim/plot/plot.hpp"
#include "libsim/post/run_folder.hpp"
#include "libsim/report/numbers.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/unit/apps/trench.hpp"

/// What a pass has done to the soil, against displacements that are made up and so known.
namespace subsoil::sim::test::disturbance_test {
namespace {

constexpr double d = 0.02;  ///< diameter, and pitch of a cubic lattice
constexpr int nx = 40, ny = 12, nz = 31;

/// A block of spheres from x = 0, top at y = 0, middle at z = 0.
std::vector<dem::Vec3> block() {
  std::vector<dem::Vec3> out;
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k) out.push_back({(i + 0.5) * d, -(j + 0.5) * d, (k - 0.5 * (nz - 1)) * d});
  return out;
}

struct Given {
  double half_width = 0.1, depth = 0.16, strain = 0;  ///< of the box that is loosened upward from its bottom
  dem::Vec3 shift{};                                  ///< and moved as a whole
  dem::Vec3 (*seen)(const dem::Vec3&) = [](const dem::Vec3& p) { return p; };  ///< the scene turned or mirrored
};

/// Two frames: the block, and the block after; a tool 20 mm wide and 160 mm deep has gone through.
Disturbance after(const Given& given) {
  const RunDirectory dir;
  std::vector<dem::Vec3> before = block(), moved = before;
  for (dem::Vec3& p : moved)
    if (std::abs(p.z) < given.half_width && p.y > -given.depth)
      p += given.shift + dem::Vec3{0, given.strain * (p.y + given.depth), 0};
  for (dem::Vec3& p : before) p = given.seen(p);
  for (dem::Vec3& p : moved) p = given.seen(p);
  ParticleTable table;
  table.material_names = {"soil"};
  for (std::size_t i = 0; i < before.size(); ++i) {
    table.id.push_back(static_cast<std::int64_t>(i));
    table.radius.push_back(0.5 * d), table.density.push_back(2000), table.material.push_back(0);
  }
  const dem::TriangleMesh box = dem::box_mesh({0.02, 0.2, 0.02});
  OutputSurface tool{"tool", box.vertices(), {}, true};
  for (const dem::Triangle& t : box.triangles())
    tool.triangles.push_back({static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2])});
  RunOptions options;
  options.columns = {"position"}, options.precision = FramePrecision::float64;
  {
    RunWriter writer(dir.path(), table, {tool}, options);
    for (const auto& [time, x, points] : {std::tuple{0.0, -0.1, &before}, std::tuple{1.0, nx * d + 0.1, &moved}}) {
      const dem::Pose pose{given.seen({x, 0.1 - given.depth, 0}), {}};
      Frame frame;
      frame.time = time;
      frame.position = *points;
      frame.surfaces = std::span(&pose, 1);
      writer.write(frame);
    }
    writer.finish();
  }
  const FramesFile file(dir / "run.h5");
  return disturbance_of(file, nullptr, 0, std::nan(""));
}

TEST(Disturbance, OfALiftIsItsArea) {
  const double up = 0.03;
  const Disturbance found = after({.shift = {0.02, up, 0}});
  ASSERT_TRUE(found.furrow) << found.why;
  const Furrow& f = *found.furrow;
  // Whole columns and rows of the lattice: 11 of 2 cm lie within 10 cm of the middle... z = -0.1 ... 0.1 without the
  // ends.
  const int columns = 9, rows = 8;
  EXPECT_NEAR(f.disturbed_area, columns * rows * d * d, 1e-8);  // radii are floats
  EXPECT_NEAR(f.heave, up, 1e-6);
  EXPECT_NEAR(f.heap_area, columns * d * up, 1e-8);
  EXPECT_NEAR(f.furrow_area, 0, 1e-9);
  EXPECT_NEAR(f.swell, columns * d * up / (columns * rows * d * d), 1e-6);
  EXPECT_NEAR(found.tool->width, 0.02, 1e-6);
  // Fifths of the depth of the centres, 22 mm and 44 mm ...: all of the upper ones near the tool went up and forward.
  double rise = 0, forward = 0;
  for (const LayerMotion& l : f.layers) {
    double sum = 0;
    for (const double share : l.into) sum += share;
    EXPECT_NEAR(sum, 1, 1e-12) << l.name << ": every sphere is in some layer afterwards";
    rise = std::max(rise, l.rise), forward = std::max(forward, l.forward);
    EXPECT_NEAR(l.aside, 0, 1e-9);
  }
  EXPECT_GT(rise, 0.4 * up);
  EXPECT_NEAR(forward / rise, 0.02 / up, 1e-5);
}

/// Of cells that reach beyond the surface only what is soil counts: here the uppermost layer lies 0.4 diameters lower.
TEST(Disturbance, EndsAtTheSurface) {
  const auto sunk = [](const dem::Vec3& p) { return dem::Vec3{p.x, p.y > -d ? p.y - 0.4 * d : p.y, p.z}; };
  const Disturbance found = after({.depth = 1, .shift = {0.02, 0.03, 0}, .seen = sunk});
  ASSERT_TRUE(found.furrow) << found.why;
  EXPECT_NEAR(found.furrow->disturbed_area, 9 * (ny - 0.4) * d * d, 1e-8);
}

/// Turned about the vertical, or mirrored, a pass does the same; the cross-section is across the way of the tool. The
/// bed is not whole columns wide: its outermost spheres are drawn in by 3 mm.
TEST(Disturbance, DoesNotDependOnTheDirectionOfTravel) {
  const auto turned = [](const dem::Vec3& p) { return dem::Vec3{p.z, p.y, -p.x}; };
  const auto mirrored = [](const dem::Vec3& p) { return dem::Vec3{p.x, p.y, -p.z}; };
  const auto narrow = [](const dem::Vec3& p) { return dem::Vec3{p.x, p.y, p.z > 0.29 ? p.z - 0.012 : p.z}; };
  const auto narrow_mirrored = [](const dem::Vec3& p) { return dem::Vec3{p.x, p.y, p.z > 0.29 ? 0.012 - p.z : -p.z}; };
  const dem::Vec3 shift{0.02, -0.015, 0.01};
  const auto same = [&](const Disturbance& one, const Disturbance& other) {
    ASSERT_TRUE(one.furrow && other.furrow) << one.why << other.why;
    const Furrow &a = *one.furrow, &b = *other.furrow;
    EXPECT_NEAR(one.tool->width, other.tool->width, 1e-6);
    EXPECT_NEAR(one.tool->speed, other.tool->speed, 1e-6);
    EXPECT_NEAR(a.until - a.from, b.until - b.from, 1e-6);
    for (const auto value : {&Furrow::furrow_area, &Furrow::depth, &Furrow::width, &Furrow::disturbed_area,
                             &Furrow::heap_area, &Furrow::swell})
      EXPECT_NEAR(a.*value, b.*value, 1e-6 * (1 + std::abs(a.*value)));
    EXPECT_NEAR(a.loosened_area, b.loosened_area, 1e-8);
    for (std::size_t k = 0; k < a.layers.size(); ++k) EXPECT_NEAR(a.layers[k].forward, b.layers[k].forward, 1e-6);
  };
  const Disturbance along_x = after({.half_width = 0.05, .shift = shift}),
                    along_z = after({.half_width = 0.05, .shift = shift, .seen = turned});
  ASSERT_TRUE(along_z.furrow) << along_z.why;
  EXPECT_EQ(along_x.furrow->along, 'x');
  EXPECT_EQ(along_z.furrow->along, 'z');
  EXPECT_EQ(along_z.tool->direction, -1);
  same(along_x, along_z);
  same(along_x, after({.half_width = 0.05, .shift = shift, .seen = mirrored}));
  const Disturbance left = after({.half_width = 0.05, .shift = shift, .seen = narrow});
  same(left, after({.half_width = 0.05, .shift = shift, .seen = narrow_mirrored}));
  EXPECT_NEAR(left.furrow->column * static_cast<double>(left.furrow->columns), nz * d - 0.012, 1e-6);
}

/// A box that is strained upward by e has 1/(1 + e) of its solid: from pi/6 of the cubic lattice the porosity rises by
/// pi/6 e/(1 + e), 0.0476 for a tenth. Deep inside that is exact up to the lattice's ripple under a kernel of two
/// diameters' reach; the edge of what exceeds 0.02 lies within half a cell of the box's.
TEST(Disturbance, LoosenedAreaIsWherePorosityHasRisen) {
  const Disturbance found = after({.half_width = 0.15, .depth = 0.2, .strain = 0.1});
  ASSERT_TRUE(found.furrow) << found.why;
  const Furrow& f = *found.furrow;
  const std::size_t column = f.columns / 2, row = static_cast<std::size_t>((-0.1 - f.y0) / f.cell);
  const double expected = M_PI / 6 * 0.1 / 1.1;
  EXPECT_NEAR(f.loosened[row * f.columns + column], expected, 0.15 * expected);
  // 15 columns of 2 cm, from the bottom at -0.2 up to one cell below the surface before.
  const double width = 0.3, height = 0.2 - d;
  EXPECT_GT(f.loosened_area, (width - 2 * d) * (height - 2 * d));
  EXPECT_LT(f.loosened_area, (width + 2 * d) * (height + 2 * d));
  const Disturbance lifted = after({.half_width = 1, .shift = {0.1, 0, 0}});
  ASSERT_TRUE(lifted.furrow);
  EXPECT_EQ(lifted.furrow->loosened_area, 0) << "sheared as a whole: nothing is looser";
}

TEST(Disturbance, FurrowHasDepthWidthAndRidges) {
  const Disturbance found = after({.half_width = 0.05, .shift = {0, -0.015, 0}});
  ASSERT_TRUE(found.furrow) << found.why;
  EXPECT_NEAR(found.furrow->depth, 0.015, 1e-6);
  EXPECT_NEAR(found.furrow->width, 5 * d, 1e-8);
  EXPECT_NEAR(found.furrow->furrow_area, 5 * d * 0.015, 1e-8);
  EXPECT_TRUE(std::isnan(found.furrow->ridge_to_ridge)) << "no side rose";
  EXPECT_LT(found.furrow->swell, 0);
}

/// The summary holds what the frames tell, by the same code; specific draft is the mean draft over the disturbed area.
TEST(Disturbance, StandsInTheSummary) {
  const RunDirectory dir;
  const std::string text = dir.scenario(trench);
  ASSERT_EQ(run_scenario(text, dir / "out", {"output.every=50 ms"}), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out"), &found = summary.at("disturbance");
  ASSERT_FALSE(found.contains("none")) << found;
  const Disturbance again = disturbance_of(dir / "out");
  ASSERT_TRUE(again.furrow);
  EXPECT_EQ(found.at("disturbed area [m2]").get<double>(), again.furrow->disturbed_area);
  EXPECT_EQ(found.at("profile").at("surface after [m]").size(), again.furrow->z.size());
  EXPECT_GT(found.at("disturbed area [m2]").get<double>(), 0);
  const double draft = summary.at("tools").at("tool").at("draft [N]").at("mean");
  EXPECT_NEAR(found.at("specific draft [N/m2]").get<double>() * again.furrow->disturbed_area, draft,
              1e-9 * std::abs(draft));
}

/// A first frame with the tool in the soil shows no soil before the pass up to a depth ahead of the tip: at 0.2 s that
/// is at 140 mm, 30 mm deep, in soil of 20 mm diameters.
TEST(Disturbance, TheStretchBeginsAheadOfTheToolInTheFirstFrame) {
  const RunDirectory dir;
  std::string late = trench;
  late.replace(late.find("every: 0.2 s, series"), 20, "at: [0.2 s, 0.79 s], series");
  ASSERT_EQ(run_scenario(dir.scenario(late), dir / "out"), exit_ok);
  const Disturbance found = disturbance_of(dir / "out");
  ASSERT_TRUE(found.furrow) << found.why;
  EXPECT_NEAR(found.furrow->from, 0.17, 0.011) << "the tip is within half the tool's length of 140 mm";
}

/// Frames of a part of the soil do not tell what the pass has done to it.
TEST(Disturbance, NeedsAllSoilInTheFrames) {
  const RunDirectory dir;
  const std::string text = dir.scenario(trench);
  ASSERT_EQ(run_scenario(text, dir / "out", {"output.region={size: 0.4 0.2 0.04 m, at: 0 -0.1 0 m}"}), exit_ok);
  const nlohmann::json none = summary_of(dir / "out").at("disturbance").at("none");
  EXPECT_NE(none.get<std::string>().find("`output.region`"), std::string::npos) << none;
}

/// Whether disturbed soil reaches a wall is what the run has warned of: in a bed of twice the width the floor is
/// reached below the tool, and not over the stretch of the furrow.
TEST(Disturbance, WallsAreReachedWhereTheRunWarns) {
  const RunDirectory dir;
  const std::string text = dir.scenario(trench);
  const auto said = [&](const char* name, std::vector<std::string> sets) {
    sets.insert(sets.end(), {"output.every=50 ms", "soil.container.at=0 -0.2 -0.08 m"});
    EXPECT_EQ(run_scenario(text, dir / name, sets), exit_ok);
    const nlohmann::json summary = summary_of(dir / name);
    const nlohmann::json& found = summary.at("disturbance").at(reaches_wall_key);
    const bool warned = summary.at("warnings").dump().find("disturbed soil reaches") != std::string::npos;
    EXPECT_EQ(found.is_boolean() && found.get<bool>(), warned) << name << found << summary.at("warnings");
    return found;
  };
  const std::string wide = "soil.container.size=0.4 0.2 0.16 m";
  EXPECT_EQ(said("shallow", {wide, "time.end=0.2 s"}), true);
  EXPECT_EQ(said("deep", {wide, "time.end=0.2 s", "soil.bed.depth=160 mm"}), false);
}

/// A tool that goes towards -x, with a watch along -x as one has it from another scenario: the report's specific draft
/// is that of the summary, positive against the travel.
TEST(Disturbance, SpecificDraftIsAgainstTheTravel) {
  const RunDirectory dir;
  const std::string text = dir.scenario(trench);
  ASSERT_EQ(run_scenario(text, dir / "out",
                         {"output.every=50 ms", "soil.container.open after settling=[-x]",
                          "boundaries.tool.at=340 10 0 mm", "boundaries.tool.moves=[{velocity: -0.4 0 0 m/s}]"}),
            exit_ok);
  const double by_summary = summary_of(dir / "out").at("disturbance").at("specific draft [N/m2]");
  EXPECT_GT(by_summary, 0);
  EXPECT_LT(summary_of(dir / "out")["columns"]["draft"]["mean in window"].get<double>(), 0);
  const RunFolder folder = read_run_folder(dir / "out");
  const Disturbance found = disturbance_of(dir / "out");
  ASSERT_TRUE(found.tool && found.furrow);
  int seen = 0;
  for (const ReportNumber& n : numbers_of_soil(folder, *found.tool, found.furrow)) {
    if (n.quantity != "specific draft") continue;
    EXPECT_EQ(n.value, by_summary);
    ++seen;
  }
  EXPECT_EQ(seen, 1);
}

/// On a page with a window of its own it is that window's draft, here of the rows of 1 ms, over the area of the pass.
TEST(Disturbance, SpecificDraftIsOfTheWindowOfThePage) {
  const RunDirectory dir;
  const std::string text = dir.scenario(trench);
  ASSERT_EQ(run_scenario(text, dir / "out", {"output.every=50 ms"}), exit_ok);
  const RunFolder folder = read_run_folder(dir / "out", TimeWindow{0.2, 0.3, "as asked"});
  const Disturbance found = disturbance_of(dir / "out");
  ASSERT_TRUE(found.tool && found.furrow);
  double sum = 0, rows = 0;
  const std::vector<double>&time = folder.series->at("time"), &draft = folder.series->at("draft");
  for (std::size_t i = 0; i < time.size(); ++i)
    if (time[i] > 0.2 + 1e-6 && time[i] < 0.3 + 1e-6) sum += draft[i], ++rows;
  ASSERT_EQ(rows, 100);
  int seen = 0;
  for (const ReportNumber& n : numbers_of_soil(folder, *found.tool, found.furrow)) {
    if (n.quantity != "specific draft") continue;
    EXPECT_NEAR(n.value * found.furrow->disturbed_area, sum / rows, 1e-6 * std::abs(sum / rows));
    EXPECT_EQ(n.window.from, 0.2);
    const double of_run = summary_of(dir / "out").at("disturbance").at("specific draft [N/m2]");
    EXPECT_GT(std::abs(n.value - of_run), 1e-3 * std::abs(of_run)) << "the run has another window";
    ++seen;
  }
  EXPECT_EQ(seen, 1);
}

/// Each tool has the draft against its own way; there is no specific draft of two that go against each other.
TEST(Disturbance, OfToolsThatTravelAgainstEachOther) {
  const RunDirectory dir;
  std::string text = trench;
  const std::string tool = "boundaries:\n";
  text.replace(text.find(tool), tool.size(),
               tool +
                   "  - {name: other, material: steel, shape: {box: 20 80 20 mm}, at: 340 10 0 mm, moves: [{velocity: "
                   "-0.3 0 0 m/s}]}\n");
  ASSERT_EQ(run_scenario(dir.scenario(text), dir / "out",
                         {"output.every=50 ms", "time.end=0.3 s", "soil.container.open after settling=[]",
                          "boundaries.tool.moves=[{velocity: 0.3 0 0 m/s}]"}),
            exit_ok);
  const nlohmann::json summary = summary_of(dir / "out");
  EXPECT_GT(summary.at("tools").at("tool").at("draft [N]").at("mean").get<double>(), 0);
  EXPECT_GT(summary.at("tools").at("other").at("draft [N]").at("mean").get<double>(), 0);
  for (const char* key : {"specific draft [N/m2]", "specific draft, interval 95 % [N/m2]"})
    EXPECT_TRUE(summary.at("disturbance").at(key).is_null()) << key;
  EXPECT_NE(summary.at("warnings").dump().find("other and tool travel against each other"), std::string::npos)
      << summary.at("warnings");
}

/// 60 mm forth and 160 mm back: the draft is against the way that it has come in all, as the column of a machine has
/// it.
TEST(Disturbance, DraftIsAgainstTheWayInAll) {
  const RunDirectory dir;
  const std::string text = dir.scenario(trench);
  ASSERT_EQ(
      run_scenario(
          text, dir / "out",
          {"time.end=0.55 s", "soil.container.open after settling=[]", "boundaries.tool.at=200 10 0 mm",
           "output.window={from: 0.2 s}",
           "boundaries.tool.moves=[{velocity: 0.4 0 0 m/s, until: 0.15 s}, {velocity: -0.4 0 0 m/s, from: 0.15 s}]"}),
      exit_ok);
  const nlohmann::json summary = summary_of(dir / "out");
  const double draft = summary.at("tools").at("tool").at("draft [N]").at("mean");
  EXPECT_NEAR(draft, -summary.at("columns").at("draft").at("mean in window").get<double>(), 1e-9 * std::abs(draft));
  EXPECT_GT(draft, 0);
}

TEST(Disturbance, IsDrawn) {
  if (!gnuplot_found()) GTEST_SKIP() << "no gnuplot: scripts/setup installs it";
  const RunDirectory dir;
  const std::string text = dir.scenario(trench);
  ASSERT_EQ(run_scenario(text, dir / "out", {"output.every=50 ms"}), exit_ok);
  draw_furrow(dir / "out", dir / "furrow.svg");
  std::ifstream file(dir / "furrow.svg");
  const std::string svg((std::istreambuf_iterator<char>(file)), {});
  EXPECT_NE(svg.find("surface after"), std::string::npos);
  EXPECT_NE(svg.find("rise of porosity"), std::string::npos);
}

TEST(Disturbance, SaysWhyThereIsNone) {
  const RunDirectory dir;
  const std::string text = dir.scenario(trench);
  ASSERT_EQ(run_scenario(text, dir / "out", {"time.end=80 ms", "output.every=20 ms"}), exit_ok);
  const nlohmann::json summary = summary_of(dir / "out");
  EXPECT_TRUE(summary.at("disturbance").contains("none")) << summary.at("disturbance");
  EXPECT_THROW(draw_furrow(dir / "out", dir / "furrow.svg"), std::invalid_argument);
}

}  // namespace
}  // namespace subsoil::sim::test::disturbance_test
