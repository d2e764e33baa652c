#include <gtest/gtest.h>

#include <algorithm>

#include "libsim/studies/impact/report.hpp"
#include "tests/tools/paths.hpp"
#include "tests/tools/program_runs.hpp"
#include "tests/tools/verified.hpp"

/// The source's stamp of 132 kg (Ye Min-zhen): in a machine, beside the closed form of the ground element.
namespace subsoil::sim::stamp {
namespace {

using subsoil::test::absolute;
using subsoil::test::share;
using subsoil::test::Verified;

TEST(Stamp, ClosedFormsOfTheGroundElement) {
  GroundImpact model;
  model.stiffness = mbd::PowerStiffness{.K0 = 1e5};
  model.gravity = 0;
  const dem::impact::Pair stamp{.mass = 132};
  const Verified row("Bed and machine", "Ground element: 132 kg on K' 100 kN/m, follower a tenth, 1 m/s",
                     "quarter period of (m + m_b) on K' by hand");
  const auto e = model.strike(stamp, 1, 200);
  const char* const digits = "printed to eight digits";
  row.near("maximum depth", "m", e.largest, 34.641016e-3, absolute(5e-10), digits);
  row.near("time to it", "s", e.time_in, 59.855379e-3, absolute(5e-10), digits);
  row.near("energy lost at touch", "J", e.at_touch, 6, absolute(1e-12), "rounding");
  row.near("energy that deforms the ground", "J", e.in_ground, 60, absolute(1e-10), "quadrature");
  model.gravity = 9.81;
  row.near("maximum depth, with gravity", "m", model.strike(stamp, 1, 200).largest, 49.931382e-3, absolute(5e-10),
           digits);
}

TEST(Stamp, SinksInAMachineAsTheClosedFormSays) {
  const Verified found("Bed and machine", "configs/stamp.yaml: stamp of 132 kg dropped on the ground element",
                       "closed form of the ground element");
  const LoadedStudy study = load_study(subsoil::test::source_dir() + "/configs/impact/stamp.yaml", {});
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
    char at[24];
    std::snprintf(at, sizeof at, " at %g m/s", e.speed);
    found.near(std::string("sinking") + at, "m", 0.1 - *lowest, e.largest, share(2e-3),
               "body and follower become one within 2 ms, not at once");
    found.near(std::string("time to the maximum depth") + at, "s",
               series.at("time")[static_cast<std::size_t>(lowest - y.begin())], e.time_in, absolute(5e-4), "the same");
    // Lost in the contact with the follower and in the ground: all of it, but what the unloading line holds.
    const double taken = 0.5 * 132 * e.speed * e.speed + 132 * 9.81 * (0.1 - y.back());
    EXPECT_NEAR(series.at("energy.lost").back(), taken, 0.02 * taken);
    EXPECT_NEAR(series.at("energy.balance").back(), 0, 1e-3 * taken);
  }
}

}  // namespace
}  // namespace subsoil::sim::stamp
