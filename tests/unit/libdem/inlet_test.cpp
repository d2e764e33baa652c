// Spheres and clumps poured in while a bed steps: the rate, sizes, attitudes, energy, threads, restart, and what lies
// in the way.
#include "libdem/packing/inlet.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

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

/// Two spheres of unequal size that overlap, and three in a row, of 0.7 and 0.3 of the grains.
std::vector<ClumpShape> two_shapes() {
  return {clump_shape("pear", {{{0, 0, 0}, kRadius}, {{0.8 * kRadius, 0, 0}, 0.7 * kRadius}}, density),
          clump_shape("row", {{{}, 0.5 * kRadius}, {{kRadius, 0, 0}, 0.5 * kRadius}, {{0, kRadius, 0}, 0.5 * kRadius}},
                      density)};
}

/// The inlet pours clumps into a bed that has their shapes. @param clumps share of the grains; the rest are spheres
void pour_clumps(InletPlan& plan, Bed& bed, double clumps = 1) {
  for (const ClumpShape& shape : two_shapes()) bed.add_shape(shape);
  plan.shapes = bed.clump_shapes();
  plan.clumps = {clump_part(bed, 0, 0.7 * clumps), clump_part(bed, 1, 0.3 * clumps)};
  plan.id_step = 3;
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
  const std::vector<InletGrain> known = inlet.due_by(0.4);
  run(bed, inlet, 0.4);
  ASSERT_GT(known.size(), 150U);
  ASSERT_LE(bed.spheres().size(), known.size());
  double volume = 0;
  for (const Sphere& s : bed.spheres()) {
    const Sphere& as = known.at((s.id - 7) / 3).body;
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
  InletPlan plan = feed(0.5);
  plan.interval *= 0.7;  // of a run that would take another step: the state's holds
  Inlet after(plan);
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

/// Half of the heavier shape, and what has become due since the last interval began.
TEST(Inlet, ClumpsComeAtTheRateWithTheirMass) {
  Bed bed = bin();
  InletPlan plan = feed(0.3);
  pour_clumps(plan, bed, 0.8);
  Inlet inlet(plan);
  const double heaviest = std::max(density * sphere_volume(kRadius), bed.clump_shapes()[0].mass);
  for (const double t : {0.2, 0.4, 0.6}) {
    run(bed, inlet, t);
    EXPECT_NEAR(inlet.come(), plan.rate * t, 0.5 * heaviest + plan.rate * plan.interval) << t;
    EXPECT_NEAR(mass(bed), inlet.poured().mass, 1e-12);
  }
  // Of n draws each part has its share within four standard deviations.
  std::size_t loose = 0, pears = 0;
  for (const Sphere& s : bed.spheres()) loose += s.kind == SphereKind::free;
  for (const Clump& c : bed.clumps()) pears += c.shape == 0;
  const auto grains = static_cast<double>(inlet.poured().spheres);
  ASSERT_EQ(loose + bed.clumps().size(), inlet.poured().spheres);
  EXPECT_NEAR(static_cast<double>(loose) / grains, 0.2, 4 * std::sqrt(0.16 / grains));
  EXPECT_NEAR(static_cast<double>(pears) / grains, 0.56, 4 * std::sqrt(0.25 / grains));
  std::set<std::uint32_t> ids;
  for (const Sphere& s : bed.spheres()) ids.insert(s.id);
  EXPECT_EQ(ids.size(), bed.spheres().size()) << "each sphere has a number of its own";
}

/// The mean of a rotation matrix over all attitudes is 0, that of the square of each element 1/3, that of its fourth
/// power 1/5 (a coordinate of a point even on the sphere); so means of n have the variances 1/(3 n) and 4/(45 n).
TEST(Inlet, AttitudesOfClumpsAreEvenOverAll) {
  Bed bed = bin();
  InletPlan plan = feed(2);
  pour_clumps(plan, bed);
  const std::vector<InletGrain> grains = Inlet(plan).due_by(6);
  const auto n = static_cast<double>(grains.size());
  ASSERT_GT(n, 8000);
  for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
    Vec3 sum, squares;
    for (const InletGrain& g : grains) {
      const Vec3 turned = g.attitude.rotate(axis);
      sum += turned;
      for (int d = 0; d < 3; ++d) squares[d] += turned[d] * turned[d];
    }
    for (int d = 0; d < 3; ++d) {
      EXPECT_NEAR(sum[d] / n, 0, 3 * std::sqrt(1 / (3 * n))) << d;
      EXPECT_NEAR(squares[d] / n, 1.0 / 3, 3 * std::sqrt(4 / (45 * n))) << d;
    }
  }
}

/// Nothing turns a clump that falls freely, and leapfrog has no error where the acceleration is constant: every sphere
/// is where the closed form has it, from the attitude that the order of grains had given.
TEST(Inlet, AClumpFallsAsInClosedForm) {
  Bed bed(sand(), quiet({0, -9.81, 0}));
  InletPlan plan = feed(0.3);
  plan.region = Bounds{{0, 0, 0}, {1, 0.1, 1}};  // too wide to meet
  pour_clumps(plan, bed);
  Inlet inlet(plan);
  const std::vector<InletGrain> known = inlet.due_by(0.3);
  struct Start {
    double time;
    Vec3 centre;
  };
  std::map<std::uint32_t, Start> starts;
  double worst = 0, moved = 0;
  while (bed.time() < 0.3) {
    inlet.pour(bed, bed.time() > 0 ? kStep : 0);
    for (const Clump& c : bed.clumps()) starts.try_emplace(c.id, Start{bed.time(), c.position});
    bed.step(kStep, {.energy = true});
    worst = std::max(worst, std::abs(bed.energy().total()));
    moved = std::max(moved, bed.energy().kinetic);
  }
  ASSERT_GT(starts.size(), 100U);
  EXPECT_LT(worst, 1e-6 * moved);
  for (const Clump& c : bed.clumps()) {
    const Start& start = starts.at(c.id);
    const double t = bed.time() - start.time;
    const Vec3 centre = start.centre + t * plan.velocity + Vec3{0, -0.5 * 9.81 * t * t, 0};
    InletGrain grain = known.at(c.id / plan.id_step);
    grain.body.x = centre;
    for (const Sphere& expected : grain.spheres(plan.shapes)) {
      const Sphere& s = sphere(bed, expected.id);
      EXPECT_LT(norm(s.x - expected.x), 1e-12);
      EXPECT_EQ(s.r, expected.r);
      EXPECT_EQ(s.m, expected.m);
    }
  }
}

/// None comes into another or into a wall, however full the region is; those that wait keep their attitude.
TEST(Inlet, ClumpsComeWhereTheyTouchNothing) {
  InletPlan plan = feed(20);
  plan.region = Bounds{{0.02, 0.05, 0.02}, {0.08, 0.09, 0.08}};
  Bed bed = bin();
  pour_clumps(plan, bed);
  Inlet inlet(plan);
  const std::vector<InletGrain> known = inlet.due_by(0.3);
  std::size_t pours = 0;
  for (double t = 0; t < 0.3; t = bed.time()) {
    const std::size_t before = bed.clumps().size();
    if (inlet.pour(bed, t > 0 ? kStep : 0) > 0) {
      ++pours;
      std::set<std::uint32_t> fresh;
      for (std::size_t k = before; k < bed.clumps().size(); ++k) {
        const Clump& c = bed.clumps()[k];
        const auto count = static_cast<std::uint32_t>(plan.shapes[c.shape].members.size());
        for (std::uint32_t m = 0; m < count; ++m) fresh.insert(c.first_sphere + m);
        const Quaternion& drawn = known.at(c.id / plan.id_step).attitude;
        EXPECT_LT(norm(c.attitude.rotate({1, 2, 3}) - drawn.rotate({1, 2, 3})), 1e-14);
      }
      for (const ContactRecord& c : bed.contacts())
        EXPECT_FALSE(fresh.contains(c.i) || (!c.at_surface && fresh.contains(c.j)));
    }
    bed.step(kStep);
  }
  EXPECT_GT(pours, 5U);
  EXPECT_GT(inlet.waited(), 20U);
}

TEST(Inlet, ClumpsHaveTheSameBitsOnAnyNumberOfThreads) {
  std::uint64_t expected = 0;
  for (const int threads : {1, 2}) {
    Bed bed = bin(threads);
    InletPlan plan = feed(1.5);
    pour_clumps(plan, bed, 0.8);
    Inlet inlet(plan);
    run(bed, inlet, 0.1);
    ASSERT_GT(bed.clumps().size(), 100U);
    if (threads == 1) expected = hash(bed);
    EXPECT_EQ(hash(bed), expected) << threads;
  }
}

TEST(Inlet, ClumpsContinueFromAStateWithTheSameBits) {
  struct Poured {
    Bed bed = bin();
    InletPlan plan = feed(0.5);
    std::optional<Inlet> inlet;
    Poured() {
      pour_clumps(plan, bed, 0.8);
      inlet.emplace(plan);
    }
  };
  Poured whole, first, second;
  run(whole.bed, *whole.inlet, 0.4);
  run(first.bed, *first.inlet, 0.1503);
  second.bed.restore(first.bed.save());
  second.inlet->restore(first.inlet->state());
  run(second.bed, *second.inlet, 0.4);
  EXPECT_GT(second.bed.clumps().size(), 150U);
  EXPECT_EQ(hash(second.bed), hash(whole.bed));
  EXPECT_EQ(second.inlet->poured().mass, whole.inlet->poured().mass);
}

/// What the balance misses, of what has come, J: clumps that meet each other and walls.
double missing_of_clumps(double step, double& brought) {
  Bed bed = bin();
  InletPlan plan = feed(0.5);
  pour_clumps(plan, bed);
  Inlet inlet(plan);
  double worst = 0;
  while (bed.time() < 0.3) {
    inlet.pour(bed, bed.time() > 0 ? step : 0);
    bed.step(step, {.energy = true});
    worst = std::max(worst, std::abs(bed.energy().total() - bed.energy().boundary_work));
  }
  brought = inlet.poured().energy();
  return worst;
}

/// As for spheres: a quarter of the step misses a sixteenth, of which less than a quarter of the factor is left to
/// impacts that begin elsewhere within their step.
TEST(Inlet, EnergyOfClumpsClosesWithTheSquareOfTheStep) {
  double brought = 0;
  const double coarse = missing_of_clumps(0.5 * kStep, brought), fine = missing_of_clumps(0.125 * kStep, brought);
  EXPECT_GT(coarse, 4 * fine);
  EXPECT_LT(fine, 2e-3 * brought);
}

TEST(Inlet, ClumpsWithNumbersThatAreTakenAreRefused) {
  Bed bed(sand(), quiet());
  for (const ClumpShape& shape : two_shapes()) bed.add_shape(shape);
  const auto at = [](double x, int shape, std::uint32_t number) {
    return ClumpSpec{shape, {x, 0, 0}, {}, {}, {}, 0, number};
  };
  const auto message = [&](const std::vector<ClumpSpec>& clumps) {
    return subsoil::test::message_of([&] { bed.add(clumps); });
  };
  bed.add(std::vector{at(0, 0, 10), at(1, 1, 4)});  // 10, 11 and 4, 5, 6
  EXPECT_NE(message({at(2, 1, 8)}).find("a sphere of number 10 already"), std::string::npos);
  EXPECT_NE(message({at(2, 0, 6)}).find("a sphere of number 6 already"), std::string::npos);
  EXPECT_NE(message({at(2, 1, 20), at(3, 0, 22)}).find("a sphere of number 22 already"), std::string::npos);
  EXPECT_EQ(message({at(2, 1, 7), at(3, 0, 2)}), "accepted");
  bed.step(kStep);
  EXPECT_EQ(bed.spheres().size(), 10U);
  EXPECT_EQ(bed.clumps().size(), 4U);
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
