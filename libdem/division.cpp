#include <algorithm>
#include <utility>
#include <vector>

#include "libdem/bed_impl.hpp"

/// Who works on what: each thread owns a range of tiles. No result depends on where it ends.
namespace subsoil::dem {

/// Contiguous ranges of whole tiles with about equal work, and rings long enough for the farthest partner. The work of
/// pairs is what their blocks were evaluated since the last division; of new lists it is a guess: near pairs sleep.
/// Blocks at a border are evaluated by the thread after it.
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
  std::uint32_t tile = 0;
  for (int t = 0; t < threads; ++t) {
    Worker& w = workers[static_cast<std::size_t>(t)];
    if (known) w.border.work = static_cast<double>(w.border.evaluated) / steps_divided;
    w.border.evaluated = 0;
    // Up to here all threads have done their shares, and the next one the blocks at this border.
    const double share = until.back() * (t + 1) / threads + w.border.work;
    w.tiles_begin = tile;
    while (tile < tiles.size() && (t + 1 == threads || 0.5 * (until[tile] + until[tile + 1]) <= share)) ++tile;
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

/// Blocks with a partner that belongs to a later thread, and what those threads have to add of them.
void Bed::Impl::find_borders() {
  int before = -1;
  for (Worker& w : workers) {
    Border& b = w.border;
    b.place.clear(), b.block.clear(), w.foreign.clear();
    w.before = -1;
    if (w.tiles_begin == w.tiles_end) continue;
    w.before = std::exchange(before, static_cast<int>(&w - workers.data()));
    for (std::uint32_t k = w.tiles_begin; k < w.tiles_end; ++k) {
      if (tiles[k].last < w.tiles_end) continue;
      for (std::uint32_t r = tiles[k].runs_begin; r < tiles[k].runs_end; ++r)
        for (std::uint32_t n = 0; n < runs[r].blocks; ++n) {
          const PairBlock& block = blocks[runs[r].first + n];
          if (*std::max_element(block.other, block.other + shapes[runs[r].first + n].lanes) < w.end) continue;
          b.place.push_back({k, r});
          b.block.push_back(n);
        }
    }
    b.result.resize(b.block.size());
    b.awake.resize(b.block.size());
  }
  for (std::uint32_t from = 0; from < workers.size(); ++from) {
    const Border& border = workers[from].border;
    for (std::uint32_t k = 0; k < border.block.size(); ++k) {
      const std::uint32_t block = runs[border.place[k].run].first + border.block[k];
      for (std::uint32_t l = 0; l < shapes[block].lanes; ++l) {
        const std::uint32_t other = blocks[block].other[l];
        for (std::uint32_t to = from + 1; to < workers.size(); ++to)
          if (other >= workers[to].begin && other < workers[to].end) workers[to].foreign.push_back({from, k, l, other});
      }
    }
  }
}

}  // namespace subsoil::dem
