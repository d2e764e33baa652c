#include "tests/tools/program_runs.hpp"

/// A rod pushed through loose topsoil into a pan (configs/layers.yaml), beside the same bed of topsoil alone.
/// Oracle: order. A material with more friction and with attraction resists more, and only where the rod is near it;
/// the spheres' materials in the file are those of their depth at the start.
namespace subsoil::sim::layers {
namespace {

/// Mean of the rod's resistance between two depths of its foot, which starts 5 mm above the surface at 0.2 m/s.
double resistance(const Series& series, double from, double to) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < series.rows(); ++i) {
    const double depth = 0.2 * series.at("time")[i] - 0.005;
    if (depth >= from && depth < to) sum += series.at("resistance")[i], ++count;
  }
  return sum / count;
}

TEST(Layers, PanResistsWhereTheRodComesNearIt) {
  const test::RunDirectory dir;
  // Under a rod of three diameters loose grains scatter by tens of percent: the ratios of four packings are 1.3,
  // 0.9, 2.0, 1.5 in the topsoil and 1.5, 4.5, 2.3, 4.5 at the pan. The bounds lie between those of three together, 1.4
  // and 2.2.
  double above[2] = {0, 0}, at_pan[2] = {0, 0};
  for (const char* seed : {"1", "2", "3"})
    for (const bool pan : {true, false}) {
      const std::string out = std::string(pan ? "two" : "one") + seed;
      std::vector<std::string> sets{std::string("soil.bed.seed=") + seed};
      if (!pan) sets.emplace_back("soil.bed.layers[1].material=topsoil");
      ASSERT_EQ(test::run_scenario(test::config("layers"), dir / out, sets), exit_ok);
      const Series series = read_series(dir / out / "series.csv");
      above[pan] += resistance(series, 0.005, 0.025), at_pan[pan] += resistance(series, 0.033, 0.037);
    }
  EXPECT_LT(above[1] / above[0], 1.8);
  EXPECT_GT(at_pan[1] / at_pan[0], 1.8);

  const nlohmann::json layers = test::summary_of(dir / "two1")["soil"]["layers"];
  ASSERT_EQ(layers.size(), 2U);
  EXPECT_EQ(layers[0]["material"], "topsoil");
  // Heights of a bed of some hundred spheres are known to a step of one sphere in one of nine columns.
  EXPECT_NEAR(layers[0]["thickness [m]"].get<double>(), 0.035, 0.003);
  EXPECT_NEAR(layers[1]["thickness [m]"].get<double>(), 0.035, 0.003);
  const double interface = layers[1]["top [m]"].get<double>();

  const auto file = h5::open_file(dir / "two1/run.h5");
  EXPECT_EQ(h5::read_text(file, "/particles/material names"), (std::vector<std::string>{"topsoil", "pan", "steel"}));
  const std::vector<std::int64_t> material = h5::read<std::int64_t>(file, "/particles/material");
  const std::vector<dem::Vec3> at = test::frame_positions(dir / "two1", 0);
  ASSERT_EQ(material.size(), at.size());
  for (std::size_t i = 0; i < at.size(); ++i)  // a rough interface: a diameter of the larger spheres
    EXPECT_TRUE(material[i] == 0 ? at[i].y > interface - 0.012 : at[i].y < interface + 0.006) << at[i].y;
}

}  // namespace
}  // namespace subsoil::sim::layers
