#include <numeric>
#include <utility>

#include "libdem/contacts/contact_store.hpp"

/// Contacts across block interfaces, between cache blocks (neighbours/grid.hpp).
namespace subsoil::dem {

/// By particle block of the second particle what its spheres get across interfaces, for each in the order of the first.
void ContactStore::link_interfaces() {
  std::uint32_t blocks_at_interfaces = 0;
  for (PairRun& run : runs)
    if (run.across_interface) run.rows = std::exchange(blocks_at_interfaces, blocks_at_interfaces + run.blocks);
  interface_rows.resize(blocks_at_interfaces), interface_given.assign(blocks_at_interfaces, 0);
  const auto each_pair = [&](const auto& use) {
    for (const PairRun& run : runs)
      if (run.across_interface) each_lane(run, [&](std::uint32_t block, std::uint32_t lane) { use(run, block, lane); });
  };
  std::vector<std::uint32_t> next(particle_blocks.size() + 1, 0);
  const auto second = [&](const PairRun& run, std::uint32_t block, std::uint32_t lane) {
    return images.sphere(blocks[run.first + block].j[lane]);
  };
  each_pair([&](const PairRun& run, std::uint32_t block, std::uint32_t lane) {
    ++next[second(run, block, lane) / kParticleBlock + 1];
  });
  std::partial_sum(next.begin(), next.end(), next.begin());
  for (std::size_t k = 0; k < particle_blocks.size(); ++k)
    particle_blocks[k].remote_begin = next[k], particle_blocks[k].remote_end = next[k + 1];
  remote.resize(next.back());
  each_pair([&](const PairRun& run, std::uint32_t block, std::uint32_t lane) {
    const std::uint32_t sphere = second(run, block, lane), row = run.rows + block;
    remote[next[sphere / kParticleBlock]++] = {&interface_rows[row].of[lane], &interface_given[row], sphere};
  });
}

}  // namespace subsoil::dem
