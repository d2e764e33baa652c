#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "libdem/step/bed_impl.hpp"

/// From neighbours to streams of blocks: which contacts lie beside each other in memory.
namespace subsoil::dem {
namespace {

/// Near pairs are laid down by gap, so that the blocks of wide gaps sleep long: each class is twice as wide as the one
/// before, the last reaches from half the skin to all of it.
constexpr std::uint32_t kGapClasses = 8;
/// A gap of less than this share of the skin counts as touching: it would wake its block at once.
constexpr double kTouchingShare = 0.01;

/// Class of a pair within its tile: all touching runs by law, then all near ones; after them those across a seam.
struct Classes {
  std::uint32_t laws;
  std::uint32_t of_strip() const { return laws * (1 + kGapClasses); }
  std::uint32_t count() const { return 2 * of_strip(); }
  std::uint32_t touching(std::uint32_t law, bool seam) const { return law + (seam ? of_strip() : 0); }
  bool touches(std::uint32_t c) const { return c % of_strip() < laws; }
  std::uint32_t near(std::uint32_t law, bool seam) const { return laws + law * kGapClasses + (seam ? of_strip() : 0); }
  std::uint32_t of(std::uint32_t law, double gap, double skin, bool seam) const {
    if (gap < kTouchingShare * skin) return touching(law, seam);
    // gap/skin = f 2^doublings, f in [0.5, 1): the exponent of a float, whose bias is 126 for such f.
    const int doublings = static_cast<int>(std::bit_cast<std::uint32_t>(static_cast<float>(gap / skin)) >> 23) - 126;
    const int width = std::clamp(doublings + static_cast<int>(kGapClasses) - 1, 0, static_cast<int>(kGapClasses) - 1);
    return near(law, seam) + static_cast<std::uint32_t>(width);
  }
};

/// The touching pairs of one law in one tile as slices of eight owners, those with most pairs first.
class Slices {
 public:
  /// Partners of each sphere of the tile.
  explicit Slices(const std::array<std::uint32_t, kParticleBlock>& pairs) {
    // Counting sort, stable; those with many pairs share the first counter.
    constexpr std::uint32_t many = 63;
    std::array<std::uint32_t, many + 2> next{};
    const auto counter = [&](std::uint32_t k) { return many - std::min(pairs[k], many); };
    for (std::uint32_t k = 0; k < kParticleBlock; ++k) ++next[counter(k) + 1];
    owners_ = kParticleBlock - next[many + 1];
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (std::uint32_t k = 0; k < kParticleBlock; ++k) place_[next[counter(k)]++] = k;
    const auto shared = std::find_if(place_.begin(), place_.end(), [&](std::uint32_t k) { return pairs[k] < many; });
    std::stable_sort(place_.begin(), shared, [&](std::uint32_t a, std::uint32_t b) { return pairs[a] > pairs[b]; });
    for (std::uint32_t first = 0; first < owners_; first += kBlock) {
      first_block_[first / kBlock] = blocks_;
      blocks_ += pairs[place_[first]];
    }
  }
  std::uint32_t blocks() const { return blocks_; }

  /// visit(sphere of the tile, first block of its slice, lane) for each owner.
  template <class Visit>
  void each(const Visit& visit) const {
    for (std::uint32_t k = 0; k < owners_; ++k) visit(place_[k], first_block_[k / kBlock], k % kBlock);
  }

 private:
  std::array<std::uint32_t, kParticleBlock> place_;
  std::array<std::uint32_t, kParticleBlock / kBlock> first_block_{};
  std::uint32_t owners_ = 0, blocks_ = 0;
};

/// Lays the pairs of one tile into their blocks.
class TileLayout {
 public:
  TileLayout(PairBlock* blocks, BlockShape* shapes) : blocks_(blocks), shapes_(shapes) {}

  void begin(std::uint32_t block, bool slice) { shapes_[block] = {.lanes = 0, .begins = slice}; }
  void put(std::uint32_t block, std::uint32_t lane, std::uint32_t owner, std::uint32_t other) {
    blocks_[block].i[lane] = owner, blocks_[block].j[lane] = other;
    shapes_[block].lanes = static_cast<std::uint8_t>(std::max<std::uint32_t>(shapes_[block].lanes, lane + 1));
  }
  /// Lanes without a pair: in a slice that of the block before, which has one; else the block's first.
  void fill(std::uint32_t block) {
    PairBlock& b = blocks_[block];
    for (std::uint32_t l = shapes_[block].lanes; l < kBlock; ++l) {
      const PairBlock& from = shapes_[block].begins ? b : blocks_[block - 1];
      const std::uint32_t lane = shapes_[block].begins ? 0 : l;
      b.i[l] = from.i[lane], b.j[l] = from.j[lane];
    }
  }

 private:
  PairBlock* blocks_;
  BlockShape* shapes_;
};

}  // namespace

void Bed::Impl::build_runs(HalfList& list, const Grid& grid) {
  const auto count = static_cast<std::uint32_t>(spheres.size());
  const Classes classes{static_cast<std::uint32_t>(laws.laws.size())};
  tiles.assign((count + kParticleBlock - 1) / kParticleBlock, {});
  const int tile_count = static_cast<int>(tiles.size());
  // By tile and class: of touching pairs blocks, of near pairs pairs; then where they begin.
  std::vector<std::uint32_t> sizes(tiles.size() * classes.count(), 0);
  Buffer<std::uint16_t> class_of;
  class_of.renew(list.other.size());
  const auto slices = [&](const Tile& t, std::uint32_t touching) {
    std::array<std::uint32_t, kParticleBlock> pairs{};
    for (std::uint32_t i = t.begin; i < t.end; ++i)
      for (std::uint32_t p = list.start[i]; p < list.start[i + 1]; ++p) pairs[i - t.begin] += class_of[p] == touching;
    return Slices(pairs);
  };
  std::vector<std::uint32_t> part_ends;  // in spheres
  for (const std::size_t cells : grid.part_ends()) part_ends.push_back(grid.start[cells]);
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int k = 0; k < tile_count; ++k) {
    Tile& t = tiles[static_cast<std::size_t>(k)];
    const Sphere& first = spheres[static_cast<std::size_t>(k) * kParticleBlock];
    const auto as_first = [&](const Sphere& s) { return s.r == first.r && s.m == first.m; };
    t.begin = static_cast<std::uint32_t>(k) * kParticleBlock, t.end = std::min(count, t.begin + kParticleBlock);
    t.last = static_cast<std::uint32_t>(k);
    t.uniform = true;
    t.seam_first = t.last + 1, t.seam_last = t.last;
    auto part_end = std::upper_bound(part_ends.begin(), part_ends.end(), t.begin);
    std::uint32_t* size = sizes.data() + static_cast<std::size_t>(k) * classes.count();
    for (std::uint32_t i = t.begin; i < t.end; ++i) {
      t.uniform = t.uniform && as_first(spheres[i]);
      while (i >= *part_end) ++part_end;
      for (std::uint32_t p = list.start[i]; p < list.start[i + 1]; ++p) {
        const Sphere &a = spheres[i], &b = spheres[list.other[p]];
        const auto law = static_cast<std::uint32_t>(laws.of(a.material, b.material));
        const double gap = norm(a.x - b.x) - a.r - b.r - reach(law);
        const bool seam = list.other[p] >= *part_end;
        class_of[p] = static_cast<std::uint16_t>(classes.of(law, gap, skin, seam));
        ++size[class_of[p]];
        t.uniform = t.uniform && as_first(b);
        const std::uint32_t tile = list.other[p] / kParticleBlock;
        if (!seam)
          t.last = std::max(t.last, tile);
        else if (t.seam_first > t.seam_last)
          t.seam_first = t.seam_last = tile;
        else
          t.seam_first = std::min(t.seam_first, tile), t.seam_last = std::max(t.seam_last, tile);
      }
    }
    for (const bool seam : {false, true})
      for (std::uint32_t law = 0; law < classes.laws; ++law)
        if (const std::uint32_t c = classes.touching(law, seam); size[c] > 0) size[c] = slices(t, c).blocks();
  }

  // Runs in order; each class gets the place of its first block or pair.
  std::uint32_t block = 0;
  std::size_t line = 0;
  const auto add_run = [&](const Tile& t, std::uint32_t law, std::uint32_t n, bool near, bool seam) {
    if (n == 0) return;
    runs.push_back(
        {.law = law, .first = block, .blocks = n, .lines = line, .near = near, .uniform = t.uniform, .seam = seam});
    block += n;
    line += pair_memory[law].lines(n);
  };
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    std::uint32_t* size = sizes.data() + k * classes.count();
    tiles[k].runs_begin = static_cast<std::uint32_t>(runs.size());
    for (const bool seam : {false, true}) {
      if (seam) tiles[k].seam_runs_begin = static_cast<std::uint32_t>(runs.size());
      for (std::uint32_t law = 0; law < classes.laws; ++law)
        add_run(tiles[k], law, std::exchange(size[classes.touching(law, seam)], block), false, seam);
      for (std::uint32_t law = 0; law < classes.laws; ++law) {
        std::uint32_t pairs = 0;
        for (std::uint32_t c = 0; c < kGapClasses; ++c)
          pairs += std::exchange(size[classes.near(law, seam) + c], block * kBlock + pairs);
        add_run(tiles[k], law, (pairs + kBlock - 1) / kBlock, true, seam);
      }
    }
    tiles[k].runs_end = static_cast<std::uint32_t>(runs.size());
  }
  run_broke.assign(runs.size(), 0);
  blocks.renew(block);
  shapes.renew(block);
  wake.renew(block);
  lines.renew(line);
  list.lane.renew(list.other.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int k = 0; k < tile_count; ++k) {
    const Tile& t = tiles[static_cast<std::size_t>(k)];
    std::uint32_t* next = sizes.data() + static_cast<std::size_t>(k) * classes.count();
    TileLayout layout(blocks.data(), shapes.data());
    for (std::uint32_t r = t.runs_begin; r < t.runs_end; ++r)
      for (std::uint32_t b = 0; b < runs[r].blocks; ++b) layout.begin(runs[r].first + b, runs[r].near);
    for (std::uint32_t r = t.runs_begin; r < t.runs_end; ++r) {
      const PairRun& run = runs[r];
      if (run.near) continue;
      const std::uint32_t touching = classes.touching(run.law, run.seam);
      slices(t, touching).each([&](std::uint32_t in_tile, std::uint32_t first, std::uint32_t lane) {
        std::uint32_t b = run.first + first;
        shapes[b].begins = true;
        for (std::uint32_t p = list.start[t.begin + in_tile]; p < list.start[t.begin + in_tile + 1]; ++p) {
          if (class_of[p] != touching) continue;
          list.lane[p] = b * kBlock + lane;
          layout.put(b++, lane, t.begin + in_tile, list.other[p]);
        }
      });
    }
    for (std::uint32_t i = t.begin; i < t.end; ++i)
      for (std::uint32_t p = list.start[i]; p < list.start[i + 1]; ++p) {
        if (classes.touches(class_of[p])) continue;
        const std::uint32_t lane = next[class_of[p]]++;
        list.lane[p] = lane;
        layout.put(lane / kBlock, lane % kBlock, i, list.other[p]);
      }
    for (std::uint32_t r = t.runs_begin; r < t.runs_end; ++r) {
      const PairRun& run = runs[r];
      for (std::uint32_t b = 0; b < run.blocks; ++b) layout.fill(run.first + b);
      std::fill_n(wake.data() + run.first, run.blocks, 0.0);
      std::fill_n(lines.data() + run.lines, pair_memory[run.law].lines(run.blocks), Line{});
    }
  }
}

/// use_pair(PairHistory), use_bond(BondHistory) for all lanes of a run that remember something.
template <class UsePair, class UseBond>
void Bed::Impl::each_history(const PairRun& run, const Buffer<PairBlock>& of_blocks,
                             const Buffer<BlockShape>& of_shapes, const Buffer<Line>& of_lines, const UsePair& use_pair,
                             const UseBond& use_bond) const {
  const MemoryShape& shape = pair_memory[run.law];
  // The memory is only read.
  auto* const first = const_cast<Line*>(of_lines.data()) + run.lines;
  for (std::uint32_t block = 0; block < run.blocks; ++block) {
    const PairBlock& b = of_blocks[run.first + block];
    const BlockMemory memory = BlockMemory::at(first, run.blocks, shape, block);
    for (std::uint32_t lane = 0; lane < of_shapes[run.first + block].lanes; ++lane) {
      if (const PairState s = read_lane(memory, shape, lane); !s.empty()) use_pair({b.i[lane], b.j[lane], s});
      if (!shape.bonds) continue;
      if (const BondMemory<double> s = read_bond(memory, shape, lane); s.state != kNoBond)
        use_bond({b.i[lane], b.j[lane], s});
    }
  }
}

void Bed::Impl::put_pairs(const HalfList& list, const std::vector<std::uint32_t>& new_index) {
  Buffer<std::uint32_t> run_of;
  run_of.renew(blocks.size());
  for (std::uint32_t r = 0; r < runs.size(); ++r) std::fill_n(run_of.data() + runs[r].first, runs[r].blocks, r);
  // Whether the pair is still there, and its law keeps such a state.
  const auto always = [](const MemoryShape&) { return true; };
  const auto if_it_bonds = [](const MemoryShape& shape) { return shape.bonds; };
  const auto put = [&](const auto& was, const auto& has_room, const auto& write) {
    const std::uint32_t a = new_index[was.owner], b = new_index[was.other];
    if (a == kGone || b == kGone) return false;
    const std::uint32_t owner = std::min(a, b), other = std::max(a, b);
    for (std::uint32_t p = list.start[owner]; p < list.start[owner + 1]; ++p) {
      if (list.other[p] != other) continue;
      const std::uint32_t block = list.lane[p] / kBlock;
      const PairRun& run = runs[run_of[block]];
      const MemoryShape& shape = pair_memory[run.law];
      if (!has_room(shape)) return false;
      write(memory(run, block - run.first), shape, list.lane[p] % kBlock, a < b ? was.state : was.state.turned_over());
      return true;
    }
    return false;
  };
  const auto put_pair = [&](const PairHistory& was) { put(was, always, write_lane); };
  const auto put_bond = [&](const BondHistory& was) { return put(was, if_it_bonds, write_bond); };
  std::size_t gone = 0;  // bonds
  const auto old_runs = static_cast<long>(old.runs.size());
#pragma omp parallel for num_threads(threads) schedule(static) reduction(+ : gone)
  for (long r = 0; r < old_runs; ++r)
    each_history(old.runs[static_cast<std::size_t>(r)], old.blocks, old.shapes, old.lines, put_pair,
                 [&](const BondHistory& was) { gone += put_bond(was) ? 0 : 1; });
  for (const PairHistories& part : waiting) {
    const auto number = static_cast<long>(part.pairs.size()), bonded = static_cast<long>(part.bonds.size());
#pragma omp parallel for num_threads(threads) schedule(static)
    for (long k = 0; k < number; ++k) put_pair(part.pairs[static_cast<std::size_t>(k)]);
#pragma omp parallel for num_threads(threads) schedule(static) reduction(+ : gone)
    for (long k = 0; k < bonded; ++k) gone += put_bond(part.bonds[static_cast<std::size_t>(k)]) ? 0 : 1;
  }
  bonds.removed += gone;
}

std::vector<PairHistories> Bed::Impl::pair_histories() const {
  std::vector<PairHistories> found(static_cast<std::size_t>(threads));
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int t = 0; t < threads; ++t) {
    const std::size_t n = runs.size(), share = static_cast<std::size_t>(t), all = static_cast<std::size_t>(threads);
    const std::size_t begin = n * share / all, end = n * (share + 1) / all;
    std::size_t touching = 0;
    for (std::size_t r = begin; r < end; ++r) touching += runs[r].near ? 0 : runs[r].blocks * kBlock;
    found[share].pairs.reserve(touching + touching / 32);
    for (std::size_t r = begin; r < end; ++r) {
      each_history(
          runs[r], blocks, shapes, lines, [&](const PairHistory& was) { found[share].pairs.push_back(was); },
          [&](const BondHistory& was) { found[share].bonds.push_back(was); });
    }
  }
  return found;
}

}  // namespace subsoil::dem
