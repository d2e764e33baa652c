#include "libdem/contacts/contact_store.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <optional>
#include <utility>

#include "libdem/contacts/lane_copy.hpp"

namespace subsoil::dem {
namespace {

/// Blocks of pairs wherever they lie, now or before a rebuild; only read.
struct Streams {
  const Buffer<PairBlock>& blocks;
  const Buffer<BlockShape>& shapes;
  const Buffer<Line>& lines;
  const PeriodicImages& images;
};

/// Memory of the blocks of a run. BlockMemory::at counts the fields of the shape, here once in place of once a contact.
class RunMemory {
 public:
  RunMemory(Line* lines, const PairRun& run, const MemoryShape& shape)
      : first_(BlockMemory::at(lines + run.lines, run.blocks, shape, 0)),
        state_bytes_(shape.state_bytes()),
        diagnostic_bytes_(shape.diagnostic_bytes()) {}

  BlockMemory block(std::size_t block) const { return first_.further(block, state_bytes_, diagnostic_bytes_); }

 private:
  BlockMemory first_;
  std::size_t state_bytes_, diagnostic_bytes_;
};

/// use_pair(PairHistory), use_bond(BondHistory) for all lanes of a run that have one; of an image its sphere.
template <class UsePair, class UseBond>
void each_history(const PairRun& run, const Streams& in, const MemoryShape& shape, const UsePair& use_pair,
                  const UseBond& use_bond) {
  const RunMemory all(const_cast<Line*>(in.lines.data()), run, shape);
  for (std::uint32_t block = 0; block < run.blocks; ++block) {
    const PairBlock& b = in.blocks[run.first + block];
    const BlockMemory memory = all.block(block);
    for (std::uint32_t lane = 0; lane < in.shapes[run.first + block].lanes; ++lane) {
      const std::uint32_t j = in.images.sphere(b.j[lane]);
      if (const PairState s = read_lane(memory, shape, lane); !s.empty()) use_pair({b.i[lane], j, s});
      if (!shape.bonds) continue;
      if (const BondMemory<double> s = read_bond(memory, shape, lane); s.state != kNoBond) use_bond({b.i[lane], j, s});
    }
  }
}

/// Puts one history after the other to its pair, wherever that lies now.
class HistoryWriter {
 public:
  HistoryWriter(ContactStore& store, const NeighbourList& list, const Buffer<std::uint32_t>& place,
                const std::vector<std::uint32_t>& new_index, const ContactLaws& laws)
      : store_(store), list_(list), place_(place), new_index_(new_index), laws_(laws) {
    run_of_.renew(store.blocks.size());
    for (std::uint32_t r = 0; r < store.runs.size(); ++r) {
      const PairRun& run = store.runs[r];
      std::fill_n(run_of_.data() + run.first, run.blocks, r);
      memory_.emplace_back(store.lines.data(), run, laws.pair_memory(run.law));
    }
    for (std::uint32_t law = 0; law < laws.count(); ++law) copies_.emplace_back(laws.pair_memory(law));
  }

  void put(const PairHistory& was) const { put(was, true, write_lane); }
  /// Those of a run as it was: contacts from lane to lane, since a pair keeps its law between two rebuilds. Returns how
  /// many bonds are gone.
  std::size_t put(const PairRun& run, const Streams& before) const {
    const MemoryShape& shape = laws_.pair_memory(run.law);
    const RunMemory all(const_cast<Line*>(before.lines.data()), run, shape);
    const LaneCopy& contacts = copies_[run.law];
    std::size_t gone = 0;
    for (std::uint32_t block = 0; block < run.blocks; ++block) {
      const PairBlock& b = before.blocks[run.first + block];
      const BlockMemory memory = all.block(block);
      const std::uint32_t lanes = before.shapes[run.first + block].lanes;
      for (std::uint32_t left = contacts.filled(memory, lanes); left != 0; left &= left - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
        at_pair(b.i[lane], before.images.sphere(b.j[lane]),
                [&](const PairRun&, const BlockMemory& to, std::uint32_t to_lane, bool turned_over) {
                  contacts.copy(memory, lane, to, to_lane, turned_over);
                  return true;
                });
      }
      if (!shape.bonds) continue;
      for (std::uint32_t lane = 0; lane < lanes; ++lane)
        if (const BondMemory<double> s = read_bond(memory, shape, lane); s.state != kNoBond)
          gone += put(BondHistory{b.i[lane], before.images.sphere(b.j[lane]), s}) ? 0 : 1;
    }
    return gone;
  }
  /// False where the pair is gone or its law has no bonds any more.
  bool put(const BondHistory& was) const { return put(was, false, write_bond); }

 private:
  template <class History, class Write>
  bool put(const History& was, bool in_any_law, const Write& write) const {
    return at_pair(was.i, was.j, [&](const PairRun& run, const BlockMemory& to, std::uint32_t lane, bool turned_over) {
      const MemoryShape& shape = laws_.pair_memory(run.law);
      if (!in_any_law && !shape.bonds) return false;
      write(to, shape, lane, turned_over ? was.state.turned_over() : was.state);
      return true;
    });
  }
  /// use(its run, memory of its block, lane, whether i and j are exchanged) of the pair that spheres before are now;
  /// false where it is gone.
  template <class Use>
  bool at_pair(std::uint32_t i_before, std::uint32_t j_before, const Use& use) const {
    const std::uint32_t a = new_index_[i_before], b = new_index_[j_before];
    if (a == kGone || b == kGone) return false;
    const std::uint32_t i = std::min(a, b), j = std::max(a, b);
    const auto use_at = [&](std::uint32_t p, bool turned_over) {
      const std::uint32_t block = place_[p] / kBlock, run = run_of_[block];
      return use(store_.runs[run], memory_[run].block(block - store_.runs[run].first), place_[p] % kBlock, turned_over);
    };
    for (std::uint32_t p = list_.start[i]; p < list_.start[i + 1]; ++p)
      if (list_.j[p] == j) return use_at(p, a > b);
    if (store_.images.empty()) return false;
    if (const auto p = across(a, b)) return use_at(*p, false);
    if (const auto p = across(b, a)) return use_at(*p, true);
    return false;
  }
  /// Place in the list of a pair across a periodic side.
  std::optional<std::uint32_t> across(std::uint32_t first, std::uint32_t second) const {
    for (std::uint32_t p = list_.start[first]; p < list_.start[first + 1]; ++p)
      if (list_.j[p] >= store_.images.spheres && store_.images.sphere(list_.j[p]) == second) return p;
    return std::nullopt;
  }

  const ContactStore& store_;
  const NeighbourList& list_;
  const Buffer<std::uint32_t>& place_;
  const std::vector<std::uint32_t>& new_index_;
  const ContactLaws& laws_;
  Buffer<std::uint32_t> run_of_;   ///< by block
  std::vector<RunMemory> memory_;  ///< by run
  std::vector<LaneCopy> copies_;   ///< by law
};

}  // namespace

std::size_t ContactStore::restore_histories(const NeighbourList& list, const Buffer<std::uint32_t>& place,
                                            const std::vector<std::uint32_t>& new_index, const ContactLaws& laws,
                                            int threads) {
  const HistoryWriter writer(*this, list, place, new_index, laws);
  const Streams before{retired_.blocks, retired_.shapes, retired_.lines, retired_.images};
  std::size_t gone = 0;  // bonds
  const auto old_runs = static_cast<long>(retired_.runs.size());
#pragma omp parallel for num_threads(threads) schedule(static) reduction(+ : gone)
  for (long r = 0; r < old_runs; ++r) gone += writer.put(retired_.runs[static_cast<std::size_t>(r)], before);
  for (const PairHistories& part : waiting_) {
    const auto number = static_cast<long>(part.pairs.size()), bonded = static_cast<long>(part.bonds.size());
#pragma omp parallel for num_threads(threads) schedule(static)
    for (long k = 0; k < number; ++k) writer.put(part.pairs[static_cast<std::size_t>(k)]);
#pragma omp parallel for num_threads(threads) schedule(static) reduction(+ : gone)
    for (long k = 0; k < bonded; ++k) gone += writer.put(part.bonds[static_cast<std::size_t>(k)]) ? 0 : 1;
  }
  retired_.runs.clear();
  waiting_ = {};
  return gone;
}

std::uint64_t ContactStore::next_lists() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

void ContactStore::copy(const ContactStore& from) {
  runs = from.runs;  // steps write their activation
  activation.copy(from.activation), lines.copy(from.lines);
  waiting_ = from.waiting_;
  if (lists_ != from.lists_) {
    particle_blocks = from.particle_blocks;
    blocks.copy(from.blocks), shapes.copy(from.shapes);
    images = from.images;
    link_interfaces();
    lists_ = from.lists_;
  }
  interface_given = from.interface_given;  // of runs that no step has activated yet it is not written
}

void ContactStore::clear() {
  lists_ = next_lists();
  particle_blocks.clear(), runs.clear(), blocks.clear(), shapes.clear(), activation.clear(), lines.clear();
  images = {};
  waiting_.clear();
}

void ContactStore::retire() {
  std::swap(runs, retired_.runs), std::swap(blocks, retired_.blocks);
  std::swap(shapes, retired_.shapes), std::swap(lines, retired_.lines);
  retired_.images = std::move(images);
  clear();
}

void ContactStore::set_aside(const ContactLaws& laws, int threads) {
  std::vector<PairHistories> kept = histories(laws, threads);
  clear();
  waiting_ = std::move(kept);
}

std::vector<PairHistories> ContactStore::histories(const ContactLaws& laws, int threads) const {
  std::vector<PairHistories> found(static_cast<std::size_t>(threads));
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int t = 0; t < threads; ++t) {
    const std::size_t n = runs.size(), share = static_cast<std::size_t>(t), all = static_cast<std::size_t>(threads);
    const std::size_t begin = n * share / all, end = n * (share + 1) / all;
    std::size_t touching = 0;
    for (std::size_t r = begin; r < end; ++r) touching += runs[r].candidates ? 0 : runs[r].blocks * kBlock;
    found[share].pairs.reserve(touching + touching / 32);
    for (std::size_t r = begin; r < end; ++r) {
      each_history(
          runs[r], {blocks, shapes, lines, images}, laws.pair_memory(runs[r].law),
          [&](const PairHistory& was) { found[share].pairs.push_back(was); },
          [&](const BondHistory& was) { found[share].bonds.push_back(was); });
    }
  }
  return found;
}

}  // namespace subsoil::dem
