#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "libdem/base/buffer.hpp"
#include "libdem/contacts/blocks.hpp"
#include "libdem/contacts/contact_laws.hpp"
#include "libdem/contacts/histories.hpp"
#include "libdem/contacts/particle_block.hpp"
#include "libdem/neighbours/neighbour_list.hpp"
#include "libdem/particles/particle_store.hpp"

/// The room of contacts: what lies in memory and who is whose neighbour, no force. This header holds contacts between
/// spheres, surface_contacts.hpp those with boundaries, bonds.hpp what is special to bonded ones; blocks.hpp is the
/// layout that the kernels read.
namespace subsoil::dem {

/// What is kept of pairs. Bonds stand apart: few laws have any, and they are longer than all else.
struct PairHistories {
  std::vector<PairHistory> pairs;
  std::vector<BondHistory> bonds;
};

/// What a contact evaluated elsewhere, by another worker or across a block interface, gives to its second particle; of
/// an image, which is a particle across an interface, to its sphere.
struct RemoteContribution {
  const Accumulator* sum;
  const std::uint8_t* given;  ///< whether there is something
  std::uint32_t sphere;
};

/// Contacts between spheres, laid out for the step.
///
/// | data                   | written by                                              | read by                  |
/// |---|---|---|
/// | particle_blocks        | rebuilds                                                | every worker             |
/// | runs                   | rebuilds; `activation` by the worker that evaluates it | every worker             |
/// | blocks, shapes         | rebuilds                                                | kernels, in order        |
/// | lines (histories)      | kernels, each block by the worker that evaluates it     | the same; rebuilds       |
/// | activation             | kernels, of inactive candidates; bonds that form        | kernels                  |
/// | interface_rows, _given | the worker of the first particle's block                | that of the second's     |
/// | remote                 | rebuilds                                                | the worker of the sphere |
/// | waiting                | restarts and exchanges of laws                          | the next rebuild         |
/// | images                 | rebuilds                                                | rebuilds, saved states   |
///
/// Layout: runs, all contacts of one law of one particle block, are contiguous in four parallel streams (indices,
/// shapes, activation paths, histories), since a step reads them once, in order, and writes only the histories back. In
/// one record with the indices, parts of a history that a step does not touch would come along. Lists of contacts per
/// sphere are too short for vectors (blocks.hpp states what SELL chunks gain).
///
/// Pairs in contact and candidates that may come to touch are in runs of their own: a candidate costs nothing until the
/// path bound of its particle block states that its block of eight may have met, and activates it.
class ContactStore {
 public:
  std::vector<ParticleBlock> particle_blocks;
  std::vector<PairRun> runs;
  Buffer<PairBlock> blocks;
  Buffer<BlockShape> shapes;
  Buffer<double> activation;                  ///< path at which a block of inactive candidates is activated, m
  Buffer<Line> lines;                         ///< contact histories
  std::vector<BlockRows> interface_rows;      ///< by PairRun::rows
  std::vector<std::uint8_t> interface_given;  ///< whether a block at an interface gives something in this step
  std::vector<RemoteContribution> remote;     ///< across interfaces, by particle block of the second particle
  PeriodicImages images;                      ///< second particles of the pairs across periodic sides

  bool empty() const { return particle_blocks.empty(); }  ///< no lists; histories may wait for the next

  /// Lays out the pairs of a neighbour list; what is there is first put away by `retire` or `set_aside`.
  /// @param spheres and behind them their images, which are `images_in`
  /// @param masses that contacts find of these; empty: their own
  /// @return place of each pair of the list: 8 x block + lane
  Buffer<std::uint32_t> build(std::span<const Sphere> spheres, std::span<const double> masses,
                              const PeriodicImages& images_in, const NeighbourList& list, const Grid& grid,
                              const ContactLaws& laws, double skin, int threads);
  /// Histories into the new blocks, from the saved ones if there are any, else from what waits.
  /// @param new_index of the spheres @return bonds of spheres that are gone
  std::size_t restore_histories(const NeighbourList& list, const Buffer<std::uint32_t>& place,
                                const std::vector<std::uint32_t>& new_index, const ContactLaws& laws, int threads);

  /// Number of the lists, unique in the process; another one after `build` and `clear`.
  std::uint64_t lists() const { return lists_; }
  /// All that lists and histories are; of the same lists only what steps write.
  void copy(const ContactStore& from);

  void clear();   ///< lists and what waits
  void retire();  ///< the blocks as they are become those that `restore_histories` reads
  void set_aside(const ContactLaws& laws, int threads);  ///< takes all histories out of the lists and ends these
  PairHistories& begin_waiting() { return waiting_.emplace_back(); }  ///< for a restart, by index of the spheres
  const std::vector<PairHistories>& waiting() const { return waiting_; }
  /// All that are not empty, by index of the spheres; in parts, since a single array would double the memory.
  std::vector<PairHistories> histories(const ContactLaws& laws, int threads) const;

  /// Histories of one block, for reading and writing.
  BlockMemory memory(const PairRun& run, std::size_t block, const MemoryShape& shape) const {
    return BlockMemory::at(const_cast<Line*>(lines.data()) + run.lines, run.blocks, shape, block);
  }
  /// use(block of the run, lane) for each pair.
  template <class Use>
  void each_lane(const PairRun& run, const Use& use) const {
    for (std::uint32_t block = 0; block < run.blocks; ++block)
      for (std::uint32_t lane = 0; lane < shapes[run.first + block].lanes; ++lane) use(block, lane);
  }

 private:
  void link_interfaces();
  static std::uint64_t next_lists();

  /// The streams as they were before a rebuild; afterwards storage for those of the next.
  struct Retired {
    std::vector<PairRun> runs;
    Buffer<PairBlock> blocks;
    Buffer<BlockShape> shapes;
    Buffer<Line> lines;
    PeriodicImages images;
  } retired_;
  std::vector<PairHistories> waiting_;  ///< by index of the spheres
  std::uint64_t lists_ = next_lists();
};

}  // namespace subsoil::dem
