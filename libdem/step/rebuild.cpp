#include <omp.h>

#include <algorithm>
#include <utility>

#include "libdem/neighbours/cell_sort.hpp"
#include "libdem/neighbours/neighbour_list.hpp"
#include "libdem/step/bed_impl.hpp"

/// New lists: spheres sorted by cell, neighbours, blocks of contacts with their histories, surfaces, work. Each part
/// builds its own; here is the order.
namespace subsoil::dem {

bool Bed::Impl::lists_hold() { return criterion.lists_hold(particles, boundaries, paths.longest(), threads); }

bool Bed::Impl::update_neighbours() {
  if (!lists_hold()) {
    rebuild();
    return true;
  }
  work.divide_again(contacts, surfaces, region, particles.is_mixed());
  return false;
}

void Bed::Impl::clear_lists() {
  contacts.clear(), surfaces.clear(), region.forget();
  balance.begin_lists(0);
  criterion.invalidate();
}

void Bed::Impl::set_histories_aside() {
  balance.fold(surfaces.chunks);
  if (contacts.empty()) return;  // there are no lists; what waits goes on waiting
  contacts.set_aside(laws, threads);
  surfaces.set_aside(laws);
  criterion.invalidate();
}

namespace {

/// By index before spheres left and before the sort.
std::vector<std::uint32_t> invert(const std::vector<std::uint32_t>& old_index,
                                  const std::vector<std::uint32_t>& before_removal, std::size_t count_before,
                                  int threads) {
  std::vector<std::uint32_t> new_index(count_before, kGone);
  const auto count = static_cast<long>(old_index.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (long i = 0; i < count; ++i) {
    const std::uint32_t was = old_index[static_cast<std::size_t>(i)];
    new_index[before_removal.empty() ? was : before_removal[was]] = static_cast<std::uint32_t>(i);
  }
  return new_index;
}

/// Two threads that wait for each other asleep take 1.45 times as long as one at 455 spheres, 0.82 times at 911 and
/// 0.75 times at 2,282; beside other programs 1.6 to 2 times at 1,340 (docs/performance.md).
int threads_for(std::size_t spheres) {
  constexpr std::size_t spheres_per_thread = 1000;
  return static_cast<int>(
      std::clamp<std::size_t>(spheres / spheres_per_thread, 1, static_cast<std::size_t>(omp_get_max_threads())));
}

}  // namespace

double Bed::Impl::skin_of(const ParticleStatistics& statistics) const {
  if (options.skin > 0) return options.skin;
  // Longer, and the lists grow, though most of what is added stays inactive; shorter, and they are built more often:
  // under a plough 0.25 costs 13 %, 0.6 costs 40 % more.
  return skin_within_period(options.periodic, 2 * statistics.largest + laws.largest_cutoff(),
                            clumps.any() ? clumps.widest_gap() : 0, 0.1 * statistics.mean, 0.4 * statistics.mean);
}

void Bed::require_room() {
  if (!impl_->options.periodic.any()) return;
  const ParticleStatistics statistics =
      particle_statistics(impl_->particles.spheres(), impl_->laws.table().materials, impl_->threads, impl_->now.time);
  impl_->laws.update_cutoffs(statistics.largest);
  impl_->check_periodic_sides(statistics, impl_->skin_of(statistics));
}

void Bed::Impl::rebuild(const std::function<bool(const Sphere&)>& gone) {
  balance.fold(surfaces.chunks);
  particles.sync_from_mixed(threads);
  if (particles.drop_images()) criterion.invalidate();
  if (options.periodic.any()) wrap();
  region.keep(particles.spheres());
  // Spheres leave before the sort; histories still count them, so they are found by the numbering before.
  const std::size_t count_before = particles.size();
  clumps.choose_leaving(particles.spheres(), options.floor_drop, gone);
  const auto leave = [&](const Sphere& s, bool fell) {
    if (const std::uint32_t c = clumps.clump_of(s.id); c != kGone)
      fell = clumps.fell(c);
    else if (!is_fixed(s))
      balance.removed += kinetic_energy_of(s) - s.m * dot(options.gravity, s.x);
    if (fell) ++now.fallen;
  };
  const std::vector<std::uint32_t> before_removal =
      particles.take_out(options.floor_drop, clumps.with_whole_clumps(gone), leave, threads);
  if (clumps.any()) balance.removed += clumps.take_out(options.gravity);
  if (options.threads <= 0) threads = threads_for(particles.size());
  const ParticleStatistics statistics =
      particle_statistics(particles.spheres(), laws.table().materials, threads, now.time);
  laws.require(statistics.present);
  laws.update_cutoffs(statistics.largest);
  const double skin = skin_of(statistics);
  const double cutoff = laws.largest_cutoff() + skin;
  if (options.periodic.any()) check_periodic_sides(statistics, skin);
  // Only now, when nothing refuses the bed any more: what a failed rebuild had put aside would meet other lists later.
  if (!contacts.empty()) {
    contacts.retire();
    surfaces.set_aside(laws);
    criterion.invalidate();
  }
  Grid grid;
  grid.fits = radius_that_fits(particles.spheres(), statistics.smallest, statistics.largest);
  const std::vector<std::uint32_t> old_index =
      sort_by_cell(particles.spheres(), 2 * grid.fits + cutoff, statistics.box, options.cache_blocks, threads, grid);
  for (int k = 0; k < 3; ++k) grid.around[k] = options.periodic.length[grid.axis[k]] > 0;
  const std::vector<std::uint32_t> new_index = invert(old_index, before_removal, count_before, threads);
  {
    NeighbourList list = find_neighbours(particles.spheres(), grid, cutoff, threads);
    if (options.periodic.any()) add_images(list, grid, statistics, cutoff);
    fixed.find(statistics.all_free ? std::span<const Sphere>{} : particles.spheres());
    fixed.drop_pairs(list, particles.images());
    clumps.find(particles.spheres(), options.periodic);
    clumps.drop_pairs(list, particles.images());
    particles.find_masses(statistics.all_free, [&](std::uint32_t i) {
      const std::uint32_t clump = clumps.clump_at(i);
      // Of a state whose clumps are not there yet: as if it were alone.
      return clump == kGone ? particles[i].m : clumps.mass_at(clump);
    });
    const Buffer<std::uint32_t> place = contacts.build(particles.spheres_and_images(), particles.masses(),
                                                       particles.images(), list, grid, laws, skin, threads);
    bonds.count.removed += contacts.restore_histories(list, place, new_index, laws, threads);
  }
  surfaces.build(particles, boundaries, laws, skin, threads);
  surfaces.restore_histories(new_index, laws);
  bonds.begin_lists(contacts);
  balance.begin_lists(contacts.particle_blocks.size());
  fixed.begin_lists(contacts.particle_blocks);
  clumps.begin_lists(contacts.particle_blocks);
  forces.begin_lists(contacts.particle_blocks.size());
  paths.begin(contacts.particle_blocks.size());
  region.sort(new_index, particles.size());
  region.begin_lists(contacts, particles, clumps, statistics.mean, cutoff, threads);
  work.begin_lists(contacts, surfaces, region, particles.is_mixed(), threads);
  criterion.begin(skin, particles, boundaries, statistics, std::move(grid), threads);
  particles.number_slots();
  particles.sync_to_mixed(threads);
  ++now.rebuilds;
}

}  // namespace subsoil::dem
