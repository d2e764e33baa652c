#include <gtest/gtest.h>

#include <algorithm>

#include "apps/impact/report.hpp"
#include "tests/tools/program_runs.hpp"

/// The source's stamp of 132 kg (Ye Min-zhen): in a machine, beside the closed form of the ground element.
namespace subsoil::app {
namespace {

TEST(Stamp, SinksInAMachineAsTheClosedFormSays) {
  const LoadedStudy study = load_study(SUBSOIL_SOURCE_DIR "/configs/impact/stamp.yaml", {});
  const std::vector<ImpactRow> closed = strike_all(study);
  ASSERT_EQ(closed.size(), 4U);
  for (const ImpactRow& row : closed) {
    const dem::impact::Event& e = row.closed;
    SCOPED_TRACE(e.speed);
    const test::RunDirectory directory;
    ASSERT_EQ(test::run_scenario(test::config("stamp"), directory / "out",
                                 {"machine.bodies.stamp.velocity=0 -" + std::to_string(e.speed) + " m/s",
                                  "output.series every=20 us", "time.end=0.12 s"}),
              exit_ok);
    const Series series = read_series(directory / "out/series.csv");
    const std::vector<double>& y = series.at("stamp.y");
    const auto lowest = std::min_element(y.begin(), y.end());
    // Body and follower become one within 2 ms and not at once; K' takes the speed at the first step after touch.
    EXPECT_NEAR((0.1 - *lowest) / e.largest, 1, 2e-3);
    EXPECT_NEAR(series.at("time")[static_cast<std::size_t>(lowest - y.begin())], e.time_in, 5e-4);
    // Lost in the contact with the follower and in the ground: all of it, but what the unloading line holds.
    const double taken = 0.5 * 132 * e.speed * e.speed + 132 * 9.81 * (0.1 - y.back());
    EXPECT_NEAR(series.at("energy.lost").back(), taken, 0.02 * taken);
    EXPECT_NEAR(series.at("energy.balance").back(), 0, 1e-3 * taken);
  }
}

}  // namespace
}  // namespace subsoil::app
