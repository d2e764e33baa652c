#include <gtest/gtest.h>

#include <bit>

#include "libdem/packing/measure.hpp"
#include "libdem/particles/rigid_rotation.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/message_of.hpp"

/// Clumps across periodic sides: members go round one by one, and the clump stays one body.
namespace subsoil::dem::test::clumps_periodic {
namespace {

using subsoil::test::message_of;

constexpr double kRadius = 5e-3;                // m
constexpr Vec3 kPeriod{0.14, 0.16, 0.18};       // m
constexpr Vec3 kLow{-0.03, 0.01, 0.02};         // m
constexpr std::size_t kClumps = 6 * 6 * 7 / 2;  // every second grain of the cloud

ClumpShape bent() {
  return clump_shape("bent", {{{0, 0, 0}, kRadius}, {{6e-3, 0, 0}, 4e-3}, {{8e-3, 6e-3, 1e-3}, 4e-3}}, 1500);
}

BedOptions all_around(int threads = 1, Precision precision = Precision::doubles) {
  BedOptions o = quiet({}, threads);
  o.precision = precision;
  o.periodic = {kLow, kPeriod};
  return o;
}

/// Clumps and spheres that fly about; `offset` moves all of it.
Bed cloud(const Linear& law, const BedOptions& options, double speed, const Vec3& offset = {}) {
  Bed bed(table(law), options);
  const int shape = bed.add_shape(bent());
  Dice dice(5);
  bool clump = false;
  for (const SphereSpec& s : loose_lattice(kLow + offset, 6, 6, 7, 0.0225, kRadius, 0.3, speed, dice)) {
    const Vec3 turn = dice.ball(3);
    const ClumpSpec c{shape, s.position, Quaternion::from_rotation_vector(turn), s.velocity, dice.ball(20), 0};
    if (clump = !clump; clump)
      bed.add(std::span(&c, 1));
    else
      bed.add(std::vector<SphereSpec>{s});
  }
  return bed;
}

std::uint64_t hash_all(const Bed& bed) {
  std::uint64_t h = hash(bed);
  const auto take = [&](double x) { h = (h ^ std::bit_cast<std::uint64_t>(x)) * 1099511628211ull; };
  for (const Clump& c : bed.clumps()) {
    take(c.position.x), take(c.position.y), take(c.position.z);
    take(c.angular_momentum.x), take(c.attitude.w);
  }
  return h;
}

/// Members that lie a period away from their place in the clump.
std::size_t parted_clumps(const Bed& bed) {
  std::size_t count = 0;
  for (const Clump& c : bed.clumps()) {
    bool parted = false;
    for (std::uint32_t m = 0; m < 3; ++m) parted |= norm(sphere(bed, c.first_sphere + m).x - c.position) > 0.05;
    count += parted;
  }
  return count;
}

/// A gas without friction and damping. What forces do to a body across a side is what they do to its other half, so
/// momentum stays to rounding; energy but for leapfrog's error, (2 pi/140)^2/24 = 1e-4 of what collides, and that of
/// the rotation, of second order as well.
TEST(ClumpsPeriodic, AnElasticGasKeepsMomentumAndEnergy) {
  Bed bed = cloud(grains(1e5, 1, 0, 0), all_around(), 3);
  const auto momentum = [&] {
    Vec3 sum;
    for (const Sphere& s : bed.spheres())
      if (bed.clump_of(s) < 0) sum += s.m * s.v;
    for (const Clump& c : bed.clumps()) sum += bed.clump_shapes()[c.shape].mass * c.velocity;
    return sum;
  };
  observe(bed, 5e-6);
  const Vec3 first = momentum();
  const BedEnergy start = bed.energy();
  const Vec3 before = bed.clumps().front().velocity;
  std::size_t parted = 0;
  for (int step = 0; step < 3000; ++step) {
    bed.step(5e-6);
    if (step % 500 == 0) parted += parted_clumps(bed);
  }
  observe(bed, 5e-6);
  double mass = 0;
  for (const Sphere& s : bed.spheres()) mass += s.m;
  EXPECT_LT(norm(momentum() - first), 1e-12 * mass * 3);
  EXPECT_NEAR(bed.energy().total(), start.total(), 1e-3 * start.kinetic);
  EXPECT_GT(norm(bed.clumps().front().velocity - before), 0.1) << "they have collided";
  EXPECT_GT(parted, 20u) << "some lie across a side";
}

/// Two beds of which one is moved by a part of the period differ by rounding, 1e-17 m, of which every collision of a
/// body makes ten times as much.
TEST(ClumpsPeriodic, WhereTheSidesAreDoesNotMatter) {
  const BedOptions options = all_around();
  const Vec3 offset{0.37 * kPeriod.x, 0.61 * kPeriod.y, 0.83 * kPeriod.z};
  Bed a = cloud(grains(), options, 1), b = cloud(grains(), options, 1, offset);
  for (int step = 0; step < 600; ++step) a.step(1e-5), b.step(1e-5);
  observe(a, 1e-5), observe(b, 1e-5);
  ASSERT_EQ(a.clumps().size(), kClumps);
  EXPECT_GT(parted_clumps(b), 10u);
  for (std::size_t k = 0; k < kClumps; ++k) {
    const Clump &p = a.clumps()[k], &q = b.clumps()[k];
    EXPECT_LT(norm(options.periodic.shortest(p.position + offset - q.position)), 1e-9) << k;
    EXPECT_LT(norm(p.velocity - q.velocity), 1e-7) << k;
    EXPECT_LT(norm(p.angular_momentum - q.angular_momentum), 1e-12) << k;
  }
  EXPECT_NEAR(a.energy().total(), b.energy().total(), 1e-9 * a.energy().total());
  const Bounds cell{kLow, kLow + kPeriod};
  EXPECT_EQ(report(a, cell).coordination, report(b, {kLow, kLow + kPeriod}).coordination);
}

/// Gravity along periodic directions, losses of all kinds.
TEST(ClumpsPeriodic, TheEnergyBalanceClosesWhileClumpsGoRound) {
  BedOptions options = all_around();
  options.gravity = {30, -20, 10};
  options.sample_every = 1;
  Bed bed = cloud(grains(), options, 1);
  bed.step(1e-5, {.energy = true});
  const double start = bed.energy().total();
  for (int step = 0; step < 6000; ++step) bed.step(1e-5);
  bed.step(1e-5, {.energy = true});
  const BedEnergy& e = bed.energy();
  EXPECT_LT(e.removed, -0.1) << "J that gravity gave to those that went round";
  EXPECT_NEAR(e.total(), start, 2e-3 * e.lost.total());
  for (const Clump& c : bed.clumps())
    EXPECT_LT(norm(options.periodic.wrapped(c.position) - c.position), 0.25) << "within a period of the cell";
}

TEST(ClumpsPeriodic, SameBitsOnAnyNumberOfThreadsAndAfterARestart) {
  for (const Precision precision : {Precision::doubles, Precision::mixed}) {
    const auto advance = [](Bed& bed, int steps) {
      for (int n = 0; n < steps; ++n) bed.step(1e-5, {.energy = true, .snapshot = nullptr});
    };
    Bed straight = cloud(grains(), all_around(1, precision), 3);
    advance(straight, 300);
    EXPECT_GT(straight.rebuilds(), 3);
    EXPECT_GT(parted_clumps(straight), 0u);
    for (const int threads : {2, 3}) {
      Bed other = cloud(grains(), all_around(threads, precision), 3);
      advance(other, 300);
      EXPECT_EQ(hash_all(other), hash_all(straight)) << threads;
    }
    for (const int stop : {0, 17, 150}) {
      advance(straight, stop);
      Bed on(table(grains()), all_around(1, precision));
      for (const ClumpShape& s : straight.clump_shapes()) on.add_shape(s);
      on.restore(straight.save());
      advance(straight, 200), advance(on, 200);
      EXPECT_EQ(hash_all(on), hash_all(straight)) << stop;
      EXPECT_EQ(on.energy().total(), straight.energy().total()) << stop;
    }
  }
}

/// A rod as long as the period would meet its own end.
TEST(ClumpsPeriodic, APeriodIsLongerThanItsClumps) {
  const auto refused = [](double length) {
    BedOptions options = all_around();
    options.periodic.length.x = length;
    Bed bed(table(grains()), options);
    std::vector<ClumpMember> members;
    for (int k = 0; k < 12; ++k) members.push_back({{8e-3 * k, 0, 0}, kRadius});
    const int shape = bed.add_shape(clump_shape("rod", members, 1500));
    const ClumpSpec spec{shape, {0, 0.1, 0.1}, Quaternion::from_rotation_vector({0, 1.5, 0}), {}, {}, 0};
    bed.add(std::span(&spec, 1));
    return message_of([&] { bed.step(1e-5); });
  };
  EXPECT_NE(refused(0.09).find("a clump could meet itself"), std::string::npos) << refused(0.09);
  EXPECT_EQ(refused(0.105), "accepted");
}

}  // namespace
}  // namespace subsoil::dem::test::clumps_periodic
