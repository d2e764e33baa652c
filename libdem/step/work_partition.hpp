#pragma once
#include <cstdint>
#include <vector>

#include "libdem/base/flag.hpp"
#include "libdem/base/worker_timer.hpp"
#include "libdem/bed.hpp"
#include "libdem/contacts/contact_store.hpp"
#include "libdem/contacts/surface_contacts.hpp"
#include "libdem/step/active_region.hpp"

namespace subsoil::dem {

/// Blocks of contacts of one worker whose second particles belong to later ones, or to a later cache block. The worker
/// of the second particles evaluates them before its own sweep and adds what its spheres get; the worker of the first
/// particles adds the rest when it comes to their place.
struct HaloBlocks {
  struct Place {
    std::uint32_t particle_block, run, evaluator;
  };
  std::vector<Place> place;          ///< ascending
  std::vector<std::uint32_t> block;  ///< of the run
  std::vector<BlockResult> result;
  std::vector<BlockRows> rows;       ///< not of runs across a block interface
  std::vector<std::uint8_t> active;  ///< whether there is a result

  void reserve(std::size_t blocks);
  void resize();
  /// Blocks begin to end, all of one run, for the kernel.
  void hand_to(PairJob& job, std::size_t begin, std::size_t end);
};

/// Halo blocks of one run of another worker, for the one that evaluates them.
struct RemoteEvaluation {
  std::uint32_t worker, first, end;  ///< of its halo blocks
};

/// Force and torque sums of the spheres that a worker comes to, in the precision of the pairs: a ring as long as the
/// farthest partner, so that sums stay in the cache where an array of all forces would travel through memory twice.
class ForceRing {
 public:
  /// @param size power of two
  void resize(std::size_t size, bool mixed);
  Ring ring() { return {doubles_.data(), singles_.data(), mask_}; }

 private:
  std::vector<Accumulator> doubles_;
  std::vector<MixedAccumulator> singles_;
  std::uint32_t mask_ = 0;
};

/// What one worker owns during a sweep; nobody else writes it, but for the halo results that its evaluators fill in.
struct Worker {
  std::uint32_t blocks_begin = 0, blocks_end = 0;    ///< particle blocks
  std::uint32_t begin = 0, end = 0;                  ///< their spheres
  HaloBlocks halo;                                   ///< evaluated by others before the sweep
  HaloBlocks at_interface;                           ///< for the blocks of one run that the sweep evaluates
  std::vector<RemoteEvaluation> remote_evaluations;  ///< what this worker evaluates before its sweep
  Flag remote_done;                                  ///< results are there
  double before_sweep = 0;                           ///< s, in this step
  WorkerTimer timer;                                 ///< since the work was divided
  double overhead = 0;                               ///< work that its particle blocks do not account for, in blocks
  std::vector<std::uint32_t> waits_for;              ///< workers that evaluate what spheres of this one get
  std::vector<RemoteContribution> remote;            ///< in the order in which one thread would add them
  std::uint32_t reached = 0;                         ///< last block of partners, in the cache block, of earlier ones
  ForceRing forces;
  Flag surfaces_done;  ///< its share of contacts with edges and curved surfaces
  Phases spent;        ///< in the step
};

/// What the contacts of one particle block cost: contact blocks evaluated since the work was divided, and the steps in
/// which any were.
struct BlockCost {
  std::uint64_t touching = 0, candidates = 0, steps = 0;
};

/// Who works on what: each worker, one per thread, owns a range of particle blocks. No result depends on where it ends.
///
/// | data                     | written by                                            | read by               |
/// |---|---|---|
/// | ranges, halo places      | `divide`: rebuilds, and now and then                  | every worker          |
/// | halo results             | the evaluator, before the sweep                       | their worker          |
/// | flags                    | their worker, once a step                             | those that wait       |
/// | costs                    | the worker of the particle block                      | `divide`              |
/// | timers, phases           | their worker                                          | `divide`, sums        |
///
/// Ranges of the sorted order and not a task queue: a worker's spheres stay in its cache from step to step, and only
/// the ends of ranges are shared. Halo blocks are evaluated once, by the later worker, and handed back: if both workers
/// evaluated them, as across processes, histories would have two writers.
class WorkPartition {
 public:
  std::vector<Worker> workers;
  std::vector<BlockCost> cost;  ///< by particle block

  /// For new lists, on so many threads.
  void begin_lists(const ContactStore& contacts, const SurfaceContacts& surfaces, const ActiveRegion& region,
                   bool mixed, int threads);
  /// Once what the first steps with new lists did is known, and now and then: sums are the same for any division.
  void divide_again(const ContactStore& contacts, const SurfaceContacts& surfaces, const ActiveRegion& region,
                    bool mixed);

 private:
  void divide(const ContactStore& contacts, const SurfaceContacts& surfaces, const ActiveRegion& region, bool mixed);
  void estimate_work(const ContactStore& contacts, const SurfaceContacts& surfaces, const ActiveRegion& region);
  void cut_ranges(const ContactStore& contacts, std::size_t ring, bool mixed);
  void measure_overheads();
  void reserve_halos(const ContactStore& contacts);
  void find_halos(const ContactStore& contacts);
  void find_halos_of(std::uint32_t worker, const ContactStore& contacts);
  void add_halo_block(std::uint32_t worker, const HaloBlocks::Place& place, std::uint32_t block);
  void link_remote(const ContactStore& contacts);
  std::uint32_t worker_of(std::uint32_t sphere) const;

  int threads_ = 1;
  int steps_divided_ = 0;           ///< since the work was
  bool guessed_ = true;             ///< what inactive candidates cost was not known then
  std::vector<double> work_until_;  ///< of the particle blocks before each, in contact blocks
  std::vector<char> waits_;         ///< whether one worker has to wait for another, by both
};

}  // namespace subsoil::dem
