// Compaction to a density: reached, by an independent count; refused with the range; the same bits from anywhere.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libdem/laws/linear.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/unit/libdem/bed_support.hpp"

namespace subsoil::dem::test::bed_compaction {
namespace {

constexpr double r = 0.01, kSide = 0.12, kDepth = 0.13;
const Bounds box{{0, 0, 0}, {kSide, 0.3, kSide}};

/// Sand: poured with all its friction it lies loose.
LawTable sand() {
  Linear law;
  law.k_n = 1e4, law.restitution = 0.4;
  law.friction.mu = 0.5, law.friction.mu_r = 0.2;
  return {.materials = 2, .index = {0, 0, 0, -1}, .laws = {law}};
}

RandomFill fill(std::uint64_t seed) {
  RandomFill f;
  f.region = box;
  f.radius = UniformRadius{0.8 * r, r};
  f.of = soil_material;
  f.seed = seed;
  f.depth = kDepth;
  return f;
}

SettlePlan plan(double density) {
  SettlePlan p;
  p.step = 1e-4, p.staged = true, p.lowered = 1;
  p.compaction.density = density, p.compaction.region = box;
  return p;
}

Bed sides() {
  BedOptions options;
  options.threads = 1;
  options.periodic = {.low = {0, 0, 0}, .length = {kSide, 0, kSide}};
  Bed bed(sand(), options);
  Boundary floor;
  floor.name = "floor", floor.shape = Plane(box.low, {0, 1, 0}), floor.material = 1;
  bed.add(floor);
  return bed;
}

/// Of a sphere that lies between two heights: the share of its volume, by the integral of its section.
double share_between(const Sphere& s, double low, double high) {
  const auto below = [&](double y) {
    const double h = std::clamp((y - s.x.y) / s.r, -1.0, 1.0);
    return 0.5 + 0.75 * h - 0.25 * h * h * h;
  };
  return below(high) - below(low);
}

/// Mass between two heights over the volume there: sides are periodic, so no wall disturbs it.
double counted_density(const Bed& bed, double low, double high) {
  double mass = 0;
  for (const Sphere& s : bed.spheres()) mass += density * sphere_volume(s.r) * share_between(s, low, high);
  return mass / (kSide * kSide * (high - low));
}

/// Product and count weigh the depth differently (a window against a slab between a diameter above the floor and one
/// below the surface), and a random packing of this height differs by a percent between the two: both poured and
/// compacted, so the count must follow from one state to the other within 1.5 %.
TEST(BedCompaction, ReachesTheDensityByAnIndependentCount) {
  for (const double target : {1060.0, 1090.0}) {
    Bed bed = sides();
    const SettleReport report = fill_at_random(bed, sand(), fill(3), plan(target));
    EXPECT_NEAR(report.bulk_density, target, Compaction::kTolerance * target);
    EXPECT_NEAR(counted_density(bed, 2 * r, report.surface.mean - 2 * r), target, 0.015 * target);
    EXPECT_NEAR(report.surface.mean, kDepth, 0.3 * r);
    EXPECT_LT(report.rms_speed, rest_speed(r, 9.81));
    EXPECT_EQ(bed.options().gravity, (Vec3{0, -9.81, 0}));
  }
}

TEST(BedCompaction, RefusesWhatNoPackingHas) {
  for (const double target : {900.0, 1300.0}) {
    Bed bed = sides();
    const std::string message = subsoil::test::message_of([&] { fill_at_random(bed, sand(), fill(3), plan(target)); });
    double from = 0, to = 0;
    const std::size_t at = message.find("goes from ");
    ASSERT_NE(at, std::string::npos) << message;
    ASSERT_EQ(
        std::sscanf(message.c_str() + at, "goes from %lf kg/m3, poured with all its friction, to %lf", &from, &to), 2)
        << message;
    // Loose and dense random packings of spheres: solid fractions of 0.53 (with rolling resistance) to 0.60 and of 0.61
    // to 0.66.
    EXPECT_GT(from / density, 0.53);
    EXPECT_LT(from / density, 0.60);
    EXPECT_GT(to / density, 0.61);
    EXPECT_LT(to / density, 0.66);
  }
}

/// Continued from places all over its cycles a compaction ends with the same bits.
TEST(BedCompaction, ContinuesFromAnywhereWithTheSameBits) {
  SettlePlan p = plan(1080);
  std::vector<SettleState> states;
  long asked = 0;
  p.keep_due = [&] { return ++asked % 400 == 7; };
  p.keep = [&](const SettleState& state) { states.push_back(state); };
  Bed whole = sides();
  fill_at_random(whole, sand(), fill(3), p);
  const std::uint64_t expected = hash(whole);
  ASSERT_GT(states.size(), 6U);
  p.keep_due = {}, p.keep = {};
  for (std::size_t k = 0; k < states.size(); k += states.size() / 3) {
    p.from = &states[k];
    Bed bed = sides();
    fill_at_random(bed, sand(), fill(3), p);
    EXPECT_EQ(hash(bed), expected) << k;
  }
}

/// A bed that lies already, such as one from a file.
TEST(BedCompaction, CompactsABedThatLies) {
  Bed bed = sides();
  SettlePlan loose = plan(1);
  loose.compaction = {};
  const SettleReport before = fill_at_random(bed, sand(), fill(3), loose);
  SettlePlan p = plan(1.03 * before.bulk_density);
  p.staged = false;
  const SettleReport after = settle(bed, sand(), p, box);
  EXPECT_NEAR(after.bulk_density, 1.03 * before.bulk_density, Compaction::kTolerance * after.bulk_density);
  EXPECT_EQ(after.spheres, before.spheres);
}

}  // namespace
}  // namespace subsoil::dem::test::bed_compaction
