#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "libdem/step/bed_impl.hpp"

/// Who works on what: each thread owns a range of tiles. No result depends on where it ends.
namespace subsoil::dem {

/// Contiguous ranges of whole tiles that take equally long, and rings long enough for the farthest partner. The work of
/// pairs is what their blocks were evaluated since the last division; of new lists it is a guess: near pairs sleep.
/// What a thread takes longer than that work says, for blocks at borders and for spheres that the other core has last
/// written, is measured.
void Bed::Impl::divide_work() {
  // In units of a block of touching pairs: what one of near pairs, whose owners are read for it alone, one of planes, a
  // contact that is looked at by itself, and a sphere cost beside it.
  constexpr double near_block = 1.3, plane_block = 1.5, entry = 0.15, sphere = 0.06, guess_near = 0.05;
  const bool known = steps_divided > 0;
  std::vector<double>& until = work_until;
  until.assign(tiles.size() + 1, 0);
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    Tile& t = tiles[k];
    double work = sphere * (t.end - t.begin) + entry * (t.entries_end - t.entries_begin);
    for (std::uint32_t r = t.planes_begin; r < t.planes_end; ++r) work += plane_block * plane_runs[r].blocks;
    if (known)
      work +=
          (static_cast<double>(t.touching_blocks) + near_block * static_cast<double>(t.near_blocks)) / steps_divided;
    else
      for (std::uint32_t r = t.runs_begin; r < t.runs_end; ++r)
        work += (runs[r].near ? guess_near : 1.0) * runs[r].blocks;
    t.touching_blocks = t.near_blocks = 0;
    until[k + 1] = until[k] + work;
  }
  std::uint32_t span = 0;
  for (std::uint32_t k = 0; k < tiles.size(); ++k) span = std::max(span, (tiles[k].last + 1 - k) * kParticleBlock);
  std::size_t ring = 2 * kParticleBlock;
  while (ring < span + kParticleBlock) ring *= 2;

  workers.resize(static_cast<std::size_t>(threads));
  if (known)
    measure_overheads();
  else
    make_room_for_borders();
  double overheads = 0, share = 0;
  for (const Worker& w : workers) overheads += w.overhead;
  std::uint32_t tile = 0, reached = 0;
  for (int t = 0; t < threads; ++t) {
    Worker& w = workers[static_cast<std::size_t>(t)];
    share += (until.back() + overheads) / threads - w.overhead;
    w.tiles_begin = tile, w.reached = reached;
    for (; tile < tiles.size() && (t + 1 == threads || 0.5 * (until[tile] + until[tile + 1]) <= share); ++tile)
      reached = std::max(reached, tiles[tile].last);
    w.tiles_end = tile;
    w.begin = w.tiles_begin < w.tiles_end ? tiles[w.tiles_begin].begin : 0;
    w.end = w.tiles_begin < w.tiles_end ? tiles[w.tiles_end - 1].end : 0;
    w.waiting.resize(ring, is_mixed());
  }
  for (Worker& w : workers) w.pace.begin();
  division_guessed = !known;
  steps_divided = 0;
  find_borders();
}

/// From the times of the threads, in the units of work: the thread that is fastest at it has none.
void Bed::Impl::measure_overheads() {
  const auto work = [&](const Worker& w) { return work_until[w.tiles_end] - work_until[w.tiles_begin]; };
  double unit = 0;  // s
  for (Worker& w : workers)
    if (const double time = w.pace.median(); time > 0 && work(w) > 0)
      unit = unit > 0 ? std::min(unit, time / work(w)) : time / work(w);
  // A thread whose core is taken away most of the time is not left without work.
  const double most = 0.5 * work_until.back() / threads;
  for (Worker& w : workers)
    w.overhead = unit > 0 && work(w) > 0 ? std::clamp(w.pace.median() / unit - work(w), 0.0, most) : 0;
}

/// Once what the first steps with new lists did is known, and now and then: sums are the same for any division.
void Bed::Impl::divide_work_again() {
  constexpr int soon = 16, later = 256;
  if (++steps_divided >= (division_guessed ? soon : later) && threads > 1) divide_work();
}

/// For any division, so that none but that of new lists asks for memory: as much as the worst place for a thread's end
/// needs.
void Bed::Impl::make_room_for_borders() {
  if (threads == 1) return;
  // By tile where a thread might end: blocks of the tiles before that reach beyond, at seams and elsewhere. First what
  // each tile has more than the one before.
  struct Across {
    std::ptrdiff_t in_strip = 0, at_seams = 0;
  };
  std::vector<Across> across(tiles.size() + 2);
  std::size_t anywhere = 0, longest = 0;
  std::uint32_t reached = 0;
  for (std::uint32_t k = 0; k < tiles.size(); ++k) {
    const Tile& t = tiles[k];
    reached = std::max(reached, t.last);
    for (std::uint32_t r = t.runs_begin; r < t.runs_end; ++r) {
      const PairRun& run = runs[r];
      if (run.seam) {
        longest = std::max<std::size_t>(longest, run.blocks);
        if (t.seam_first <= reached) anywhere += run.blocks;
        across[k + 1].at_seams += run.blocks, across[t.seam_last + 1].at_seams -= run.blocks;
        continue;
      }
      if (t.last == k) continue;
      for (std::uint32_t n = run.first; n < run.first + run.blocks; ++n) {
        const std::uint32_t last = *std::max_element(blocks[n].j, blocks[n].j + kBlock) / kParticleBlock;
        ++across[k + 1].in_strip, --across[last + 1].in_strip;
      }
    }
  }
  std::ptrdiff_t in_strip = 0, at_seams = 0, most_in_strip = 0, most = 0;
  for (const Across& more : across) {
    in_strip += more.in_strip, at_seams += more.at_seams;
    most_in_strip = std::max(most_in_strip, in_strip);
    most = std::max(most, in_strip + at_seams);
  }
  const std::size_t border = static_cast<std::size_t>(most) + anywhere, ends = workers.size() - 1;
  for (Worker& w : workers) {
    w.border.reserve(border);
    w.at_seam.reserve(longest);
    w.errands.reserve(border * ends);
    w.foreign.reserve(static_cast<std::size_t>(most_in_strip) * kBlock * ends);
    w.waits.reserve(ends);
  }
}

/// Blocks that are evaluated before the sweep, by the thread of their last partner, whose sweep needs them first: those
/// with a partner that belongs to a later thread. At a seam whole runs, and also those with partners that the sweep
/// reaches before it has evaluated them: strips that are nearly empty end soon.
void Bed::Impl::find_borders() {
  for (Worker& w : workers) w.errands.clear();
  for (std::uint32_t owner = 0; owner < workers.size(); ++owner) {
    Worker& w = workers[owner];
    Border& b = w.border;
    b.place.clear(), b.block.clear();
    std::uint32_t reached = w.reached, at_seam = 0;
    for (std::uint32_t k = w.tiles_begin; k < w.tiles_end; ++k) {
      reached = std::max(reached, tiles[k].last);
      for (std::uint32_t r = tiles[k].runs_begin; r < tiles[k].runs_end; ++r) {
        const bool seam = runs[r].seam;
        if (seam && tiles[k].seam_last < w.tiles_end && tiles[k].seam_first > reached) {
          at_seam = std::max(at_seam, runs[r].blocks);
          continue;
        }
        if (!seam && tiles[k].last < w.tiles_end) continue;
        for (std::uint32_t n = 0; n < runs[r].blocks; ++n) {
          const PairBlock& block = blocks[runs[r].first + n];
          const std::uint32_t last = *std::max_element(block.j, block.j + shapes[runs[r].first + n].lanes);
          if (!seam && last < w.end) continue;
          const auto place = static_cast<std::uint32_t>(b.place.size());
          const std::uint32_t evaluator = worker_of(seam ? tiles[tiles[k].seam_last].begin : last);
          std::vector<Errand>& errands = workers[evaluator].errands;
          if (!errands.empty() && errands.back().owner == owner && errands.back().end == place &&
              b.place.back().run == r)
            ++errands.back().end;
          else
            errands.push_back({.owner = owner, .first = place, .end = place + 1});
          b.place.push_back({k, r, evaluator});
          b.block.push_back(n);
        }
      }
    }
    b.resize();
    w.at_seam.block.resize(at_seam);
    std::iota(w.at_seam.block.begin(), w.at_seam.block.end(), 0u);
    w.at_seam.resize();
  }
  find_foreign_lanes();
}

std::uint32_t Bed::Impl::worker_of(std::uint32_t sphere) const {
  std::uint32_t w = 0;
  while (sphere >= workers[w].end) ++w;
  return w;
}

/// What each thread has to add of blocks that others evaluate before the sweep, and whom it waits for.
void Bed::Impl::find_foreign_lanes() {
  waits.assign(workers.size() * workers.size(), 0);
  for (Worker& w : workers) w.foreign.clear(), w.waits.clear();
  for (const Worker& from : workers) {
    const Border& border = from.border;
    for (std::size_t k = 0; k < border.block.size(); ++k) {
      const PairRun& run = runs[border.place[k].run];
      const std::uint32_t block = run.first + border.block[k];
      for (std::uint32_t l = 0; l < shapes[block].lanes; ++l) {
        const std::uint32_t other = blocks[block].j[l];
        if (other < from.end && !run.seam) continue;  // added in the sweep
        const std::uint32_t to = worker_of(other);
        waits[to * workers.size() + border.place[k].evaluator] = 1;
        if (!run.seam) workers[to].foreign.push_back({&border.rows[k].of[l], &border.awake[k], other});
      }
    }
  }
  for (std::uint32_t to = 0; to < workers.size(); ++to)
    for (std::uint32_t from = 0; from < workers.size(); ++from)
      if (from != to && waits[to * workers.size() + from] != 0) workers[to].waits.push_back(from);
}

}  // namespace subsoil::dem
