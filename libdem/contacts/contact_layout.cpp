#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "libdem/contacts/contact_store.hpp"

/// From the neighbour list to streams of contact blocks: which contacts lie beside each other in memory.
namespace subsoil::dem {
namespace {

/// Inactive candidates are laid down by gap, so that the blocks of wide gaps stay inactive long: each class is twice as
/// wide as the one before, the last reaches from half the skin to all of it.
constexpr std::uint32_t kGapClasses = 8;
/// A gap of less than this share of the skin counts as touching: it would activate its block at once.
constexpr double kTouchingShare = 0.01;

/// Class of a pair within its particle block: all touching runs by law, then all candidates; after them those across a
/// block interface, or a periodic side, whose images come after the spheres of all cache blocks.
struct Classes {
  std::uint32_t laws;
  std::uint32_t of_cache_block() const { return laws * (1 + kGapClasses); }
  std::uint32_t count() const { return 2 * of_cache_block(); }
  std::uint32_t touching(std::uint32_t law, bool across) const { return law + (across ? of_cache_block() : 0); }
  bool touches(std::uint32_t c) const { return c % of_cache_block() < laws; }
  std::uint32_t candidates(std::uint32_t law, bool across) const {
    return laws + law * kGapClasses + (across ? of_cache_block() : 0);
  }
  std::uint32_t of(std::uint32_t law, std::uint32_t step) const {
    return step == 0 ? law : laws + law * kGapClasses + step - 1;
  }
};

/// Where a gap stands among the classes of a law: 0 touching, then the classes of candidates.
struct GapStep {
  static std::uint32_t of(double gap, double skin) {
    return gap < kTouchingShare * skin ? 0 : of_candidate(static_cast<float>(gap / skin));
  }

  static constexpr std::uint16_t kUnclear = 0xffff;
  /// The same of gaps in single precision, to `step`: kUnclear where their error may change it. Without jumps, several
  /// at once: a pair touches or not as it comes, which no processor foresees.
  /// @param cutoff of the law, m; error of a gap's share of the skin
  static void of_nearly(std::span<const float> gap, float cutoff, float per_skin, float error, std::uint16_t* step) {
    constexpr auto limit = static_cast<float>(kTouchingShare);
    for (std::size_t p = 0; p < gap.size(); ++p) {
      const float share = (gap[p] - cutoff) * per_skin, least = share - error, most = share + error;
      const int touches = most < limit ? 1 : 0, parted = least > limit ? 1 : 0;
      const int same = exponent(least) == exponent(most) ? 1 : 0, candidate = of_candidate(share);
      step[p] = static_cast<std::uint16_t>((parted & same) != 0 ? candidate : touches - 1);
    }
  }

 private:
  static int exponent(float positive) { return std::bit_cast<std::int32_t>(positive) >> 23; }
  static int of_candidate(float share) {
    // share = f 2^doublings, f in [0.5, 1): the exponent of a float, whose bias is 126 for such f.
    const int doublings = exponent(share) - 126;
    const int step = doublings + static_cast<int>(kGapClasses), at_least = step < 1 ? 1 : step;
    return at_least > static_cast<int>(kGapClasses) ? static_cast<int>(kGapClasses) : at_least;
  }
};

/// The touching pairs of one law in one particle block as SELL chunks of eight first particles, those with most pairs
/// first.
class Chunks {
 public:
  /// @param pairs of each sphere of the particle block
  explicit Chunks(const std::array<std::uint32_t, kParticleBlock>& pairs) : pairs_(pairs) {
    // Counting sort, stable; those with many pairs share the first counter.
    constexpr std::uint32_t many = 63;
    std::array<std::uint32_t, many + 2> next{};
    const auto counter = [&](std::uint32_t k) { return many - std::min(pairs[k], many); };
    for (std::uint32_t k = 0; k < kParticleBlock; ++k) ++next[counter(k) + 1];
    count_ = kParticleBlock - next[many + 1];
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (std::uint32_t k = 0; k < kParticleBlock; ++k) place_[next[counter(k)]++] = static_cast<std::uint8_t>(k);
    const auto shared = std::find_if(place_.begin(), place_.end(), [&](std::uint32_t k) { return pairs[k] < many; });
    std::stable_sort(place_.begin(), shared, [&](std::uint32_t a, std::uint32_t b) { return pairs[a] > pairs[b]; });
    for (std::uint32_t first = 0; first < count_; first += kBlock) {
      first_block_[first / kBlock] = blocks_;
      blocks_ += pairs[place_[first]];
    }
  }
  std::uint32_t blocks() const { return blocks_; }

  /// visit(sphere of the particle block, first block of its chunk, lane, pairs) for each first particle.
  template <class Visit>
  void each(const Visit& visit) const {
    for (std::uint32_t k = 0; k < count_; ++k)
      visit(place_[k], first_block_[k / kBlock], k % kBlock, pairs_[place_[k]]);
  }

 private:
  std::array<std::uint32_t, kParticleBlock> pairs_;
  std::array<std::uint8_t, kParticleBlock> place_;
  std::array<std::uint32_t, kParticleBlock / kBlock> first_block_{};
  std::uint32_t count_ = 0, blocks_ = 0;
};

/// Lays the pairs of one particle block into their blocks.
class BlockWriter {
 public:
  BlockWriter(PairBlock* blocks, BlockShape* shapes) : blocks_(blocks), shapes_(shapes) {}

  void begin(std::uint32_t block, bool chunk) { shapes_[block] = {.lanes = 0, .begins = chunk}; }
  /// @param at lane, those of all blocks one after the other
  void put(std::uint32_t at, std::uint32_t i, std::uint32_t j) {
    PairBlock& block = blocks_[at / kBlock];
    block.i[at % kBlock] = i, block.j[at % kBlock] = j;
  }
  void end(std::uint32_t block, std::uint32_t lanes) { shapes_[block].lanes = static_cast<std::uint8_t>(lanes); }
  /// Lanes without a pair: in a chunk that of the block before, which has one; else the block's first.
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

/// One layout: sizes by class, then runs, then the blocks themselves. Each particle block is laid out alone, so passes
/// run in parallel and the result does not depend on the threads.
class Layout {
 public:
  /// @param spheres and behind them their images
  Layout(ContactStore& store, std::span<const Sphere> spheres, std::span<const double> masses,
         const NeighbourList& list, const Grid& grid, const ContactLaws& laws, double skin, int threads)
      : store_(store), spheres_(spheres), masses_(masses), list_(list), laws_(laws), skin_(skin), threads_(threads) {
    count_ = static_cast<std::uint32_t>(spheres.size() - store.images.size());
    classes_.laws = laws.count();
    store.particle_blocks.assign((count_ + kParticleBlock - 1) / kParticleBlock, {});
    chunks_.resize(store.particle_blocks.size());
    per_skin_ = static_cast<float>(1 / skin);
    for (std::uint32_t law = 0; law < laws.count(); ++law) {
      cutoffs_.push_back(static_cast<float>(laws.cutoff(law)));
      for (std::uint32_t step = 0; step <= kGapClasses; ++step) class_of_step_.push_back(classes_.of(law, step));
    }
    for (std::uint32_t c = 0; c < classes_.count(); ++c) further_.push_back(classes_.touches(c) ? kBlock : 1);
    // The share itself is rounded a few times.
    error_ = static_cast<float>((list.gap_error + 1e-6 * laws.largest_cutoff()) / skin) + 1e-6f;
    sizes_.assign(store.particle_blocks.size() * classes_.count(), 0);
    class_of_.renew(list.j.size());
    for (const std::size_t cells : grid.cache_block_ends()) cache_block_ends_.push_back(grid.start[cells]);
  }

  Buffer<std::uint32_t> run() {
    find_what_is_alike();
    each_block([&](std::size_t k) { classify(k); });
    for (std::size_t k = 0; k < store_.particle_blocks.size(); ++k) place_runs(k);
    store_.blocks.renew(block_);
    store_.shapes.renew(block_);
    store_.activation.renew(block_);
    store_.lines.renew(line_);
    place_.renew(list_.j.size());
    each_block([&](std::size_t k) { write_blocks(k); });
    return std::move(place_);
  }

 private:
  template <class Work>
  void each_block(const Work& work) {
    const auto blocks = static_cast<long>(store_.particle_blocks.size());
#pragma omp parallel for num_threads(threads_) schedule(static)
    for (long k = 0; k < blocks; ++k) work(static_cast<std::size_t>(k));
  }
  /// Whether the bed has one radius and one mass and no fixed spheres, so that no pair need ask; likewise one material.
  void find_what_is_alike() {
    bool alike = true, one_material = true;
    const auto count = static_cast<long>(spheres_.size());
#pragma omp parallel for num_threads(threads_) schedule(static) reduction(&& : alike, one_material)
    for (long k = 0; k < count; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const Sphere &a = spheres_[0], &b = spheres_[i];
      alike = alike && a.r == b.r && a.m == b.m && b.kind == SphereKind::free &&
              (masses_.empty() || masses_[0] == masses_[i]);
      one_material = one_material && a.material == b.material;
    }
    all_alike_ = alike;
    if (one_material && count > 0) only_law_ = laws_.between(spheres_[0].material, spheres_[0].material);
  }
  std::uint32_t law_of(std::uint32_t i, std::uint32_t j) const {
    if (only_law_ >= 0) return static_cast<std::uint32_t>(only_law_);
    return static_cast<std::uint32_t>(laws_.between(spheres_[i].material, spheres_[j].material));
  }

  /// By class: of touching pairs contact blocks, of candidates pairs; then where they begin.
  std::uint32_t* sizes_of(std::size_t k) { return sizes_.data() + k * classes_.count(); }

  static void include_across(ParticleBlock& b, std::uint32_t partner) {
    if (b.interface_first > b.interface_last)
      b.interface_first = b.interface_last = partner;
    else
      b.interface_first = std::min(b.interface_first, partner), b.interface_last = std::max(b.interface_last, partner);
  }

  void classify(std::size_t k) {
    ParticleBlock& block = store_.particle_blocks[k];
    const auto first = static_cast<std::uint32_t>(k * kParticleBlock);
    const auto include = [&](std::uint32_t i) {
      if (all_alike_) return;
      const Sphere &a = spheres_[first], &b = spheres_[i];
      block.uniform = block.uniform && a.r == b.r && a.m == b.m && (masses_.empty() || masses_[first] == masses_[i]);
      block.all_free = block.all_free && b.kind == SphereKind::free;
    };
    block.begin = static_cast<std::uint32_t>(k) * kParticleBlock;
    block.end = std::min(count_, block.begin + kParticleBlock);
    block.last = static_cast<std::uint32_t>(k);
    block.uniform = block.all_free = true;
    block.interface_first = block.last + 1, block.interface_last = block.last;
    find_steps(block);
    auto end = std::upper_bound(cache_block_ends_.begin(), cache_block_ends_.end(), block.begin);
    std::uint32_t* const size = sizes_of(k);
    const std::uint32_t *const js = list_.j.data(), *const start = list_.start.data();
    std::uint16_t* const class_of = class_of_.data();
    const std::uint32_t* const class_of_step = class_of_step_.data();
    const Classes classes = classes_;
    // Touching pairs of each sphere, by law; of those across an interface behind the others.
    std::vector<std::array<std::uint32_t, kParticleBlock>> touching(2 * std::size_t{classes.laws});
    std::uint32_t farthest = block.begin;
    for (std::uint32_t i = block.begin; i < block.end; ++i) {
      include(i);
      while (i >= *end) ++end;
      const std::uint32_t last = start[i + 1], end_of_cache_block = *end, in_block = i - block.begin;
      for (std::uint32_t p = start[i]; p < last; ++p) {
        const std::uint32_t j = js[p], law = law_of(i, j);
        const bool across = j >= end_of_cache_block;
        const std::uint32_t step = class_of[p] != GapStep::kUnclear ? class_of[p] : exact_step(i, j, law);
        const std::uint32_t c = class_of_step[law * (1 + kGapClasses) + step] + (across ? classes.of_cache_block() : 0);
        class_of[p] = static_cast<std::uint16_t>(c);
        ++size[c];
        touching[law + (across ? classes.laws : 0)][in_block] += step == 0 ? 1 : 0;
        include(j);
        if (across)
          include_across(block, store_.images.sphere(j) / kParticleBlock);
        else
          farthest = std::max(farthest, j);
      }
    }
    block.last = farthest / kParticleBlock;
    for (const bool across : {false, true})
      for (std::uint32_t law = 0; law < classes.laws; ++law)
        if (const std::uint32_t c = classes.touching(law, across); size[c] > 0)
          size[c] = chunks_[k].emplace_back(touching[law + (across ? classes.laws : 0)]).blocks();
  }

  /// Of the pairs of a particle block, by the gaps of the list, to class_of_.
  void find_steps(const ParticleBlock& block) {
    const float* const gap = list_.gap.data();
    std::uint16_t* const step = class_of_.data();
    const float per_skin = per_skin_, error = error_;
    const auto find = [&](std::uint32_t begin, std::uint32_t end, float cutoff) {
      GapStep::of_nearly({gap + begin, gap + end}, cutoff, per_skin, error, step + begin);
    };
    if (only_law_ >= 0)
      return find(list_.start[block.begin], list_.start[block.end], cutoffs_[static_cast<std::size_t>(only_law_)]);
    for (std::uint32_t i = block.begin; i < block.end; ++i)
      for (std::uint32_t p = list_.start[i]; p < list_.start[i + 1]; ++p)
        find(p, p + 1, cutoffs_[law_of(i, list_.j[p])]);
  }
  /// Where the list's gap leaves it open.
  std::uint32_t exact_step(std::uint32_t i, std::uint32_t j, std::uint32_t law) const {
    const Sphere &a = spheres_[i], &b = spheres_[j];
    return GapStep::of(norm(a.x - b.x) - a.r - b.r - laws_.cutoff(law), skin_);
  }

  /// Runs in order; each class gets the place of its first block or pair.
  void place_runs(std::size_t k) {
    ParticleBlock& b = store_.particle_blocks[k];
    std::uint32_t* size = sizes_of(k);
    b.runs_begin = static_cast<std::uint32_t>(store_.runs.size());
    for (const bool across : {false, true}) {
      if (across) b.interface_runs_begin = static_cast<std::uint32_t>(store_.runs.size());
      for (std::uint32_t law = 0; law < classes_.laws; ++law)
        add_run(b, law, std::exchange(size[classes_.touching(law, across)], block_), false, across);
      for (std::uint32_t law = 0; law < classes_.laws; ++law) {
        std::uint32_t pairs = 0;
        for (std::uint32_t c = 0; c < kGapClasses; ++c)
          pairs += std::exchange(size[classes_.candidates(law, across) + c], block_ * kBlock + pairs);
        add_run(b, law, (pairs + kBlock - 1) / kBlock, true, across);
      }
    }
    b.runs_end = static_cast<std::uint32_t>(store_.runs.size());
  }
  void add_run(const ParticleBlock& b, std::uint32_t law, std::uint32_t blocks, bool candidates, bool across) {
    if (blocks == 0) return;
    store_.runs.push_back({.law = law,
                           .first = block_,
                           .blocks = blocks,
                           .lines = line_,
                           .candidates = candidates,
                           .uniform = b.uniform,
                           .all_free = b.all_free,
                           .across_interface = across});
    block_ += blocks;
    line_ += laws_.pair_memory(law).lines(blocks);
  }

  void write_blocks(std::size_t k) {
    const ParticleBlock& b = store_.particle_blocks[k];
    BlockWriter writer(store_.blocks.data(), store_.shapes.data());
    for (std::uint32_t r = b.runs_begin; r < b.runs_end; ++r) {
      const PairRun& run = store_.runs[r];
      for (std::uint32_t n = 0; n < run.blocks; ++n) writer.begin(run.first + n, run.candidates);
    }
    const std::vector<FirstLanes> touching = begin_chunks(b, chunks_[k], writer);
    std::uint32_t* const next = sizes_of(k);
    const std::uint32_t *const js = list_.j.data(), *const start = list_.start.data(), *const further = further_.data();
    const std::uint16_t* const class_of = class_of_.data();
    std::uint32_t* const place = place_.data();
    for (std::uint32_t i = b.begin; i < b.end; ++i) {
      for (const FirstLanes& first : touching) next[first.of_class] = first.of_sphere[i - b.begin];
      for (std::uint32_t p = start[i], last = start[i + 1]; p < last; ++p) {
        const std::uint32_t c = class_of[p], lane = next[c];
        next[c] = lane + further[c];
        place[p] = lane;
        writer.put(lane, i, js[p]);
      }
    }
    for (std::uint32_t r = b.runs_begin; r < b.runs_end; ++r) {
      const PairRun& run = store_.runs[r];
      if (run.candidates) end_candidates(run, next, writer);
      for (std::uint32_t n = 0; n < run.blocks; ++n) writer.fill(run.first + n);
      std::fill_n(store_.activation.data() + run.first, run.blocks, 0.0);
      std::fill_n(store_.lines.data() + run.lines, laws_.pair_memory(run.law).lines(run.blocks), Line{});
    }
  }
  /// Of the touching pairs of one class, the first lane of each sphere of a particle block that has some.
  struct FirstLanes {
    std::uint32_t of_class;
    std::array<std::uint32_t, kParticleBlock> of_sphere;
  };
  /// Of all touching runs, whose blocks get their numbers of lanes.
  std::vector<FirstLanes> begin_chunks(const ParticleBlock& b, const std::vector<Chunks>& chunks, BlockWriter& writer) {
    std::vector<FirstLanes> out;
    out.reserve(chunks.size());
    for (std::uint32_t r = b.runs_begin; r < b.runs_end; ++r) {
      const PairRun& run = store_.runs[r];
      if (run.candidates) continue;
      const Chunks& of_run = chunks[out.size()];
      FirstLanes& lanes = out.emplace_back();
      lanes.of_class = classes_.touching(run.law, run.across_interface);
      of_run.each([&](std::uint32_t sphere, std::uint32_t first, std::uint32_t lane, std::uint32_t pairs) {
        const std::uint32_t n = run.first + first;
        lanes.of_sphere[sphere] = n * kBlock + lane;
        store_.shapes[n].begins = true;
        for (std::uint32_t k = 0; k < pairs; ++k) writer.end(n + k, lane + 1);  // lanes come one after the other
      });
    }
    return out;
  }
  /// All blocks of a run are full but the last. @param next where the pairs of each class end
  void end_candidates(const PairRun& run, const std::uint32_t* next, BlockWriter& writer) const {
    const std::uint32_t end = next[classes_.candidates(run.law, run.across_interface) + kGapClasses - 1];
    for (std::uint32_t n = run.first; n < run.first + run.blocks; ++n)
      writer.end(n, std::min(kBlock, end - n * kBlock));
  }

  ContactStore& store_;
  std::span<const Sphere> spheres_;
  std::span<const double> masses_;
  const NeighbourList& list_;
  const ContactLaws& laws_;
  double skin_;
  int threads_;
  bool all_alike_ = false;
  int only_law_ = -1;                         ///< of all pairs; -1: there are several
  float per_skin_ = 0;                        ///< 1/m
  float error_ = 0;                           ///< of a gap's share of the skin
  std::vector<float> cutoffs_;                ///< by law, m
  std::vector<std::uint32_t> class_of_step_;  ///< by law and step, of pairs that are not across an interface
  std::vector<std::uint32_t> further_;        ///< by class: lanes from one pair of a sphere to the next
  std::uint32_t count_ = 0;                   ///< spheres without images
  Classes classes_{};
  std::vector<std::uint32_t> sizes_;
  std::vector<std::uint32_t> cache_block_ends_;  ///< in spheres
  Buffer<std::uint16_t> class_of_;               ///< by pair of the list
  Buffer<std::uint32_t> place_;                  ///< likewise
  std::vector<std::vector<Chunks>> chunks_;      ///< by particle block, of its touching runs
  std::uint32_t block_ = 0;                      ///< next free
  std::size_t line_ = 0;
};

}  // namespace

Buffer<std::uint32_t> ContactStore::build(std::span<const Sphere> spheres, std::span<const double> masses,
                                          const PeriodicImages& images_in, const NeighbourList& list, const Grid& grid,
                                          const ContactLaws& laws, double skin, int threads) {
  images = images_in;
  Buffer<std::uint32_t> place = Layout(*this, spheres, masses, list, grid, laws, skin, threads).run();
  link_interfaces();
  lists_ = next_lists();
  return place;
}

}  // namespace subsoil::dem
