#pragma once
#include <cstdint>
#include <vector>

#include "libdem/contacts/blocks.hpp"

namespace subsoil {
class Archive;
}
namespace subsoil::dem {

/// 256 consecutive spheres (kParticleBlock) with the contacts of which they are the first particle: the unit of a
/// worker's sweep, of sums in a fixed order and of sampling.
///
/// Written by rebuilds (ContactStore), read by every worker in every step. What steps write by particle block lies in
/// arrays of the parts: path bounds (below), energies (step/energy_balance.hpp), costs (step/work_partition.hpp). Then
/// lines that one worker reads are never written by another.
struct ParticleBlock {
  std::uint32_t begin, end;                       ///< spheres
  std::uint32_t runs_begin, runs_end;             ///< of contact blocks
  std::uint32_t interface_runs_begin;             ///< those across a block interface are the last
  std::uint32_t last;                             ///< particle block of the farthest partner in the cache block
  std::uint32_t interface_first, interface_last;  ///< of partners in other cache blocks; the latter smaller: none
  std::uint32_t remote_begin, remote_end;         ///< contributions that its own spheres get across interfaces
  bool uniform;   ///< it and all its partners have one radius, one mass, and one that contacts find
  bool all_free;  ///< likewise they are SphereKind::free
};

/// How far spheres may have gone since the lists were built, by particle block: a bound on the path of any sphere of it
/// and of its partners' blocks, m. One fast corner of the bed activates only its own inactive candidates.
///
/// | data | written by                                           | read by                                  |
/// |---|---|---|
/// | step | the worker that moves the block's spheres            | `add_step`                               |
/// | path | `add_step`, one thread after the step                | every run of inactive candidates; rebuild criterion
/// |
class PathBounds {
 public:
  void begin(std::size_t blocks) { of_block_.assign(blocks, {}); }  ///< for new lists
  double of(std::size_t block) const { return of_block_[block].path; }
  /// @param longest path of one of its spheres in this step, m
  void moved(std::size_t block, double longest) { of_block_[block].step = longest; }
  /// After a step; returns the longest path of any sphere in it.
  double add_step(const std::vector<ParticleBlock>& blocks);
  double longest() const;
  void archive(Archive& a);  ///< since the same lists were built

 private:
  struct Bound {
    double step = 0, path = 0;
  };
  std::vector<Bound> of_block_;
};

}  // namespace subsoil::dem
