#include <cmath>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/packing/settle.hpp"
#include "libsim/scenario/load.hpp"
#include "libsim/setup/bed_profile.hpp"
#include "libsim/setup/compaction_plate.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/program_runs.hpp"

/// Beds that are compacted before the run. Oracles: weight and load for stresses, Jaky's relation for their ratio.
namespace subsoil::sim::bed_compaction {
namespace {

using dem::Vec3;
constexpr double kSide = 0.14, kPressure = 20e3, kStep = 4e-5;

dem::Linear law(double mu) {
  dem::Linear l = dem::test::grains(1e5, 0.4, mu, 0.1);
  return l;
}
/// Spheres with friction between walls without.
dem::LawTable laws() { return {.materials = 2, .index = {0, 1, 1, -1}, .laws = {law(0.5), law(0)}}; }

/// What the floor bears and the bed is like under the load, before it is taken off.
class Watched final : public dem::BedLoad {
 public:
  Watched(dem::BedLoad& load) : load_(load) {}
  void begin(dem::Bed& bed) override { load_.begin(bed); }
  void advance(dem::Bed& bed, double dt) override { load_.advance(bed, dt); }
  bool holds() const override { return load_.holds(); }
  std::string state() const override { return load_.state(); }
  void end(dem::Bed& bed) override {
    on_floor = -bed.boundary(0).wrench.force.y, weight = 0;
    for (const dem::Sphere& s : bed.spheres()) weight += s.m * 9.81;
    rows = profile_by_depth(bed, {{0, 0, 0}, {kSide, 0.4, kSide}});
    load_.end(bed);
  }
  Archive::Columns save() const override { return load_.save(); }
  void restore(const Archive::Columns& saved) override { load_.restore(saved); }

  double on_floor = 0, weight = 0;
  std::vector<DepthRow> rows;

 private:
  dem::BedLoad& load_;
};

/// A bin with a plate above it that does not act yet; its index.
int add_bin_and_plate(dem::Bed& bed) {
  dem::test::add_bin(bed, kSide, kSide);
  for (int b = 0; b < bed.boundary_count(); ++b) bed.boundary(b).material = 1;
  dem::Boundary plate;
  plate.name = "plate", plate.material = 1, plate.active = false;
  plate.shape = dem::MeshSurface(dem::rectangle_mesh({0, 0, 0}, {kSide, 0, 0}, {0, 0, kSide}));
  return bed.add(std::move(plate));
}

dem::RandomFill fill_to(double depth) {
  dem::RandomFill fill;
  fill.region = {{0, 0, 0}, {kSide, 0.4, kSide}};
  fill.radius = dem::UniformRadius{0.008, 0.01};
  fill.of = {.density = 2600, .material = 0};
  fill.depth = depth;
  return fill;
}

dem::BedOptions one_thread() {
  dem::BedOptions options;
  options.threads = 1;
  return options;
}

/// From a state that was kept while the plate presses, in another bed with a plate of its own, the bed comes to the
/// same bits: how fast the plate may go and its gain follow from the spheres that lay there when it began.
TEST(BedCompaction, GoesOnFromAStateUnderThePlate) {
  const dem::LawTable table = laws();
  const dem::RandomFill fill = fill_to(0.05);
  const auto settled = [&](const dem::SettleState* from, dem::SettleState* keep) {
    dem::Bed bed(table, one_thread());
    CompactionPlate load(bed, add_bin_and_plate(bed), kPressure, kStep);
    dem::SettlePlan plan;
    plan.step = kStep, plan.staged = true, plan.lowered = 1;
    plan.compaction.load = &load, plan.from = from;
    long presses = 0;
    plan.keep_due = [&] {
      return keep != nullptr && !load.save().at("servo/load").empty() && load.save().at("servo/load")[0] > 0 &&
             !load.holds() && ++presses == 20;
    };
    plan.keep = [&](const dem::SettleState& state) { *keep = state; };
    dem::fill_at_random(bed, table, fill, plan);
    return dem::test::hash(bed);
  };
  dem::SettleState kept;
  const std::uint64_t whole = settled(nullptr, &kept);
  ASSERT_FALSE(kept.load.empty()) << "kept while the plate presses";
  EXPECT_EQ(settled(&kept, nullptr), whole);
}

TEST(BedCompaction, APlateHoldsItsPressureAndTheSoilLeansAsSoilDoes) {
  const dem::LawTable table = laws();
  dem::Bed bed(table, one_thread());
  CompactionPlate load(bed, add_bin_and_plate(bed), kPressure, kStep);
  Watched watched(load);
  const dem::RandomFill fill = fill_to(0.14);
  dem::SettlePlan plan;
  plan.step = kStep, plan.staged = true, plan.lowered = 1;
  plan.compaction.load = &watched;
  const dem::SettleReport report = dem::fill_at_random(bed, table, fill, plan);

  // Walls without friction bear nothing: the floor bears weight and load. A plate holds within 1 %, a bed at rest is in
  // balance within less.
  EXPECT_NEAR(watched.on_floor, kPressure * kSide * kSide + watched.weight, 0.015 * kPressure * kSide * kSide);
  ASSERT_GE(watched.rows.size(), 3U);
  double ratio = 0, vertical = 0;
  for (const DepthRow& row : watched.rows) {
    EXPECT_GT(row.coordination, 4);
    EXPECT_LT(row.coordination, 7);
    ratio += row.stress_ratio / static_cast<double>(watched.rows.size());
    vertical += row.vertical_stress / static_cast<double>(watched.rows.size());
  }
  // In the middle of the section, a quarter of it: force chains leave it 10 to 20 % beside the mean over the section.
  // Rows at even depths bear half of the weight in the mean.
  EXPECT_NEAR(vertical, kPressure + 0.5 * watched.weight / (kSide * kSide), 0.2 * kPressure);
  // Jaky 1944: 1 - sin phi, of friction angles between 20 degrees (spheres) and 40 (dense sand).
  EXPECT_GT(ratio, 1 - std::sin(40 * M_PI / 180));
  EXPECT_LT(ratio, 1 - std::sin(20 * M_PI / 180));
  // Taken off it leaves a bed at its depth.
  EXPECT_NEAR(report.surface.mean, 0.14, 0.003);
}

constexpr const char* kBed = R"(subsoil: 1
title: a compacted bed
gravity: 9.81 m/s^2
materials:
  soil: {density: 2600 kg/m^3}
  steel: {density: 7850 kg/m^3}
contacts:
  - &dry {between: [soil, soil], law: linear, k_n: 20 kN/m, restitution: 0.4, mu: 0.5, mu_r: 0.2}
  - {<<: *dry, between: [soil, steel], mu: 0.3}
soil:
  container: {size: 0.13 0.3 0.13 m, at: 0 0 0 m, material: steel}
  surface: 0 m
  bed: {fill: random, material: soil, radius: {uniform: 8 10 mm}, depth: 130 mm, settle: {to: 1460 kg/m^3}}
time: {end: 2 ms}
output: {every: 2 ms}
)";

TEST(BedCompaction, AScenarioReportsTheStateByDepth) {
  const test::RunDirectory dir;
  const std::string scenario = dir.scenario(kBed);
  ASSERT_EQ(test::run_scenario(scenario, dir / "density"), exit_ok);
  EXPECT_NO_THROW(load_scenario(dir / "density/scenario.yaml")) << "what the run writes reads as it stands";
  const nlohmann::json soil = test::summary_of(dir / "density")["soil"];
  EXPECT_NEAR(soil["bulk density [kg/m3]"].get<double>(), 1460, 7.3);
  ASSERT_GT(soil["by depth"].size(), 0U);
  double last = 0;
  for (const auto& row : soil["by depth"]) {
    const double depth = row["depth [m]"].get<double>();
    EXPECT_GT(depth, last);
    last = depth;
    // At rest under its own weight, less what the walls bear.
    const double weight = row["bulk density [kg/m3]"].get<double>() * 9.81 * depth;
    EXPECT_LT(row["vertical stress [Pa]"].get<double>(), 1.3 * weight);
    EXPECT_GT(row["vertical stress [Pa]"].get<double>(), 0.4 * weight);
  }
  ASSERT_EQ(test::run_scenario(scenario, dir / "pressure", {"soil.bed.settle.to=5 kPa"}), exit_ok);
  EXPECT_NEAR(test::summary_of(dir / "pressure")["soil"]["mean surface [m]"].get<double>(), 0, 1e-12);
}

TEST(BedCompaction, RefusesWhatCannotBe) {
  const test::RunDirectory dir;
  const std::string scenario = dir.scenario(kBed);
  const auto refusal = [&](const char* set) {
    return subsoil::test::message_of([&] { test::run_scenario(scenario, dir / "out", {set}); });
  };
  const auto holds = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  EXPECT_PRED2(holds, refusal("soil.bed.settle.to=2700 kg/m^3"), "must be below the density of the grains");
  EXPECT_PRED2(holds, refusal("soil.bed.settle.to=20 mm"), "needs a density (1450 kg/m^3) or a pressure (20 kPa)");
  EXPECT_PRED2(holds, refusal("soil.bed.settle.to=0 kPa"), "must be above zero");
  EXPECT_PRED2(holds, refusal("soil.bed.settle.lowered=0.5"), "has no effect");
  EXPECT_PRED2(holds, refusal("soil.bed.depth=100 mm"), "this bed is 0.1 m deep; make it larger");
  EXPECT_PRED2(holds, refusal("soil.container.size=0.1 0.3 0.13 m"), "this bed is 0.1 m long; make it larger");
  EXPECT_PRED2(holds, refusal("soil.bed.settle.to=2000 kg/m^3"), "this bed goes from 1");
}

}  // namespace
}  // namespace subsoil::sim::bed_compaction
