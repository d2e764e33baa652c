#pragma once
#include <vector>

#include "libdem/bed.hpp"

/// Inside of Bed: data that search.cpp builds, surfaces.cpp and sweep.cpp work on. Private to libdem.
namespace subsoil::dem {

inline constexpr std::uint32_t kTile = 256;  ///< spheres whose energy is summed together; threads own whole tiles
inline constexpr std::size_t kMaxSurfaceContacts = 6;  ///< of one sphere with one boundary

/// Half list: pairs of owner i are start[i] .. start[i+1], partners ascending and above i.
struct PairList {
  std::vector<std::uint32_t> start{0};
  std::vector<std::uint32_t> other;
  std::vector<PairState> state;
  std::vector<std::uint8_t> live;  ///< in reach at the last step, so `state` holds a history
};

/// One sphere near one boundary.
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

/// A contact between spheres of two threads, computed before the sweep and added by both at its place in the order.
struct BorderContact {
  std::uint32_t owner, other, pair;
  bool in_reach = false, active = false;
  ContactForce force{};
};

/// Force and torque that wait for a sphere's turn; one cache line.
struct alignas(64) Accumulator {
  Four f;  ///< N; the last is not used
  Four t;  ///< N m; number of touching contacts
};

/// Running maximum that takes a NaN and keeps it: no later finite value replaces it, so the fault is found.
inline bool exceeds(double value, double largest) { return !(value <= largest) && largest == largest; }

struct Extremes {
  double speed2 = 0, overlap = 0;
  std::uint32_t fastest = 0, deepest = 0;
  double kinetic = 0;
  std::size_t pairs = 0;
  void take(const Extremes& b);
};

/// What one thread owns during a sweep.
struct Worker {
  std::uint32_t begin = 0, end = 0;
  std::vector<BorderContact> border;
  std::vector<Accumulator> ring;  ///< power of two; indexed by sphere & mask
  Batch batch;
  std::vector<std::pair<std::uint32_t, const BorderContact*>> foreign;  ///< by sphere: what earlier threads computed
  Extremes extremes;
};

struct TileSums {
  Four lost{};  ///< damping, sliding, rolling: running; stored: of the last step
  double kinetic = 0, spin = 0, gravity = 0, half_step_kinetic = 0;
};

inline Losses losses_of(const Four& e) { return {e[0], e[1], e[2]}; }

struct Bed::Impl {
  LawTable laws;
  BedOptions options;
  Kernel kernel;
  int threads = 1;
  std::vector<double> law_reach;  ///< per law

  std::vector<Sphere> spheres;
  std::vector<Boundary> boundaries;
  PairList pairs;
  std::vector<SurfaceEntry> entries;
  std::vector<std::uint32_t> candidates;      ///< of all entries
  std::vector<std::uint32_t> entry_start{0};  ///< entries of sphere i: entry_of[entry_start[i] .. entry_start[i+1]]
  std::vector<std::uint32_t> entry_of;
  std::vector<SurfaceChunk> chunks;
  std::vector<Worker> workers;
  std::vector<TileSums> tiles;

  // validity of the lists
  bool stale = true;
  int single_law = -1;  ///< only_law() when the lists were built
  double skin = 0;
  double moved = 0;  ///< bound on any sphere's path since the lists were built, m
  std::vector<Pose> listed_pose;
  std::vector<char> listed_active;
  std::vector<double> boundary_radius;  ///< largest distance of a shape's points from its origin, m

  // time
  double time = 0, dt_before = 0;
  long steps = 0, rebuilds = 0;
  std::size_t removed = 0;
  std::uint32_t next_id = 0;
  std::vector<std::uint32_t> slot_of_id;  ///< place in a snapshot

  BedEnergy energy;
  Losses lost_before;  ///< folded from lists that are gone
  double removed_energy = 0;
  Extremes extremes;

  Impl(LawTable laws_in, BedOptions options_in);

  // search.cpp
  bool lists_hold() const;
  /// Builds all lists; spheres that fell below the floor, or for which `gone` holds, leave.
  void rebuild(const std::function<bool(const Sphere&)>& gone = {});
  std::vector<std::uint32_t> take_out(const std::function<bool(const Sphere&)>& gone);
  void require_laws() const;
  std::vector<std::uint32_t> sort_spheres(double cell, struct Grid& grid);
  void build_pairs(const struct Grid& grid, const std::vector<std::uint32_t>& old_index);
  void build_entries(const std::vector<std::uint32_t>& old_index);
  void divide_work();
  void fold_losses();
  double largest_reach() const;

  // surfaces.cpp
  void surface_chunk(SurfaceChunk& chunk, Batch& batch, double elapsed);
  void sum_surfaces(double dt);

  // sweep.cpp
  void run_sweep(double dt, const Request& request);
  void border_contacts(Worker& worker, double elapsed);
  void sum_up(double dt, const Request& request);
  void check_faults() const;

  /// The one law between all spheres, or -1: then the inner loop need not look it up.
  int only_law() const;
  double reach(int law) const { return law_reach[static_cast<std::size_t>(law)]; }
  void update_laws();
};

}  // namespace subsoil::dem
