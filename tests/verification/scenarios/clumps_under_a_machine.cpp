#include "tests/tools/program_runs.hpp"

/// A machine on clumps: a plate of 0.5 kg, guided upright, comes to rest on a poured bed of dumbbells.
/// Oracles: at rest the bed bears the plate's weight and the walls that of both (statics); energy of bed and machine
/// closes; one thread and three give the same bits.
namespace subsoil::app::clumps_under_a_machine {
namespace {

constexpr const char* scenario = R"(subsoil: 1
gravity: 9.81 m/s^2
materials: {maize: {density: 1250 kg/m^3}, steel: {density: 7850 kg/m^3}}
contacts:
  - {between: [maize, maize], law: linear, k_n: 20 kN/m, restitution: 0.3, mu: 0.5}
  - {between: [maize, steel], law: linear, k_n: 20 kN/m, restitution: 0.3, mu: 0.3}
soil:
  clumps:
    pair: {spheres: [{at: -4 0 0 mm, radius: 6 mm}, {at: 4 0 0 mm, radius: 6 mm}]}
  container: {size: 0.1 0.1 0.1 m, at: -0.05 -0.1 -0.05 m, material: steel}
  surface: 0 m
  bed: {fill: random, material: maize, clumps: [{shape: pair, share: 1}], depth: 50 mm}
machine:
  bodies: {plate: {mass: 0.5 kg, inertia: 1e-3 kg m^2, at: 0 10 mm}}
  joints: {guide: {translational: [ground, plate], at: 0 0 m, along: 0 1}}
  surfaces: {sole: {body: plate, material: steel, box: 90 10 90 mm}}
time: {end: 0.4 s}
output:
  every: 0.4 s
  watch:
    borne: {soil force: plate, along: 0 1}
    floor: {soil force: floor, along: 0 -1}
    walls: {soil force: container, along: 0 -1}
)";

TEST(ClumpsUnderAMachine, BearItsWeightCloseTheBalanceAndGiveTheSameBits) {
  const test::RunDirectory dir;
  const std::string file = dir.scenario(scenario);
  ASSERT_EQ(test::run_scenario(file, dir / "out"), exit_ok);
  const nlohmann::json summary = test::summary_of(dir / "out"), soil = summary["soil"];
  EXPECT_GT(soil["clumps"], 100);
  EXPECT_EQ(soil["spheres"].get<int>(), 2 * soil["clumps"].get<int>());
  const Series series = read_series(dir / "out" / "series.csv");
  const double plate = 0.5 * 9.81, bed = soil["mass [kg]"].get<double>() * 9.81;
  // What still moves at the end: a hundredth of the weights, measured 0.1 %.
  EXPECT_NEAR(series.at("borne").back(), plate, 0.01 * plate);
  EXPECT_NEAR(series.at("walls").back(), plate + bed, 0.01 * (plate + bed));
  EXPECT_LT(series.at("floor").back(), series.at("walls").back()) << "friction at the sides bears a part";
  EXPECT_LT(std::abs(summary["energy"]["closure over work put in"].get<double>()), 5e-3);

  ASSERT_EQ(run({.scenario = file, .out = dir / "three", .threads = 3}), exit_ok);
  const Series other = read_series(dir / "three" / "series.csv");
  EXPECT_EQ(series.at("walls"), other.at("walls"));
  EXPECT_EQ(series.at("plate.y"), other.at("plate.y"));
}

}  // namespace
}  // namespace subsoil::app::clumps_under_a_machine
