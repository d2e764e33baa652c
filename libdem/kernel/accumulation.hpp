#pragma once
#include <algorithm>

#include "libdem/kernel/contact_rows.hpp"

/// What blocks of pairs give to the sums of their spheres: in the precision of the pairs, in the order of blocks and
/// lanes.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

/// Whether loops that accumulate nothing, for the usual friction alone, are compiled beside the general ones, which
/// give the same bits.
#ifdef SUBSOIL_GENERAL_LOOPS_ONLY
inline constexpr bool kUsualLoops = false;
#else
inline constexpr bool kUsualLoops = true;
#endif

inline Accumulator* sums_of(Ring ring, VecD) { return ring.doubles; }
inline MixedAccumulator* sums_of(Ring ring, VecF) { return ring.singles; }

template <class P>
[[gnu::always_inline]] inline Part<P> pushed(const BlockResult& r, std::uint32_t lanes, int k, int first) {
  if constexpr (std::is_same_v<P, VecD>)
    return load_part(r.push[k] + first, lanes, first);
  else
    return load_part(r.push_single[k] + first, lanes, first);
}

/// Force and torque on some spheres, as columns, zero in lanes that hold no pair: these may be added to any sum, which
/// stays what it is to the bit, since none that began with +0 ever becomes -0. The last of the torque counts touching
/// contacts.
template <class P>
struct Push {
  Part<P> f[4], t[4];
};

template <class P, bool Count>
[[gnu::always_inline]] inline Push<P> push_on_i(const BlockResult& r, std::uint32_t lanes, int first) {
  const auto column = [&](int k) { return pushed<P>(r, lanes, k, first); };
  const Part<P> zero(0.0);
  return {{column(0), column(1), column(2), zero},
          {column(3), column(4), column(5), Count ? column(BlockResult::kTouching) : zero}};
}
/// The force still has to be turned round.
template <class P>
[[gnu::always_inline]] inline Push<P> push_on_j(const Push<P>& on_i, const BlockResult& r, std::uint32_t lanes,
                                                int first, bool same_torque) {
  Push<P> on = on_i;
  if (!same_torque)
    for (int d = 0; d < 3; ++d) on.t[d] = pushed<P>(r, lanes, 6 + d, first);
  return on;
}

/// use(lane, row), the first of which is lane `first` of the block.
template <class P, class Use>
[[gnu::always_inline]] inline void each_row(const Push<P>& push, int first, const Use& use) {
  Row<Part<P>> row[kPart<P>];
  make_rows(push.f, push.t, row);
#pragma GCC unroll 8
  for (int l = 0; l < kPart<P>; ++l) use(first + l, row[l]);
}

/// What blocks that were evaluated before the sweep, or at a block interface, give to their spheres j, who take it
/// later.
template <class P, bool Count>
void keep_for_j(const PairJob& job) {
  for (std::uint32_t k = 0; k < job.halo_count; ++k) {
    if (job.halo_active[k] == 0) continue;
    const std::uint32_t b = job.halo_block[k];
    BlockRows& rows = job.interface_rows != nullptr ? job.interface_rows[b] : job.halo_rows[k];
    const BlockResult& r = job.halo_result[k];
    const std::uint32_t lanes = job.shapes[b].lanes;
    for (int first = 0; first < static_cast<int>(kBlock); first += kPart<P>)
      each_row(push_on_j<P>(push_on_i<P, Count>(r, lanes, first), r, lanes, first, job.same_torque), first,
               [&](int l, const auto& of) { write(of, rows.of[l]); });
    if (job.interface_rows != nullptr) job.interface_given[b] = 1;
  }
}

/// What the blocks of the present SELL chunk give to its spheres i, between groups of blocks.
template <class P, bool Count>
struct SumsOfI {
  static constexpr int kParts = static_cast<int>(kBlock) / kPart<P>, kColumns = Count ? 7 : 6;
  Part<P> column[kParts][kColumns];
  const PairBlock* block = nullptr;  ///< that began the SELL chunk

  SumsOfI() {
    for (auto& columns : column)
      for (auto& c : columns) c = Part<P>(0.0);
  }
};

/// One part of the lanes of SumsOfI in registers: with all parts AVX2 would have none left for the rows. Loops are
/// unrolled for GCC to keep the sums there: 2 % of a step in mixed precision, 6 in double.
template <class P, bool Count>
struct SumsOfPart {
  using All = SumsOfI<P, Count>;
  Part<P> column[All::kColumns];
  const PairBlock* block;  ///< that began the SELL chunk
  int first;               ///< lane of the block

  [[gnu::always_inline]] SumsOfPart(const All& all, int part) : block(all.block), first(part * kPart<P>) {
#pragma GCC unroll 8
    for (int k = 0; k < All::kColumns; ++k) column[k] = all.column[part][k];
  }
  /// Returns the block that began the SELL chunk.
  [[gnu::always_inline]] const PairBlock* give_back(All& all) const {
#pragma GCC unroll 8
    for (int k = 0; k < All::kColumns; ++k) all.column[first / kPart<P>][k] = column[k];
    return block;
  }
  /// Before each block.
  [[gnu::always_inline]] void come_to(const PairBlock& b, const BlockShape& shape, Ring ring) {
    if (!shape.begins) return;
    give(ring);
    block = &b;
#pragma GCC unroll 8
    for (auto& c : column) c = Part<P>(0.0);
  }
  [[gnu::always_inline]] void add(const Push<P>& push) {
#pragma GCC unroll 8
    for (int k = 0; k < All::kColumns; ++k) column[k] += k < 3 ? push.f[k] : push.t[k - 3];
  }

  /// To the ring; lane by lane, since a block of inactive candidates may have a sphere i twice.
  [[gnu::always_inline]] void give(Ring ring) const {
    if (block == nullptr) return;
    const Part<P> zero(0.0);
    Push<P> push{{column[0], column[1], column[2], zero},
                 {column[3], column[4], column[5], Count ? column[All::kColumns - 1] : zero}};
#if defined(__AVX2__)
    // Else GCC makes the rows before it asks whether a SELL chunk ends, which one block of three does.
    for (int d = 0; d < 3; ++d) asm volatile("" : "+v"(push.f[d].v), "+v"(push.t[d].v));
#endif
    each_row(push, first, [&](int l, const auto& of) {
      dem::SUBSOIL_ISA::add(*record(sums_of(ring, P{}), block->i[l].masked(ring.mask)), of);
    });
  }
};

/// What a block gives to its spheres j: in the order of blocks and lanes, in which other workers' spheres take it too
/// (keep_for_j).
template <class P, bool Count>
[[gnu::always_inline]] inline void add_to_j(const BlockResult& r, const PairBlock& block, const BlockShape& shape,
                                            bool same_torque, Ring ring) {
  const auto to_lane = [&](int l, const auto& of) {
    react(*record(sums_of(ring, P{}), block.j[l].masked(ring.mask)), of);
  };
#if defined(__AVX2__) && !defined(__AVX512F__)
  typename P::Real const* column[7];
  for (int k = 0; k < 6; ++k) {
    const int from = k < 3 || same_torque ? k : k + 3;
    if constexpr (std::is_same_v<P, VecD>)
      column[k] = r.push[from];
    else
      column[k] = r.push_single[from];
  }
  if constexpr (std::is_same_v<P, VecD>)
    column[6] = Count ? r.push[BlockResult::kTouching] : nullptr;
  else
    column[6] = Count ? r.push_single[BlockResult::kTouching] : nullptr;
#pragma GCC unroll 4
  for (int first = 0; first < static_cast<int>(kBlock); first += 4) {
    Row<Part<P>> row[4];
    rows_in_memory<Count>(column, first, row);
#pragma GCC unroll 4
    for (int l = 0; l < 4; ++l) to_lane(first + l, row[l]);
  }
  return;
#endif
#pragma GCC unroll 4
  for (int first = 0; first < static_cast<int>(kBlock); first += kPart<P>)
    each_row(push_on_j<P>(push_on_i<P, Count>(r, shape.lanes, first), r, shape.lanes, first, same_torque), first,
             to_lane);
}

/// BlockResult::sums of many blocks, lane by lane.
struct alignas(64) BlockSums {
  ContactSums<double[kBlock]> of = {};

  /// Lanes beyond `count` have repeated another pair.
  void add(const BlockResult& r, std::uint32_t count) {
    for (int first = 0; first < static_cast<int>(kBlock); first += kLanesD) {
      const VecDMask used = lanes_below(count, first);
      const auto lanes = [&](const double* column) { return select(used, load<VecD>(column + first), VecD(0.0)); };
      ContactSums<double>::each(
          of, r.sums,
          [&](double* sum, const double* column) { store(load<VecD>(sum + first) + lanes(column), sum + first); },
          [&](double* most, const double* column) {
            store(max(load<VecD>(most + first), lanes(column)), most + first);
          });
    }
  }
  void give(RunSums& to) const {
    RunSums::each(
        to, of,
        [](double& sum, const double* column) {
          double total = 0;
          for (std::uint32_t l = 0; l < kBlock; ++l) total += column[l];
          sum += total;
        },
        [](double& most, const double* column) {
          double largest = column[0];
          for (std::uint32_t l = 1; l < kBlock; ++l)
            if (column[l] > largest) largest = column[l];
          most = std::max(most, largest);
        });
  }
};

/// What the blocks of a run at a block interface, which have been evaluated, give to their spheres i, and their sums.
template <class P, bool Count>
void add_to_i(PairJob& job) {
  BlockSums sums;
  for (int part = 0; part < SumsOfI<P, Count>::kParts; ++part) {
    SumsOfPart<P, Count> sums_of_i(SumsOfI<P, Count>{}, part);
    for (std::uint32_t k = 0; k < job.halo_count; ++k) {
      if (job.halo_active[k] == 0) continue;
      const std::uint32_t b = job.halo_block[k];
      sums_of_i.come_to(job.blocks[b], job.shapes[b], job.ring);
      sums_of_i.add(push_on_i<P, Count>(job.halo_result[k], job.shapes[b].lanes, sums_of_i.first));
    }
    sums_of_i.give(job.ring);
  }
  if constexpr (Count)
    if (job.accumulate)
      for (std::uint32_t k = 0; k < job.halo_count; ++k)
        if (job.halo_active[k] != 0) sums.add(job.halo_result[k], job.shapes[job.halo_block[k]].lanes);
  if constexpr (Count) sums.give(job.sums);
}

/// In the precision of the job; `record` as it was when the blocks were evaluated, by the general loops if there are no
/// others.
template <class Run>
void in_precision(const PairJob& job, const Run& run) {
  const auto with = [&]<class P>(P) {
    job.record || !kUsualLoops ? run(P{}, std::true_type{}) : run(P{}, std::false_type{});
  };
  job.mixed != nullptr ? with(VecF{}) : with(VecD{});
}
inline void keep(PairJob& job) {
  in_precision(job, [&]<class P>(P, auto count) { keep_for_j<P, count.value>(job); });
}
inline void add_interface(PairJob& job) {
  in_precision(job, [&]<class P>(P, auto count) { add_to_i<P, count.value>(job); });
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
