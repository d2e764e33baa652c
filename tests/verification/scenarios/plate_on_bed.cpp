#include <numbers>

#include "tests/tools/program_runs.hpp"
#include "tests/tools/verified.hpp"

/// Plate of known weight on a settled bed, through the machine and the coupling (configs/plate-sinking.yaml).
/// Oracle: statics. The spheres carry the plate; slide and soil balance each other sideways and in turn; floor and
/// walls carry everything. No number of it comes from the contact law.
namespace subsoil::sim::plate_on_bed {
namespace {

TEST(PlateOnBed, ForcesAndMomentsBalanceAtRest) {
  const test::RunDirectory dir;
  ASSERT_EQ(test::run_scenario(test::config("plate-sinking"), dir / "out"), exit_ok);
  const Series series = read_series(dir / "out" / "series.csv");
  const auto last = [&](const std::string& column) { return series.at(column).back(); };
  const double g = 9.81, plate = 20 * g;
  const nlohmann::json summary = test::summary_of(dir / "out");
  const double soil = summary["soil"]["mass [kg]"].get<double>() * g;
  // At rest: 0.1 % of the weight is what an acceleration of g/1000 would make; the plate's speed must match.
  const double small = 1e-3 * plate;
  const subsoil::test::Verified row("Bed and machine", "Plate of 20 kg on a settled wet bed, at rest", "statics");
  const auto near = [&](const char* quantity, const char* unit, double ours, double reference, double tolerance) {
    row.near_by_chance(quantity, unit, ours, reference, subsoil::test::absolute(tolerance),
                       "1e-3 of the weight: an acceleration of g/1000");
  };
  EXPECT_NEAR(last("plate.vy"), 0, 1e-5);
  near("force of the soil on the plate, upward", "N", last("plate.soil.Fy"), plate, small);
  EXPECT_GT(std::abs(last("plate.soil.Fx")), 1) << "the plate stands off the middle: its soil must push sideways";
  EXPECT_GT(std::abs(last("plate.soil.Mz")), 0.1);
  // The reaction on the ground is what the soil does to the plate.
  near("reaction of the slide, sideways, and the soil's force", "N", last("slide.fx"), last("plate.soil.Fx"), small);
  near("moment of the slide, and the soil's moment", "N m", last("slide.moment"), last("plate.soil.Mz"),
       1e-3 * plate * 0.05);
  double up = 0, along = 0, across = 0;
  for (const char* wall : {"floor", "wall -x", "wall +x", "wall -z", "wall +z"}) {
    up += last(std::string(wall) + ".Fy");
    along += last(std::string(wall) + ".Fx");
    across += last(std::string(wall) + ".Fz");
  }
  // Columns of surfaces are the spheres' force on them.
  near("weight on floor and walls, of soil and plate", "N", -up, soil + plate, small);
  near("sum of forces on the soil along x", "N", along + last("plate.soil.Fx"), 0, small);
  near("sum of forces on the soil along z, which the guide takes", "N", across + last("plate.soil.Fz"), 0, small);
  EXPECT_LT(std::abs(summary["energy"]["closure over energy there or put in"].get<double>()), 0.01);
}

}  // namespace
}  // namespace subsoil::sim::plate_on_bed
