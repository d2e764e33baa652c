#include <map>

#include "libdem/particles/particles.hpp"
#include "tests/tools/program_runs.hpp"

/// Steady flow down a rough incline between periodic sides (configs/inclined-flow.yaml).
/// Oracle: balance of momentum; Bagnold's profile, which follows from a shear stress that goes with the square of the
/// shear rate at a solid fraction that does not depend on the depth (Silbert et al., Phys. Rev. E 64 (2001) 051302,
/// find both).
namespace subsoil::app::inclined_flow {
namespace {

constexpr double from = 5, until = 8;  // s, of steady flow
constexpr double diameter = 0.01, period_x = 0.111, period_z = 0.0666, slope = 24 * M_PI / 180;

struct Slice {
  double count = 0, velocity = 0, volume = 0;
};

/// By slices of a diameter, mean over the frames: velocity along the plane, m/s, and solid fraction.
std::map<int, Slice> profile(const std::filesystem::path& out) {
  const auto file = h5::open_file(out / "run.h5");
  const std::vector<float> radius = h5::read<float>(file, "/particles/radius");
  const std::vector<double> times = test::frame_times(out);
  std::map<int, Slice> slices;
  double frames = 0;
  for (std::size_t f = 0; f < times.size(); ++f) {
    if (times[f] < from) continue;
    ++frames;
    char group[48];
    std::snprintf(group, sizeof group, "/frames/%06zu/", f);
    const std::vector<float> x = h5::read<float>(file, group + std::string("position")),
                             v = h5::read<float>(file, group + std::string("velocity"));
    for (std::size_t i = 0; i < radius.size(); ++i) {
      EXPECT_TRUE(x[3 * i] >= 0 && x[3 * i] <= period_x && x[3 * i + 2] >= 0 && x[3 * i + 2] <= period_z);
      Slice& s = slices[static_cast<int>(std::floor(x[3 * i + 1] / diameter))];
      ++s.count, s.velocity += v[3 * i], s.volume += dem::sphere_volume(radius[i]);
    }
  }
  for (auto& [k, s] : slices) s.velocity /= s.count, s.volume /= frames * diameter * period_x * period_z;
  return slices;
}

double mean(const Series& series, const char* column) {
  double sum = 0, rows = 0;
  for (std::size_t k = 0; k < series.rows(); ++k)
    if (series.at("time")[k] > from) sum += series.at(column)[k], ++rows;
  return sum / rows;
}

/// The layer's momentum changes by some 0.05 m/s of its mass in 3 s: 0.002 g; spheres that jump count as its weight.
TEST(InclinedFlow, TheFloorCarriesWeightAndShear) {
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(test::config("inclined-flow"), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const double weight = 9.81 * test::summary_of(dir / "out")["soil"]["mass [kg]"].get<double>();
  EXPECT_NEAR(mean(series, "load"), weight * std::cos(slope), 0.01 * weight);
  EXPECT_NEAR(mean(series, "shear"), weight * std::sin(slope), 0.01 * weight);

  const std::map<int, Slice> slices = profile(dir / "out");
  int top = 0;
  while (slices.contains(top + 1) && slices.at(top + 1).volume > 0.3) ++top;
  ASSERT_GE(top, 12);
  double fraction = 0, inner = 0;
  for (int k = 3; k <= top - 3; ++k) fraction += slices.at(k).volume, ++inner;
  fraction /= inner;
  EXPECT_TRUE(fraction > 0.53 && fraction < 0.6) << fraction;
  for (int k = 3; k <= top - 3; ++k) EXPECT_NEAR(slices.at(k).volume, fraction, 0.04 * fraction) << k;

  // v = v_s (1 - (1 - y/h)^1.5) from the fixed layer to the surface; a straight line misses the middle by 0.12 v_s.
  const double floor = diameter, h = (top + 1) * diameter - floor;
  const auto bagnold = [&](int k) { return 1 - std::pow(1 - ((k + 0.5) * diameter - floor) / h, 1.5); };
  double products = 0, squares = 0;
  for (int k = 2; k <= top - 1; ++k) {
    products += bagnold(k) * slices.at(k).velocity;
    squares += bagnold(k) * bagnold(k);
  }
  const double v_s = products / squares;
  EXPECT_GT(v_s, 3 * std::sqrt(9.81 * diameter));
  for (int k = 2; k <= top - 1; ++k) EXPECT_NEAR(slices.at(k).velocity, v_s * bagnold(k), 0.06 * v_s) << k;
}

}  // namespace
}  // namespace subsoil::app::inclined_flow
