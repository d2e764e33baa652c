#include <algorithm>
#include <utility>
#include <vector>

#include "libdem/bed_impl.hpp"

/// Who works on what: each thread owns a range of tiles. No result depends on where it ends.
namespace subsoil::dem {

/// Contiguous ranges of whole tiles with about equal work, and rings long enough for the farthest partner. The work of
/// pairs is what their blocks were evaluated since the last division; of new lists it is a guess: near pairs sleep.
/// Blocks at a border are evaluated by the thread of their partners.
void Bed::Impl::divide_work() {
  // In units of a block of touching pairs: what one of near pairs, whose owners are read for it alone, one of planes, a
  // contact that is looked at by itself, and a sphere cost beside it.
  constexpr double near_block = 1.3, plane_block = 1.5, entry = 0.15, sphere = 0.06, guess_near = 0.05;
  const bool known = steps_divided > 0;
  std::vector<double> until(tiles.size() + 1, 0);
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
  for (std::uint32_t k = 0; k < tiles.size(); ++k) span = std::max(span, (tiles[k].last + 1 - k) * kTile);
  std::size_t ring = 2 * kTile;
  while (ring < span + kTile) ring *= 2;

  workers.resize(static_cast<std::size_t>(threads));
  if (known) {
    for (Worker& w : workers) w.lent = 0;
    for (Worker& w : workers)
      for (const Errand& e : w.errands) {
        const double work = static_cast<double>(e.evaluated) / steps_divided;
        workers[e.owner].lent += work, w.lent -= work;
      }
  }
  std::uint32_t tile = 0, reached = 0;
  double lent = 0;
  for (int t = 0; t < threads; ++t) {
    Worker& w = workers[static_cast<std::size_t>(t)];
    // Up to here all threads have done their shares, and later ones some blocks of theirs.
    lent += w.lent;
    const double share = until.back() * (t + 1) / threads + lent;
    w.tiles_begin = tile, w.reached = reached;
    for (; tile < tiles.size() && (t + 1 == threads || 0.5 * (until[tile] + until[tile + 1]) <= share); ++tile)
      reached = std::max(reached, tiles[tile].last);
    w.tiles_end = tile;
    w.begin = w.tiles_begin < w.tiles_end ? tiles[w.tiles_begin].begin : 0;
    w.end = w.tiles_begin < w.tiles_end ? tiles[w.tiles_end - 1].end : 0;
    if (w.ring.size() != ring) w.ring.assign(ring, Accumulator{});
  }
  division_guessed = !known;
  steps_divided = 0;
  find_borders();
}

/// Once what the first steps with new lists did is known, and now and then: sums are the same for any division.
void Bed::Impl::divide_work_again() {
  constexpr int soon = 16, later = 256;
  if (++steps_divided >= (division_guessed ? soon : later) && threads > 1) divide_work();
}

/// Blocks that are evaluated before the sweep, by the thread of their last partner, whose sweep needs them first: those
/// with a partner that belongs to a later thread. At a seam also those whose partners the sweep reaches before it has
/// evaluated them: strips that are nearly empty end soon.
void Bed::Impl::find_borders() {
  for (Worker& w : workers) w.errands.clear();
  for (std::uint32_t owner = 0; owner < workers.size(); ++owner) {
    Worker& w = workers[owner];
    Border& b = w.border;
    b.place.clear(), b.block.clear();
    std::uint32_t reached = w.reached;
    for (std::uint32_t k = w.tiles_begin; k < w.tiles_end; ++k) {
      reached = std::max(reached, tiles[k].last);
      for (std::uint32_t r = tiles[k].runs_begin; r < tiles[k].runs_end; ++r) {
        const bool seam = runs[r].seam;
        if ((seam ? tiles[k].seam_last : tiles[k].last) < w.tiles_end && !(seam && tiles[k].seam_first <= reached))
          continue;
        for (std::uint32_t n = 0; n < runs[r].blocks; ++n) {
          const PairBlock& block = blocks[runs[r].first + n];
          const auto [first, last] = std::minmax_element(block.other, block.other + shapes[runs[r].first + n].lanes);
          if (*last < w.end && !(seam && *first < tiles[reached].end)) continue;
          const auto place = static_cast<std::uint32_t>(b.place.size());
          const std::uint32_t evaluator = worker_of(*last);
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
    b.result.resize(b.block.size());
    b.rows.resize(b.block.size());
    b.awake.resize(b.block.size());
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
  std::vector<std::vector<char>> waits(workers.size(), std::vector<char>(workers.size(), 0));
  for (Worker& w : workers) w.foreign.clear(), w.waits.clear();
  for (const Worker& from : workers) {
    const Border& border = from.border;
    for (std::size_t k = 0; k < border.block.size(); ++k) {
      const PairRun& run = runs[border.place[k].run];
      const std::uint32_t block = run.first + border.block[k];
      for (std::uint32_t l = 0; l < shapes[block].lanes; ++l) {
        const std::uint32_t other = blocks[block].other[l];
        if (other < from.end) continue;  // added in the sweep
        const std::uint32_t to = worker_of(other);
        waits[to][border.place[k].evaluator] = 1;
        if (!run.seam) workers[to].foreign.push_back({&border.rows[k].of[l], &border.awake[k], other});
      }
    }
  }
  for (std::uint32_t to = 0; to < workers.size(); ++to)
    for (std::uint32_t from = 0; from < workers.size(); ++from)
      if (from != to && waits[to][from] != 0) workers[to].waits.push_back(from);
}

}  // namespace subsoil::dem
