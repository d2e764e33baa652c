#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "libdem/contacts/contact_memory.hpp"
#include "libdem/laws/law.hpp"
#include "libdem/particles/particles.hpp"

/// How contacts lie in memory, the same for every instruction set: blocks of 8, ready to be read by vector
/// instructions without a shuffle.
///
/// All contacts of one law between the spheres of a particle block (as spheres i) and others form a run of blocks.
/// Pairs that touch when the lists are built and pairs that may come to touch before the next build are in runs of
/// their own.
///
/// Touching pairs lie in SELL chunks: eight spheres i, one per lane, and block k of a SELL chunk holds the k-th sphere
/// j of each (the sliced ELLPACK format of sparse matrices; Monakov, Lokhmotov, Avetisyan 2010). The spheres i are then
/// read once for a SELL chunk, and what its blocks give to them adds up in registers. Within the particle block spheres
/// i are sorted by their number of pairs, so that few lanes stay empty. A block of inactive candidates is a SELL chunk
/// of its own, in any order, and is inactive until its spheres may have met.
namespace subsoil::dem {

inline constexpr std::uint32_t kParticleBlock = 256;  ///< spheres per particle block; threads own whole particle blocks

/// Index of a sphere, kept times eight: so scaled the address of its record or of its sum takes no shift (lanes.hpp).
class SphereIndex {
 public:
  SphereIndex() = default;
  SphereIndex(std::uint32_t index) : eightfold_(index << 3) {}
  operator std::uint32_t() const { return eightfold_ >> 3; }
  std::uint32_t eightfold() const { return eightfold_; }
  /// `mask` one less than a power of two.
  SphereIndex masked(std::uint32_t mask) const {
    SphereIndex i = *this;
    i.eightfold_ &= mask << 3;
    return i;
  }

 private:
  std::uint32_t eightfold_;
};
inline constexpr std::uint32_t kMostSpheres = 1u << 29;  ///< of which eightfold indices are 32 bits

/// Lanes that hold no pair repeat one of the SELL chunk; what comes out there is not added.
struct alignas(64) PairBlock {
  SphereIndex i[kBlock], j[kBlock];
};

struct BlockShape {
  std::uint8_t lanes;  ///< in use, the first ones
  bool begins;         ///< a SELL chunk; other blocks of it have the same spheres i
};

struct PairRun {
  std::uint32_t law, first, blocks;  ///< `first` counts in PairBlock
  std::size_t lines;                 ///< where the memory of the first block begins
  bool candidates;                   ///< pairs that may come to touch before the next build; inactive at first
  double activation = 0;             ///< of candidates: path at which the first of them is activated
  bool uniform;                      ///< all its spheres have one radius, one mass, and one that contacts find
  bool all_free;                     ///< contacts find the mass in the record of each
  bool across_interface = false;     ///< spheres j lie in another cache block (grid.hpp)
  std::uint32_t rows = 0;            ///< where what they get begins, for runs at a block interface
};

/// Spheres near a flat face of a boundary, far from the face's edges: all that is left of it is a plane.
struct alignas(64) PlaneBlock {
  double normal[3][kBlock], offset[kBlock];  ///< axes of the boundary; the face is normal . x = offset
  std::uint32_t sphere[kBlock];
};

/// Four doubles that are added together; two SSE2 or one AVX addition.
using Four = double __attribute__((vector_size(32)));

using FourFloats = float __attribute__((vector_size(16)));

/// Force and torque that wait for a sphere's turn; one cache line.
struct alignas(64) Accumulator {
  Four f;  ///< N; the last is not used
  Four t;  ///< N m; number of touching contacts
};

/// Likewise in mixed precision: half a line.
struct alignas(32) MixedAccumulator {
  FourFloats f, t;
};

/// What waits for the spheres that a thread comes to, by index & mask. In the precision of the pairs: what a float
/// force lacks of the exact one, a float sum of a dozen lacks once more.
struct Ring {
  Accumulator* doubles;
  MixedAccumulator* singles;  ///< in place of `doubles` in mixed precision
  std::uint32_t mask;
};

/// What contacts add to the sums of a step. T: a number, a SIMD vector, a column of eight.
template <class T>
struct ContactSums {
  T damped, slid, rolled;  ///< J lost in dashpots and plastically, in sliding, in rolling
  T yielded;               ///< J lost by plastic bending of bonds
  T stored;                ///< J
  T within_cutoff;         ///< contacts: 1 or 0
  T overlap;               ///< over the smaller radius; of several the maximum

  /// use(a's, b's) for each; the overlap, of which the maximum counts, goes to `largest`(a's, b's).
  template <class A, class B, class Use, class Largest>
  [[gnu::always_inline]] static void each(A& a, B& b, const Use& use, const Largest& largest) {
    use(a.damped, b.damped), use(a.slid, b.slid), use(a.rolled, b.rolled), use(a.yielded, b.yielded);
    use(a.stored, b.stored), use(a.within_cutoff, b.within_cutoff);
    largest(a.overlap, b.overlap);
  }
};

/// What one block of contacts does, before it is added up; columns of eight.
struct alignas(64) BlockResult {
  static constexpr int kTouching = 9, kColumns = 10;
  /// Force on sphere i, which its sphere j gets turned round; torque on sphere i, on sphere j; 1 where they touch,
  /// in steps that accumulate only.
  union {
    double push[kColumns][kBlock];
    float push_single[kColumns][kBlock];  ///< mixed precision
  };
  ContactSums<double[kBlock]> sums;
  double overlap[kBlock];  ///< m
};

/// What a block gives to its spheres j, lane by lane, to be taken off (force) and added (torque).
struct BlockRows {
  Accumulator of[kBlock];
};

/// Sums over the contacts of a run, in the order of its blocks and lanes.
using RunSums = ContactSums<double>;

/// One run of pairs for the kernel.
struct PairJob {
  bool record;      ///< whether the step keeps what the losses of the next need
  bool accumulate;  ///< and sums its own
  const Sphere* spheres;
  const MixedSphere* mixed;  ///< in place of `spheres` in mixed precision
  const double* masses;      ///< that contacts find, by sphere; null: those in the records
  const PairBlock* blocks;
  const BlockShape* shapes;
  Line* lines;
  std::uint32_t count;
  bool uniform;  ///< all spheres have one radius and one mass
  double elapsed;
  // How far any sphere of the neighbourhood may have gone since the lists were built, m, and for inactive blocks where
  // that activates them; null where all blocks are active.
  double path;
  double* activation;
  double cutoff;  ///< m, of the law
  Ring ring;
  // At a block interface what spheres j get is kept for them, by block of the run; null elsewhere.
  BlockRows* interface_rows;
  std::uint8_t* interface_given;  ///< set where there is something
  // Blocks whose spheres j belong to another thread, ascending. Before the sweep `halo` is set: only these are
  // evaluated, and what they give is kept. In the sweep it is added at its place.
  bool halo;
  const std::uint32_t* halo_block;
  std::uint32_t halo_count;
  BlockResult* halo_result;
  BlockRows* halo_rows;
  std::uint8_t* halo_active;  ///< whether there is a result
  // Fetched into the cache meanwhile, a few with each block: spheres that the next particle block will meet first, then
  // spheres j of a run at a block interface, with its memory and what it keeps for them, and the blocks of the run
  // after this and their memory; null where there is none.
  std::uint32_t ahead, ahead_count;
  const PairBlock* interface_blocks;
  std::uint32_t interface_count;
  const Accumulator* interface_pushes;
  const Line* interface_lines;
  const PairBlock* next_blocks;
  const Line* next_lines;
  RunSums sums{};
  std::uint32_t evaluated;  ///< blocks; in the sweep those at a halo are among them
  bool same_torque;         ///< set when results hold only that on sphere i, which spheres j get, too
  bool broke;               ///< set when a bond did
};

struct PlaneJob {
  bool record;  ///< as of a PairJob
  const Sphere* spheres;
  const MixedSphere* mixed;
  const double* masses;
  const PlaneBlock* blocks;
  Line* lines;
  std::uint32_t count, contacts;
  double elapsed, cutoff;
  double rotation[3][3], position[3], velocity[3], angular_velocity[3];  ///< pose and motion of the boundary
  Ring ring;
  RunSums sums{};
  double force[3], moment[3];  ///< on the boundary, about `position`
};

/// Contacts with edges, corners and curved surfaces, found one sphere at a time: up to 8 of one law.
struct SurfaceJob {
  const Sphere* spheres;
  const MixedSphere* mixed;
  std::uint32_t sphere[kBlock];
  double normal[3][kBlock];  ///< world axes, from the surface to the centre
  double turn[3][kBlock];    ///< normal less that of the middle of the step
  double distance[kBlock];   ///< of the centre from the surface; negative behind it
  double mass[kBlock];       ///< kg, of the sphere or its clump, of a fixed sphere its own
  double velocity[3][kBlock], angular_velocity[3][kBlock];  ///< of the surface at the contact point
  Line lines[MemoryShape::whole().lines(1)];
  std::uint32_t count;
  double elapsed, cutoff;
  Four f[kBlock], t_i[kBlock], t_j[kBlock];  ///< on the sphere; on the surface only its rolling torque
  ContactSums<double[kBlock]> sums;
};

/// Spheres `begin` to `end` and the sums that wait for them.
struct ParticleBlockJob {
  Sphere* spheres;
  MixedSphere* mixed;  ///< in place of `spheres` in mixed precision
  std::uint32_t begin, end;
  Ring ring;
  double gravity[3];
  bool uniform;  ///< all of them have one radius and one mass
};

struct MoveJob : ParticleBlockJob {
  double kick = 0, dt = 0;  ///< s: velocities advance by a kick, positions by v dt
  double speed2 = 0;        ///< maximum v.v after the kick
  double squares = 0;       ///< a sum over velocities, linear and angular: NaN where one is
};

struct ObserveJob : ParticleBlockJob {
  double before = 0, dt = 0;                          ///< s: the step before this instant and the one after it
  double kinetic = 0, rotational = 0, potential = 0;  ///< J
};

/// The step's work, compiled once per instruction set.
struct Kernel {
  const char* name;  ///< for the record of a run
  InstructionSet set;
  void (*keep)(
      PairJob&);  ///< what blocks of a halo or block interface give to spheres j; after `pairs`, which evaluated them
  void (*add_interface)(PairJob&);  ///< and those of a block interface to their spheres i, in the sweep
  void (*observe)(ObserveJob&);     ///< energies of spheres whose sums are complete
  void (*move)(MoveJob&);

  /// In mixed precision if the job has mixed spheres; likewise the others.
  void pairs(const Law& law, PairJob& job) const {
    const LawKernels& of = law->kernels(set);
    (job.mixed != nullptr ? of.mixed_pairs : of.pairs)(law->parameters(), job);
  }
  void planes(const Law& law, PlaneJob& job) const { law->kernels(set).planes(law->parameters(), job); }
  void surface(const Law& law, SurfaceJob& job) const { law->kernels(set).surface(law->parameters(), job); }
};

/// The kernel by name ("portable", "avx2", "avx512"), or the best this machine has ("auto"). Throws
/// std::invalid_argument when the machine or the build lacks the set.
Kernel choose_kernel(const char* name);

}  // namespace subsoil::dem
