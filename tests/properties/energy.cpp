#include <gtest/gtest.h>

#include <memory>

#include "libdem/step/sampling.hpp"
#include "libdem/step/stability.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_law.hpp"

/// Kinetic + spin + gravity + stored + lost = start + work of boundaries, every term summed on its own. 1 % of what was
/// turned over (lost + |work|) is the bound; the terms come from mid-step velocities and mean forces, so what
/// remains is the half step in which a contact begins or jumps, of order dt.
namespace subsoil::dem::test::energy {
namespace {

struct EnergyRecord {
  BedEnergy start, end;
  double turned_over() const { return lost() + std::abs(end.boundary_work - start.boundary_work); }
  double lost() const { return end.lost.total() - start.lost.total(); }
  double gap() const { return end.total() - start.total() - (end.boundary_work - start.boundary_work); }
};

double step_for(const Law& law, double share) {
  const StepQuestion q{.smallest_radius = 0.007, .largest_radius = 0.01, .density = 1800, .speed = 3, .neighbours = 12};
  return share * std::min(stable_step(law, q).step, stable_step_at_surface(law, q).step);
}

/// A column of 80 spheres dropped into a bin; then `motions` act.
EnergyRecord run(const Law& law, const std::function<std::vector<Motion>(Bed&)>& surfaces, double time,
                 double share = 0.4, Precision precision = Precision::doubles) {
  const Law resolved = table(law).laws[0];
  BedOptions options = quiet({0, -9.81, 0});
  options.precision = precision;
  options.overlap_limit = 0.95;  // soft laws under a fast piston; the balance does not mind
  Bed bed(table(law), options);
  Dice dice(29);
  bed.add(loose_lattice({0.001, 0.002, 0.001}, 4, 5, 4, 0.0205, 0.01, 0.3, 1.0, dice));
  add_bin(bed, 0.084, 0.084);
  const std::vector<Motion> motions = surfaces(bed);
  bed.let_bonds_form();
  const double dt = step_for(resolved, share);
  EnergyRecord record;
  const int steps = static_cast<int>(time / dt);
  for (int n = 0; n <= steps; ++n) {
    for (const Motion& m : motions) m.place(bed);
    bed.step(dt, {.energy = n == 0 || n == steps, .snapshot = nullptr});
    if (n == 0) record.start = bed.energy();
  }
  record.end = bed.energy();
  return record;
}

std::vector<Motion> none(Bed&) { return {}; }

/// A lid that presses down, a rough plate that slides through the heap's top, a drum that turns in it.
std::vector<Motion> piston(Bed& bed) {
  return {{add_plane(bed, {}, {0, -1, 0}), {{0, 0.108, 0}, {}}, {0, -0.7, 0}, {}}};
}
std::vector<Motion> sliding_floor(Bed& bed) {
  return {{add_plane(bed, {}, {0, 1, 0}), {{0, 0.0005, 0}, {}}, {0.8, 0, 0.3}, {}}};
}
std::vector<Motion> drum(Bed& bed) {
  Boundary b;
  b.shape = Cylinder({}, {0, 0, 1}, 0.03, 0.2);
  return {{bed.add(std::move(b)), {{0.042, 0.137, 0.042}, {}}, {0, -0.5, 0}, {0, 0, 25}}};
}

void closes(const Law& law, const std::string& name, const std::function<std::vector<Motion>(Bed&)>& surfaces,
            Precision precision = Precision::doubles) {
  const EnergyRecord record = run(law, surfaces, 0.06, 0.4, precision);
  EXPECT_LT(std::abs(record.gap()), 0.01 * record.turned_over())
      << name << ": gap " << record.gap() << " J of " << record.turned_over() << " J turned over, damping "
      << record.end.lost.damping << " sliding " << record.end.lost.sliding << " rolling " << record.end.lost.rolling
      << " work " << record.end.boundary_work;
  EXPECT_GT(record.turned_over(), 1e-2) << name;
}

TEST(Energy, ClosesForADroppedHeap) {
  for (const auto& [name, law] : every_law()) closes(law, name, none);
}
TEST(Energy, ClosesUnderAPiston) {
  for (const auto& [name, law] : every_law()) closes(law, name, piston);
}
TEST(Energy, ClosesOverASlidingFloor) {
  for (const auto& [name, law] : every_law()) closes(law, name, sliding_floor);
}
TEST(Energy, ClosesAroundATurningDrum) {
  for (const auto& [name, law] : every_law()) closes(law, name, drum);
}

TEST(Energy, ClosesInMixedPrecision) {
  for (const auto& [name, law] : every_law()) closes(law, name + ", mixed", piston, Precision::mixed);
}

/// What a sampled balance says is the sum of what the steps of its samples lost, each times the steps that it stands
/// for: nothing of the step before is missing, none counts twice, also where lists are built anew. All spheres are of
/// one particle block; that samples stand for every step is Sampling's own test. Kernels round differently, hence 1e-6.
TEST(Energy, ASampleIsTheLossOfItsStep) {
  const Law law = grains(1e5, 0.6, 0.4, 0.05);
  const double dt = step_for(table(law).laws[0], 0.4);
  constexpr int every = 8, steps = 150;
  const auto make = [&](int sample_every) {
    BedOptions options = quiet({0, 0, 0});
    options.sample_every = sample_every;
    auto bed = std::make_unique<Bed>(table(law), options);
    Dice dice(31);
    bed->add(loose_lattice({}, 5, 5, 5, 0.0205, 0.01, 0.3, 3.0, dice));
    add_plane(*bed, {0, -0.011, 0}, {0, 1, 0});
    return bed;
  };
  const auto full = make(1);
  Sampling sampling;
  double before = 0, expected = 0;
  int samples = 0;
  for (int n = 0; n < steps; ++n) {
    const long lists = full->rebuilds();
    full->step(dt, {.energy = true, .snapshot = nullptr});
    sampling.begin(every, n, full->rebuilds() > lists);
    const double lost = full->energy().lost.total();
    if (const Sample b = sampling.of(0); b.accumulate) expected += b.weight * (lost - before), ++samples;
    before = lost;
    if (n % 3 != 2) continue;  // a bed of its own for each reading, which samples the step in which it is asked for
    const auto sampled = make(every);
    for (int k = 0; k <= n; ++k) sampled->step(dt, {.energy = k == n, .snapshot = nullptr});
    ASSERT_NEAR(sampled->energy().lost.total(), expected, 1e-6 * (std::abs(expected) + std::abs(lost)))
        << "after " << n + 1 << " steps";
  }
  EXPECT_GT(full->rebuilds(), 5);
  EXPECT_GT(samples, 15);
  EXPECT_GT(before, 0.1 * (full->energy().kinetic + full->energy().rotational));
}

/// The gap falls with the step: it is the integrator's, no missing term.
TEST(Energy, GapFallsWithTheStep) {
  const Law law = grains(1e5, 0.6, 0.4, 0.05);
  const EnergyRecord coarse = run(law, sliding_floor, 0.06, 0.2), fine = run(law, sliding_floor, 0.06, 0.025);
  const double rough = std::abs(coarse.gap()) / coarse.turned_over(),
               smooth = std::abs(fine.gap()) / fine.turned_over();
  EXPECT_LT(smooth, 0.5 * rough + 2e-4);
}

/// Elastic and smooth: nothing may be lost, and the balance must say so at every step.
TEST(Energy, ElasticBedLosesNothing) {
  Linear law = grains(1e5, 1.0, 0, 0);
  const EnergyRecord record = run(law, none, 0.1, 0.1);
  EXPECT_EQ(record.lost(), 0);
  EXPECT_LT(std::abs(record.gap()), 1e-3 * (record.start.kinetic + record.start.rotational));
}

/// The tester: each dissipation term is large enough in this scene that its absence breaks the 1 %.
TEST(Energy, ADroppedTermBreaksTheBalance) {
  Linear law = grains(1e5, 0.6, 0.4, 0.3);
  EnergyRecord record = run(law, sliding_floor, 0.1);
  ASSERT_LT(std::abs(record.gap()), 0.01 * record.turned_over());
  for (double Losses::*term : {&Losses::damping, &Losses::sliding, &Losses::rolling}) {
    EnergyRecord without = record;
    without.end.lost.*term = 0;
    without.start.lost.*term = 0;
    EXPECT_GT(std::abs(without.gap()), 0.01 * without.turned_over());
  }
  EnergyRecord without_work = record;
  without_work.end.boundary_work = without_work.start.boundary_work;
  EXPECT_GT(std::abs(without_work.gap()), 0.01 * without_work.turned_over());
}

}  // namespace
}  // namespace subsoil::dem::test::energy
