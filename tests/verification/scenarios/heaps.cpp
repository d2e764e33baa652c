#include <algorithm>
#include <numbers>

#include "tests/tools/program_runs.hpp"

/// A heap of dry spheres and a block of wet ones (configs/heap-dry.yaml, heap-wet.yaml).
/// Oracle: no closed form exists for frictional spheres; dry ones must lie between the angle of frictionless ones (none)
/// and Coulomb's arctan(mu_wall = 0.8), with a scatter over packings, and less friction must make a flatter heap. Wet
/// ones stand by cohesion: c = mu F/p^2 = 22 kPa at most, a face stands up to 4 c/(rho g) = 5 m, the block is 0.12 m high.
namespace subsoil::app {
namespace {

/// Angle of the slopes, rad: the mean over the four directions of a line through the tops of the spheres that lie within
/// 40 mm of the plane through the heap's axis, from 40 mm off the axis (its tip is round) to 30 mm off the edge.
double repose_angle(const std::vector<dem::Vec3>& spheres, double half) {
  constexpr int bins = 6;
  double angle = 0;
  for (int side = 0; side < 4; ++side) {
    double top[bins];
    std::fill(std::begin(top), std::end(top), 0.0);
    const double from = 0.04, to = half - 0.03;
    for (const dem::Vec3& p : spheres) {
      const double out = side == 0 ? p.x : side == 1 ? -p.x : side == 2 ? p.z : -p.z, across = side < 2 ? p.z : p.x;
      if (std::abs(across) > 0.04 || out < from || out >= to || p.y < 0) continue;
      double& highest = top[static_cast<int>((out - from) / (to - from) * bins)];
      highest = std::max(highest, p.y + 0.01);
    }
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (int b = 0; b < bins; ++b) {
      const double x = from + (b + 0.5) * (to - from) / bins;
      sx += x, sy += top[b], sxx += x * x, sxy += x * top[b];
    }
    angle += std::atan(-(bins * sxy - sx * sy) / (bins * sxx - sx * sx)) / 4;
  }
  return angle;
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
    EXPECT_GT(angle, 10);
    EXPECT_LT(angle, std::atan(0.8) * 180 / std::numbers::pi);
    sum += angle, squares += angle * angle;
  }
  const double mean = sum / 3, deviation = std::sqrt(std::max(0.0, (squares - 3 * mean * mean) / 2));
  std::printf("angle of repose: %.1f deg, standard deviation %.1f deg over three packings\n", mean, deviation);
  EXPECT_LT(deviation, 4) << "more is no property of the material";
  const double slippery =
      angle_of_run(dir / "slippery", {"contacts[0].mu=0.05", "contacts[0].mu_r=0", "contacts[1].mu=0.05", "contacts[1].mu_r=0"});
  std::printf("with mu = 0.05 and no rolling resistance: %.1f deg\n", slippery);
  EXPECT_LT(slippery, 0.5 * mean);
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
}  // namespace subsoil::app
