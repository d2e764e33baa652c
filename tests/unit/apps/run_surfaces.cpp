#include <gtest/gtest.h>

#include <cmath>

#include "libsim/io/series.hpp"
#include "libsim/setup/world.hpp"
#include "tests/tools/program_runs.hpp"

/// Every named surface of a body has columns and a block of its own, also where one boundary of the bed carries
/// several. Surfaces on given paths.
namespace subsoil::sim::run_surfaces {
namespace {

using namespace test;

/// A body that is held, with two shelves apart and a sphere over each: 20 mm and 10 mm of radius.
constexpr const char* shelves = R"(subsoil: 1
materials:
  stone: {density: 2000 kg/m^3}
  steel: {density: 7850 kg/m^3}
contacts:
  - {between: [stone, stone], law: linear, k_n: 20 kN/m, restitution: 0.3, mu: 0.5}
  - {between: [stone, steel], law: linear, k_n: 20 kN/m, restitution: 0.1, mu: 0.5}
soil:
  bed:
    fill: particles
    material: stone
    particles:
      - {position: -0.1 0.031 0 m, radius: 20 mm}
      - {position: 0.1 0.021 0 m, radius: 10 mm}
machine:
  bodies:
    rack: {mass: 5 kg, inertia: 1 kg m^2, at: 0 0 m}
  joints:
    held: {fixed: [ground, rack], at: 0 0 m}
  surfaces:
    left: {body: rack, material: steel, box: 100 20 100 mm, at: -0.1 0 0 m}
    right: {body: rack, material: steel, box: 100 20 100 mm, at: 0.1 0 0 m}
time: {end: 0.4 s}
output: {every: 0.1 s, monitor: {on the right: {soil force: right, along: 0 1}}}
)";

double mean_of_last(const std::vector<double>& values, std::size_t rows) {
  double sum = 0;
  for (std::size_t i = values.size() - rows; i < values.size(); ++i) sum += values[i];
  return sum / static_cast<double>(rows);
}

TEST(RunSurfaces, EachCarriesTheWeightOfWhatLiesOnIt) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(shelves), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const auto weight = [](double r) { return 2000 * 4.0 / 3 * 3.141592653589793 * r * r * r * 9.81; };
  // At rest over the last 50 ms: what is left of the bounce is below 0.1 % after twenty half periods at 0.1.
  EXPECT_NEAR(mean_of_last(series.at("left.Fy"), 50), -weight(0.02), 1e-3 * weight(0.02));
  EXPECT_NEAR(mean_of_last(series.at("right.Fy"), 50), -weight(0.01), 1e-3 * weight(0.01));
  EXPECT_EQ(series.at("on the right"), series.at("right.Fy"));
  // Moment of a weight on an arm of 0.1 m about the body's centre, on either side.
  EXPECT_NEAR(mean_of_last(series.at("left.Mz"), 50), 0.1 * weight(0.02), 1e-3 * weight(0.02));
  EXPECT_NEAR(mean_of_last(series.at("right.Mz"), 50), -0.1 * weight(0.01), 1e-3 * weight(0.01));
  for (std::size_t row = 0; row < series.rows(); ++row)
    EXPECT_NEAR(series.at("rack.soil.Fy")[row], series.at("left.Fy")[row] + series.at("right.Fy")[row],
                1e-7 * weight(0.02))
        << "nine digits of the file, row " << row;
}

TEST(RunSurfaces, EachIsABlockOfTheFrames) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(shelves), dir / "out", {"time.end=1 ms"}), exit_ok);
  const auto file = h5::open_file(dir / "out" / "run.h5");
  for (const char* name : {"left", "right"}) {
    ASSERT_TRUE(h5::exists(file, std::string("/surfaces/") + name)) << name;
    EXPECT_EQ(h5::shape(file, std::string("/surfaces/") + name + "/triangles").at(0), 12U) << "a box";
  }
}

BoundarySection moving(const Vec3& at, std::vector<Move> moves) {
  BoundarySection b;
  b.at = at, b.moves = std::move(moves);
  return b;
}
void expect_pose(const BoundarySection& b, double t, const Vec3& place, double angle) {
  const dem::Pose pose = motion_of(b)(t);
  EXPECT_LT(norm(pose.position - place), 1e-14) << "at " << t;
  const Vec3 arm = pose.attitude.rotate({1, 0, 0});
  EXPECT_LT(norm(arm - Vec3{std::cos(angle), std::sin(angle), 0}), 1e-14) << "at " << t;
}

/// A roller that has travelled spins about where it is.
TEST(Moves, ASpinFollowsThePlace) {
  const Move travel{.velocity = {0.5, 0, 0}, .about = {}, .until = 1}, spin{.spin = {0, 0, 3}, .about = {}, .from = 1};
  for (const std::vector<Move>& moves : {std::vector{travel, spin}, {spin, travel}}) {
    expect_pose(moving({0, 0.1, 0}, moves), 0.5, {0.25, 0.1, 0}, 0);
    expect_pose(moving({0, 0.1, 0}, moves), 2, {0.5, 0.1, 0}, 3);
  }
}

/// A wheel on an arm: its place goes round the arm's pivot, which travels; its own spin beside does not move it.
TEST(Moves, SpinsAboutTheOwnPlaceAndAboutAPivotAddUp) {
  const Move round{.spin = {0, 0, 2}, .about = Vec3{1, 0, 0}}, own{.spin = {0, 0, 5}, .about = {}, .from = 0.2},
      travel{.velocity = {0, -0.3, 0.1}, .about = {}};
  for (const std::vector<Move>& moves : {std::vector{round, own, travel}, {travel, own, round}, {own, travel, round}})
    for (const double t : {0.1, 0.7}) {
      const Vec3 pivot = Vec3{1, 0, 0} + t * travel.velocity;
      expect_pose(moving({1.4, 0, 0}, moves), t, pivot + 0.4 * Vec3{std::cos(2 * t), std::sin(2 * t), 0},
                  2 * t + 5 * std::max(0.0, t - 0.2));
    }
}

/// One after the other about other axes and points: the product of both rotations, the later one outside.
TEST(Moves, SpinsOfDifferentAxesFollowEachOther) {
  const Move first{.spin = {0, 0, 1.5}, .about = Vec3{}, .until = 1},
      then{.spin = {0, 2, 0}, .about = Vec3{0, 0, 1}, .from = 1};
  const auto z = dem::Quaternion::from_rotation_vector({0, 0, 1.5}),
             y = dem::Quaternion::from_rotation_vector({0, 1, 0});
  const dem::Pose pose = motion_of(moving({0.2, 0, 0}, {then, first}))(1.5);
  EXPECT_LT(norm(pose.position - (Vec3{0, 0, 1} + y.rotate(z.rotate({0.2, 0, 0}) - Vec3{0, 0, 1}))), 1e-15);
  EXPECT_LT(norm(pose.attitude.rotate({1, 2, 3}) - y.rotate(z.rotate({1, 2, 3}))), 1e-14);
}

/// Four spheres stand on the floor and lean on wall +x, at rest and without friction. Moments about the world's origin
/// are those of the places as they are once the bed is at its datum: the tops at y = 0, so the centres a radius below.
///     wall +x:  Fx = 4 m g_x,  Mz = -y Fx with y = -r
///     all:      M = sum x_i x m g
TEST(RunSurfaces, MomentsOfWallsAreAboutTheOriginOfABedThatWasShifted) {
  const RunDirectory dir;
  ASSERT_EQ(run_scenario(dir.scenario(R"(subsoil: 1
gravity: 3 -9 0 m/s^2
materials: {soil: {density: 2600 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 50 kN/m, restitution: 0.4, mu: 0}
  - {<<: *dry, between: [soil, steel]}
soil:
  container: {size: 40 60 40 mm, at: 0 -160 0 mm, material: steel}
  surface: 0 m
  bed: {fill: lattice, pitch: 20 mm, material: soil, radius: 10 mm, depth: 20 mm, settle: {until: 0.01 mm/s}}
time: {end: 0.2 s}
output: {every: 0.2 s, precision: double, series digits: all, monitor: {M: {soil moment: wall +x}}}
)"),
                         dir / "out"),
            exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const double r = 0.01, m = 2600 * 4.0 / 3 * M_PI * r * r * r, wall = 4 * m * 3;
  EXPECT_NEAR(series.at("wall +x.Fx").back(), wall, 1e-3 * wall);
  EXPECT_NEAR(series.at("wall +x.Mz").back(), r * wall, 1e-3 * r * wall);
  EXPECT_NEAR(series.at("M").back(), r * wall, 1e-3 * r * wall);
  dem::Vec3 expected, sum;
  for (const dem::Vec3& x : frame_positions(dir / "out", 1)) expected += dem::cross(x, m * dem::Vec3{3, -9, 0});
  for (const char* name : {"wall -x", "wall +x", "floor", "wall -z", "wall +z"}) {
    const auto last = [&](const char* of) { return series.at(name + std::string(of)).back(); };
    sum += {last(".Mx"), last(".My"), last(".Mz")};
  }
  EXPECT_LT(dem::norm(sum - expected), 1e-3 * dem::norm(expected));
}

/// A surface that stands in a settled bed takes away what it overlaps, box or plane, as one that moves does: the bed
/// begins at rest, with no more in its contacts than without it. Asked to refuse, it names itself.
TEST(RunSurfaces, StandInABedThatHasSettled) {
  const auto with = [](const std::string& shape, const char* rule, std::string* refused) {
    const RunDirectory dir;
    const std::string text = fmt::format(R"(subsoil: 1
materials: {{soil: {{density: 2600 kg/m^3}}, steel: {{density: 7850 kg/m^3}}}}
contacts:
  - &dry {{between: [soil, soil], law: linear, k_n: 50 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.2}}
  - {{<<: *dry, between: [soil, steel], mu: 0.3}}
soil:
  container: {{size: 0.16 0.1 0.1 m, at: 0 -0.1 -0.05 m, material: steel}}
  surface: 0 m
  bed: {{fill: random, material: soil, radius: 10 mm, depth: 60 mm, inside machine: {}}}
boundaries: [{{name: stone, material: steel, shape: {}, at: 0.08 -0.03 0 m}}]
time: {{end: 5 ms}}
output: {{every: 5 ms, series every: 1 ms, forces: instant}}
)",
                                         rule, shape);
    if (refused != nullptr) {
      *refused = subsoil::test::message_of<ScenarioError>([&] { run_scenario(dir.scenario(text), dir / "out"); });
      return 0.0;
    }
    EXPECT_EQ(run_scenario(dir.scenario(text), dir / "out"), exit_ok) << shape;
    const nlohmann::json summary = summary_of(dir / "out");
    EXPECT_GT(summary["soil"]["carved for the machine"].get<int>(), 5) << shape;
    EXPECT_LT(summary["run"]["largest overlap [share of a radius]"].get<double>(), 0.05) << shape;
    const Series series = read_series(dir / "out" / "series.csv");
    return series.at("soil.stored").front();
  };
  const double heavy = 2600 * 0.6 * 0.16 * 0.1 * 0.06 * 9.81 * 0.06;  // J, of the bed's weight along its depth
  for (const char* shape : {"{box: 40 40 40 mm}", "{plane: {point: 0 0 0 m, normal: 1 0 0}}"}) {
    EXPECT_LT(with(shape, "carve", nullptr), 0.05 * heavy) << shape;
    std::string refused;
    with(shape, "refuse", &refused);
    EXPECT_NE(refused.find("lie inside or overlap `stone` at the start"), std::string::npos) << refused;
  }
}

/// Grains that are rained into a narrow region above the floor roll away below it, and never fill it to a depth.
TEST(RunSurfaces, ARegionThatGrainsLeaveIsRefused) {
  const RunDirectory dir;
  const std::string text = R"(subsoil: 1
materials: {soil: {density: 2600 kg/m^3}}
contacts: [{between: [soil, soil], law: linear, k_n: 5 kN/m, restitution: 0.4, mu: 0.3}]
soil:
  container: {size: 100 150 100 mm, at: 0 0 0 m, material: soil}
  bed: {fill: random, material: soil, radius: 4 mm, depth: 40 mm, region: {size: 40 60 40 mm, at: 30 40 30 mm}}
time: {end: 1 ms}
)";
  const std::string message =
      subsoil::test::message_of<ScenarioError>([&] { run_scenario(dir.scenario(text), dir / "out"); });
  EXPECT_NE(message.find("roll or fall out of it; make `region` as wide as the container"), std::string::npos)
      << message;
}

}  // namespace
}  // namespace subsoil::sim::run_surfaces
