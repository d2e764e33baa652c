#pragma once
#include <algorithm>

#include "libdem/kernel/lanes.hpp"

/// What blocks of pairs give to the sums of their spheres: in double in either precision, in the order of blocks and
/// lanes.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

/// Force and torque of one lane.
#if defined(__AVX512F__)
struct Row {
  __m512d all;
};
#else
struct Row {
  Four f, t;
};
#endif

/// Rows from the columns of force and torque.
[[gnu::always_inline]] inline void make_rows(const Doubles (&f)[4], const Doubles (&t)[4], Row (&row)[kDoubles]) {
#if defined(__AVX512F__)
  __m512d rows_f[4], rows_t[4];
  transpose4(f, rows_f), transpose4(t, rows_t);
  for (int l = 0; l < 4; ++l) {
    row[l].all = _mm512_maskz_shuffle_f64x2(0xFF, rows_f[l], rows_t[l], 0x44);
    row[l + 4].all = _mm512_maskz_shuffle_f64x2(0xFF, rows_f[l], rows_t[l], 0xEE);
  }
#else
  double* rows_f[kDoubles];
  double* rows_t[kDoubles];
  for (int l = 0; l < kDoubles; ++l)
    rows_f[l] = reinterpret_cast<double*>(&row[l].f), rows_t[l] = reinterpret_cast<double*>(&row[l].t);
  store4(f, rows_f), store4(t, rows_t);
#endif
}

[[gnu::always_inline]] inline void write(const Row& row, Accumulator& to) {
#if defined(__AVX512F__)
  _mm512_store_pd(reinterpret_cast<double*>(&to), row.all);
#else
  to.f = row.f, to.t = row.t;
#endif
}
/// For the owner of a pair.
[[gnu::always_inline]] inline void add(Accumulator& sum, const Row& row) {
#if defined(__AVX512F__)
  auto* of = reinterpret_cast<double*>(&sum);
  _mm512_store_pd(of, _mm512_add_pd(_mm512_load_pd(of), row.all));
#else
  sum.f += row.f, sum.t += row.t;
#endif
}
/// For the partner: the force is taken off, the torque is its own.
[[gnu::always_inline]] inline void react(Accumulator& sum, const Row& row) {
#if defined(__AVX512F__)
  auto* of = reinterpret_cast<double*>(&sum);
  const __m512d sign = _mm512_set_pd(1, 1, 1, 1, -1, -1, -1, -1);
  _mm512_store_pd(of, _mm512_fmadd_pd(sign, row.all, _mm512_load_pd(of)));
#else
  sum.f -= row.f, sum.t += row.t;
#endif
}

/// use(lane, row) for those of a pack's lanes that are below `lanes`.
template <class Use>
[[gnu::always_inline]] inline void each_row(const Row (&row)[kDoubles], int first, std::uint32_t lanes,
                                            const Use& use) {
  if (lanes >= static_cast<std::uint32_t>(first + kDoubles)) {
#pragma GCC unroll 8
    for (int l = 0; l < kDoubles; ++l) use(first + l, row[l]);
  } else {
    Row in_memory[kDoubles];  // the others stay in registers
    for (int l = 0; l < kDoubles; ++l) in_memory[l] = row[l];
    for (int l = first; l < static_cast<int>(lanes); ++l) use(l, in_memory[l - first]);
  }
}

template <class P>
[[gnu::always_inline]] inline Doubles pushed(const BlockResult& r, int k, int first) {
  if constexpr (std::is_same_v<P, Doubles>)
    return load<Doubles>(r.push[k] + first);
  else
    return load_floats<Doubles>(r.push_single[k] + first);
}

/// Force and torque on a pack's spheres, as columns; the last of the torque counts touching contacts.
struct Push {
  Doubles f[4], t[4];
};

template <class P, bool Count>
[[gnu::always_inline]] inline Push push_on_owners(const BlockResult& r, int first) {
  const auto column = [&](int k) { return pushed<P>(r, k, first); };
  const Doubles zero(0.0);
  return {{column(0), column(1), column(2), zero},
          {column(3), column(4), column(5), Count ? column(BlockResult::kTouching) : zero}};
}
/// The force still has to be turned round.
template <class P>
[[gnu::always_inline]] inline Push push_on_partners(const Push& on_owners, const BlockResult& r, int first,
                                                    bool same_torque) {
  Push on = on_owners;
  if (!same_torque)
    for (int d = 0; d < 3; ++d) on.t[d] = pushed<P>(r, 6 + d, first);
  return on;
}

/// use(lane, row) for those of a pack's lanes that are below `lanes`.
template <class Use>
[[gnu::always_inline]] inline void each_row(const Push& push, int first, std::uint32_t lanes, const Use& use) {
  Row row[kDoubles];
  make_rows(push.f, push.t, row);
  each_row(row, first, lanes, use);
}

/// What blocks that were evaluated before the sweep, or at a seam, give to their partners, who take it later.
template <class P, bool Count>
void keep_for_partners(const PairJob& job) {
  for (std::uint32_t k = 0; k < job.border_count; ++k) {
    if (job.border_awake[k] == 0) continue;
    const std::uint32_t b = job.border_block[k];
    BlockRows& rows = job.seam_rows != nullptr ? job.seam_rows[b] : job.border_rows[k];
    const BlockResult& r = job.border_result[k];
    for (int first = 0; first < static_cast<int>(kBlock); first += kDoubles)
      each_row(push_on_partners<P>(push_on_owners<P, Count>(r, first), r, first, job.same_torque), first,
               job.shapes[b].lanes, [&](int l, const Row& of) { write(of, rows.of[l]); });
    if (job.seam_rows != nullptr) job.seam_given[b] = 1;
  }
}

/// What the blocks of the present slice give to its owners.
template <bool Count>
struct OwnerSums {
  static constexpr int kParts = static_cast<int>(kBlock) / kDoubles, kColumns = Count ? 7 : 6;
  Doubles column[kColumns][kParts];
  const PairBlock* block = nullptr;  ///< that began the slice
  std::uint32_t lanes = 0;

  /// Before each block.
  [[gnu::always_inline]] void come_to(const PairBlock& b, const BlockShape& shape, Accumulator* ring,
                                      std::uint32_t mask) {
    if (!shape.begins) return;
    give(ring, mask);
    block = &b, lanes = shape.lanes;
    for (auto& parts : column)
      for (Doubles& part : parts) part = Doubles(0.0);
  }
  [[gnu::always_inline]] void add(const Push& push, int first, const BlockShape& shape) {
    const int part = first / kDoubles;
    const auto from = [&](int k) -> const Doubles& { return k < 3 ? push.f[k] : push.t[k - 3]; };
    if (shape.lanes == kBlock) {
      for (int k = 0; k < kColumns; ++k) column[k][part] += from(k);
    } else {
      const DoublesMask used = lanes_below(shape.lanes, first);
      for (int k = 0; k < kColumns; ++k) column[k][part] += select(used, from(k), Doubles(0.0));
    }
  }

  /// To the ring; lane by lane, since a block of near pairs may have an owner twice.
  [[gnu::always_inline]] void give(Accumulator* ring, std::uint32_t mask) {
    if (block == nullptr) return;
    for (int part = 0; part < kParts; ++part) {
      const Doubles zero(0.0);
      const Push push{{column[0][part], column[1][part], column[2][part], zero},
                      {column[3][part], column[4][part], column[5][part], Count ? column[kColumns - 1][part] : zero}};
      each_row(push, part * kDoubles, lanes,
               [&](int l, const Row& of) { dem::SUBSOIL_ISA::add(*record(ring, block->owner[l] & mask), of); });
    }
    block = nullptr;
  }
};

/// What a block gives to its owners and to its partners.
template <class P, bool Count>
[[gnu::always_inline]] inline void add_block(const BlockResult& r, const PairBlock& block, const BlockShape& shape,
                                             bool same_torque, OwnerSums<Count>& owners, Accumulator* ring,
                                             std::uint32_t mask) {
  owners.come_to(block, shape, ring, mask);
  for (int first = 0; first < static_cast<int>(kBlock); first += kDoubles) {
    const Push push = push_on_owners<P, Count>(r, first);
    owners.add(push, first, shape);
    each_row(push_on_partners<P>(push, r, first, same_torque), first, shape.lanes,
             [&](int l, const Row& of) { react(*record(ring, block.other[l] & mask), of); });
  }
}

/// BlockResult::sums of many blocks, lane by lane.
struct alignas(64) BlockSums {
  double of[6][kBlock] = {};

  /// Lanes beyond `count` have repeated another pair.
  void add(const BlockResult& r, std::uint32_t count) {
    for (int first = 0; first < static_cast<int>(kBlock); first += kDoubles) {
      const DoublesMask used = lanes_below(count, first);
      const auto lanes = [&](int k) { return select(used, load<Doubles>(r.sums[k] + first), Doubles(0.0)); };
      for (int k = 0; k < 5; ++k) store(load<Doubles>(of[k] + first) + lanes(k), of[k] + first);
      store(max(load<Doubles>(of[5] + first), lanes(5)), of[5] + first);
    }
  }
  double total(int k) const {
    double t = 0;
    for (const double x : of[k]) t += x;
    return t;
  }
  double largest(int k) const {
    double t = of[k][0];
    for (const double x : of[k])
      if (x > t) t = x;
    return t;
  }
  void give(RunSums& to) const {
    for (int k = 0; k < 3; ++k) to.lost[k] += total(k);
    to.stored += total(3);
    to.in_reach += total(4);
    to.overlap = std::max(to.overlap, largest(5));
  }
};

/// What the blocks of a run at a seam, which have been evaluated, give to their owners, and their sums.
template <class P, bool Count>
void add_to_owners(PairJob& job) {
  OwnerSums<Count> owner_sums;
  BlockSums sums;
  for (std::uint32_t k = 0; k < job.border_count; ++k) {
    if (job.border_awake[k] == 0) continue;
    const std::uint32_t b = job.border_block[k];
    owner_sums.come_to(job.blocks[b], job.shapes[b], job.ring, job.mask);
    for (int first = 0; first < static_cast<int>(kBlock); first += kDoubles)
      owner_sums.add(push_on_owners<P, Count>(job.border_result[k], first), first, job.shapes[b]);
    if constexpr (Count)
      if (job.sum) sums.add(job.border_result[k], job.shapes[b].lanes);
  }
  owner_sums.give(job.ring, job.mask);
  if constexpr (Count) sums.give(job.sums);
}

/// In the precision of the job; `book` as it was when the blocks were evaluated.
template <class Run>
void in_precision(const PairJob& job, const Run& run) {
  const auto with = [&]<class P>(P) { job.book ? run(P{}, std::true_type{}) : run(P{}, std::false_type{}); };
  job.mixed != nullptr ? with(Singles{}) : with(Doubles{});
}
inline void keep(PairJob& job) {
  in_precision(job, [&]<class P>(P, auto count) { keep_for_partners<P, count.value>(job); });
}
inline void add_seam(PairJob& job) {
  in_precision(job, [&]<class P>(P, auto count) { add_to_owners<P, count.value>(job); });
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
