#include "tests/tools/program_runs.hpp"
#include "tests/tools/verified.hpp"

/// Two wet particles pulled apart quasi-statically (configs/pull-apart.yaml).
/// Oracle: the law's force over the gap as model.md prints it, and its area (K_C dc^2 + K_B dB^2)/2 = 28 mJ.
namespace subsoil::sim::pull_apart {
namespace {

/// Pull of the pair at an overlap of 2 mm less the stretch, from section 2 of model.md (K_C = K_B dB/dc = 7000 N/m).
double pull_of_pair(double stretch) {
  const double k = 7000, d = 0.002;
  if (stretch < d) return k * stretch;          // K_C (dc - delta)
  return std::max(0.0, k * (2 * d - stretch));  // K_B (dB + delta)
}

TEST(PullApart, ForceOverGapIsTheLawsCurveAndItsAreaTwentyEightMillijoule) {
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(test::config("pull-apart"), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const std::vector<double>&x = series.at("right jaw.x"), &pull = series.at("pull"), &left = series.at("left jaw.Fx");
  ASSERT_NEAR(x.front(), 0.017, 1e-9);
  double work = 0, highest = 0;
  const subsoil::test::Verified row("Scenarios", "configs/pull-apart.yaml", "force over gap of the wet law, by hand");
  subsoil::test::Worst worst;
  for (std::size_t i = 1; i < x.size(); ++i) {
    // Forces are means over the interval before the sample, so compare at its middle; each jaw's bond (1 MN/m) gives by
    // F/K. At a kink the mean over 5 um of travel is off by at most K 5 um/8.
    const double middle = 0.5 * (x[i] + x[i - 1]) - 0.017, stretch = middle - 2 * pull[i] / 1e6;
    // 0.05 N is how hard it is to pull two spheres of 7.5 g at 5 mm/s slowly: they ring by m v omega/2 in the bonds.
    char at[32];
    std::snprintf(at, sizeof at, "stretch %.3f mm", stretch * 1e3);
    worst.take(at, pull[i], pull_of_pair(stretch));
    EXPECT_NEAR(left[i], pull[i], 0.05) << "both jaws feel the same";
    work += pull[i] * (x[i] - x[i - 1]);
    highest = std::max(highest, pull[i]);
  }
  const auto within = [](double amount) { return subsoil::test::absolute(amount); };
  const char* const ring = "spheres of 7.5 g ring in the jaws' bonds, m v omega/2";
  worst.near(row, "pull over the gap", "N", within(0.05), ring);
  row.near("maximum pull", "N", highest, 14, within(0.05), ring);
  // 28 mJ and what damping takes, c v^2 t < 1 uJ; the sum over 5 um of travel is exact for straight lines.
  row.near("area under the curve", "J", work, 28e-3, within(2e-5), "damping takes less than 1 uJ; kinks of 5 um");
  const nlohmann::json energy = test::summary_of(dir / "out")["energy"];
  EXPECT_NEAR(energy["work of given motions [J]"].get<double>(), 28e-3, 2e-6);
  EXPECT_NEAR(energy["bed closure [J]"].get<double>(), 0, 1e-8);
}

/// A capillary bridge between them (configs/pull-apart-bridge.yaml): pressure of a cylindrical meniscus over the gap,
/// and nothing beyond Lian's distance of rupture.
TEST(PullApart, BridgeOfWaterPullsAsItsMeniscusUntilItRuptures) {
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(test::config("pull-apart-bridge"), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const std::vector<double>&x = series.at("right jaw.x"), &pull = series.at("pull"), &time = series.at("time");
  const double r = 0.005, angle = 20 * 3.14159265358979 / 180, volume = 1e-9, end = (1 + angle / 2) * 1e-3;
  int held = 0;
  const subsoil::test::Verified row("Scenarios", "configs/pull-apart-bridge.yaml",
                                    "capillary force of a cylindrical meniscus; Lian et al. 1993");
  subsoil::test::Worst worst;
  for (std::size_t i = 1; i < x.size(); ++i) {
    if (time[i] < 0.05) continue;  // the pull begins with a jerk, and the jaws' bonds ring
    const double gap = 0.5 * (x[i] + x[i - 1]) - 0.017999 - 2e-6;
    if (std::abs(gap - end) < 0.02e-3) continue;
    const double want = gap > end ? 0
                                  : 4 * 3.14159265358979 * r * 0.072 * std::cos(angle) *
                                        (1 - gap / std::sqrt(gap * gap + volume / (3.14159265358979 * r)));
    char at[32];
    std::snprintf(at, sizeof at, "gap %.3f mm", gap * 1e3);
    if (gap > end + 0.1e-3 || gap < end) worst.take(at, pull[i], want);
    held += gap < end;
  }
  EXPECT_GT(held, 400);
  worst.near(row, "pull over the gap", "N", subsoil::test::absolute(2e-5), "half a per cent: the jaws' bonds ring");
}

}  // namespace
}  // namespace subsoil::sim::pull_apart
