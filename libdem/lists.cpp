#include <algorithm>
#include <cmath>
#include <numeric>

#include "libdem/bed_impl.hpp"

/// From neighbours to streams of blocks: which contacts lie beside each other in memory, and who works on them.
namespace subsoil::dem {
namespace {

/// Near pairs are laid down by gap, so that the blocks of wide gaps sleep long.
constexpr std::uint32_t kGapClasses = 4;
/// A gap of less than this share of the skin counts as touching: it would wake its block at once.
constexpr double kTouchingShare = 0.05;

/// Class of a pair within its tile: all touching runs by law, then all near ones.
struct Classes {
  std::uint32_t laws;
  std::uint32_t count() const { return laws * (1 + kGapClasses); }
  std::uint32_t of(std::uint32_t law, double gap, double skin) const {
    if (gap < kTouchingShare * skin) return law;
    const auto width = static_cast<std::uint32_t>(std::clamp(gap / skin * kGapClasses, 0.0, kGapClasses - 1.0));
    return laws + law * kGapClasses + width;
  }
};

void repeat_first_lane(PairBlock& b, std::uint32_t from) {
  for (std::uint32_t l = from; l < kBlock; ++l) b.owner[l] = b.owner[0], b.other[l] = b.other[0];
}

}  // namespace

void Bed::Impl::build_runs(HalfList& list) {
  const auto count = static_cast<std::uint32_t>(spheres.size());
  const Classes classes{static_cast<std::uint32_t>(laws.laws.size())};
  tiles.assign((count + kTile - 1) / kTile, {});
  const int tile_count = static_cast<int>(tiles.size());
  std::vector<std::uint32_t> sizes(tiles.size() * classes.count(), 0);
  Buffer<std::uint16_t> class_of;
  class_of.renew(list.other.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int k = 0; k < tile_count; ++k) {
    Tile& t = tiles[static_cast<std::size_t>(k)];
    t.begin = static_cast<std::uint32_t>(k) * kTile, t.end = std::min(count, t.begin + kTile);
    t.last = static_cast<std::uint32_t>(k);
    std::uint32_t* size = sizes.data() + static_cast<std::size_t>(k) * classes.count();
    for (std::uint32_t i = t.begin; i < t.end; ++i)
      for (std::uint32_t p = list.start[i]; p < list.start[i + 1]; ++p) {
        const Sphere &a = spheres[i], &b = spheres[list.other[p]];
        const auto law = static_cast<std::uint32_t>(laws.of(a.material, b.material));
        class_of[p] = static_cast<std::uint16_t>(classes.of(law, norm(a.x - b.x) - a.r - b.r - reach(law), skin));
        ++size[class_of[p]];
        t.last = std::max(t.last, list.other[p] / kTile);
      }
  }

  // Runs in order; each class gets the place of its first pair.
  std::uint32_t block = 0;
  std::size_t line = 0;
  const auto add_run = [&](std::uint32_t law, std::uint32_t* size, std::uint32_t parts, bool near) {
    std::uint32_t pairs = 0;
    for (std::uint32_t c = 0; c < parts; ++c) {
      const std::uint32_t here = size[c];
      size[c] = block * kBlock + pairs;
      pairs += here;
    }
    if (pairs == 0) return;
    const std::uint32_t n = (pairs + kBlock - 1) / kBlock;
    runs.push_back({.law = law, .first = block, .blocks = n, .pairs = pairs, .lines = line, .near = near});
    block += n;
    line += pair_memory[law].lines(n);
  };
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    std::uint32_t* size = sizes.data() + k * classes.count();
    tiles[k].runs_begin = static_cast<std::uint32_t>(runs.size());
    for (std::uint32_t law = 0; law < classes.laws; ++law) add_run(law, size + law, 1, false);
    for (std::uint32_t law = 0; law < classes.laws; ++law)
      add_run(law, size + classes.laws + law * kGapClasses, kGapClasses, true);
    tiles[k].runs_end = static_cast<std::uint32_t>(runs.size());
  }
  run_broke.assign(runs.size(), 0);
  blocks.renew(block);
  wake.renew(block);
  lines.renew(line);
  list.lane.renew(list.other.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int k = 0; k < tile_count; ++k) {
    const Tile& t = tiles[static_cast<std::size_t>(k)];
    std::uint32_t* next = sizes.data() + static_cast<std::size_t>(k) * classes.count();
    for (std::uint32_t i = t.begin; i < t.end; ++i)
      for (std::uint32_t p = list.start[i]; p < list.start[i + 1]; ++p) {
        const std::uint32_t lane = next[class_of[p]]++;
        list.lane[p] = lane;
        blocks[lane / kBlock].owner[lane % kBlock] = i;
        blocks[lane / kBlock].other[lane % kBlock] = list.other[p];
      }
    for (std::uint32_t r = t.runs_begin; r < t.runs_end; ++r) {
      const PairRun& run = runs[r];
      repeat_first_lane(blocks[run.first + run.blocks - 1], (run.pairs - 1) % kBlock + 1);
      std::fill_n(wake.data() + run.first, run.blocks, 0.0);
      std::fill_n(lines.data() + run.lines, pair_memory[run.law].lines(run.blocks), Line{});
    }
  }
}

void Bed::Impl::put_pairs(const HalfList& list, const std::vector<PairHistories>& histories,
                          const std::vector<std::uint32_t>& new_index) {
  Buffer<std::uint32_t> run_of;
  run_of.renew(blocks.size());
  for (std::uint32_t r = 0; r < runs.size(); ++r) std::fill_n(run_of.data() + runs[r].first, runs[r].blocks, r);
  // Whether the pair is still there.
  const auto put = [&](const auto& was, const auto& write) {
    const std::uint32_t a = new_index[was.owner], b = new_index[was.other];
    if (a == kGone || b == kGone) return false;
    const std::uint32_t owner = std::min(a, b), other = std::max(a, b);
    for (std::uint32_t p = list.start[owner]; p < list.start[owner + 1]; ++p) {
      if (list.other[p] != other) continue;
      const std::uint32_t block = list.lane[p] / kBlock;
      const PairRun& run = runs[run_of[block]];
      write(memory(run, block - run.first), pair_memory[run.law], list.lane[p] % kBlock,
            a < b ? was.state : was.state.turned_over());
      return true;
    }
    return false;
  };
  for (const PairHistories& part : histories) {
    const auto number = static_cast<long>(part.pairs.size()), bonded = static_cast<long>(part.bonds.size());
#pragma omp parallel for num_threads(threads) schedule(static)
    for (long k = 0; k < number; ++k) put(part.pairs[static_cast<std::size_t>(k)], write_lane);
    std::size_t gone = 0;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(+ : gone)
    for (long k = 0; k < bonded; ++k) gone += put(part.bonds[static_cast<std::size_t>(k)], write_bond) ? 0 : 1;
    bonds.removed += gone;
  }
}

std::vector<PairHistories> Bed::Impl::pair_histories() const {
  std::vector<PairHistories> found(static_cast<std::size_t>(threads));
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int t = 0; t < threads; ++t) {
    const std::size_t n = runs.size(), share = static_cast<std::size_t>(t), all = static_cast<std::size_t>(threads);
    const std::size_t begin = n * share / all, end = n * (share + 1) / all;
    std::size_t touching = 0;
    for (std::size_t r = begin; r < end; ++r) touching += runs[r].near ? 0 : runs[r].pairs;
    found[share].pairs.reserve(touching + touching / 16);
    for (std::size_t r = begin; r < end; ++r) {
      const PairRun& run = runs[r];
      const MemoryShape& shape = pair_memory[run.law];
      for (std::uint32_t p = 0; p < run.pairs; ++p) {
        const std::uint32_t block = p / kBlock, lane = p % kBlock;
        const PairBlock& b = blocks[run.first + block];
        if (const PairState s = read_lane(memory(run, block), shape, lane); !s.empty())
          found[share].pairs.push_back({b.owner[lane], b.other[lane], s});
        if (!shape.bonds) continue;
        if (const BondMemory<double> s = read_bond(memory(run, block), shape, lane); s.state != kNoBond)
          found[share].bonds.push_back({b.owner[lane], b.other[lane], s});
      }
    }
  }
  return found;
}

/// Contiguous ranges of whole tiles with about equal work, and rings long enough for the farthest partner.
void Bed::Impl::divide_work() {
  // In units of a touching pair: what a near pair, most of which sleep, and a sphere cost beside it.
  constexpr double near_pair = 0.15, sphere = 0.4;
  std::vector<double> until(tiles.size() + 1, 0);
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    until[k + 1] = until[k] + sphere * (tiles[k].end - tiles[k].begin);
    for (std::uint32_t r = tiles[k].runs_begin; r < tiles[k].runs_end; ++r)
      until[k + 1] += (runs[r].near ? near_pair : 1.0) * runs[r].pairs;
  }
  std::uint32_t span = 0;
  for (std::uint32_t k = 0; k < tiles.size(); ++k) span = std::max(span, (tiles[k].last + 1 - k) * kTile);
  std::size_t ring = 2 * kTile;
  while (ring < span + kTile) ring *= 2;

  workers.resize(static_cast<std::size_t>(threads));
  std::uint32_t tile = 0;
  for (int t = 0; t < threads; ++t) {
    Worker& w = workers[static_cast<std::size_t>(t)];
    w.tiles_begin = tile;
    while (tile < tiles.size() && (t + 1 == threads || until[tile + 1] <= until.back() * (t + 1) / threads)) ++tile;
    w.tiles_end = tile;
    w.begin = w.tiles_begin < w.tiles_end ? tiles[w.tiles_begin].begin : 0;
    w.end = w.tiles_begin < w.tiles_end ? tiles[w.tiles_end - 1].end : 0;
    if (w.ring.size() != ring) w.ring.assign(ring, Accumulator{});
  }
  find_borders();
}

/// Blocks with a partner that belongs to a later thread, and what those threads have to add of them.
void Bed::Impl::find_borders() {
  for (Worker& w : workers) {
    w.border.clear(), w.border_block.clear(), w.foreign.clear();
    for (std::uint32_t k = w.tiles_begin; k < w.tiles_end; ++k) {
      if (tiles[k].last < w.tiles_end) continue;
      for (std::uint32_t r = tiles[k].runs_begin; r < tiles[k].runs_end; ++r)
        for (std::uint32_t b = 0; b < runs[r].blocks; ++b) {
          const PairBlock& block = blocks[runs[r].first + b];
          if (*std::max_element(block.other, block.other + kBlock) < w.end) continue;
          w.border.push_back({r, b});
          w.border_block.push_back(b);
        }
    }
    w.border_result.resize(w.border.size());
  }
  for (std::uint32_t from = 0; from < workers.size(); ++from)
    for (std::uint32_t k = 0; k < workers[from].border.size(); ++k) {
      const BorderBlock& at = workers[from].border[k];
      const PairRun& run = runs[at.run];
      const std::uint32_t lanes = std::min(kBlock, run.pairs - at.block * kBlock);
      for (std::uint32_t l = 0; l < lanes; ++l) {
        const std::uint32_t other = blocks[run.first + at.block].other[l];
        for (std::uint32_t to = from + 1; to < workers.size(); ++to)
          if (other >= workers[to].begin && other < workers[to].end) workers[to].foreign.push_back({from, k, l, other});
      }
    }
}

}  // namespace subsoil::dem
