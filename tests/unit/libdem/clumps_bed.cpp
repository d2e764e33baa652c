#include <gtest/gtest.h>

#include "libdem/packing/measure.hpp"
#include "libdem/packing/settle.hpp"
#include "libdem/particles/rigid_rotation.hpp"
#include "libdem/step/stability.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_law.hpp"

/// Clumps among the spheres of a bed: impacts of rigid bodies in closed form, rest on supports, what passes between
/// clump and spheres in steps, states and lists.
namespace subsoil::dem::test::clumps_bed {
namespace {

constexpr double kRadius = 5e-3;  // m

ClumpShape dumbbell(double apart = 2 * kRadius) {
  return clump_shape("dumbbell", {{{-0.5 * apart, 0, 0}, kRadius}, {{0.5 * apart, 0, 0}, kRadius}}, 1500);
}
ClumpShape bent() {
  return clump_shape("bent", {{{0, 0, 0}, kRadius}, {{6e-3, 0, 0}, 4e-3}, {{8e-3, 6e-3, 1e-3}, 4e-3}}, 1500);
}

/// The middle of the pair's motion at t_n, by leapfrog.
const Clump& only(const Bed& bed) { return bed.clumps().front(); }
Vec3 spin_of(const Bed& bed) {
  const Clump& c = only(bed);
  return angular_velocity_of(c.attitude, bed.clump_shapes()[c.shape].inertia, c.angular_momentum);
}

double kinetic(const Bed& bed) { return bed.kinetic_energy(); }

/// A dumbbell of which one end meets a plane, e = 1 to 0.3, without friction. The law's damping is that of the clump's
/// mass, so with the effective mass m* = 1/(1/M + (r x n).J^-1 (r x n)) at the end the oscillator of contact has the
/// damping ratio beta sqrt(M/m*), and the restitution e* = exp(-pi b/sqrt(1 - b^2)). Then P = (1 + e*) m* v,
/// V' = V + P n/M, w' = w + J^-1 (r x n) P (Routh). The dumbbell turns by w t_c ~ 3e-4 while it touches, of which
/// what comes out is wrong by as much; so is it by the 900 steps of a contact.
TEST(ClumpImpact, DumbbellOnAPlaneIsAsInClosedForm) {
  for (const double restitution : {1.0, 0.7, 0.3})
    for (const double tilt : {0.3, 0.8, 1.4}) {
      Linear law = grains(1e10, restitution, 0, 0);
      Bed bed(table(law), quiet());
      const ClumpShape shape = dumbbell();
      const int index = bed.add_shape(shape);
      const Vec3 velocity{0.2, -1, 0.1}, spin{0, 0, 5};
      const Vec3 arm{-kRadius * std::cos(tilt), -kRadius * std::sin(tilt), 0};
      const Quaternion attitude = Quaternion::from_rotation_vector({0, 0, tilt});
      const ClumpSpec spec{index, {0, kRadius - arm.y + 1e-7, 0}, attitude, velocity, spin, 0};
      bed.add(std::span(&spec, 1));
      add_plane(bed, {}, {0, 1, 0});
      for (int n = 0; n < 12000; ++n) bed.step(1e-9);

      const Vec3 n{0, 1, 0}, lever = cross(arm, n);
      const Vec3 turned = angular_velocity_of(attitude, shape.inertia, lever);
      const double m = 1 / (1 / shape.mass + dot(lever, turned));
      const double ratio = damping_ratio(restitution) * std::sqrt(shape.mass / m);
      const double e = ratio < 1 ? std::exp(-pi * ratio / std::sqrt(1 - ratio * ratio)) : 0;
      const double approach = -dot(velocity + cross(spin, arm), n), impulse = (1 + e) * m * approach;
      const Vec3 v = velocity + (impulse / shape.mass) * n, w = spin + impulse * turned;
      EXPECT_LT(norm(only(bed).velocity - v), 1e-3 * norm(velocity)) << restitution << ' ' << tilt;
      EXPECT_LT(norm(spin_of(bed) - w), 1e-3 * norm(w)) << restitution << ' ' << tilt;
      EXPECT_GT(norm(w - spin), 1);
    }
}

/// What a sphere does, a clump of that one sphere does: a heap that falls and slides, as loose spheres and as clumps.
/// The order of additions differs, so rounding does: 1e-16 of the numbers, of which each of some ten collisions makes
/// ten times as much.
TEST(Clumps, OneSphereIsTheSphere) {
  const auto run = [](bool clumps) {
    Bed bed(table(grains()), quiet({1, -9.81, 0}));
    const int shape = bed.add_shape(clump_shape("ball", {{{}, kRadius}}, 1800));
    Dice dice(5);
    const auto spheres = loose_lattice({}, 3, 4, 3, 2.02 * kRadius, kRadius, 0, 0.5, dice);
    if (!clumps) bed.add(spheres);
    for (const SphereSpec& s : spheres)
      if (const ClumpSpec c{shape, s.position, {}, s.velocity, s.angular_velocity, 0}; clumps)
        bed.add(std::span(&c, 1));
    add_bin(bed, 0.04, 0.04);
    for (int n = 0; n < 2000; ++n) bed.step(1e-5, {.energy = true, .snapshot = nullptr});
    return bed;
  };
  const Bed loose = run(false), clumps = run(true);
  for (std::uint32_t id = 0; id < 36; ++id) {
    const Sphere &a = sphere(loose, id), &b = sphere(clumps, id);
    EXPECT_LT(norm(a.x - b.x), 1e-11 * kRadius);
    EXPECT_LT(norm(a.v - b.v), 1e-9);
    EXPECT_LT(norm(a.w - b.w), 1e-7);
  }
  const BedEnergy &e = loose.energy(), &f = clumps.energy();
  EXPECT_NEAR(e.kinetic, f.kinetic, 1e-9 * e.total());
  EXPECT_NEAR(e.rotational, f.rotational, 1e-9 * e.total());
  EXPECT_NEAR(e.gravity, f.gravity, 1e-9 * e.total());
  EXPECT_NEAR(e.lost.total(), f.lost.total(), 1e-9 * e.total());
  EXPECT_GT(e.lost.sliding, 1e-3 * e.lost.total());
}

/// Spheres of one clump lie deep in each other and do not feel it.
TEST(Clumps, MembersDoNotMeet) {
  Bed bed(table(grains()), quiet());
  const int shape = bed.add_shape(dumbbell(kRadius));
  const ClumpSpec spec{shape, {1, 2, 3}, Quaternion::from_rotation_vector({1, 2, 3}), {}, {}, 0};
  bed.add(std::span(&spec, 1));
  for (int n = 0; n < 10; ++n) bed.step(1e-5);
  EXPECT_EQ(only(bed).position, (Vec3{1, 2, 3}));
  EXPECT_EQ(only(bed).velocity, Vec3{});
  EXPECT_EQ(bed.touching_pairs(), 0u);
  EXPECT_EQ(report(bed, {{0, 0, 0}, {2, 4, 4}}).coordination, 0);
}

/// A dumbbell in the plane x-y on two fixed spheres, the line between the centres at 30 degrees from the vertical
/// outward: each carries half the weight, N = M g/(2 cos 30). The overlaps, 1e-5 of a radius, move the contact normals
/// by as much.
TEST(Clumps, RestsOnTwoSpheres) {
  Linear law = grains(2e5, 0.3, 0, 0);
  Bed bed(table(law), quiet({0, -9.81, 0}));
  const ClumpShape shape = dumbbell();
  const int index = bed.add_shape(shape);
  const double a = pi / 6, across = kRadius + 2 * kRadius * std::sin(a);
  for (const double side : {-1.0, 1.0}) {
    const SphereSpec support = fixed({{side * across, 0, 0}, {}, {}, kRadius, 1500, 0});
    bed.add(std::span(&support, 1));
  }
  const ClumpSpec spec{index, {0, 2 * kRadius * std::cos(a), 0}, {}, {}, {}, 0};
  bed.add(std::span(&spec, 1));
  for (int n = 0; n < 40000; ++n) bed.step(1e-5);
  const double weight = 9.81 * shape.mass;
  ASSERT_EQ(bed.fixed_spheres().size(), 2u);
  for (const FixedSphere& f : bed.fixed_spheres()) {
    EXPECT_NEAR(f.force.y, -0.5 * weight, 1e-4 * weight);
    EXPECT_NEAR(std::abs(f.force.x), 0.5 * weight * std::tan(a), 2e-4 * weight);
  }
  EXPECT_LT(norm(only(bed).velocity), 1e-6);
}

struct Heap {
  Bed bed;
  double mass = 0;
};

/// Clumps of two shapes and loose spheres in a bin.
Heap heap(const Law& law, int threads = 1, Precision precision = Precision::doubles, int layers = 4, double skin = 0) {
  BedOptions options = quiet({0.5, -9.81, 0.2}, threads);
  options.skin = skin;
  options.precision = precision;
  options.overlap_limit = 0.95;
  Heap out{Bed(table(law), options)};
  Bed& bed = out.bed;
  const int shapes[] = {bed.add_shape(dumbbell(1.2 * kRadius)), bed.add_shape(bent())};
  ClumpPart parts[] = {clump_part(bed, shapes[0], 0.4), clump_part(bed, shapes[1], 0.4)};
  LoosePlacer placer({{}, {0.08, 0.2, 0.08}}, EqualRadius{kRadius}, ShareOf::number, 3, {1500, 0},
                     {parts[0], parts[1]});
  add(bed, placer.grains(static_cast<std::size_t>(9 * layers), 0));
  add_bin(bed, 0.08, 0.08);
  for (const Sphere& s : bed.spheres()) out.mass += s.m;
  return out;
}

TEST(Clumps, SharesOfMassSumToTheBed) {
  const Heap h = heap(grains());
  double mass = 0, volume = 0;
  std::size_t members = 0;
  for (const Clump& c : h.bed.clumps()) {
    mass += h.bed.clump_shapes()[c.shape].mass, volume += h.bed.clump_shapes()[c.shape].volume;
    members += h.bed.clump_shapes()[c.shape].members.size();
  }
  const std::size_t loose = h.bed.spheres().size() - members;
  EXPECT_GT(loose, 0u);
  EXPECT_GT(h.bed.clumps().size(), 20u);
  mass += static_cast<double>(loose) * 1500 * sphere_volume(kRadius);
  volume += static_cast<double>(loose) * sphere_volume(kRadius);
  double of_spheres = 0;
  for (const Sphere& s : h.bed.spheres()) of_spheres += h.bed.volume_of(s);
  EXPECT_NEAR(h.mass, mass, 1e-12 * mass);
  EXPECT_NEAR(of_spheres, volume, 1e-12 * volume);
  EXPECT_NEAR(report(h.bed, {{}, {0.08, 0.2, 0.08}}).mass, mass, 1e-12 * mass);
}

/// Of what is turned over, 1 % (tests/properties/energy.cpp), with every law; laws with bonds among them.
TEST(Clumps, EnergyCloses) {
  int laws = 0;
  for (const auto& [name, law] : every_law()) {
    Heap h = heap(law, 1, laws++ % 3 == 0 ? Precision::mixed : Precision::doubles);
    h.bed.let_bonds_form();
    const BedEnergy start = (h.bed.step(4e-6, {.energy = true, .snapshot = nullptr}), h.bed.energy());
    for (int n = 0; n < 20000; ++n) h.bed.step(4e-6);
    h.bed.step(4e-6, {.energy = true, .snapshot = nullptr});
    const BedEnergy end = h.bed.energy();
    const double lost = end.lost.total() - start.lost.total();
    const double gap = end.total() - start.total() - (end.boundary_work - start.boundary_work);
    EXPECT_LT(std::abs(gap), 0.01 * lost) << name << ": gap " << gap << " J of " << lost << " J lost";
    EXPECT_GT(lost, 1e-2 * h.mass) << name;
    EXPECT_GT(end.rotational, 0);
  }
}

TEST(Clumps, WeightIsOnTheFloor) {
  Heap h = heap(grains(1e5, 0.3, 0.5, 0.1));
  h.bed.set_gravity({0, -9.81, 0});
  for (int n = 0; n < 60000; ++n) h.bed.step(1e-5);
  Snapshot s = observe(h.bed, 1e-5);
  double floor = 0, above = 0;
  for (int k = 0; k < h.bed.boundary_count(); ++k) floor += h.bed.boundary(k).wrench.force.y;
  for (const Vec3& f : s.force) above += f.y;
  const double weight = 9.81 * h.mass;
  EXPECT_LT(std::sqrt(2 * kinetic(h.bed) / h.mass), 2 * rest_speed(kRadius, 9.81));
  EXPECT_NEAR(floor, -weight, 5e-3 * weight);
  // Contacts and gravity on all grains: what the floor carries is the rest of it.
  EXPECT_NEAR(above, -weight - floor, 1e-9 * weight);
}

std::uint64_t hash_all(const Bed& bed) {
  std::uint64_t h = hash(bed);
  for (const Clump& c : bed.clumps())
    for (const double x : {c.attitude.w, c.attitude.x, c.attitude.y, c.attitude.z, c.angular_momentum.x,
                           c.angular_momentum.y, c.angular_momentum.z, c.position.x, c.velocity.y}) {
      std::uint64_t bits;
      std::memcpy(&bits, &x, 8);
      h = (h ^ bits) * 1099511628211ull;
    }
  return h;
}

TEST(Clumps, SameBitsOnAnyNumberOfThreads) {
  for (const Precision precision : {Precision::doubles, Precision::mixed}) {
    std::uint64_t one = 0;
    BedEnergy energy;
    for (const int threads : {1, 2, 3, 8}) {
      Heap h = heap(grains(), threads, precision, 40, 3e-4);
      h.bed.set_gravity({20, -300, 10});
      for (int n = 0; n < 200; ++n) h.bed.step(2e-5, {.energy = n == 199, .snapshot = nullptr});
      EXPECT_GT(h.bed.rebuilds(), 2);
      EXPECT_GT(h.bed.spheres().size(), 3u * 256);
      if (threads == 1) one = hash_all(h.bed), energy = h.bed.energy();
      EXPECT_EQ(hash_all(h.bed), one) << threads;
      EXPECT_EQ(h.bed.energy().total(), energy.total()) << threads;
    }
  }
}

TEST(Clumps, RestartEndsWithTheSameBits) {
  for (const Precision precision : {Precision::doubles, Precision::mixed})
    for (const int stop : {0, 333, 900}) {
      Heap straight = heap(grains(), 1, precision), saved = heap(grains(), 1, precision);
      const auto advance = [](Bed& bed, int steps) {
        for (int n = 0; n < steps; ++n) bed.step(2e-5, {.energy = true, .snapshot = nullptr});
      };
      advance(straight.bed, stop), advance(saved.bed, stop);
      BedOptions options = saved.bed.options();
      Bed on(table(grains()), options);
      for (const ClumpShape& s : saved.bed.clump_shapes()) on.add_shape(s);
      add_bin(on, 0.08, 0.08);
      on.restore(saved.bed.save());
      advance(on, 300), advance(straight.bed, 300);
      EXPECT_EQ(hash_all(on), hash_all(straight.bed)) << stop;
      EXPECT_EQ(on.energy().total(), straight.bed.energy().total()) << stop;
      EXPECT_EQ(on.clumps().size(), straight.bed.clumps().size());
    }
  Bed without(table(grains()), quiet());
  add_bin(without, 0.08, 0.08);
  Bed::State state = heap(grains()).bed.save();
  EXPECT_THROW(without.restore(state), std::invalid_argument);
  Archive::Columns columns = state.parts.columns();
  columns.at("clumps/first sphere")[0] = 1e6;
  state.parts = Archive(std::move(columns), {});
  Heap other = heap(grains());
  EXPECT_THROW(other.bed.restore(state), std::invalid_argument);
}

/// A clump leaves as a whole, with its energy; the others stay themselves.
TEST(Clumps, LeaveAsAWhole) {
  Heap h = heap(grains());
  Bed& bed = h.bed;
  for (int n = 0; n < 100; ++n) bed.step(2e-5, {.energy = true, .snapshot = nullptr});
  const BedEnergy before = bed.energy();
  const std::size_t clumps = bed.clumps().size(), spheres = bed.spheres().size();
  const Clump last = bed.clumps().back(), first = bed.clumps().front();
  const std::uint32_t one = first.first_sphere + 1;
  const std::size_t members = bed.clump_shapes()[first.shape].members.size();
  EXPECT_EQ(bed.remove_if([&](const Sphere& s) { return s.id == one; }), members);
  ASSERT_EQ(bed.clumps().size(), clumps - 1);
  EXPECT_EQ(bed.spheres().size(), spheres - members);
  EXPECT_EQ(bed.clumps().back().id, last.id);
  EXPECT_EQ(bed.clumps().back().position, last.position);
  for (const Sphere& s : bed.spheres())
    if (s.id >= last.first_sphere) {
      EXPECT_EQ(bed.clump_of(s), static_cast<long>(clumps) - 2);
    }
  bed.step(2e-5, {.energy = true, .snapshot = nullptr});
  EXPECT_GT(bed.energy().removed, 0);
  EXPECT_NEAR(bed.energy().total(), before.total(), 2e-3 * std::abs(before.kinetic));
}

/// One member below the floor is enough.
TEST(Clumps, FallOutOfTheBed) {
  BedOptions options = quiet({0, -9.81, 0});
  options.floor_drop = -0.02;
  Bed bed(table(grains()), options);
  const int shape = bed.add_shape(dumbbell());
  const ClumpSpec specs[] = {{shape, {}, Quaternion::from_rotation_vector({0, 0, pi / 2}), {0, -1, 0}, {}, 0},
                             {shape, {1, 0.05, 0}, {}, {}, {}, 0}};
  bed.add(specs);
  for (int n = 0; n < 4000 && bed.clumps().size() == 2; ++n) bed.step(1e-5);
  ASSERT_EQ(bed.clumps().size(), 1u);
  EXPECT_EQ(bed.removed_count(), 2u);
  EXPECT_EQ(bed.clumps()[0].position.x, 1);
}

/// One that joins an active bed is awake: it falls, by g t (t + dt)/2 in leapfrog.
TEST(Clumps, JoinAnActiveBedAwake) {
  Bed bed(table(grains()), quiet({0, -9.81, 0}));
  const int shape = bed.add_shape(dumbbell());
  bed.set_active(ActiveRule{0.1, 1e-3});
  const ClumpSpec spec{shape, {0, 1, 0}, {}, {}, {}, 0};
  bed.add(std::span(&spec, 1));
  constexpr double dt = 1e-5;
  constexpr int steps = 2000;
  for (int n = 0; n < steps; ++n) bed.step(dt);
  EXPECT_EQ(bed.frozen_count(), 0u);
  EXPECT_NEAR(bed.clumps()[0].position.y, 1 - 0.5 * 9.81 * steps * dt * steps * dt, 9.81 * dt * steps * dt);
}

/// The bounds of a clump of one sphere are those of the sphere: in corners the same matrix, among twelve contacts the
/// same or shorter: 200 points in place of an even spread err by some 1/200, and the largest stiffness and the largest
/// damping may be of two modes, which the sphere's bound takes one by one.
TEST(Clumps, StableStepOfOneSphereIsTheSpheres) {
  int laws = 0;
  for (const auto& [name, law] : every_law()) {
    if (law->bond() != nullptr) continue;
    const Law resolved = table(law).laws[0];
    const StepQuestion q{
        .smallest_radius = kRadius, .largest_radius = kRadius, .density = 1500, .speed = 1, .neighbours = 12};
    const ClumpShape ball = clump_shape("ball", {{{}, kRadius}}, 1500);
    const double corner = stable_step_at_surface(resolved, q).step;
    EXPECT_NEAR(stable_step_at_surface(resolved, ball, q).step, corner, 1e-9 * corner) << name;
    const double among = stable_step(resolved, q).step;
    EXPECT_LT(stable_step(resolved, ball, q).step, 1.02 * among) << name;
    EXPECT_GT(stable_step(resolved, ball, q).step, 0.75 * among) << name;
    ++laws;
  }
  EXPECT_GT(laws, 5);
  EXPECT_NEAR(least_effective_mass(dumbbell()), 1 / (1 / dumbbell().mass + kRadius * kRadius / dumbbell().inertia.z),
              1e-9 * dumbbell().mass);
}

/// The bounds sample directions. A clump, also one whose axes rounding could choose, and its mirror images have the
/// same ones, so that a mirrored scenario has the same step. 1e-12: sums in another order.
TEST(Clumps, MirrorImagesHaveTheSameStableStep) {
  const std::vector<std::vector<ClumpMember>> shapes{
      {{{0, 0, 0}, kRadius}, {{6e-3, 1e-3, 2e-3}, 4e-3}},
      {{{-6e-3, 0, 0}, 8e-3}, {{6e-3, 1e-3, 0}, 7e-3}},
      {{{0, 0, 0}, kRadius}, {{6e-3, 0, 0}, 4e-3}, {{8e-3, 6e-3, 1e-3}, 4e-3}},
      {{{0, 0, 0}, kRadius}, {{5e-3, 1e-3, -2e-3}, 3e-3}, {{2e-3, 6e-3, 1e-3}, 4e-3}, {{-3e-3, 2e-3, 5e-3}, 3e-3}}};
  const Linear law = grains(1e5, 0.3, 0.5, 0.1);
  const Law resolved = heap(law).bed.laws().laws[0];
  const StepQuestion q{
      .smallest_radius = 4e-3, .largest_radius = kRadius, .density = 1500, .speed = 1, .neighbours = 12};
  for (const std::vector<ClumpMember>& members : shapes) {
    const ClumpShape shape = clump_shape("one", members, 1500);
    const double among = stable_step(resolved, shape, q).step, corner = stable_step_at_surface(resolved, shape, q).step;
    const double mass = least_effective_mass(shape);
    for (int d = 0; d < 3; ++d) {
      std::vector<ClumpMember> other = members;
      for (ClumpMember& m : other) m.at[d] = -m.at[d];
      const ClumpShape image = clump_shape("other", other, 1500);
      EXPECT_NEAR(stable_step(resolved, image, q).step, among, 1e-12 * among) << members.size() << " along " << d;
      EXPECT_NEAR(stable_step_at_surface(resolved, image, q).step, corner, 1e-12 * corner) << members.size();
      EXPECT_NEAR(least_effective_mass(image), mass, 1e-12 * mass) << members.size() << " along " << d;
    }
  }
}

/// At the bound a bed of clumps at rest stays at rest; at twelve times the bound it does not. It is that far on the
/// safe side here: grains of this heap have few contacts each, where the bound
/// takes twelve on every member.
TEST(Clumps, StableStepIsOnTheSafeSide) {
  const Linear law = grains(1e5, 0.3, 0.5, 0);
  Heap h = heap(law);
  Bed& bed = h.bed;
  bed.set_gravity({0, -9.81, 0});
  double step = 1;
  const StepQuestion q{
      .smallest_radius = 4e-3, .largest_radius = kRadius, .density = 1500, .speed = 1, .neighbours = 12};
  const Law& resolved = bed.laws().laws[0];
  for (const ClumpShape& shape : bed.clump_shapes())
    step = std::min({step, stable_step(resolved, shape, q).step, stable_step_at_surface(resolved, shape, q).step});
  step = std::min({step, stable_step(resolved, q).step, stable_step_at_surface(resolved, q).step});
  const auto advance = [&](double dt, double time) {
    for (double t = 0; t < time; t += dt) bed.step(dt);
  };
  advance(0.5 * step, 1.2);  // the last clump has rolled out, whatever the last bits are
  const double still = kinetic(bed);
  advance(0.98 * step, 0.1);
  EXPECT_LT(kinetic(bed), 2 * still + 1e-12);
  bed.set_limits(1e6, 1e6);
  advance(12 * step, 0.05);
  EXPECT_GT(kinetic(bed), 100 * still);
}

/// A bed filled to a depth: its mean surface is there, within half a grain, and no clump is cut.
TEST(Clumps, FillToADepth) {
  Bed bed(table(grains(1e4, 0.3, 0.3, 0)), quiet({0, -9.81, 0}));
  const int shape = bed.add_shape(dumbbell(1.5 * kRadius));
  add_bin(bed, 0.06, 0.06);
  RandomFill fill;
  fill.region = {{}, {0.06, 0.05, 0.06}};
  fill.radius = EqualRadius{kRadius}, fill.of = {1500, 0}, fill.depth = 0.04;
  fill.clumps = {clump_part(bed, shape, 0.7)};
  SettlePlan plan;
  plan.step = 4e-5;
  const SettleReport r = fill_at_random(bed, bed.laws(), fill, plan);
  EXPECT_NEAR(r.surface.mean, 0.04, kRadius);
  const double solid = r.mass / 1500, bulk = r.bulk_density / 1500;
  // Four diameters deep, where floor and surface, by the tops of the columns, take about one: 0.58 x 3/4.
  EXPECT_GT(bulk, 0.4);
  EXPECT_LT(bulk, 0.8);
  EXPECT_LT(solid, 0.8 * 0.06 * 0.06 * 0.045);
  std::size_t members = 0;
  for (const Sphere& s : bed.spheres()) members += bed.clump_of(s) >= 0;
  EXPECT_EQ(members, 2 * bed.clumps().size());
}

}  // namespace
}  // namespace subsoil::dem::test::clumps_bed
