#pragma once
#include <cstdint>
#include <vector>

#include "libdem/base/buffer.hpp"
#include "libdem/base/flag.hpp"
#include "libdem/base/large_pages.hpp"
#include "libdem/base/worker_timer.hpp"
#include "libdem/bed.hpp"
#include "libdem/contacts/blocks.hpp"
#include "libdem/neighbours/relative_displacement.hpp"
#include "libdem/step/sampling.hpp"

/// Inside of Bed: data that search.cpp and lists.cpp build, surfaces.cpp and sweep.cpp work on. Private to libdem.
namespace subsoil::dem {

using Spheres = std::vector<Sphere, LargePages<Sphere>>;

inline constexpr std::uint32_t kGone = ~std::uint32_t{0};  ///< new place of a sphere that left
inline constexpr std::size_t kMaxSurfaceContacts = 6;      ///< of one sphere with one boundary

/// One sphere near an edge, a corner or a curved surface of one boundary.
struct SurfaceEntry {
  struct Contact {
    PairState state;
    Vec3 normal;  ///< shape axes
  };
  std::uint32_t sphere = 0, boundary = 0;
  std::uint32_t candidates_begin = 0, candidates_end = 0;
  std::uint32_t live = 0;  ///< contacts in use
  std::uint32_t touching = 0;
  Vec3 force, torque;  ///< on the sphere
  Contact contact[kMaxSurfaceContacts];
};

/// Consecutive entries of one boundary, summed together: the unit of work and of fixed-order sums.
struct SurfaceChunk {
  std::uint32_t boundary, begin, end;
  Wrench wrench;
  Losses lost;  ///< running
  double stored = 0;
  int contacts = 0;
  double max_overlap = 0;
  std::uint32_t worst = 0;  ///< sphere of max_overlap
};

/// Spheres of one tile on flat faces of one boundary, of one law.
struct PlaneRun {
  std::uint32_t boundary, law, first, blocks, contacts;  ///< `first` counts in PlaneBlock
  std::size_t lines;
  Wrench wrench;
  double in_reach = 0, stored = 0;
};

/// Contact memory outside the lists: between two of them, and in a restart.
struct PairHistory {
  std::uint32_t owner, other;
  PairState state;
};
struct BondHistory {
  std::uint32_t owner, other;
  BondMemory<double> state;
};
/// What is kept of pairs. Bonds stand apart: few laws have any, and they are longer than all else.
struct PairHistories {
  std::vector<PairHistory> pairs;
  std::vector<BondHistory> bonds;
};
/// The streams of pairs as they were before a rebuild; afterwards storage for those of the next.
struct OldPairs {
  std::vector<PairRun> runs;
  Buffer<PairBlock> blocks;
  Buffer<BlockShape> shapes;
  Buffer<Line> lines;
};
struct SurfaceHistory {
  std::uint32_t sphere, boundary;
  Vec3 normal;  ///< shape axes
  PairState state;
};

/// Running maximum that takes a NaN and keeps it: no later finite value replaces it, so the fault is found.
inline bool exceeds(double value, double largest) { return !(value <= largest) && largest == largest; }

/// J, of the half-step velocities.
inline double kinetic_energy_of(const Sphere& s) {
  return 0.5 * s.m * dot(s.v, s.v) + 0.5 * inertia(s) * dot(s.w, s.w);
}

/// 256 consecutive spheres: what they own, and sums over them in a fixed order.
struct Tile {
  std::uint32_t begin, end;
  std::uint32_t runs_begin, runs_end, planes_begin, planes_end;
  std::uint32_t entries_begin, entries_end;  ///< in entry_order
  std::uint32_t last;                        ///< tile of the farthest partner in the strip
  std::uint32_t seam_runs_begin;             ///< those at a seam are the last
  std::uint32_t seam_first, seam_last;       ///< tiles of partners in other strips; the latter smaller: none
  std::uint32_t seams_begin, seams_end;      ///< what its own spheres get across seams
  bool uniform;                                ///< it and all its partners have one radius and one mass
  Losses lost;                               ///< running
  double stored = 0, kinetic = 0, spin = 0, gravity = 0;
  double pairs = 0, overlap = 0, speed2 = 0, squares = 0;
  std::uint64_t touching_blocks = 0, near_blocks = 0;  ///< evaluated since the work was divided
  double step = 0;                                     ///< longest path of one of its spheres in the last step, m
  double path = 0;  ///< bound on the path of any sphere of this and its partners' tiles since the lists were built, m
};

/// Blocks of contacts that one thread owns and whose partners belong to later ones, or to a later strip. The thread of
/// the partners evaluates them before its own sweep and adds what its spheres get; the owner adds the rest when it
/// comes to their place.
struct Border {
  struct Place {
    std::uint32_t tile, run, evaluator;
  };
  std::vector<Place> place;          ///< ascending
  std::vector<std::uint32_t> block;  ///< of the run
  std::vector<BlockResult> result;
  std::vector<BlockRows> rows;      ///< not of runs at a seam
  std::vector<std::uint8_t> awake;  ///< whether there is a result

  void reserve(std::size_t blocks) {
    place.reserve(blocks), block.reserve(blocks), result.reserve(blocks), rows.reserve(blocks), awake.reserve(blocks);
  }
  void resize() {
    result.resize(block.size());
    rows.resize(block.size());
    awake.resize(block.size());
  }
  /// Blocks begin to end, all of one run, for the kernel.
  void offer(PairJob& job, std::size_t begin, std::size_t end) {
    job.halo_block = block.data() + begin;
    job.halo_count = static_cast<std::uint32_t>(end - begin);
    job.halo_result = result.data() + begin;
    job.halo_rows = rows.data() + begin;
    job.halo_active = awake.data() + begin;
  }
};

/// Blocks of one run of a thread's border, for the thread that evaluates them.
struct Errand {
  std::uint32_t owner, first, end;  ///< of its border
};

/// A pair of another thread or across a seam: what its partner, of this thread, gets.
struct ForeignLane {
  const Accumulator* push;
  const std::uint8_t* given;  ///< whether there is something
  std::uint32_t sphere;
};

/// What waits for the spheres that a thread comes to, in the precision of the pairs.
class WaitingSums {
 public:
  /// @param size power of two
  void resize(std::size_t size, bool mixed) {
    const auto renew = [size]<class Sum>(std::vector<Sum>& sums) {
      if (sums.size() != size) sums.assign(size, Sum{});
    };
    mixed ? renew(singles_) : renew(doubles_);
    mask_ = static_cast<std::uint32_t>(size - 1);
  }
  Ring ring() { return {doubles_.data(), singles_.data(), mask_}; }

 private:
  std::vector<Accumulator> doubles_;
  std::vector<MixedAccumulator> singles_;
  std::uint32_t mask_ = 0;
};

/// What one thread owns during a sweep.
struct Worker {
  std::uint32_t tiles_begin = 0, tiles_end = 0, begin = 0, end = 0;
  Border border;
  Border at_seam;                    ///< for the blocks of one run that the sweep evaluates
  std::vector<Errand> errands;       ///< what this thread evaluates before its sweep
  Flag errands_done;                 ///< results are there
  double before_sweep = 0;           ///< s, in this step
  WorkerTimer pace;                  ///< since the work was divided
  double overhead = 0;               ///< work that its tiles do not account for, in blocks
  std::vector<std::uint32_t> waits;  ///< threads that evaluate what spheres of this one get
  std::vector<ForeignLane> foreign;  ///< in the order in which one thread would add them
  std::uint32_t reached = 0;         ///< last tile of partners in the strip of earlier tiles
  WaitingSums waiting;
  Flag chunks_done;  ///< its share of contacts with edges and curved surfaces
  Phases spent;      ///< in the step
};

/// Adds the time between its calls to one phase after the other; idle unless asked.
class PhaseClock {
 public:
  explicit PhaseClock(bool on) : on_(on), last_(on ? WorkerTimer::now() : 0) {}
  void end(double& phase) {
    if (!on_) return;
    const double t = WorkerTimer::now();
    phase += t - last_;
    last_ = t;
  }

 private:
  bool on_;
  double last_;
};

struct Bed::Impl {
  LawTable laws;
  BedOptions options;
  Kernel kernel;
  int threads = 1;
  std::vector<double> law_reach;                         ///< per law, between the spheres of the lists
  std::vector<double> surface_reach;                     ///< per law, at surfaces
  std::vector<MemoryShape> pair_memory, surface_memory;  ///< per law; surfaces are double also in mixed precision

  Spheres spheres;
  // In mixed precision what the steps work on; `spheres` is then true only where sync_from_mixed() was called.
  std::vector<MixedSphere, LargePages<MixedSphere>> mixed;
  bool spheres_behind = false;
  std::vector<Boundary> boundaries;
  std::vector<Tile> tiles;
  std::vector<PairRun> runs;
  Buffer<PairBlock> blocks;
  Buffer<BlockShape> shapes;
  Buffer<double> wake;                   ///< per block
  Buffer<Line> lines;                    ///< memory of pairs
  std::vector<BlockRows> interface_rows;      ///< by PairRun::rows
  std::vector<std::uint8_t> interface_given;  ///< whether a block at a seam gives something in this step
  std::vector<ForeignLane> seams;        ///< by tile of the partner
  OldPairs old;
  std::vector<PlaneRun> plane_runs;
  std::vector<PlaneJob> plane_jobs;  ///< by boundary, of this step
  std::vector<PlaneBlock> plane_blocks;
  std::vector<Line> plane_lines;
  std::vector<SurfaceEntry> entries;
  std::vector<std::uint32_t> candidates;   ///< of all entries
  std::vector<std::uint32_t> entry_order;  ///< entries by sphere, then boundary
  std::vector<SurfaceChunk> chunks;
  std::vector<Worker> workers;
  int steps_divided = 0;           ///< since the work was
  bool division_guessed = true;    ///< what near pairs cost was not known then
  std::vector<double> work_until;  ///< of the tiles before each, in blocks
  std::vector<char> waits;         ///< whether one thread has to wait for another, by both

  // validity of the lists
  bool stale = true;
  double skin = 0;
  std::vector<PairHistories> waiting;            ///< memory between two lists, by place of the spheres
  std::vector<SurfaceHistory> waiting_surfaces;  ///< likewise
  std::vector<Pose> listed_pose;
  std::vector<char> listed_active;
  std::vector<double> boundary_radius;  ///< largest distance of a shape's points from its origin, m
  double path = 0;                      ///< bound on that of any sphere since the lists were built, m
  RelativeDisplacement drift;
  bool drift_counts = false;  ///< else paths alone say how long the lists hold
  struct Drifted {
    bool known = false;  ///< measured for these lists
    RelativeDisplacement::Found found;
    double path = 0;               ///< as above, then, m
    std::vector<Vec3> place, way;  ///< of the boundaries' origins, then, and theirs since the lists were built
  } drifted;                       ///< as last measured

  // bonds
  bool any_bonds = false, bonds_may_form = false;
  std::vector<char> bonds_formed;  ///< per law
  std::vector<char> run_broke;     ///< per run, in this step; a byte of its own for each, threads write them
  BondCount bonds;
  std::vector<BrokenBond> broken;

  // time
  double time = 0, dt_before = 0;
  long steps = 0, rebuilds = 0;
  long sweeps = 0;  ///< this object's; never put back
  std::size_t removed = 0;
  std::uint32_t next_id = 0;
  std::vector<std::uint32_t> slot_of_id;  ///< place in a snapshot; empty once spheres were taken out

  bool measures_phases = false;
  Phases phases;
  Sampling sampling;     ///< of what pairs lose
  bool book_all = true;  ///< in this step, beside what is sampled: stored energy is asked for
  BedEnergy energy;
  Losses lost_before;  ///< folded from lists that are gone
  double removed_energy = 0;
  struct Extremes {
    double speed2 = 0, overlap = 0;
    double squares = 0;  ///< of velocities and spins
    std::size_t pairs = 0;
  } extremes;

  Impl(LawTable laws_in, BedOptions options_in);

  // mixed.cpp
  bool is_mixed() const { return options.precision == Precision::mixed; }
  void sync_to_mixed();  ///< positions and motions of `spheres` to the records of mixed precision, if that is asked for
  void sync_from_mixed();                ///< and back, where steps have run since
  Sphere sphere(std::uint32_t i) const;  ///< as it is now

  // validity.cpp
  bool lists_hold();  ///< may measure the drift
  bool lists_hold_within(double limit) const;
  void begin_validity(Grid grid, double largest_radius);
  void measure_drift();

  // search.cpp
  /// Builds all lists; spheres that fell below the floor, or for which `gone` holds, leave.
  void rebuild(const std::function<bool(const Sphere&)>& gone = {});
  std::vector<std::uint32_t> take_out(const std::function<bool(const Sphere&)>& gone);
  void require_laws(const std::vector<char>& present) const;  ///< by material
  /// Takes the memory of all contacts out of the lists, to be put into the next ones.
  void put_aside();
  void clear_lists();
  int strips_of(const Grid& grid, std::size_t count) const;
  std::vector<std::uint32_t> sort_spheres(double cell, const Bounds& box, Grid& grid);
  void measure_boundaries(const struct ParticleStatistics& census);
  void number_slots();
  void fold_losses();
  double largest_reach() const;

  // lists.cpp
  void build_runs(struct HalfList& list, const Grid& grid);
  /// Contact memory into the new lists, from the old ones if there are any, else from what waits.
  void put_pairs(const struct HalfList& list, const std::vector<std::uint32_t>& new_index);
  void build_surfaces();
  void put_surfaces(std::vector<SurfaceHistory>& histories, const std::vector<std::uint32_t>& new_index);
  template <class UsePair, class UseBond>
  void each_history(const PairRun& run, const Buffer<PairBlock>& of_blocks, const Buffer<BlockShape>& of_shapes,
                    const Buffer<Line>& of_lines, const UsePair& use_pair, const UseBond& use_bond) const;
  /// All that are not empty, by place of the spheres; in parts, since a single array would double the memory.
  std::vector<PairHistories> pair_histories() const;
  /// use(block of the run, lane) for each pair.
  template <class Use>
  void each_lane(const PairRun& run, const Use& use) const {
    for (std::uint32_t block = 0; block < run.blocks; ++block)
      for (std::uint32_t lane = 0; lane < shapes[run.first + block].lanes; ++lane) use(block, lane);
  }
  std::vector<SurfaceHistory> surface_histories() const;

  // division.cpp
  void divide_work();
  void divide_work_again();
  void measure_overheads();
  void make_room_for_borders();
  void find_borders();
  std::uint32_t worker_of(std::uint32_t sphere) const;
  void find_foreign_lanes();

  // seams.cpp
  void find_seams();

  // bonds.cpp
  /// Places of the spheres of each intact bond.
  void each_bond(const std::function<void(std::uint32_t, std::uint32_t)>& use) const;
  void form_bonds(double until);
  void form_bonds_of(std::uint32_t run, double gap);
  void note_broken_bonds();
  void count_bonds(Snapshot& out) const;
  void save_bonding(State& out) const;  // state.cpp
  void restore_bonding(const State& in);

  // surfaces.cpp
  void surface_chunk(SurfaceChunk& chunk, double elapsed);
  void sum_surfaces(double dt);
  PlaneJob plane_job(const Boundary& b, double elapsed) const;

  // sweep.cpp
  void run_sweep(double dt, const Request& request);
  PairJob pair_job(const PairRun& run, const Tile& tile, const Booking& booking, double elapsed);
  void run_errands(Worker& w);
  void note_break(std::uint32_t run);
  void plan_book(const Request& request, bool new_lists);
  Booking booking(std::size_t tile) const;
  void sum_up(const Request& request);
  void sum_phases(double search, double sweep);  ///< s by the clock
  void check_faults();
  std::uint32_t deepest_sphere() const;

  // const_cast: a view for reading and writing alike
  BlockMemory memory(const PairRun& run, std::size_t block) const {
    return BlockMemory::at(const_cast<Line*>(lines.data()) + run.lines, run.blocks, pair_memory[run.law], block);
  }
  BlockMemory plane_memory(const PlaneRun& run, std::size_t block) const {
    return BlockMemory::at(const_cast<Line*>(plane_lines.data()) + run.lines, run.blocks, surface_memory[run.law],
                           block);
  }
  double reach(std::uint32_t law) const { return law_reach[law]; }
  /// Reaches for spheres up to a radius.
  void update_reach(double largest_radius);
  const Law& law(std::uint32_t index) const { return laws.laws[index]; }
  void update_laws();
};

/// Every pair of spheres nearer than reach and skin, once: partners of owner i are other[start[i]] ..
/// other[start[i+1]], ascending and above i. Lives during a rebuild only.
struct HalfList {
  std::vector<std::uint32_t> start{0};
  Buffer<std::uint32_t> other;
  Buffer<std::uint32_t> lane;  ///< place of the pair: 8 x block + lane
};
HalfList find_pairs(const Spheres& spheres, const Grid& grid, double reach, int threads);

}  // namespace subsoil::dem
