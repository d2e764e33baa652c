#include <numeric>

#include "tests/tools/program_runs.hpp"

/// A machine on clumps: a plate of 0.5 kg, guided upright, comes to rest on a poured bed of dumbbells.
/// Oracles: over the whole run the bed bears the plate's weight and the walls that of both, but for the momentum that
/// is left (the theorem of momentum); energy of bed and machine closes; one thread and three give the same bits.
namespace subsoil::sim::clumps_under_a_machine {
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
  monitor:
    borne: {soil force: plate, along: 0 1}
    floor: {soil force: floor, along: 0 -1}
    walls: {soil force: container, along: 0 -1}
)";

/// Rows are means over 1 ms, the first one of the instant 0.
double mean(const std::vector<double>& rows) {
  return std::accumulate(rows.begin() + 1, rows.end(), 0.0) / static_cast<double>(rows.size() - 1);
}

TEST(ClumpsUnderAMachine, BearItsWeightAndCloseTheBalance) {
  const test::RunDirectory dir;
  const std::string file = dir.scenario(scenario);
  ASSERT_EQ(test::run_scenario(file, dir / "out"), exit_ok);
  const nlohmann::json summary = test::summary_of(dir / "out"), soil = summary["soil"];
  EXPECT_GT(soil["clumps"], 100);
  EXPECT_EQ(soil["spheres"].get<int>(), 2 * soil["clumps"].get<int>());
  const Series series = read_series(dir / "out" / "series.csv");
  const double plate = 0.5 * 9.81, bed = soil["mass [kg]"].get<double>() * 9.81;
  // The plate still swings at the end: its momentum belongs to the balance, that of the bed is 0.5 % of it at most.
  const double swing = 0.5 * series.at("plate.vy").back() / 0.4;
  EXPECT_NEAR(mean(series.at("borne")), plate + swing, 0.003 * plate);
  EXPECT_NEAR(mean(series.at("walls")), plate + bed + swing, 0.005 * (plate + bed));
  // What the floor does not bear is friction at the sides, of either sign while the bed settles; no more than mu N.
  double pressed = 0;
  for (const char* side : {"wall -x.Fx", "wall +x.Fx", "wall -z.Fz", "wall +z.Fz"})
    pressed += std::abs(mean(series.at(side)));
  EXPECT_GT(pressed, 0);
  EXPECT_LE(std::abs(mean(series.at("walls")) - mean(series.at("floor"))), 0.3 * pressed);
  EXPECT_LT(std::abs(summary["energy"]["closure over energy there or put in"].get<double>()), 1e-2);
}

TEST(ClumpsUnderAMachine, SameBitsOnOneAndThreeThreads) {
  const test::RunDirectory dir;
  RunRequest request;
  request.scenario = dir.scenario(scenario),
  request.sets = {
      "time.end=15 ms",
      "soil.bed={fill: lattice, material: maize, pitch: 20.2 mm, depth: 62 mm, clumps: [{shape: pair, share: 1}]}"};
  for (const int threads : {1, 3}) {
    request.out = dir / std::to_string(threads), request.threads = threads;
    ASSERT_EQ(run(request), exit_ok);
  }
  const Series one = read_series(dir / "1" / "series.csv"), three = read_series(dir / "3" / "series.csv");
  EXPECT_EQ(one.at("walls"), three.at("walls"));
  EXPECT_EQ(one.at("plate.y"), three.at("plate.y"));
}

}  // namespace
}  // namespace subsoil::sim::clumps_under_a_machine
