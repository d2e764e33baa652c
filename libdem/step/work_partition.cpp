#include "libdem/step/work_partition.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace subsoil::dem {

void HaloBlocks::reserve(std::size_t blocks) {
  place.reserve(blocks), block.reserve(blocks), result.reserve(blocks), rows.reserve(blocks), active.reserve(blocks);
}
void HaloBlocks::resize() {
  result.resize(block.size());
  rows.resize(block.size());
  active.resize(block.size());
}
void HaloBlocks::hand_to(PairJob& job, std::size_t begin, std::size_t end) {
  job.halo_block = block.data() + begin;
  job.halo_count = static_cast<std::uint32_t>(end - begin);
  job.halo_result = result.data() + begin;
  job.halo_rows = rows.data() + begin;
  job.halo_active = active.data() + begin;
}

void ForceRing::resize(std::size_t size, bool mixed) {
  const auto renew = [size]<class Sum>(std::vector<Sum>& sums) {
    if (sums.size() != size) sums.assign(size, Sum{});
  };
  mixed ? renew(singles_) : renew(doubles_);
  mask_ = static_cast<std::uint32_t>(size - 1);
}

void WorkPartition::begin_lists(const ContactStore& contacts, const SurfaceContacts& surfaces,
                                const ActiveRegion& region, bool mixed, int threads) {
  threads_ = threads;
  cost.assign(contacts.particle_blocks.size(), {});
  steps_divided_ = 0;
  divide(contacts, surfaces, region, mixed);
}

void WorkPartition::divide_again(const ContactStore& contacts, const SurfaceContacts& surfaces,
                                 const ActiveRegion& region, bool mixed) {
  constexpr int soon = 16, later = 256;
  if (++steps_divided_ >= (guessed_ ? soon : later) && threads_ > 1) divide(contacts, surfaces, region, mixed);
}

/// Contiguous ranges of whole particle blocks that take equally long, and rings long enough for the farthest partner.
/// What a worker takes longer than its work says, for halo blocks and for spheres that the other core has last written,
/// is measured.
void WorkPartition::divide(const ContactStore& contacts, const SurfaceContacts& surfaces, const ActiveRegion& region,
                           bool mixed) {
  const bool known = steps_divided_ > 0;
  estimate_work(contacts, surfaces, region);
  const std::vector<ParticleBlock>& blocks = contacts.particle_blocks;
  std::uint32_t span = 0;
  for (std::uint32_t k = 0; k < blocks.size(); ++k) span = std::max(span, (blocks[k].last + 1 - k) * kParticleBlock);
  std::size_t ring = 2 * kParticleBlock;
  while (ring < span + kParticleBlock) ring *= 2;

  workers.resize(static_cast<std::size_t>(threads_));
  if (known)
    measure_overheads();
  else
    reserve_halos(contacts);
  cut_ranges(contacts, ring, mixed);
  for (Worker& w : workers) w.timer.begin();
  guessed_ = !known;
  steps_divided_ = 0;
  find_halos(contacts);
}

/// The work of pairs is what their blocks were evaluated since the last division; of new lists it is a guess: most
/// candidates are inactive.
void WorkPartition::estimate_work(const ContactStore& contacts, const SurfaceContacts& surfaces,
                                  const ActiveRegion& region) {
  // In units of a block of touching pairs: what one of candidates, whose first particles are read for it alone, one of
  // planes, a contact that is looked at by itself, and a sphere cost beside it. A frozen block is looked at in a check,
  // and when its neighbours move.
  constexpr double candidates = 1.3, plane_block = 1.5, entry = 0.15, sphere = 0.06, guess_candidates = 0.05,
                   guess_frozen = 0.1;
  const bool known = steps_divided_ > 0;
  std::vector<double>& until = work_until_;
  until.assign(contacts.particle_blocks.size() + 1, 0);
  for (std::size_t k = 0; k < contacts.particle_blocks.size(); ++k) {
    const ParticleBlock& b = contacts.particle_blocks[k];
    const SurfaceContacts::OfBlock& at = surfaces.of_block[k];
    double work = sphere * (b.end - b.begin) + entry * (at.entries_end - at.entries_begin);
    for (std::uint32_t r = at.planes_begin; r < at.planes_end; ++r) work += plane_block * surfaces.plane_runs[r].blocks;
    work *= known ? static_cast<double>(cost[k].steps) / steps_divided_ : 1;
    if (known)
      work += (static_cast<double>(cost[k].touching) + candidates * static_cast<double>(cost[k].candidates)) /
              steps_divided_;
    else
      for (std::uint32_t r = b.runs_begin; r < b.runs_end; ++r)
        work += (contacts.runs[r].candidates ? guess_candidates : 1.0) * contacts.runs[r].blocks;
    if (!known && !region.moves(k)) work *= guess_frozen;
    cost[k] = {};
    until[k + 1] = until[k] + work;
  }
}

void WorkPartition::cut_ranges(const ContactStore& contacts, std::size_t ring, bool mixed) {
  const std::vector<ParticleBlock>& blocks = contacts.particle_blocks;
  const std::vector<double>& until = work_until_;
  double overheads = 0, share = 0;
  for (const Worker& w : workers) overheads += w.overhead;
  std::uint32_t k = 0, reached = 0;
  for (int t = 0; t < threads_; ++t) {
    Worker& w = workers[static_cast<std::size_t>(t)];
    share += (until.back() + overheads) / threads_ - w.overhead;
    w.blocks_begin = k, w.reached = reached;
    for (; k < blocks.size() && (t + 1 == threads_ || 0.5 * (until[k] + until[k + 1]) <= share); ++k)
      reached = std::max(reached, blocks[k].last);
    w.blocks_end = k;
    w.begin = w.blocks_begin < w.blocks_end ? blocks[w.blocks_begin].begin : 0;
    w.end = w.blocks_begin < w.blocks_end ? blocks[w.blocks_end - 1].end : 0;
    w.forces.resize(ring, mixed);
  }
}

/// From the times of the workers, in the units of work: the one that is fastest at it has none.
void WorkPartition::measure_overheads() {
  const auto work = [&](const Worker& w) { return work_until_[w.blocks_end] - work_until_[w.blocks_begin]; };
  double unit = 0;  // s
  for (Worker& w : workers)
    if (const double time = w.timer.median(); time > 0 && work(w) > 0)
      unit = unit > 0 ? std::min(unit, time / work(w)) : time / work(w);
  // A thread whose core is taken away most of the time is not left without work.
  const double most = 0.5 * work_until_.back() / threads_;
  for (Worker& w : workers)
    w.overhead = unit > 0 && work(w) > 0 ? std::clamp(w.timer.median() / unit - work(w), 0.0, most) : 0;
}

/// For any division, so that none but that of new lists asks for memory: as much as the worst place for a worker's end
/// needs.
void WorkPartition::reserve_halos(const ContactStore& contacts) {
  if (threads_ == 1) return;
  const std::vector<ParticleBlock>& particles = contacts.particle_blocks;
  // By particle block where a worker might end: contact blocks of those before that reach beyond, across interfaces and
  // elsewhere. First what each has more than the one before.
  struct Across {
    std::ptrdiff_t within = 0, at_interfaces = 0;
  };
  std::vector<Across> across(particles.size() + 2);
  std::size_t anywhere = 0, longest = 0;
  std::uint32_t reached = 0;
  for (std::uint32_t k = 0; k < particles.size(); ++k) {
    const ParticleBlock& b = particles[k];
    reached = std::max(reached, b.last);
    for (std::uint32_t r = b.runs_begin; r < b.runs_end; ++r) {
      const PairRun& run = contacts.runs[r];
      if (run.across_interface) {
        longest = std::max<std::size_t>(longest, run.blocks);
        if (b.interface_first <= reached) anywhere += run.blocks;
        if (b.interface_last >= k)
          across[k + 1].at_interfaces += run.blocks, across[b.interface_last + 1].at_interfaces -= run.blocks;
        continue;
      }
      if (b.last == k) continue;
      for (std::uint32_t n = run.first; n < run.first + run.blocks; ++n) {
        const PairBlock& pairs = contacts.blocks[n];
        const std::uint32_t last = *std::max_element(pairs.j, pairs.j + kBlock) / kParticleBlock;
        ++across[k + 1].within, --across[last + 1].within;
      }
    }
  }
  std::ptrdiff_t within = 0, at_interfaces = 0, most_within = 0, most = 0;
  for (const Across& more : across) {
    within += more.within, at_interfaces += more.at_interfaces;
    most_within = std::max(most_within, within);
    most = std::max(most, within + at_interfaces);
  }
  const std::size_t halo = static_cast<std::size_t>(most) + anywhere, ends = workers.size() - 1;
  for (Worker& w : workers) {
    w.halo.reserve(halo);
    w.at_interface.reserve(longest);
    w.remote_evaluations.reserve(halo * ends);
    w.remote.reserve(static_cast<std::size_t>(most_within) * kBlock * ends);
    w.waits_for.reserve(ends);
  }
}

/// Halo blocks are evaluated before the sweep, by the worker of their last partner, whose sweep needs them first.
void WorkPartition::find_halos(const ContactStore& contacts) {
  for (Worker& w : workers) w.remote_evaluations.clear();
  for (std::uint32_t w = 0; w < workers.size(); ++w) find_halos_of(w, contacts);
  link_remote(contacts);
}

/// Those with a partner that belongs to a later worker. Across a block interface whole runs, and also those with
/// partners that the sweep reaches before it has evaluated them: cache blocks that are nearly empty end soon.
void WorkPartition::find_halos_of(std::uint32_t of, const ContactStore& contacts) {
  Worker& w = workers[of];
  w.halo.place.clear(), w.halo.block.clear();
  std::uint32_t reached = w.reached, at_interface = 0;
  for (std::uint32_t k = w.blocks_begin; k < w.blocks_end; ++k) {
    const ParticleBlock& particles = contacts.particle_blocks[k];
    reached = std::max(reached, particles.last);
    for (std::uint32_t r = particles.runs_begin; r < particles.runs_end; ++r) {
      const PairRun& run = contacts.runs[r];
      const bool across = run.across_interface;
      if (across && particles.interface_last < w.blocks_end && particles.interface_first > reached) {
        at_interface = std::max(at_interface, run.blocks);
        continue;
      }
      if (!across && particles.last < w.blocks_end) continue;
      for (std::uint32_t n = 0; n < run.blocks; ++n) {
        const PairBlock& block = contacts.blocks[run.first + n];
        const std::uint32_t last = *std::max_element(block.j, block.j + contacts.shapes[run.first + n].lanes);
        if (!across && last < w.end) continue;
        const std::uint32_t evaluator =
            worker_of(across ? contacts.particle_blocks[particles.interface_last].begin : last);
        add_halo_block(of, {k, r, evaluator}, n);
      }
    }
  }
  w.halo.resize();
  w.at_interface.block.resize(at_interface);
  std::iota(w.at_interface.block.begin(), w.at_interface.block.end(), 0u);
  w.at_interface.resize();
}

/// Blocks of one run beside each other are one remote evaluation.
void WorkPartition::add_halo_block(std::uint32_t of, const HaloBlocks::Place& place, std::uint32_t block) {
  HaloBlocks& halo = workers[of].halo;
  const auto at = static_cast<std::uint32_t>(halo.place.size());
  std::vector<RemoteEvaluation>& evaluations = workers[place.evaluator].remote_evaluations;
  if (!evaluations.empty() && evaluations.back().worker == of && evaluations.back().end == at &&
      halo.place.back().run == place.run)
    ++evaluations.back().end;
  else
    evaluations.push_back({.worker = of, .first = at, .end = at + 1});
  halo.place.push_back(place);
  halo.block.push_back(block);
}

std::uint32_t WorkPartition::worker_of(std::uint32_t sphere) const {
  std::uint32_t w = 0;
  while (sphere >= workers[w].end) ++w;
  return w;
}

/// What each worker has to add of blocks that others evaluate before the sweep, and whom it waits for.
void WorkPartition::link_remote(const ContactStore& contacts) {
  waits_.assign(workers.size() * workers.size(), 0);
  for (Worker& w : workers) w.remote.clear(), w.waits_for.clear();
  for (const Worker& from : workers) {
    const HaloBlocks& halo = from.halo;
    for (std::size_t k = 0; k < halo.block.size(); ++k) {
      const PairRun& run = contacts.runs[halo.place[k].run];
      const std::uint32_t block = run.first + halo.block[k];
      for (std::uint32_t l = 0; l < contacts.shapes[block].lanes; ++l) {
        const std::uint32_t second = contacts.images.sphere(contacts.blocks[block].j[l]);
        if (second < from.end && !run.across_interface) continue;  // added in the sweep
        const std::uint32_t to = worker_of(second);
        waits_[to * workers.size() + halo.place[k].evaluator] = 1;
        if (!run.across_interface) workers[to].remote.push_back({&halo.rows[k].of[l], &halo.active[k], second});
      }
    }
  }
  for (std::uint32_t to = 0; to < workers.size(); ++to)
    for (std::uint32_t from = 0; from < workers.size(); ++from)
      if (from != to && waits_[to * workers.size() + from] != 0) workers[to].waits_for.push_back(from);
}

}  // namespace subsoil::dem
