// Settling: rest, stages, depth, seeds and threads.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "libdem/laws/linear.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/unit/libdem/bed_support.hpp"

namespace subsoil::dem::test::bed_settle {
namespace {

constexpr double r = 0.010;

/// x v w of every sphere, in the bed's own order.
std::vector<double> motions(const Bed& bed) {
  std::vector<double> out;
  for (const Sphere& s : bed.spheres())
    for (const Vec3& v : {s.x, s.v, s.w}) out.insert(out.end(), {v.x, v.y, v.z});
  return out;
}

// A lattice at rest pitch is free of stress but for its weight. A column of 4 layers presses a contact by 4 m g/K_X =
// 30 um at most, 4 x 30 um in all; the weight comes on at once, so the top comes down by no more than twice that.
// Walls: the box is so wide that the outer rows stand at the wall's rest overlap. Elsewhere a lattice is in reach of a
// wall's attraction or out of it, as its pitch divides the bin.
TEST(BedSettle, RestLatticeOfTheWetLawStaysWhereItIs) {
  const double side = 5 * 0.018 + 2 * 0.008;
  LatticePlan plan;
  plan.region = {{0, 0, 0}, {side + 0.004, 3 * 0.018 + 0.02, side + 0.004}};  // six rows that stand free of it,
  const Bounds walls{{0.002, 0, 0.002}, {side + 0.002, 1, side + 0.002}};     // in a box narrower by the rest overlap
  plan.radius = EqualRadius{r};
  plan.floor_overlap = 0.002;
  const auto spheres = rest_lattice(plan, 0.002, soil_material);
  ASSERT_EQ(spheres.size(), 6u * 6u * 4u);
  Bed bed = boxed_bed(table_3(), walls);
  bed.add(spheres);
  for (int k = 0; k < 3333; ++k) bed.step(15e-6);
  const double weight = spheres[0].density * sphere_volume(spheres[0].radius) * 9.81;
  const double sag = 2 * 4 * 4 * weight / 10e3;
  for (const Sphere& s : bed.spheres()) EXPECT_LE(norm(s.x - spheres[s.id].position), sag) << s.id;
  const double per_sphere = bed.kinetic_energy() / static_cast<double>(spheres.size());
  EXPECT_LT(per_sphere, weight * r * 1e-4);
}

const Bounds box{{0, 0, 0}, {0.1, 0.5, 0.1}};

RandomFill fill(std::uint64_t seed) {
  RandomFill f;
  f.region = box;
  f.radius = UniformRadius{0.008, 0.012};
  f.of = soil_material;
  f.seed = seed;
  return f;
}
SettlePlan soft_plan(bool staged) {
  SettlePlan plan;
  plan.step = soft_step;
  plan.staged = staged;
  return plan;
}

/// Dry grains between walls of their own law.
LawTable dry_grains(Rolling rolling, double stiffness = 2e4) {
  Linear law;
  law.k_n = stiffness, law.restitution = 0.5;
  law.friction.mu = 0.3, law.friction.mu_r = 0.3, law.friction.rolling = rolling;
  return {.materials = 2, .index = {0, 0, 0, -1}, .laws = {law}};
}

/// A constant torque against rolling reverses in every step about zero: angular velocities jitter for ever in a bed
/// whose centres lie still. The bed is at rest when these are.
TEST(BedSettle, AConstantTorqueAgainstRollingEndsAtRest) {
  const LawTable laws = dry_grains(Rolling::constant_torque);
  RandomFill f = fill(1);
  f.count = 60;
  SettlePlan plan = soft_plan(true);
  plan.at_most = 3;
  Bed bed = boxed_bed(laws, box);
  const SettleReport at_rest = fill_at_random(bed, laws, f, plan);
  EXPECT_FALSE(at_rest.stopped);
  EXPECT_LT(at_rest.rms_speed, rest_speed(0.01, 9.81)) << "of the centres";
}

/// A refusal states speeds of centres and of surfaces that turn.
TEST(BedSettle, ARefusalTellsCentresFromRotation) {
  const LawTable laws = dry_grains(Rolling::elastic_plastic);
  SettlePlan plan = soft_plan(false);
  plan.at_most = 1e-3;
  RandomFill f = fill(1);
  f.count = 20;
  Bed bed = boxed_bed(laws, box);
  const std::string said = subsoil::test::message_of([&] { fill_at_random(bed, laws, f, plan); });
  for (const char* part :
       {"m/s rms with their rotation, at ", " m/s without; the fastest centre has ", ", the fastest surface turns at "})
    EXPECT_NE(said.find(part), std::string::npos) << said;
}

/// A soft bed keeps swinging up and down as a whole when its spheres are slower than rest: from what is levelled off
/// its floor bore 7 % more than its weight, and less after that. The force that is not balanced, over 1 ms each, stays
/// below 2 %, twice what rest allows.
TEST(BedSettle, ABedAtRestPressesItsFloorByItsWeight) {
  const LawTable laws = dry_grains(Rolling::elastic_plastic, 2e3);
  RandomFill f = fill(1);
  f.depth = 0.2;
  SettlePlan plan = soft_plan(true);
  plan.step = 1e-4;
  Bed bed = boxed_bed(laws, box);
  ASSERT_FALSE(fill_at_random(bed, laws, f, plan).stopped);
  const auto momentum = [&] {
    double sum = 0;
    for (const Sphere& s : bed.spheres()) sum += s.m * s.v.y;
    return sum;
  };
  double weight = 0;
  for (const Sphere& s : bed.spheres()) weight += s.m * 9.81;
  for (int k = 0; k < 60; ++k) {
    const double before = momentum();
    for (int i = 0; i < 10; ++i) bed.step(plan.step);
    EXPECT_LT(std::abs(momentum() - before), 0.02 * weight * 1e-3) << k << " ms";
  }
}

TEST(BedSettle, SoftenedLawKeepsItsRestDistanceAndLosesItsAttraction) {
  const Wet full = *table_3().laws[0].get_if<Wet>(), soft = *softened(full, 0, 0.1).get_if<Wet>();
  EXPECT_EQ(soft.cutoff(), 0);
  EXPECT_EQ(soft.rest_overlap(), full.rest_overlap());
  EXPECT_DOUBLE_EQ(soft.friction.mu, 0.05);
  EXPECT_DOUBLE_EQ(soft.friction.mu_r, 0.03);
  for (const double overlap : {-1e-3, 0.5e-3, 1.5e-3}) {
    const Approach<double> a{.overlap = overlap, .rate = 0, .root_m = 1, .r_eff = 1, .elapsed = 0};
    EXPECT_EQ(soft.normal(a).force, 0);
    const Wet half = *softened(full, 0.5, 1).get_if<Wet>();
    EXPECT_DOUBLE_EQ(half.normal(a).force, 0.5 * full.normal(a).force);
  }
  const Approach<double> pressed{.overlap = 3e-3, .rate = 0, .root_m = 1, .r_eff = 1, .elapsed = 0};
  EXPECT_EQ(soft.normal(pressed).force, full.normal(pressed).force);
}

// Cohesive spheres rained down make fluff. Both beds hold the same spheres. 400 of them in a box of 0.14 m came to 1364
// against 608 kg/m3; seeds scatter by some percent, so a gain of 30 % is not chance.
TEST(BedSettle, StagesPackDenserThanRainingWithCohesion) {
  RandomFill f = fill(1);
  f.count = 180;
  SettlePlan one_stage = soft_plan(false), stages = soft_plan(true);
  one_stage.duration = 0.6, stages.duration = 0.1;  // the fluff's chains swing for seconds, but rise no more
  Bed rained = boxed_bed(soft_wet(), box), staged = boxed_bed(soft_wet(), box);
  const SettleReport fluff = fill_at_random(rained, soft_wet(), f, one_stage);
  const SettleReport soil_like = fill_at_random(staged, soft_wet(), f, stages);
  EXPECT_EQ(fluff.spheres, 180u);
  EXPECT_EQ(soil_like.spheres, 180u);
  EXPECT_GT(soil_like.bulk_density, 1.3 * fluff.bulk_density);
  EXPECT_LT(soil_like.surface.mean, 0.8 * fluff.surface.mean);
  EXPECT_GT(soil_like.coordination, fluff.coordination);
  EXPECT_LT(soil_like.rms_speed, rest_speed(r, 9.81));
  // The run's own law is in force again.
  EXPECT_DOUBLE_EQ(staged.laws().laws[0].get_if<Wet>()->friction.mu, 0.5);
  EXPECT_GT(staged.laws().laws[0].get_if<Wet>()->K_B, 0);
}

// Levelling puts the mean surface on the target to one sphere's step in one of four columns; settling under the law it
// rested in moves it by no more than a fraction of a radius.
TEST(BedSettle, FillsToTheDepthAsked) {
  for (const double depth : {0.06, 0.10}) {
    RandomFill f = fill(2);
    f.depth = depth;
    Bed bed = boxed_bed(soft_wet(), box);
    const SettleReport report = fill_at_random(bed, soft_wet(), f, soft_plan(true));
    EXPECT_NEAR(report.surface.mean, depth, 0.25 * r) << depth;
    EXPECT_GT(report.levelled, 0u);
    EXPECT_LT(report.spheres, 300u);
  }
}

/// A small bed through all stages: places, velocities and spins of its spheres.
std::vector<double> small_bed(std::uint64_t seed) {
  RandomFill f = fill(seed);
  f.region = {{0, 0, 0}, {0.08, 0.3, 0.08}};
  f.depth = 0.04;
  Bed bed = boxed_bed(soft_wet(), f.region);
  fill_at_random(bed, soft_wet(), f, soft_plan(true));
  return motions(bed);
}

TEST(BedSettle, SameSeedSameBed) {
  const auto one = small_bed(3), again = small_bed(3), other = small_bed(4);
  ASSERT_EQ(again.size(), one.size());
  EXPECT_EQ(std::memcmp(again.data(), one.data(), one.size() * sizeof(double)), 0);
  EXPECT_NE(other, one);
}

/// Gone on with from places all over its stages, rains and levellings, a settling ends with the same bits.
TEST(BedSettle, GoesOnFromAnywhereWithTheSameBits) {
  RandomFill f = fill(5);
  f.region = {{0, 0, 0}, {0.07, 0.3, 0.07}};
  const BedMaterial of = f.of;
  f.layers = {{.top = 0.025, .radius = EqualRadius{r}, .shares = ShareOf::number, .of = of},
              {.top = 0.05, .radius = EqualRadius{r}, .shares = ShareOf::number, .of = of}};
  SettlePlan plan = soft_plan(true);
  std::vector<SettleState> states;
  long asked = 0;
  plan.keep_due = [&] { return ++asked % 40 == 7; };
  plan.keep = [&](const SettleState& state) { states.push_back(state); };
  Bed whole = boxed_bed(soft_wet(), f.region);
  const SettleReport report = fill_at_random(whole, soft_wet(), f, plan);
  const Bed::State expected = whole.save();
  ASSERT_GT(states.size(), 8U);
  plan.keep_due = {}, plan.keep = {};
  for (std::size_t k = 0; k < states.size(); k += states.size() / 8) {
    plan.from = &states[k];
    Bed bed = boxed_bed(soft_wet(), f.region);
    const SettleReport again = fill_at_random(bed, soft_wet(), f, plan);
    const Bed::State state = bed.save();
    EXPECT_EQ(motions(bed), motions(whole)) << k;
    ASSERT_EQ(state.pairs.size(), expected.pairs.size()) << k;
    for (std::size_t p = 0; p < state.pairs.size(); ++p)
      for (int d = 0; d < 3; ++d) EXPECT_EQ(state.pairs[p].state.xi[d], expected.pairs[p].state.xi[d]) << k;
    EXPECT_EQ(state.parts, expected.parts) << k;
    EXPECT_EQ(again.settled_time, report.settled_time);
    EXPECT_EQ(again.levelled, report.levelled);
    EXPECT_EQ(again.layer_ends, report.layer_ends);
  }
}

/// A shaken lattice under the softened law, then under the full one. 726 spheres, since threads share work by some
/// hundreds; few steps, since more threads than cores wait for each other.
std::vector<double> shaken_lattice(int threads) {
  LatticePlan plan;
  plan.region = {{0, 0, 0}, {0.21, 0.12, 0.21}};
  plan.radius = EqualRadius{r};
  plan.pitch = 0.019;
  plan.floor_overlap = 0.001;
  plan.jitter = 0.1;
  Bed bed = boxed_bed(soft_wet(), plan.region, threads);
  bed.add(lattice(plan, soil_material));
  SettlePlan short_time = soft_plan(false);
  short_time.duration = 0.015;
  settle(bed, softened(soft_wet(), 0, 0.1), short_time, plan.region);
  settle(bed, soft_wet(), short_time, plan.region);
  return motions(bed);
}

TEST(BedSettle, SameBitsForAnyNumberOfThreads) {
  const auto one = shaken_lattice(1), three = shaken_lattice(3);
  ASSERT_EQ(one.size(), 9u * 726u);
  ASSERT_EQ(three.size(), one.size());
  EXPECT_EQ(std::memcmp(three.data(), one.data(), one.size() * sizeof(double)), 0);
}

TEST(BedSettle, DurationSpeedAndLimitOfTime) {
  LatticePlan lattice_plan;
  lattice_plan.region = {{0, 0.05, 0}, {0.14, 0.5, 0.14}};  // let fall by 5 cm
  lattice_plan.radius = EqualRadius{r};
  lattice_plan.pitch = 0.0215;  // out of reach of each other's attraction and of the walls'
  lattice_plan.depth = 0.05;
  const auto make = [&] {
    Bed bed = boxed_bed(soft_wet(), {{0, 0, 0}, {0.14, 0.5, 0.14}});
    bed.add(lattice(lattice_plan, soil_material));
    return bed;
  };
  SettlePlan plan = soft_plan(false);
  {
    Bed bed = make();
    plan.duration = 0.02;
    const SettleReport falling = settle(bed, soft_wet(), plan, box);
    EXPECT_NEAR(falling.settled_time, 0.02, 1e-12);
    EXPECT_NEAR(falling.rms_speed, 9.81 * 0.02, 9.81 * soft_step);  // velocities stand half a step before t
    EXPECT_EQ(bed.energy().lost.damping, 0);
  }
  plan.duration.reset();
  {
    Bed bed = make();
    plan.until_speed = 0.02;
    const SettleReport still = settle(bed, soft_wet(), plan, box);
    EXPECT_LT(still.rms_speed, 0.02);
    EXPECT_GT(still.settled_time, std::sqrt(2 * 0.05 / 9.81));  // not before it has fallen
  }
  {
    Bed bed = make();
    plan.at_most = 0.05;
    EXPECT_THROW(settle(bed, soft_wet(), plan, box), std::runtime_error);
  }
  {
    Bed bed = make();
    plan.at_most = 5;
    int calls = 0;
    plan.progress = [&](const SettleProgress& p) {
      EXPECT_STREQ(p.stage, "settling");
      return ++calls < 3;
    };
    const SettleReport stopped = settle(bed, soft_wet(), plan, box);
    EXPECT_TRUE(stopped.stopped);
    EXPECT_NEAR(stopped.settled_time, 300 * soft_step, 1e-12);
  }
  plan.duration = 1;
  Bed bed = make();
  EXPECT_THROW(settle(bed, soft_wet(), plan, box), std::invalid_argument);  // both a duration and a speed
}

}  // namespace
}  // namespace subsoil::dem::test::bed_settle
