#include <gtest/gtest.h>

#include <map>
#include <memory>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/packing/fibres.hpp"
#include "libdem/packing/settle.hpp"
#include "libdem/step/stability.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_law.hpp"

/// Spheres at rest far from all moving surfaces are frozen: what is frozen acts as a sphere at rest, nothing of the
/// energy gets lost, what moves wakes it, and threads, precision and restart are no matter. A trough of 1,882 spheres,
/// eight particle blocks along it, brought to rest once; a blade enters at one end.
namespace subsoil::dem::test::active_bed {
namespace {

constexpr double kStep = 2e-5, kBelow = 5e-4, kWithin = 0.05;
constexpr int kLong = 105, kHigh = 4, kWide = 5;

struct Scene {
  std::unique_ptr<Bed> bed;
  Motion blade;

  void step(int n, bool moves, bool energy = false) {
    for (int k = 0; k < n; ++k) {
      if (moves) blade.place(*bed);
      bed->step(kStep, {.energy = energy, .snapshot = nullptr});
    }
  }
};

struct Kind {
  bool clumps = false;  ///< every second grain, of two spheres each
  int threads = 1;
  Precision precision = Precision::doubles;
  int cache_blocks = 1;
  int sample_every = 1;
};

Scene scene(const Law& law, const Kind& kind = {}) {
  BedOptions options = quiet({0, -9.81, 0}, kind.threads);
  options.precision = kind.precision, options.cache_blocks = kind.cache_blocks;
  options.sample_every = kind.sample_every;
  options.skin = 4e-3;
  Scene s{std::make_unique<Bed>(table(law), options), {}};
  add_bin(*s.bed, kLong * 0.0201, kWide * 0.0201);
  Boundary b;
  b.shape = MeshSurface(box_mesh({0.02, 0.1, 0.06}));
  s.blade = {s.bed->add(std::move(b)), {{0.1, 0.119, 0.05}, {}}, {0.4, -0.6, 0}, {}};
  s.blade.place(*s.bed);
  s.bed->boundary(s.blade.boundary).velocity = {};
  if (kind.clumps) s.bed->add_shape(clump_shape("dumbbell", {{{-6e-4, 0, 0}, 9e-3}, {{6e-4, 0, 0}, 9e-3}}, 1800));
  return s;
}

/// Layers of which each lies in the hollows of the one below: no column that might fall over.
std::vector<SphereSpec> stacked_layers() {
  constexpr double pitch = 0.0201, rise = 0.0141;
  Dice dice(5);
  std::vector<SphereSpec> out;
  for (int j = 0; j < kHigh; ++j) {
    const int shifted = j % 2;
    for (int i = 0; i < kLong - shifted; ++i)
      for (int k = 0; k < kWide - shifted; ++k) {
        const Vec3 site{(i + 0.5 * (1 + shifted)) * pitch, 0.01 + j * rise, (k + 0.5 * (1 + shifted)) * pitch};
        out.push_back({.position = site + dice.ball(1e-4),
                       .velocity = {},
                       .angular_velocity = {},
                       .radius = 0.01,
                       .density = 1800});
      }
  }
  return out;
}

/// Loose spheres; or every second one is a clump that lies in its place, turned by chance.
void fill(Bed& bed, bool clumps) {
  const std::vector<SphereSpec> all = stacked_layers();
  if (!clumps) return bed.add(all);
  Dice dice(7);
  std::vector<SphereSpec> spheres;
  std::vector<ClumpSpec> of;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (k % 2 == 0)
      spheres.push_back(all[k]);
    else
      of.push_back({.shape = 0,
                    .position = all[k].position,
                    .attitude = Quaternion::from_rotation_vector(dice.ball(1.5)),
                    .velocity = {},
                    .angular_velocity = {}});
  }
  bed.add(spheres), bed.add(of);
}

/// The trough at rest under the law, made once for each.
const Bed::State& rest_of(const Law& law, const std::string& name, bool clumps) {
  static std::map<std::string, Bed::State> made;
  const std::string of = name + (clumps ? ", clumps" : "");
  if (const auto at = made.find(of); at != made.end()) return at->second;
  Scene s = scene(law, {.clumps = clumps});
  fill(*s.bed, clumps);
  for (int n = 0; n < 20; ++n) s.step(400, false), s.bed->freeze();
  s.step(4000, false);
  for (int n = 0; n < 40 && clumps && s.bed->max_speed() > 0.3 * kBelow; ++n)
    s.step(4000, false);  // the last ones topple
  return made[of] = s.bed->save();
}

Scene at_rest(const Law& law, const std::string& name, const Kind& kind = {}) {
  Scene s = scene(law, kind);
  s.bed->restore(rest_of(law, name, kind.clumps));
  s.bed->reset_energy_balance();
  s.bed->set_time(0);
  s.bed->set_active(ActiveRule{kWithin, kBelow});
  return s;
}

const Law kGrains = grains(1e4, 0.3, 0.5, 0.1);

TEST(ActiveBed, FreezesWhatRestsAndWakesAtTheBlade) {
  for (const bool clumps : {false, true}) {
    Scene s = at_rest(kGrains, "grains", {.clumps = clumps});
    EXPECT_EQ(s.bed->frozen_count(), 0u);
    s.step(600, false);
    EXPECT_EQ(s.bed->frozen_count(), s.bed->spheres().size());
    EXPECT_EQ(s.bed->max_speed(), 0);
    // The blade comes down: what is near it wakes, the far end does not.
    s.bed->set_time(0);
    s.step(100, true);
    const std::size_t near_blade = s.bed->spheres().size() - s.bed->frozen_count();
    EXPECT_GT(near_blade, 200u);
    EXPECT_LT(near_blade, s.bed->spheres().size() / 2);
    s.step(2500, true);
    EXPECT_GT(s.bed->max_speed(), 0.1);
    EXPECT_GT(norm(s.bed->boundary(s.blade.boundary).wrench.force), 1);
    EXPECT_GT(s.bed->frozen_count(), 0u);
  }
}

/// The floor carries the weight before and after; no sphere moves by freezing.
TEST(ActiveBed, FrozenSpheresActAsResting) {
  for (const bool clumps : {false, true}) {
    for (const Precision precision : {Precision::doubles, Precision::mixed}) {
      Scene s = at_rest(kGrains, "grains", {.clumps = clumps, .precision = precision});
      double weight = 0;
      for (const Sphere& p : s.bed->spheres()) weight += 9.81 * p.m;
      s.step(600, false);
      ASSERT_EQ(s.bed->frozen_count(), s.bed->spheres().size());
      const std::uint64_t before = hash(*s.bed);
      s.step(500, false);
      EXPECT_EQ(hash(*s.bed), before);
      double carried = 0;
      for (int b = 0; b < 5; ++b) carried -= s.bed->boundary(b).wrench.force.y;
      // Spheres fall asleep as they ring, at no more than kBelow and no faster than all twelve contacts make one: a =
      // kBelow sqrt(12 k/m). All together they ring in every phase; a tenth of it is left of the sum.
      const double ringing = kBelow * std::sqrt(12 * 1e4 / (1800 * sphere_volume(0.01)));
      EXPECT_NEAR(carried, weight, 0.1 * ringing / 9.81 * weight);
      // What a snapshot says of them: at rest, in balance.
      const Snapshot now = observe(*s.bed, kStep);
      std::map<long, Vec3> on;  // by body
      std::map<long, double> mass;
      for (const Sphere& p : s.bed->spheres()) {
        const auto k = static_cast<std::size_t>(std::find(now.id.begin(), now.id.end(), p.id) - now.id.begin());
        EXPECT_EQ(now.velocity[k], Vec3{});
        const long clump = s.bed->clump_of(p), body = clump < 0 ? -1 - static_cast<long>(p.id) : clump;
        on[body] += now.force[k], mass[body] = s.bed->mass_of_body(p);
      }
      for (const auto& [body, force] : on) EXPECT_LT(norm(force), mass[body] * ringing);
    }
  }
}

/// Fixed spheres sleep with what lies on them: floor and fixed spheres carry its weight all the while, and a restart
/// knows what they bear. One that moves, however slowly, does not: it keeps its velocity, and its block awake.
TEST(ActiveBed, FixedSpheresBearWhatSleepsOnThem) {
  for (const bool clumps : {false, true}) {
    Scene s = at_rest(kGrains, "grains", {.clumps = clumps});
    s.bed->fix_if([](const Sphere& p) { return p.x.y < 0.012; });
    double weight = 0;
    for (const Sphere& p : s.bed->spheres()) weight += is_fixed(p) ? 0 : 9.81 * p.m;
    const auto carried = [](const Bed& bed) {
      double sum = 0;
      for (int b = 0; b < 5; ++b) sum -= bed.boundary(b).wrench.force.y;
      for (const FixedSphere& f : bed.fixed_spheres()) sum -= f.force.y;
      return sum;
    };
    s.step(600, false);
    ASSERT_EQ(s.bed->frozen_count(), s.bed->spheres().size());
    s.step(500, false);
    ASSERT_EQ(s.bed->frozen_count(), s.bed->spheres().size());
    ASSERT_GT(s.bed->fixed_spheres().size(), 300u);
    // As FrozenSpheresActAsResting has it.
    const double ringing = kBelow * std::sqrt(12 * 1e4 / (1800 * sphere_volume(0.01)));
    EXPECT_NEAR(carried(*s.bed), weight, 0.1 * ringing / 9.81 * weight);
    Scene other = scene(kGrains, {.clumps = clumps});
    other.bed->set_active(ActiveRule{kWithin, kBelow});
    other.bed->restore(s.bed->save());
    s.step(1, false), other.step(1, false);
    EXPECT_EQ(carried(*other.bed), carried(*s.bed));
  }
  Bed bed(table(kGrains), quiet({0, -9.81, 0}, 1));
  add_bin(bed, 1, 1);
  bed.add(std::vector<SphereSpec>{{.position = {0.5, 0.5, 0.5},
                                   .velocity = {0.1 * kBelow, 0, 0},
                                   .angular_velocity = {},
                                   .radius = 0.01,
                                   .density = 1800,
                                   .kind = SphereKind::fixed}});
  // A ball, and a clump, on fixed spheres that turn: their surfaces move at a fifth of `below`, and carry both along.
  const int pair = bed.add_shape(clump_shape("pair", {{{0, 0, -0.02}, 0.01}, {{0, 0, 0.02}, 0.01}}, 1800));
  const double spin = 0.2 * kBelow / 0.01, sink = 1e-6;
  for (int row = 0; row < 2; ++row)
    for (const double x : {0.29, 0.3, 0.31})
      for (const double z : {0.28, 0.32})
        bed.add(std::vector<SphereSpec>{{.position = {x + 0.2 * row, 0.1, z},
                                         .velocity = {},
                                         .angular_velocity = {0, 0, -spin},
                                         .radius = 0.01,
                                         .density = 1800,
                                         .kind = SphereKind::fixed}});
  bed.add(std::vector<ClumpSpec>{
      {.shape = pair, .position = {0.3, 0.12 - sink, 0.3}, .attitude = {}, .velocity = {}, .angular_velocity = {}}});
  bed.set_active(ActiveRule{kWithin, kBelow});
  for (int k = 0; k < 5000; ++k) bed.step(kStep);
  EXPECT_EQ(bed.frozen_count(), 0u);
  EXPECT_GT(std::abs(bed.clumps().front().position.x - 0.3), 1e-6) << "it is carried along, or rolls";
  const auto first =
      std::find_if(bed.spheres().begin(), bed.spheres().end(), [](const Sphere& p) { return p.id == 0; });
  EXPECT_NEAR(first->x.x - 0.5, 5000 * kStep * 0.1 * kBelow, 1e-12);
}

/// In the step in which spheres are frozen the balance changes by rounding alone: K_n goes to `frozen`.
TEST(ActiveBed, NoEnergyGetsLostInFreezing) {
  for (const bool clumps : {false, true}) {
    for (const Precision precision : {Precision::doubles, Precision::mixed}) {
      Scene s = at_rest(kGrains, "grains", {.clumps = clumps, .precision = precision});
      s.bed->set_gravity({0.05, -9.81, 0});  // it sways
      s.step(100, false, true);
      ASSERT_GT(s.bed->max_speed(), 0.005 * kBelow);
      double total = s.bed->energy().total(), frozen = 0, scale = 0;
      bool none_moved = false;
      int freezings = 0;
      for (int n = 0; n < 2000; ++n) {
        const double moved = s.bed->energy().kinetic + s.bed->energy().rotational;
        const std::size_t before = s.bed->frozen_count();
        s.step(1, false, true);
        const BedEnergy& e = s.bed->energy();
        scale = std::max(scale, moved);
        if (e.frozen > frozen) ++freezings;
        EXPECT_GE(e.frozen, frozen);
        frozen = e.frozen;
        none_moved = before == s.bed->spheres().size();
        if (none_moved) {
          EXPECT_EQ(e.kinetic + e.rotational, 0);
          // The first energy asked for after the last freezing finds springs beyond their limit and does not book their
          // slip.
          EXPECT_NEAR(e.total(), total, 1e-12 * total);
        }
        // What the integrator makes of turning normals in a step, of second order, stays far below what moves.
        EXPECT_NEAR(e.total(), total, 0.02 * scale);
        total = e.total();
      }
      EXPECT_TRUE(none_moved);
      EXPECT_GT(freezings, 0);
      EXPECT_GT(frozen, 0);
    }
  }
}

/// Under the blade: kinetic + spin + gravity + stored + lost + frozen = start + work, within the 1 % of the energy
/// test.
TEST(ActiveBed, BalanceClosesUnderTheBlade) {
  for (const bool clumps : {false, true}) {
    for (const int every : {1, 16}) {
      Scene s = at_rest(kGrains, "grains", {.clumps = clumps, .sample_every = every});
      s.step(600, false, true);
      const BedEnergy start = s.bed->energy();
      s.bed->set_time(0);
      s.step(3000, true);
      s.step(1, true, true);
      const BedEnergy& end = s.bed->energy();
      EXPECT_GT(s.bed->frozen_count(), 0u);
      const double work = end.boundary_work - start.boundary_work;
      EXPECT_GT(work, 1e-2);
      EXPECT_NEAR(end.total() - start.total(), work, (every == 1 ? 0.01 : 0.03) * (work + end.lost.total()));
    }
  }
}

struct Trace {
  std::uint64_t spheres = 0;
  std::vector<std::size_t> frozen;
  double total = 0, taken = 0, wrench = 0;
  bool operator==(const Trace&) const = default;
};

/// At rest, then the blade, then at rest again: blocks freeze and wake.
Trace trace(const Law& law, const std::string& name, const Kind& kind) {
  Scene s = at_rest(law, name, kind);
  Trace t;
  const auto go = [&](int steps, bool moves) {
    for (int n = 0; n < steps; n += 50) {
      s.step(49, moves), s.step(1, moves, true);
      t.frozen.push_back(s.bed->frozen_count());
      t.wrench += norm(s.bed->boundary(s.blade.boundary).wrench.force);
    }
  };
  go(350, false);
  s.bed->set_time(0);
  go(400, true);
  s.bed->boundary(s.blade.boundary).velocity = {};
  go(350, false);
  t.spheres = hash(*s.bed);
  t.total = s.bed->energy().total(), t.taken = s.bed->energy().frozen;
  return t;
}

void same_bits(const Law& law, const std::string& name, Kind kind, std::initializer_list<int> threads) {
  kind.sample_every = 8;
  const Trace one = trace(law, name, kind);
  const auto most = std::max_element(one.frozen.begin(), one.frozen.end());
  EXPECT_EQ(one.frozen.front(), 0u) << name;
  EXPECT_GT(*most, 1000u) << name;
  EXPECT_LT(*std::min_element(most, one.frozen.end()), *most) << name << ": none wakes";
  for (const int n : threads) {
    kind.threads = n;
    EXPECT_TRUE(trace(law, name, kind) == one) << name << ", " << n << " threads";
  }
}

TEST(ActiveBed, SameBitsOnAnyNumberOfThreads) {
  same_bits(kGrains, "grains", {}, {2, 3, 8});
  same_bits(kGrains, "grains", {.precision = Precision::mixed, .cache_blocks = 3}, {2, 3});
  same_bits(kGrains, "grains", {.clumps = true}, {2, 3, 8});
  same_bits(kGrains, "grains", {.clumps = true, .precision = Precision::mixed, .cache_blocks = 3}, {2, 3});
}
TEST(ActiveBed, SameBitsWithBonds) {
  for (const auto& [name, law] : every_law())
    if (law->bond() != nullptr) return same_bits(law, name, {.cache_blocks = 3}, {2, 3});
}

/// Frames and energies of frozen spheres change neither what wakes nor a bit of the motion.
TEST(ActiveBed, ObservationChangesNoBit) {
  for (const bool clumps : {false, true}) {
    for (const Precision precision : {Precision::doubles, Precision::mixed}) {
      const auto end = [&](int energy_every, int frame_every) {
        Scene s = at_rest(kGrains, "grains", {.clumps = clumps, .precision = precision, .sample_every = 8});
        std::vector<std::size_t> frozen;
        Snapshot frame;
        for (int n = 1; n <= 1500; ++n) {
          if (n == 600) s.bed->set_time(0);
          if (n >= 600) s.blade.place(*s.bed);
          s.bed->step(kStep, {.energy = n % energy_every == 0, .snapshot = n % frame_every == 0 ? &frame : nullptr});
          frozen.push_back(s.bed->frozen_count());
        }
        EXPECT_EQ(frozen[590], s.bed->spheres().size());
        EXPECT_LT(frozen.back(), s.bed->spheres().size());
        EXPECT_GT(frozen.back(), 0u);
        return std::pair(hash(*s.bed), frozen);
      };
      const auto plain = end(10'000, 10'000);
      EXPECT_EQ(end(7, 10'000), plain);
      EXPECT_EQ(end(10'000, 5), plain);
    }
  }
}

/// What neighbours and surfaces do not tell is found by the forces: a wall that is taken away, another gravity.
TEST(ActiveBed, ForcesOutOfBalanceWake) {
  for (const bool clumps : {false, true}) {
    Scene s = at_rest(kGrains, "grains", {.clumps = clumps});
    s.step(600, false);
    ASSERT_EQ(s.bed->frozen_count(), s.bed->spheres().size());
    s.bed->boundary(2).active = false;  // the wall at the far end
    s.bed->surfaces_changed();
    s.step(2, false);
    EXPECT_LT(s.bed->frozen_count(), s.bed->spheres().size());
    EXPECT_GT(s.bed->frozen_count(), s.bed->spheres().size() / 2);
    s.step(1000, false);
    EXPECT_GT(s.bed->max_speed(), 0.01);

    Scene tilted = at_rest(kGrains, "grains", {.clumps = clumps});
    tilted.step(600, false);
    ASSERT_EQ(tilted.bed->frozen_count(), tilted.bed->spheres().size());
    tilted.bed->set_gravity({9.81, -2, 0});
    tilted.step(2, false);
    EXPECT_EQ(tilted.bed->frozen_count(), 0u);
  }
}

/// A wall that pushes slower than `below` wakes no neighbour by speed. The stress does, as far as it reaches: the wall
/// meets the resistance of the bed without sleep. Were the soil beside it rigid, the resistance would be a multiple.
TEST(ActiveBed, ASlowLoadWakesWhatItReaches) {
  for (const bool clumps : {false, true}) {
    constexpr double below = 10 * kBelow;
    const auto resistance = [&](bool sleeps) {
      Scene s = at_rest(kGrains, "grains", {.clumps = clumps});
      s.bed->set_active(sleeps ? std::optional(ActiveRule{0, below}) : std::nullopt);
      s.step(4000, false);  // 2 below/(0.02 g) is 0.05 s
      if (sleeps) {
        EXPECT_EQ(s.bed->frozen_count(), s.bed->spheres().size());
      }
      s.bed->set_time(0);
      Motion wall{1, s.bed->boundary(1).pose, {0.6 * below, 0, 0}, {}};
      const double before = -s.bed->boundary(1).wrench.force.x;
      for (int k = 0; k < 6000; ++k) wall.place(*s.bed), s.bed->step(kStep);
      if (sleeps) {
        EXPECT_LE(s.bed->frozen_count(), s.bed->spheres().size() - 512);
      }  // more than the block at the wall
      return -s.bed->boundary(1).wrench.force.x - before;
    };
    const double free = resistance(false);
    EXPECT_GT(free, 1);
    EXPECT_NEAR(resistance(true), free, 0.1 * free);
  }
}

/// Eight fibres of 2 m lie side by side on a floor, over several particle blocks each. Asleep, they are pushed at one
/// end: what wakes there wakes what it is bonded to, up to the far end, which comes as far as without sleep. The
/// strength is a hundred times the stress of the push, rho c v = 7 kPa, and no more: lists reach as far as a bond may
/// stretch.
TEST(ActiveBed, FibresWakeFromEndToEnd) {
  constexpr int spheres = 200, fibres = 8;
  constexpr double r = 5e-3, stiffness = 1e4, speed = 0.1, time = 0.1;
  Linear law = grains(stiffness, 0.5, 0.5, 0.1);
  law.bond = {.kind = Bond::Kind::fibre, .modulus = 1e7, .tensile = 1e6, .shear = 1e6, .damping = 0.1};
  const FibreShape shape{.length = 2 * r * spheres, .diameter = 2 * r, .of = {.density = 500, .material = 0}};
  const double sunk = shape.mass() / spheres * 9.81 / stiffness;
  const double dt =
      0.5 *
      stable_step(law, {.smallest_radius = r, .largest_radius = r, .density = 750, .speed = speed, .neighbours = 3})
          .step;
  const auto far_end = [&](bool sleeps) {
    Bed bed(table(law), quiet({0, -9.81, 0}, 1));
    add_bin(bed, 3, 0.2);
    std::vector<FibrePose> poses;
    for (int k = 0; k < fibres; ++k)
      poses.push_back({{0.05 + 0.5 * shape.length, r - sunk, 0.02 * (k + 1)}, {1, 0, 0}});
    bed.insert(fibres_at(shape, poses, 0));
    Boundary b;
    b.shape = MeshSurface(box_mesh({0.02, 0.1, 0.18}));
    Motion pusher{bed.add(std::move(b)), {{0.04 - 1e-6, 0.05, 0.09}, {}}, {speed, 0, 0}, {}};
    pusher.place(bed);
    bed.boundary(pusher.boundary).velocity = {};
    if (sleeps) bed.set_active(ActiveRule{kWithin, kBelow});
    for (int k = 0; k < 1000; ++k) bed.step(dt);
    const std::size_t all = bed.spheres().size();
    EXPECT_EQ(bed.frozen_count(), sleeps ? all : 0);
    bed.reset_energy_balance();
    bed.step(dt, {.energy = true});
    const BedEnergy start = bed.energy();
    bed.set_time(0);
    std::size_t least = all, partly = 0;
    for (long k = 0; k < std::lround(time / dt); ++k) {
      pusher.place(bed);
      bed.step(dt, {.energy = true});
      least = std::min(least, bed.frozen_count());
      partly += bed.frozen_count() > 0 && bed.frozen_count() < all ? 1 : 0;
    }
    if (sleeps) {
      EXPECT_GT(partly, 10U) << "the far end sleeps on at first";
      EXPECT_EQ(least, 0U) << "all of it wakes";
    }
    EXPECT_EQ(bed.bonds().broken(), 0U);
    const BedEnergy& end = bed.energy();
    const double work = end.boundary_work - start.boundary_work;
    EXPECT_GT(work, 1e-4);
    EXPECT_NEAR(end.total() - start.total(), work, 0.01 * work);
    double sum = 0;
    for (const Sphere& s : bed.spheres())
      if (s.id % spheres == spheres - 1) sum += s.x.x - (0.05 + shape.length - r);
    return sum / fibres;
  };
  const double awake = far_end(false);
  EXPECT_NEAR(awake, speed * time, 0.1 * speed * time);
  EXPECT_NEAR(far_end(true), awake, 0.05 * awake);
}

// In steps of 0.1 us a sphere has less than half of `below` after 256 steps, whatever accelerates it. One that falls
// and one that slides down a smooth slope of 3 degrees move all the same: g t^2/2 and g sin(alpha) t^2/2, less the
// first order dt/t of the step.
TEST(ActiveBed, ShortStepsFreezeNothingThatBeginsToMove) {
  constexpr double dt = 1e-7, g = 9.81, slope = 0.05236, r = 0.01, stiffness = 1e4;
  constexpr int steps = 20000;
  const double t = steps * dt, weight = 1800 * sphere_volume(r) * g;
  const auto way = [&](const Vec3& gravity, double height) {
    Bed bed(table(grains(stiffness, 0.5, 0, 0)), quiet(gravity, 1));
    add_bin(bed, 1, 1);
    bed.add(std::vector<SphereSpec>{
        {.position = {0.5, height, 0.5}, .velocity = {}, .angular_velocity = {}, .radius = r, .density = 1800}});
    bed.set_active(ActiveRule{kWithin, kBelow});
    for (int k = 0; k < steps; ++k) bed.step(dt);
    return bed.spheres().front().x - Vec3{0.5, height, 0.5};
  };
  const double fall = 0.5 * g * t * t;
  EXPECT_NEAR(way({0, -g, 0}, 0.1).y, -fall, 2 * dt / t * fall);
  const double sunk = weight * std::cos(slope) / stiffness, slide = fall * std::sin(slope);
  EXPECT_NEAR(way({g * std::sin(slope), -g * std::cos(slope), 0}, r - sunk).x, slide, 2 * dt / t * slide);
}

/// A restart continues with the same bits, whatever the save met: blocks that just fell asleep, that wake, that sleep.
TEST(ActiveBed, RestartContinuesWithTheSameBits) {
  for (const bool clumps : {false, true}) {
    for (const Precision precision : {Precision::doubles, Precision::mixed}) {
      Scene s = at_rest(kGrains, "grains", {.clumps = clumps, .precision = precision});
      std::vector<std::size_t> frozen;
      const auto compare = [&](bool moves, int before) {
        s.step(before, moves);
        frozen.push_back(s.bed->frozen_count());
        const Bed::State saved = s.bed->save();
        Scene other = scene(kGrains, {.clumps = clumps, .precision = precision});
        other.bed->set_active(ActiveRule{kWithin, kBelow});
        other.bed->restore(saved);
        for (int n = 0; n < 4; ++n) {
          s.step(37, moves), other.step(37, moves);
          for (int b = 0; b < s.bed->boundary_count(); ++b)
            ASSERT_EQ(other.bed->boundary(b).wrench.force, s.bed->boundary(b).wrench.force) << b;
          s.step(1, moves, true), other.step(1, moves, true);
          ASSERT_EQ(hash(*other.bed), hash(*s.bed)) << frozen.size() << ", " << n;
          ASSERT_EQ(other.bed->frozen_count(), s.bed->frozen_count());
          ASSERT_EQ(other.bed->energy().frozen, s.bed->energy().frozen);
        }
      };
      for (int k = 0; k < 4; ++k) compare(false, 1);
      compare(false, 100);
      s.bed->set_time(0);
      for (int k = 0; k < 6; ++k) compare(true, 50 + k);
      EXPECT_EQ(frozen.front(), 0u);
      EXPECT_GT(*std::max_element(frozen.begin(), frozen.end()), 1000u);
      EXPECT_LT(frozen.back(), frozen[4]);  // some woke
    }
  }
}

TEST(ActiveBed, RefusesRulesWithoutSense) {
  Bed bed(table(kGrains), quiet());
  EXPECT_THROW(bed.set_active(ActiveRule{-1, 1e-3}), std::invalid_argument);
  EXPECT_THROW(bed.set_active(ActiveRule{0.1, -1e-3}), std::invalid_argument);
  EXPECT_THROW(bed.set_active(ActiveRule{0.1, 0}), std::invalid_argument);  // and no gravity to derive it from
  bed.set_active(ActiveRule{0, 1e-3});
  EXPECT_TRUE(bed.freezes());
  bed.set_active({});
  EXPECT_FALSE(bed.freezes());
}

/// A bin 3 m long with a tine at one end: random packing of unequal spheres, brought to rest once.
namespace long_bin {

constexpr double kLength = 3, kBreadth = 0.1, kSpeed = 0.5, kLongStep = 4e-5;
const Law kSoil = grains(5e4, 0.4, 0.5, 0.2);

Scene scene() {
  Scene s{std::make_unique<Bed>(table(kSoil), quiet({0, -9.81, 0}, 1)), {}};
  add_bin(*s.bed, kLength, kBreadth);
  Boundary b;
  b.shape = MeshSurface(box_mesh({0.02, 0.2, 0.03}));
  s.blade = {s.bed->add(std::move(b)), {{0.1, 0.15, 0.05}, {}}, {kSpeed, 0, 0}, {}};
  s.blade.place(*s.bed);
  s.bed->boundary(s.blade.boundary).velocity = {};
  return s;
}

const Bed::State& rest() {
  static const Bed::State made = [] {
    Scene s = scene();
    Dice dice(11);
    std::vector<SphereSpec> spheres = loose_lattice({0.01, 0.01, 0}, 135, 6, 4, 0.0215, 0.01, 0.2, 0.05, dice);
    std::erase_if(spheres, [](const SphereSpec& p) { return p.position.x > 0.07 && p.position.x < 0.13; });
    s.bed->add(spheres);
    SettlePlan plan;
    plan.step = kLongStep;
    settle(*s.bed, table(kSoil), plan, {{0, 0, 0}, {kLength, 0.2, kBreadth}});
    return s.bed->save();
  }();
  return made;
}

struct Pass {
  std::vector<double> draft;  ///< N, means of 10 ms
  double awake = 0;           ///< mean share of the spheres
};

Pass pass(const std::optional<ActiveRule>& rule) {
  constexpr int steps = 6000, window = 250;
  Scene s = scene();
  s.bed->restore(rest());
  s.bed->set_time(0);
  s.bed->set_active(rule);
  Pass out;
  for (int n = 0; n < steps; n += window) {
    double sum = 0;
    for (int k = 0; k < window; ++k) {
      s.blade.place(*s.bed);
      s.bed->step(kLongStep);
      sum -= s.bed->boundary(s.blade.boundary).wrench.force.x;
      out.awake += 1 - static_cast<double>(s.bed->frozen_count()) / static_cast<double>(s.bed->spheres().size());
    }
    out.draft.push_back(sum / window);
  }
  out.awake /= steps;
  return out;
}

double mean(const std::vector<double>& x) {
  double sum = 0;
  for (const double v : x) sum += v;
  return sum / static_cast<double>(x.size());
}
/// Of the mean, from the means of windows, which hold several stick-slip events each.
double standard_error(const std::vector<double>& x) {
  double squares = 0;
  for (const double v : x) squares += (v - mean(x)) * (v - mean(x));
  const auto n = static_cast<double>(x.size());
  return std::sqrt(squares / (n * (n - 1)));
}

}  // namespace long_bin

/// With the limit by gravity and size less than four fifths of a bin of thirty tool widths is awake, and the draft is
/// the same within the error of its mean. The share depends on the course of the bed, and so on the last bits: below a
/// half with vectors of four doubles, 0.56 and 0.68 with eight and two orders of sums. That error is below a third
/// here: a draft that sleep changes by more is found.
TEST(ActiveBed, LongBinSleepsAndKeepsItsDraft) {
  using namespace long_bin;
  const Pass all = pass({}), few = pass(ActiveRule{0.2, 0});
  EXPECT_EQ(all.awake, 1);
  EXPECT_LT(few.awake, 0.8);
  EXPECT_GT(mean(all.draft), 1);
  EXPECT_LT(standard_error(all.draft), 0.3 * mean(all.draft));
  EXPECT_NEAR(mean(few.draft), mean(all.draft), standard_error(all.draft));
}

}  // namespace
}  // namespace subsoil::dem::test::active_bed
