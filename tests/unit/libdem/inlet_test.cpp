// Spheres poured in while a bed steps: the rate, their sizes, energy, threads, restart, and what lies in the way.
#include "libdem/packing/inlet.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "libdem/laws/linear.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/unit/libdem/bed_support.hpp"

namespace subsoil::dem::test::inlet_test {
namespace {

constexpr double kStep = 1e-4, kSide = 0.1, kRadius = 5e-3;

LawTable sand() {
  Linear law = grains(1e4, 0.4, 0.5, 0.1);
  return {.materials = 2, .index = {0, 0, 0, -1}, .laws = {law}};
}

InletPlan feed(double rate) {
  InletPlan p;
  p.region = Bounds{{0.01, 0.12, 0.01}, {0.09, 0.15, 0.09}};
  p.radius = UniformRadius{0.8 * kRadius, kRadius};
  p.of = soil_material;
  p.rate = rate;
  p.velocity = {0, -0.5, 0};
  p.interval = 50 * kStep;
  return p;
}

Bed bin(int threads = 1) { return boxed_bed(sand(), {{0, 0, 0}, {kSide, 0.2, kSide}}, threads); }

void run(Bed& bed, Inlet& inlet, double until) {
  while (bed.time() < until - 0.5 * kStep) {
    inlet.pour(bed, bed.time() > 0 ? kStep : 0);
    bed.step(kStep);
  }
}

double mass(const Bed& bed) {
  double sum = 0;
  for (const Sphere& s : bed.spheres()) sum += s.m;
  return sum;
}

TEST(Inlet, PoursItsRateInMassAndInNumber) {
  for (const bool counts : {false, true}) {
    InletPlan plan = feed(counts ? 400 : 0.3);
    plan.counts = counts, plan.from = 0.1, plan.until = 0.6;
    Bed bed = bin();
    Inlet inlet(plan);
    const double largest = density * sphere_volume(kRadius);
    for (const double t : {0.05, 0.3, 0.5, 0.8}) {
      run(bed, inlet, t);
      const double opened = std::clamp(t, plan.from, plan.until) - plan.from;
      // Half a sphere, and what has become due since the last interval began.
      const double one = counts ? 1 : largest;
      EXPECT_NEAR(inlet.come(), plan.rate * opened, 0.5 * one + plan.rate * plan.interval) << t;
      EXPECT_NEAR(mass(bed), inlet.poured().mass, 1e-12);
      EXPECT_EQ(bed.spheres().size(), inlet.poured().spheres);
    }
    EXPECT_EQ(inlet.waited(), 0U);
  }
}

/// The mean volume of radii even in [a, b] is that of r^3: (b^4 - a^4)/(4 (b - a)). Of 150 spheres whose volumes have a
/// relative deviation of 0.2 the mean is within 5 % in three deviations.
TEST(Inlet, SpheresAreThoseOfItsDistributionInTheOrderThatIsKnownBefore) {
  InletPlan plan = feed(0.3);
  plan.first_id = 7, plan.id_step = 3;
  Bed bed = bin();
  Inlet inlet(plan);
  const std::vector<Sphere> known = inlet.due_by(0.4);
  run(bed, inlet, 0.4);
  ASSERT_GT(known.size(), 150U);
  ASSERT_LE(bed.spheres().size(), known.size());
  double volume = 0;
  for (const Sphere& s : bed.spheres()) {
    const Sphere& as = known.at((s.id - 7) / 3);
    EXPECT_EQ(as.id, s.id);
    EXPECT_EQ(as.r, s.r);
    EXPECT_EQ(as.m, s.m);
    volume += sphere_volume(s.r) / static_cast<double>(bed.spheres().size());
  }
  const double a = 0.8 * kRadius, b = kRadius;
  const double mean = 4.0 / 3.0 * pi * (std::pow(b, 4) - std::pow(a, 4)) / (4 * (b - a));
  EXPECT_NEAR(volume, mean, 0.05 * mean);
}

/// Falling without contact: leapfrog keeps the sum of (m/2) v_{n-1/2} v_{n+1/2} and -m g x but for (g dt)^2/8 of each
/// sphere. What comes must come with just that, at the velocity that it has at that instant.
TEST(Inlet, FallingSpheresKeepTheEnergyThatTheyComeWith) {
  BedOptions options = quiet({0, -9.81, 0});
  Bed bed(sand(), options);
  InletPlan plan = feed(0.3);
  plan.region = Bounds{{0, 0, 0}, {1, 0.1, 1}};  // too wide to meet
  Inlet inlet(plan);
  double worst = 0, moved = 0;
  while (bed.time() < 0.3) {
    inlet.pour(bed, bed.time() > 0 ? kStep : 0);
    bed.step(kStep, {.energy = true});
    worst = std::max(worst, std::abs(bed.energy().total()));
    moved = std::max(moved, bed.energy().kinetic);
  }
  ASSERT_GT(moved, 0.05);
  EXPECT_LT(worst, 1e-6 * moved);
}

/// What the balance misses by 0.3 s, of what has come, J. @param brought by the inlet
double missing(double step, double& brought) {
  Bed bed = bin();
  Inlet inlet(feed(0.5));
  double worst = 0;
  while (bed.time() < 0.3) {
    inlet.pour(bed, bed.time() > 0 ? step : 0);
    bed.step(step, {.energy = true});
    worst = std::max(worst, std::abs(bed.energy().total() - bed.energy().boundary_work));
  }
  brought = inlet.poured().energy();
  return worst;
}

/// Impacts miss the square of the step over their duration, as in a bed that gets no spheres: half the step, a quarter
/// of it; less than a quarter of that factor is left to impacts that begin elsewhere within their step.
TEST(Inlet, EnergyClosesWithTheSquareOfTheStep) {
  double brought = 0;
  const double coarse = missing(kStep, brought), fine = missing(0.25 * kStep, brought);
  EXPECT_GT(coarse, 10 * fine);
  EXPECT_LT(fine, 2e-3 * brought);
}

TEST(Inlet, SameBitsOnAnyNumberOfThreads) {
  std::uint64_t expected = 0;
  for (const int threads : {1, 2}) {
    Bed bed = bin(threads);
    Inlet inlet(feed(1.5));
    run(bed, inlet, 0.15);
    const std::uint64_t now = hash(bed);
    ASSERT_GT(bed.spheres().size(), 200U);
    if (threads == 1) expected = now;
    EXPECT_EQ(now, expected) << threads;
  }
}

TEST(Inlet, ContinuesFromAStateWithTheSameBits) {
  Bed whole = bin();
  Inlet all(feed(0.5));
  run(whole, all, 0.4);
  Bed first = bin();
  Inlet before(feed(0.5));
  run(first, before, 0.1503);
  Archive kept;
  InletState state = before.state();
  state.archive(kept);
  Archive read = kept.to_read();
  InletState back;
  back.archive(read);
  Bed second = bin();
  second.restore(first.save());
  Inlet after(feed(0.5));
  after.restore(back);
  run(second, after, 0.4);
  EXPECT_EQ(hash(second), hash(whole));
  EXPECT_EQ(after.poured().mass, all.poured().mass);
}

/// More than there is room for: spheres wait, none comes into another, and the energy that none has stays none.
TEST(Inlet, WaitsWhereThereIsNoRoom) {
  InletPlan plan = feed(20);
  plan.region = Bounds{{0.03, 0.05, 0.03}, {0.06, 0.08, 0.06}};
  Bed bed = bin();
  Inlet inlet(plan);
  double fastest = 0, most = 0;
  while (bed.time() < 0.5) {
    inlet.pour(bed, bed.time() > 0 ? kStep : 0);
    bed.step(kStep);
    fastest = std::max(fastest, bed.max_speed()), most = std::max(most, bed.max_overlap());
  }
  EXPECT_GT(inlet.waited(), 20U);
  EXPECT_LT(inlet.come(), 0.5 * inlet.asked(0.5));
  EXPECT_GT(inlet.poured().spheres, 100U);
  // A fall from the region: no sphere is pushed out by another that came into it.
  EXPECT_LT(fastest, 1.1 * std::sqrt(0.25 + 2 * 9.81 * 0.08));
  EXPECT_LT(most, 0.1);
}

/// Neither a wall nor a sphere is met by one that comes; of a disk all centres lie in its plane, within its rim.
TEST(Inlet, ComesInItsRegionAndTouchesNothing) {
  BedOptions options = quiet();
  Bed bed(sand(), options);
  Boundary floor;
  floor.shape = Plane({0, 0, 0}, {0, 1, 0}), floor.material = 1;
  bed.add(floor);
  InletPlan plan = feed(2000);
  plan.counts = true, plan.velocity = {};
  const Vec3 centre{0.1, 0.02, 0.1}, normal{1, 1, 0};
  plan.region = InletDisk{centre, normal, 0.1};
  Inlet inlet(plan);
  run(bed, inlet, 0.05);
  ASSERT_GT(bed.spheres().size(), 30U);
  EXPECT_TRUE(bed.contacts().empty());
  const Vec3 n = (1 / norm(normal)) * normal;
  for (const Sphere& s : bed.spheres()) {
    EXPECT_GE(s.x.y, s.r);
    EXPECT_NEAR(dot(s.x - centre, n), 0, 1e-12);
    EXPECT_LE(norm(s.x - centre), 0.1 - s.r + 1e-12);
  }
}

/// Numbers between those of spheres that are there already: what is written has each sphere once, where it is.
TEST(Inlet, ComesInASnapshotBetweenEarlierNumbers) {
  Bed bed = bin();
  InletPlan odd = feed(400), even = feed(400);
  odd.first_id = 1, odd.id_step = even.id_step = 2, even.from = 0.1, even.seed = 2;
  Inlet first(odd), second(even);
  Snapshot shot;
  for (int step = 0; step < 2000; ++step) {
    const double before = step > 0 ? kStep : 0;
    first.pour(bed, before), second.pour(bed, before);
    std::map<std::uint32_t, Vec3> places;
    for (const Sphere& sphere : bed.spheres()) places[sphere.id] = sphere.x;
    bed.step(kStep, {.energy = false, .snapshot = &shot});
    ASSERT_EQ(shot.id.size(), places.size());
    std::size_t k = 0;
    for (const auto& [id, place] : places) {
      ASSERT_EQ(shot.id[k], id);
      ASSERT_EQ(norm(shot.position[k++] - place), 0);
    }
  }
  EXPECT_GT(second.poured().spheres, 20U);
}

TEST(Inlet, RefusesWhatCannotBe) {
  const auto message = [](const InletPlan& plan) { return subsoil::test::message_of([&] { Inlet inlet(plan); }); };
  EXPECT_NE(message(feed(0)).find("rate must be above zero"), std::string::npos);
  InletPlan narrow = feed(1);
  narrow.region = Bounds{{0, 0, 0}, {0.1, 0.1, 0.009}};
  EXPECT_NE(message(narrow).find("9 mm long in z, less than the diameter 10 mm"), std::string::npos);
  narrow.region = InletDisk{{0, 0, 0}, {0, 1, 0}, 0.004};
  EXPECT_NE(message(narrow).find("8 mm wide"), std::string::npos);
  InletPlan late = feed(1);
  late.from = 2, late.until = 1;
  EXPECT_NE(message(late).find("open before it closes"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::dem::test::inlet_test
