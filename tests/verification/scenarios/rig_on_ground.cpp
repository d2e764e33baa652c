#include <cmath>

#include "tests/tools/program_runs.hpp"

/// The 1S-300 rig with its depth wheels on ground elements (configs/1s300-ground.yaml).
/// Oracles: statics of the whole machine, which knows nothing of the ground's law; Bekker's load of a wheel, whose
/// power the config writes down, at the sinkages of the rig's published equilibria; the rut.
namespace subsoil::sim::rig_on_ground {
namespace {

/// Load of a rigid wheel on Bekker's soil as the rig's wheel law has it: 0.12 m wide, radius 0.2 m.
double bekker_load(double z) {
  const double b = 0.12, n = 1.3126, k = 1434.81e3 / b + 165.79e3;
  return b * k * std::sqrt(2 * 0.2) * (3 - n) / 3 * std::pow(z, n + 0.5);
}

struct Pass {
  Series series;
  double at(const char* column, double t) const {
    std::size_t i = 0;
    while (series.at("time")[i] < t - 1e-9) ++i;
    return series.at(column)[i];
  }
  double mean(const char* column, double from, double to) const {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < series.rows(); ++i)
      if (series.at("time")[i] >= from && series.at("time")[i] <= to) sum += series.at(column)[i], ++count;
    return sum / count;
  }
};

TEST(RigOnGround, WheelsSinkCarryAndRememberTheirRut) {
  // Sinkage and load per wheel of the published equilibria: what the element's power law must give, to the four digits
  // of the sinkage, 1.8 x 0.05 mm/28 mm = 0.3 %.
  for (const auto& [z, load] : {std::pair{0.0282, 805.1}, {0.0294, 864.9}, {0.0304, 920.4}, {0.0313, 969.4}})
    EXPECT_NEAR(bekker_load(z), load, 0.0033 * load);

  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(test::config("1s300-ground"), dir / "out"), exit_ok);
  const Pass pass{read_series(dir / "out" / "series.csv")};
  const double weight = 9.81 * (35.2 + 25 + 25 + 7.8 + 100 + 10 + 68);

  // Towed steadily: wheels and guide carry the machine (to the 1e-6 of the equilibrium's Newton), each wheel by the
  // law; 12.266 kN/m has five digits. Without rolling resistance nothing pulls.
  const double load = pass.at("left ground.force", 0.4), depth = pass.at("left ground.depth", 0.4);
  EXPECT_NEAR(2 * load - pass.at("H1.fy", 0.4), weight, 1e-3);
  EXPECT_NEAR(load, bekker_load(depth), 1e-4 * load);
  EXPECT_EQ(pass.at("right ground.force", 0.4), load);
  EXPECT_NEAR(pass.at("pull", 0.4), 0, 1e-3);
  // The points of the rut are 1 mm apart and the wheel presses at the ends of its steps, 0.5 mm apart: the lowest point
  // is at most 0.5 + 0.25 mm from where the wheel was lowest, (0.75 mm)^2/(2 x 0.2 m).
  EXPECT_NEAR(pass.at("left ground.rut", 0.4), depth, 1.41e-6);

  // Under 700/280 N: the same balance with the load, over many periods of heave and swing (0.25 and 0.12 s). While a
  // wheel rises the points of the rut, 1 mm apart, show as spikes of 32 N each 2 ms, which rows of 1 ms meet unevenly:
  // 5 N in the mean.
  EXPECT_NEAR(2 * pass.mean("left ground.force", 1, 2) - pass.mean("H1.fy", 1, 2), weight + 280, 10);
  EXPECT_NEAR(pass.mean("pull", 1, 2), 700, 7);
  double deepest = 0;
  for (const double z : pass.series.at("left ground.depth")) deepest = std::max(deepest, z);
  EXPECT_GT(deepest, depth + 1e-3);

  // The balance closes to what rtol = 1e-6 leaves, beside the 6 J that the ground takes.
  EXPECT_LT(std::abs(pass.at("energy.balance", 5)), 1e-3);

  // Back over the same ground the rut is what the way out left: the wheel runs in it and cuts no deeper. Between two
  // positions of the way out, 0.5 mm apart, the rut is straight: 1e-4 mm.
  const std::vector<double>&x = pass.series.at("left wheel.x"), &z = pass.series.at("left ground.depth"),
        &time = pass.series.at("time");
  int compared = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (time[i] < 3.5) continue;
    std::size_t k = 0;
    while (x[k] < x[i]) ++k;
    ASSERT_LT(time[k], 3);
    EXPECT_LT(z[i], z[k] + 1e-5) << "at x = " << x[i];
    EXPECT_GT(z[i], z[k] - 0.1e-3) << "at x = " << x[i];
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

}  // namespace
}  // namespace subsoil::sim::rig_on_ground
