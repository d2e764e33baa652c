#include <gtest/gtest.h>
#include <omp.h>

#include <tuple>
#include <utility>
#include <vector>

#include "libdem/geometry/mesh_builders.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_law.hpp"

/// Same bits for 1, 2, 3 and 8 threads: positions, velocities, spins, energies, wrenches. Beds of several thousand
/// spheres so that many particle blocks of 256 exist; one long and thin, so that the ends of workers cross contacts
/// everywhere, one with so few particle blocks that a worker's partners belong to workers further on, and some cut into
/// cache blocks, one of them into cache blocks of a single particle block.
namespace subsoil::dem::test::thread_bits {
namespace {

struct Fingerprint {
  std::uint64_t spheres;
  double lost, stored, kinetic, work, wrench;
  long rebuilds;
  std::uint64_t bonds;  ///< how many formed, who broke and in which order
  bool operator==(const Fingerprint&) const = default;
};

struct Scene {
  int nx, ny, nz;
  double spread;  ///< of radii
  int steps;
  double skin = 1e-3;    ///< m; several rebuilds within few steps
  int cache_blocks = 1;  ///< into which the bed is cut
};

LawTable three_materials(const Law& law) {
  LawTable t;
  t.materials = 3;
  t.laws = {table(law).laws[0], table(soil()).laws[0], table(grains(5e4)).laws[0],
            table(elastic(1e7, .3, .6, .3)).laws[0]};
  t.index = {0, 1, 2, 1, 3, 0, 2, 0, 0};
  return t;
}

/// What a run is asked for beside its motion.
struct Asked {
  int sample_every = 0;  ///< BedOptions
  bool energies = false, frames = false;
};

Fingerprint run(const Law& law, const Scene& scene, int threads, Precision precision, const Asked& asked = {}) {
  BedOptions options = quiet({0.5, -9.81, 0}, threads);
  options.skin = scene.skin, options.cache_blocks = scene.cache_blocks;
  options.precision = precision;
  options.sample_every = asked.sample_every;
  Bed bed(three_materials(law), options);
  Dice dice(17);
  const double pitch = 0.0196;
  auto specs = loose_lattice({0, 0, 0}, scene.nx, scene.ny, scene.nz, pitch, 0.01, scene.spread, 0.6, dice);
  for (std::size_t k = 0; k < specs.size(); ++k) specs[k].material = static_cast<int>(dice.between(0, 2.999));
  bed.add(specs);
  add_plane(bed, {0, 0, 0}, {0, 1, 0});
  Boundary box, tool, drum;
  box.shape = MeshSurface(box_mesh({0.2, 0.04, 0.05}, {scene.nx * pitch / 2, -0.0195, 0.05}));
  tool.shape = MeshSurface(box_mesh({0.03, 0.2, 0.04}));
  drum.shape = Cylinder({}, {0, 0, 1}, 0.04, 0.1);
  drum.material = 2, tool.material = 1;
  bed.add(std::move(box));
  const Motion pull{bed.add(std::move(tool)), {{-0.016, 0.05, 0.05}, {}}, {1.5, 0, 0}, {0, 0, -1}};
  const Motion turn{bed.add(std::move(drum)), {{0.1, scene.ny * pitch + 0.0405, 0.1}, {}}, {0, -0.6, 0}, {0, 0, 6}};
  bed.let_bonds_form();
  Snapshot frame;
  for (int n = 0; n < scene.steps; ++n) {
    pull.place(bed), turn.place(bed);
    bed.step(2e-5, {.energy = asked.energies || n + 1 == scene.steps, .snapshot = asked.frames ? &frame : nullptr});
  }
  const BedEnergy& e = bed.energy();
  std::uint64_t bonds = bed.bonds().formed;
  for (const BrokenBond& b : bed.broken_bonds()) bonds = 31 * bonds + b.ids[0] + 7 * b.ids[1] + b.in_tension;
  return {hash(bed),       e.lost.damping + 3 * e.lost.sliding + 7 * e.lost.rolling + 11 * e.lost.breaking,
          e.stored,        e.kinetic + e.rotational,
          e.boundary_work, bed.boundary(pull.boundary).wrench.force.x + bed.boundary(turn.boundary).wrench.moment.z,
          bed.rebuilds(),  bonds};
}

void same_bits(const Scene& scene) {
  for (const Precision precision : {Precision::doubles, Precision::mixed})
    for (const auto& [name, law] : every_law()) {
      const Fingerprint one = run(law, scene, 1, precision);
      if (scene.skin > 1e-3) {
        EXPECT_LT(one.rebuilds * 20, scene.steps) << name;  // lists live long enough for work to be divided again
      } else {
        EXPECT_GT(one.rebuilds, 2) << name;
      }
      EXPECT_NE(one.lost, 0) << name;
      EXPECT_NE(one.wrench, 0) << name;
      if (law->bond() != nullptr) {
        EXPECT_GT(one.bonds, 5u) << name;
      }
      for (const int threads : {2, 3, 8})
        EXPECT_TRUE(run(law, scene, threads, precision) == one) << name << ", " << threads << " threads";
    }
}

TEST(ThreadBits, Block) { same_bits({14, 8, 14, 0.3, 40, 1e-3, 3}); }
TEST(ThreadBits, LongThinBed) { same_bits({250, 2, 3, 0.0, 40}); }
TEST(ThreadBits, ParticleBlocksFewerThanThreads) { same_bits({10, 6, 10, 0.8, 50}); }
TEST(ThreadBits, CacheBlocksOfFewParticleBlocks) { same_bits({10, 3, 10, 0.3, 40, 1e-3, 4}); }
TEST(ThreadBits, WorkDividedAgain) { same_bits({40, 3, 9, 0.3, 70, 0.012, 2}); }

/// Observation changes no bit: losses accumulated in each step, sampled every so many, energies and frames of each
/// step.
TEST(ThreadBits, WhateverIsAskedFor) {
  const Scene scene{14, 8, 14, 0.3, 40, 1e-3, 3};
  const auto motion = [](const Fingerprint& f) { return std::tuple(f.spheres, f.wrench, f.rebuilds, f.bonds); };
  for (const Precision precision : {Precision::doubles, Precision::mixed})
    for (const auto& [name, law] : every_law()) {
      const auto plain = motion(run(law, scene, 1, precision, {.sample_every = 1000}));
      for (const Asked& asked :
           {Asked{.sample_every = 1}, Asked{.sample_every = 16}, Asked{1000, true, false}, Asked{1000, false, true}})
        EXPECT_EQ(motion(run(law, scene, 1, precision, asked)), plain)
            << name << ", samples every " << asked.sample_every << ", energies " << asked.energies << ", frames "
            << asked.frames;
    }
}

/// A bed of 900 spheres that grows to 3,100 and loses most of them again; the threads that it used, and its hashes.
std::pair<std::vector<int>, std::vector<std::uint64_t>> growing_bed(int threads) {
  Bed bed(table(grains()), quiet({0.5, -9.81, 0}, threads));
  add_plane(bed, {0, 0, 0}, {0, 1, 0});
  Dice dice(5);
  std::pair<std::vector<int>, std::vector<std::uint64_t>> out;
  const auto go_on = [&] {
    for (int n = 0; n < 20; ++n) bed.step(2e-5);
    out.first.push_back(bed.threads());
    out.second.push_back(hash(bed));
  };
  bed.add(loose_lattice({0, 0, 0}, 10, 9, 10, 0.0196, 0.01, 0.3, 0.6, dice));
  go_on();
  bed.add(loose_lattice({0.3, 0, 0}, 10, 22, 10, 0.0196, 0.01, 0.3, 0.6, dice));
  go_on();
  bed.remove_if([](const Sphere& s) { return s.x.x > 0.1; });
  go_on();
  return out;
}

TEST(ThreadBits, ABedChoosesItsThreadsByItsSize) {
  const int before = omp_get_max_threads();
  omp_set_num_threads(3);
  const auto chosen = growing_bed(0), one = growing_bed(1);
  omp_set_num_threads(2);
  const auto two_cores = growing_bed(0);
  omp_set_num_threads(before);
  EXPECT_EQ(chosen.first, (std::vector{1, 3, 1}));
  EXPECT_EQ(two_cores.first, (std::vector{1, 2, 1}));
  EXPECT_EQ(one.first, (std::vector{1, 1, 1}));
  EXPECT_EQ(chosen.second, one.second);
  EXPECT_EQ(two_cores.second, one.second);
}

TEST(ThreadBits, HashSeesOneBit) {
  Bed a(table(grains()), quiet()), b(table(grains()), quiet());
  SphereSpec s{.position = {1, 0, 0}, .velocity = {}, .angular_velocity = {}, .radius = 0.01, .density = 1000};
  a.add(std::span(&s, 1));
  s.position.x = std::nextafter(1.0, 2.0);
  b.add(std::span(&s, 1));
  EXPECT_NE(hash(a), hash(b));
}

}  // namespace
}  // namespace subsoil::dem::test::thread_bits
