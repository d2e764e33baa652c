#include <gtest/gtest.h>

#include <bit>

#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_law.hpp"
#include "tests/tools/message_of.hpp"

/// Periodic sides: what meets across one is what meets anywhere else.
namespace subsoil::dem::test::engine_periodic {
namespace {

using subsoil::test::message_of;

constexpr Vec3 period{0.17, 0.19, 0.23};  // m

BedOptions all_around(int threads, Precision precision = Precision::doubles, const Vec3& low = {-0.03, 0.01, 0.02}) {
  BedOptions o = quiet({}, threads);
  o.precision = precision;
  o.periodic = {low, period};
  return o;
}

/// Least of all distances between the places of two spheres and their images.
Vec3 apart(const Vec3& a, const Vec3& b, const PeriodicCell& cell) { return cell.shortest(a - b); }

struct PairRun {
  std::vector<Snapshot> at;
  std::vector<BedEnergy> energy;
  std::size_t formed = 0, broken = 0;
  long rebuilds = 0;
};

/// Two spheres that meet, slip, roll and twist on each other, and drift together; the first at `place`.
PairRun meet(const Law& law, BedOptions options, const Vec3& place) {
  options.skin = 4e-4;
  Bed bed(table(law), options);
  const Vec3 n = normalized({0.8, 0.5, -0.6}), drift{4, 3, -5};
  const double r = 0.01, gap = -2e-5;
  bed.add(std::vector<SphereSpec>{{place, drift, {30, -20, 10}, r, 1800, 0},
                                  {place + (1.9 * r + gap) * n, drift - 0.5 * n, {-10, 25, 40}, 0.9 * r, 1800, 0}});
  bed.form_bonds();
  PairRun out;
  for (int step = 0; step < 2000; ++step) {
    Snapshot s;
    const bool looks = step % 50 == 0;
    bed.step(1e-5, {.energy = looks, .snapshot = looks ? &s : nullptr});
    if (looks) out.at.push_back(s), out.energy.push_back(bed.energy());
  }
  out.formed = bed.bonds().formed, out.broken = bed.bonds().broken(), out.rebuilds = bed.rebuilds();
  return out;
}

/// The same pair in a bed without sides. Positions differ by roundings of 1e-17 m of 0.3 m, which a stiffness of 1e6
/// N/m over a mass of 5 g makes to 1e-9 m/s2 at most; in 30 ms to 1e-11 m/s, and less by damping. Mixed precision
/// rounds velocities to 1e-6 m/s.
void expect_same_pair(const std::string& name, const Law& law, Precision precision) {
  BedOptions open = all_around(1, precision), around = open;
  open.periodic = {};
  const Vec3 middle{0.05, 0.1, 0.13}, corner = around.periodic.low + period - Vec3{0.007, 0.004, -0.003};
  const PairRun a = meet(law, open, middle), b = meet(law, around, corner);
  const bool doubles = precision == Precision::doubles;
  const double slow = doubles ? 1e-9 : 2e-5;
  ASSERT_EQ(a.at.size(), b.at.size());
  EXPECT_GT(b.rebuilds, 10) << name;
  EXPECT_EQ(a.formed, b.formed) << name;
  EXPECT_EQ(a.broken, b.broken) << name;
  double force = 0;
  for (std::size_t k = 0; k < a.at.size(); ++k) {
    const Snapshot &p = a.at[k], &q = b.at[k];
    for (std::size_t i = 0; i < 2; ++i) {
      force = std::max(force, norm(p.force[i]));
      EXPECT_LT(norm(p.velocity[i] - q.velocity[i]), slow) << name << k;
      EXPECT_LT(norm(p.angular_velocity[i] - q.angular_velocity[i]), slow / 0.01) << name << k;
      EXPECT_EQ(p.contacts[i], q.contacts[i]) << name << k;
      EXPECT_EQ(q.position[i], around.periodic.wrapped(q.position[i])) << name << k;
      EXPECT_LT(norm(apart(p.position[i] - middle, q.position[i] - corner, around.periodic)), 0.03 * slow) << name << k;
    }
    const BedEnergy &e = a.energy[k], &f = b.energy[k];
    const double kinetic = 0.2 * slow;  // J: a momentum of 0.1 kg m/s times the difference
    EXPECT_NEAR(e.kinetic + e.rotational, f.kinetic + f.rotational, kinetic) << name << k;
    EXPECT_NEAR(e.stored, f.stored, kinetic) << name << k;
    EXPECT_NEAR(e.lost.total(), f.lost.total(), kinetic) << name << k;
  }
  EXPECT_GT(force, 0.01) << name;
}

TEST(Periodic, APairAcrossASideIsAnyOtherPair) {
  for (const auto& [name, law] : every_law())
    for (const Precision precision : {Precision::doubles, Precision::mixed}) expect_same_pair(name, law, precision);
}

/// A dense cloud of spheres that fly about; `offset` moves all of it.
Bed cloud(const Law& law, const BedOptions& options, double speed, double spread = 0.3, const Vec3& offset = {}) {
  Bed bed(table(law), options);
  Dice dice(5);
  auto spheres = loose_lattice(options.periodic.low + offset, 8, 9, 11, 0.0209, 0.01, spread, speed, dice);
  bed.add(spheres);
  return bed;
}

std::vector<int> contacts_by_brute_force(const Snapshot& s, const PeriodicCell& cell) {
  std::vector<int> out(s.id.size(), 0);
  for (std::size_t i = 0; i < s.id.size(); ++i)
    for (std::size_t j = i + 1; j < s.id.size(); ++j)
      if (norm(apart(s.position[i], s.position[j], cell)) < s.radius[i] + s.radius[j]) ++out[i], ++out[j];
  return out;
}

/// Also after long ways in which spheres are measured against each other, across sides as well.
TEST(Periodic, NoContactIsMissed) {
  for (const double spread : {0.0, 0.8}) {
    const BedOptions options = all_around(1);
    Bed bed = cloud(grains(), options, 3, spread);
    int found = 0;
    for (int step = 0; step < 400; ++step) {
      Snapshot s;
      bed.step(2e-5, {.energy = false, .snapshot = step % 20 == 0 ? &s : nullptr});
      if (step % 20 != 0) continue;
      const std::vector<int> expected = contacts_by_brute_force(s, options.periodic);
      EXPECT_EQ(s.contacts, expected) << step;
      for (const int n : expected) found += n;
    }
    EXPECT_GT(found, 500);
    EXPECT_GT(bed.rebuilds(), 10);
  }
}

/// Without friction and damping a gas keeps momentum to rounding, and energy but for leapfrog's own error, which goes
/// with the square of the step: collisions of pi sqrt(m/(2 k)) = 0.7 ms take 70 steps, (2 pi/140)^2/24 = 1e-4.
TEST(Periodic, AnElasticGasKeepsMomentumAndEnergy) {
  Bed bed = cloud(grains(1e5, 1, 0, 0), all_around(1), 3, 0.2);
  const auto momentum = [](const Snapshot& s) {
    Vec3 sum;
    for (std::size_t i = 0; i < s.id.size(); ++i) sum += 1800 * sphere_volume(s.radius[i]) * s.velocity[i];
    return sum;
  };
  const Snapshot first = observe(bed, 1e-5);
  const BedEnergy start = bed.energy();
  for (int step = 0; step < 1500; ++step) bed.step(1e-5);
  const Snapshot last = observe(bed, 1e-5);
  const BedEnergy end = bed.energy();
  EXPECT_LT(norm(momentum(last) - momentum(first)), 1e-12 * 792 * 7.5e-3 * 3);
  EXPECT_NEAR(end.total(), start.total(), 2e-4 * start.kinetic);
  EXPECT_GT(norm(last.velocity[0] - first.velocity[0]), 0.1) << "they have collided";
}

/// Gravity along a periodic direction, losses of all kinds: the balance closes as in any bed.
TEST(Periodic, TheEnergyBalanceClosesWhileSpheresGoRound) {
  BedOptions options = all_around(1);
  options.gravity = {30, -20, 10};
  options.sample_every = 1;
  Bed bed = cloud(grains(), options, 1);
  bed.step(1e-5, {.energy = true});
  const double start = bed.energy().total();
  for (int step = 0; step < 3000; ++step) bed.step(1e-5);
  bed.step(1e-5, {.energy = true});
  const BedEnergy& e = bed.energy();
  EXPECT_LT(e.removed, -1) << "J that gravity gave to those that went round";
  EXPECT_NEAR(e.total(), start, 1e-3 * e.lost.total());
}

/// Two beds of which one is moved by a part of the period differ by rounding: 1e-16 m, which collisions multiply, some
/// ten of each sphere by less than ten.
TEST(Periodic, WhereTheSidesAreDoesNotMatter) {
  const BedOptions options = all_around(1);
  const Vec3 offset{0.37 * period.x, 0.61 * period.y, 0.83 * period.z};
  Bed a = cloud(grains(), options, 1), b = cloud(grains(), options, 1, 0.3, offset);
  for (int step = 0; step < 600; ++step) a.step(1e-5), b.step(1e-5);
  const Snapshot s = observe(a, 1e-5), t = observe(b, 1e-5);
  for (std::size_t i = 0; i < s.id.size(); ++i) {
    EXPECT_LT(norm(apart(s.position[i] + offset, t.position[i], options.periodic)), 1e-9) << i;
    EXPECT_LT(norm(s.velocity[i] - t.velocity[i]), 1e-7) << i;
  }
}

struct Fingerprint {
  std::uint64_t spheres, snapshot;
  double stored, lost;
  bool operator==(const Fingerprint&) const = default;
};
Fingerprint fingerprint(Bed& bed) {
  const Snapshot s = observe(bed, 1e-5);
  std::uint64_t h = 0;
  for (std::size_t i = 0; i < s.id.size(); ++i)
    h = 31 * h + static_cast<std::uint64_t>(s.contacts[i]) + std::bit_cast<std::uint64_t>(s.force[i].x + s.torque[i].y);
  return {hash(bed), h, bed.energy().stored, bed.energy().lost.total()};
}

TEST(Periodic, SameBitsOnAnyNumberOfThreads) {
  int laws = 0;
  for (const auto& [name, law] : every_law()) {
    const int k = laws++;
    const auto run = [&](int threads) {
      BedOptions options = all_around(threads, k % 3 == 0 ? Precision::mixed : Precision::doubles);
      options.cache_blocks = k % 2 == 0 ? 3 : 0;
      Bed bed = cloud(law, options, 3, 0.3);
      bed.let_bonds_form();
      for (int step = 0; step < 40; ++step) bed.step(2e-5);
      return fingerprint(bed);
    };
    const Fingerprint one = run(1);
    for (const int threads : {2, 3}) EXPECT_TRUE(run(threads) == one) << name << ", " << threads << " threads";
  }
}

TEST(Periodic, ARestartEndsWithTheSameBits) {
  int laws = 0;
  for (const auto& [name, law] : every_law()) {
    const BedOptions options = all_around(1, laws++ % 3 == 0 ? Precision::mixed : Precision::doubles);
    Bed straight = cloud(law, options, 3);
    straight.let_bonds_form();
    for (const int stop : {0, 37, 60}) {
      for (int step = 0; step < stop; ++step) straight.step(1e-5);
      Bed on(table(law), options);
      on.restore(straight.save());
      for (int step = 0; step < 60; ++step) straight.step(1e-5), on.step(1e-5);
      EXPECT_TRUE(fingerprint(straight) == fingerprint(on)) << name << stop;
      EXPECT_EQ(straight.bonded_pairs(), on.bonded_pairs()) << name;
    }
  }
}

/// Frozen blocks have images, too: the bed comes to rest as one of which nothing is frozen.
TEST(Periodic, AColumnRestsOnItsFloorWithItsWeight) {
  for (const bool freezes : {false, true}) {
    BedOptions options = quiet({0, -9.81, 0});
    options.periodic = {{0, 0, 0}, {0.1, 0, 0.12}};
    Bed bed(table(grains(1e4, 0.1)), options);
    Dice dice(3);
    bed.add(loose_lattice({0, 0, 0}, 5, 10, 6, 0.02, 0.01, 0.2, 0.1, dice));
    const int floor = add_plane(bed, {0, 0, 0}, {0, 1, 0});
    if (freezes) bed.set_active(ActiveRule{.within = 0.1, .below = 1e-3});
    double weight = 0;
    for (const Sphere& s : bed.spheres()) weight += 9.81 * s.m;
    // One sphere rolls to and fro in its place for 2 s before most of the bed falls asleep.
    for (int step = 0; step < 24000; ++step) bed.step(1e-4);
    EXPECT_LT(bed.max_speed(), 5e-3);
    EXPECT_EQ(bed.removed_count(), 0u);
    EXPECT_NEAR(bed.boundary(floor).wrench.force.y, -weight, 2e-3 * weight);
    EXPECT_LT(std::abs(bed.boundary(floor).wrench.force.x), 0.02 * weight);
    if (freezes) {
      EXPECT_GT(bed.frozen_count(), 0u);
    }
  }
}

/// One that is fixed at a side holds one beyond it.
TEST(Periodic, AFixedSphereActsAcrossASide) {
  BedOptions options = quiet({0, -9.81, 0});
  options.periodic = {{0, 0, 0}, {0, 0.2, 0}};
  Bed bed(table(grains(1e4, 0.3)), options);
  const SphereSpec held{{0, 0.0148, 0}, {}, {}, 0.01, 1800, 0}, low{{0, 0.195, 0}, {}, {}, 0.01, 1800, 0};
  bed.add(std::vector<SphereSpec>{fixed(low), held});
  for (int step = 0; step < 6000; ++step) bed.step(1e-4);
  const double weight = 9.81 * 1800 * sphere_volume(0.01);
  ASSERT_EQ(bed.fixed_spheres().size(), 1u);
  EXPECT_NEAR(bed.fixed_spheres()[0].force.y, -weight, 1e-3 * weight);
  EXPECT_EQ(sphere(bed, 0).x, low.position);
}

/// Grains flow round over a floor of fixed ones: what these have been pushed by is what gravity gave and the others
/// have not, to rounding.
TEST(Periodic, AFloorOfFixedSpheresTakesTheImpulse) {
  BedOptions options = quiet({4, -9, 0});
  options.periodic = {{0, 0, 0}, {0.08, 0, 0.06}};
  Bed bed(table(grains(2500, 0.88, 0.5)), options);
  Dice dice(7);
  bed.add(loose_lattice({0, 0, 0}, 8, 7, 6, 0.01, 0.005, 0.1, 0.5, dice));
  const std::size_t held = bed.fix_if([](const Sphere& s) { return s.x.y < 0.01; });
  EXPECT_EQ(held, 48u);
  const auto momentum = [&](double& mass) {
    Vec3 sum;
    mass = 0;
    for (const Sphere& s : bed.spheres())
      if (!is_fixed(s)) sum += s.m * s.v, mass += s.m;
    return sum;
  };
  constexpr double dt = 6e-5;
  bed.step(dt);
  double mass = 0;
  const Vec3 start = momentum(mass);
  Vec3 impulse;
  for (int step = 0; step < 4000; ++step) {
    bed.step(dt);
    for (const FixedSphere& f : bed.fixed_spheres()) impulse += dt * f.force;
  }
  const Vec3 given = 4000 * dt * mass * options.gravity;
  EXPECT_LT(norm(momentum(mass) - start + impulse - given), 1e-12 * norm(given));
  EXPECT_GT(norm(momentum(mass)) / mass, 0.05) << "they flow";
  ASSERT_EQ(bed.fixed_spheres().size(), 48u);
}

TEST(Periodic, SpheresThatComeAndLeaveKeepTheOthersHistories) {
  const BedOptions options = all_around(2);
  Bed a = cloud(grains(), options, 1), b = cloud(grains(), options, 1);
  for (int step = 0; step < 100; ++step) a.step(1e-5), b.step(1e-5);
  const SphereSpec far{{0.05, 0.1, 0.1}, {}, {}, 1e-4, 1800, 0};
  b.add(std::span(&far, 1));
  EXPECT_EQ(a.save().pairs.size(), b.save().pairs.size());
  EXPECT_EQ(b.remove_if([](const Sphere& s) { return s.r < 1e-3; }), 1u);
  for (int step = 0; step < 100; ++step) a.step(1e-5), b.step(1e-5);
  for (std::uint32_t id = 0; id < 792; ++id)
    EXPECT_LT(norm(apart(sphere(a, id).x, sphere(b, id).x, options.periodic)), 1e-10) << id;
}

/// The skin shrinks to a tenth of a radius before a period is refused: 2 (2 r + r/10) = 42 mm.
TEST(Periodic, ShortPeriodsAreRefused) {
  const auto step_in = [](double period) {
    BedOptions options = quiet();
    options.periodic = {{0, 0, 0}, {period, 0, 0}};
    Bed bed(table(grains()), options);
    const SphereSpec one{{0, 0, 0}, {}, {}, 0.01, 1800, 0};
    bed.add(std::span(&one, 1));
    bed.step(1e-5);
  };
  EXPECT_EQ(message_of([&] { step_in(0.0421); }), "accepted");
  EXPECT_EQ(
      message_of([&] { step_in(0.041); }),
      "the period of 0.041 m in x is too short: a sphere could meet another one from both sides; it must be 0.042 "
      "m at least, twice the distance up to which neighbours are listed (two radii, the range of the law and the "
      "skin): a longer container, or smaller spheres");
}

TEST(Periodic, SurfacesThatEndAtASideAreRefused) {
  const auto step_beside = [](const Plane& plane) {
    BedOptions options = quiet();
    options.periodic = {{0, 0, 0}, {0.1, 0, 0}};
    Bed bed(table(grains()), options);
    const SphereSpec one{{0.05, 0.05, 0}, {}, {}, 0.01, 1800, 0};
    bed.add(std::span(&one, 1));
    Boundary b;
    b.name = "wall", b.shape = plane;
    bed.add(b);
    bed.step(1e-5);
  };
  step_beside(Plane({0, 0, 0}, {0, 1, 0}));
  const std::string said = message_of([&] { step_beside(Plane({0, 0, 0}, {0.1, 1, 0})); });
  EXPECT_NE(said.find("the surface 'wall' comes nearer than 0.014 m to a periodic side of the bed in x"),
            std::string::npos)
      << said;
}

TEST(PeriodicCell, WrapsOnceAndForAll) {
  const PeriodicCell cell{{0.1, 0, -0.3}, {0.3, 0, 0.7}};
  Dice dice(8);
  for (int k = 0; k < 100000; ++k) {
    Vec3 x = dice.ball(3);
    if (k % 3 == 0) x.x = std::nextafter(0.1 + 0.3 * (k % 7 - 3), k % 2 == 0 ? -9.0 : 9.0);
    const Vec3 w = cell.wrapped(x);
    EXPECT_TRUE(w.x >= 0.1 && w.x < 0.1 + 0.3 && w.z >= -0.3 && w.z < -0.3 + 0.7 && w.y == x.y);
    EXPECT_EQ(cell.wrapped(w), w);
    EXPECT_LT(norm(cell.shortest(w - x)), 1e-14);
  }
  EXPECT_TRUE(std::isnan(cell.wrapped({NAN, 0, 0}).x)) << "is found as no place";
}

}  // namespace
}  // namespace subsoil::dem::test::engine_periodic
