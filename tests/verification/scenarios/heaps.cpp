#include <algorithm>
#include <numbers>

#include "tests/tools/program_runs.hpp"

/// A heap of dry spheres and a block of wet ones (configs/heap-dry.yaml, heap-wet.yaml).
/// Oracle: no closed form exists for frictional spheres; the angle is reported with its scatter over packings, must be
/// one that natural grains have (25 to 40 deg, and the scatter), and must vanish with friction. Wet ones stand by
/// cohesion: c = mu F/p^2 = 22 kPa at most, a face stands up to 4 c/(rho g) = 5 m, the block is 0.12 m high.
namespace subsoil::sim::heaps {
namespace {

/// Angle of the slopes, rad: line through the tops of columns one diameter wide, within 2.5 diameters of the planes
/// through the heap's axis, in all four directions, from 2 diameters off the axis (its tip is round) to one off the
/// edge.
double repose_angle(const std::vector<dem::Vec3>& spheres, double half, double radius = 0.01) {
  const double cell = 2 * radius, wide = 5 * radius, from = 4 * radius;
  const int along = static_cast<int>((half - cell - from) / cell + 0.5),
            across = static_cast<int>(2 * wide / cell + 0.5);
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int side = 0; side < 4; ++side) {
    std::vector<double> top(static_cast<std::size_t>(along * across), 0.0);
    for (const dem::Vec3& p : spheres) {
      const double out = side == 0 ? p.x : side == 1 ? -p.x : side == 2 ? p.z : -p.z, aside = side < 2 ? p.z : p.x;
      const int i = static_cast<int>(std::floor((out - from) / cell)),
                j = static_cast<int>(std::floor((aside + wide) / cell));
      if (i < 0 || i >= along || j < 0 || j >= across) continue;
      double& highest = top[static_cast<std::size_t>(i * across + j)];
      highest = std::max(highest, p.y + radius);
    }
    for (int i = 0; i < along; ++i)
      for (int j = 0; j < across; ++j) {
        const double x = from + (i + 0.5) * cell, y = top[static_cast<std::size_t>(i * across + j)];
        n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
      }
  }
  return std::atan(-(n * sxy - sx * sy) / (n * sxx - sx * sx));
}

double angle_of_run(const std::filesystem::path& out, const std::vector<std::string>& sets) {
  EXPECT_EQ(test::run_scenario(test::config("heap-dry"), out, sets), exit_ok);
  return repose_angle(test::frame_positions(out, test::frame_times(out).size() - 1), 0.15) * 180 / std::numbers::pi;
}

TEST(Heaps, DrySpheresLieAtAnAngleOfReposeThatFrictionMakes) {
  const test::RunDirectory dir;
  double sum = 0, squares = 0;
  for (int seed = 1; seed <= 3; ++seed) {
    const double angle = angle_of_run(dir / ("seed" + std::to_string(seed)), {"soil.bed.seed=" + std::to_string(seed)});
    std::printf("angle of repose, seed %d: %.1f deg\n", seed, angle);
    EXPECT_GT(angle, 20) << "flatter than any natural grain";
    EXPECT_LT(angle, 45) << "steeper than any natural grain";
    sum += angle, squares += angle * angle;
  }
  const double mean = sum / 3, deviation = std::sqrt(std::max(0.0, (squares - 3 * mean * mean) / 2));
  std::printf("angle of repose: %.1f deg, standard deviation %.1f deg over three packings\n", mean, deviation);
  EXPECT_LT(deviation, 4) << "more is no property of the material";
  const double slippery = angle_of_run(dir / "slippery", {"time.end=0.7 s", "contacts[0].mu=0.05", "contacts[0].mu_r=0",
                                                          "contacts[1].mu=0.05", "contacts[1].mu_r=0"});
  std::printf("with mu = 0.05 and no rolling resistance: %.1f deg\n", slippery);
  EXPECT_LT(slippery, 0.5 * mean);
}

/// Grains of maize (configs/maize-heap.yaml), and spheres of their volume with the same law: what shape adds. Without
/// resistance to rolling spheres of mu = 0.3 run off but for a layer; clumps lock. The figures of several packings
/// stand in docs/reference/clumps.md; here the first must be as far apart as packings never are, and the clumps'
/// balance must close.
TEST(Heaps, ClumpsLieSteeperThanSpheresOfTheirVolume) {
  const test::RunDirectory dir;
  constexpr double radius = 9.4e-3;  // of a sphere of one grain's volume
  const auto angle = [&](const char* name, const std::vector<std::string>& sets) {
    EXPECT_EQ(test::run_scenario(test::config("maize-heap"), dir / name, sets), exit_ok);
    const std::size_t last = test::frame_times(dir / name).size() - 1;
    return repose_angle(test::frame_positions(dir / name, last), 0.12, radius) * 180 / std::numbers::pi;
  };
  const double clumps = angle("clumps", {});
  const double spheres =
      angle("spheres", {"soil.clumps={}", "soil.bed.clumps=[]", "soil.bed.radius=" + std::to_string(radius) + " m"});
  std::printf("angle of repose of maize: clumps %.1f deg, spheres %.1f deg\n", clumps, spheres);
  EXPECT_GT(clumps, spheres + 5);
  EXPECT_LT(clumps, 45) << "steeper than any natural grain";
  const nlohmann::json summary = test::summary_of(dir / "clumps");
  EXPECT_GT(summary["soil"]["clumps"], 800);
  EXPECT_EQ(summary["soil"]["spheres"].get<int>(), 3 * summary["soil"]["clumps"].get<int>());
  EXPECT_LT(std::abs(summary["energy"]["closure over energy there or put in"].get<double>()), 5e-3);
}

/// The same grains, poured on a board (configs/maize-pour.yaml): a heap, of which few fall over the board's edges.
/// Spheres of their volume spread to a layer, and most of them run off.
TEST(Heaps, PouredClumpsLieSteeperThanPouredSpheres) {
  const test::RunDirectory dir;
  constexpr double radius = 9.4e-3;
  const auto angle = [&](const char* name, const std::vector<std::string>& sets) {
    EXPECT_EQ(test::run_scenario(test::config("maize-pour"), dir / name, sets), exit_ok);
    const std::size_t last = test::frame_times(dir / name).size() - 1;
    return repose_angle(test::frame_positions(dir / name, last), 0.18, radius) * 180 / std::numbers::pi;
  };
  const double clumps = angle("clumps", {});
  const double spheres = angle("spheres", {"soil.clumps={}", "soil.inlets.spout.clumps=[]",
                                           "soil.inlets.spout.radius=" + std::to_string(radius) + " m"});
  std::printf("slope of poured maize: clumps %.1f deg, spheres %.1f deg\n", clumps, spheres);
  EXPECT_GT(clumps, spheres + 5);
  EXPECT_LT(clumps, 45) << "steeper than any natural grain";
  const nlohmann::json summary = test::summary_of(dir / "clumps"), other = test::summary_of(dir / "spheres");
  const double heaviest = 4.92e-3;  // kg, of a kernel
  EXPECT_NEAR(summary["inlets"]["spout"]["mass [kg]"], 4, heaviest) << "2 kg/s for 2 s";
  EXPECT_LT(summary["soil"]["fallen out and removed"], 0.3 * 3 * summary["inlets"]["spout"]["spheres"].get<double>());
  EXPECT_GT(other["soil"]["fallen out and removed"], 0.7 * other["inlets"]["spout"]["spheres"].get<double>());
  EXPECT_LT(std::abs(summary["energy"]["closure over energy there or put in"].get<double>()), 5e-3);
}

TEST(Heaps, WetSpheresStandUpright) {
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(test::config("heap-wet"), dir / "out"), exit_ok);
  const auto extent = [&](std::size_t frame) {
    dem::Vec3 low{1, 1, 1}, high{-1, -1, -1};
    for (const dem::Vec3& p : test::frame_positions(dir / "out", frame))
      for (int d = 0; d < 3; ++d) low[d] = std::min(low[d], p[d]), high[d] = std::max(high[d], p[d]);
    return high - low;
  };
  const std::size_t frames = test::frame_times(dir / "out").size();
  const dem::Vec3 first = extent(0), last = extent(frames - 1);
  EXPECT_GT(last.y, 0.95 * first.y) << "it sagged";
  EXPECT_LT(last.x, 1.1 * first.x) << "it spread";
  EXPECT_LT(last.z, 1.1 * first.z) << "it spread";
  const nlohmann::json soil = test::summary_of(dir / "out")["soil"];
  EXPECT_EQ(soil["fallen out and removed"], 0);
  const std::vector<double> kinetic = read_series(dir / "out" / "series.csv").at("soil.kinetic");
  // Still: what it has left could lift it by a hundredth of a millimetre.
  EXPECT_LT(kinetic.back(), soil["mass [kg]"].get<double>() * 9.81 * 1e-5);
}

}  // namespace
}  // namespace subsoil::sim::heaps
