#include <numeric>
#include <utility>

#include "libdem/step/bed_impl.hpp"

/// Contacts across seams, between strips of the bed (grid.hpp).
namespace subsoil::dem {

/// By tile of the partner what its spheres get across seams, for each in the order of owners.
void Bed::Impl::find_seams() {
  std::uint32_t blocks_at_seams = 0;
  for (PairRun& run : runs)
    if (run.seam) run.rows = std::exchange(blocks_at_seams, blocks_at_seams + run.blocks);
  interface_rows.resize(blocks_at_seams), interface_given.assign(blocks_at_seams, 0);
  const auto each_pair = [&](const auto& use) {
    for (const PairRun& run : runs)
      if (run.seam) each_lane(run, [&](std::uint32_t block, std::uint32_t lane) { use(run, block, lane); });
  };
  std::vector<std::uint32_t> next(tiles.size() + 1, 0);
  const auto partner = [&](const PairRun& run, std::uint32_t block, std::uint32_t lane) {
    return blocks[run.first + block].j[lane];
  };
  each_pair([&](const PairRun& run, std::uint32_t block, std::uint32_t lane) {
    ++next[partner(run, block, lane) / kParticleBlock + 1];
  });
  std::partial_sum(next.begin(), next.end(), next.begin());
  for (std::size_t k = 0; k < tiles.size(); ++k) tiles[k].seams_begin = next[k], tiles[k].seams_end = next[k + 1];
  seams.resize(next.back());
  each_pair([&](const PairRun& run, std::uint32_t block, std::uint32_t lane) {
    const std::uint32_t sphere = partner(run, block, lane), row = run.rows + block;
    seams[next[sphere / kParticleBlock]++] = {&interface_rows[row].of[lane], &interface_given[row], sphere};
  });
}

}  // namespace subsoil::dem
