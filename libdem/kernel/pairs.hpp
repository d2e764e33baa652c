#pragma once
#include "libdem/kernel/lanes.hpp"

/// Pairs of spheres, block by block: read, law, add. Three stages over a few blocks at a time, so that the processor
/// reads the next block's spheres while the law of this one waits for its square roots.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

inline constexpr int kGroup = 4;  ///< blocks per stage; 1 loses a quarter, 8 gains nothing

inline constexpr int kParts = static_cast<int>(kBlock) / kWidth;  ///< packs of a block

/// First stage: spheres of a block and how they meet, with the smaller radius of each pair. The transposes occupy one
/// port, the first square roots the other.
struct MeetingLanes {
  Meeting meeting;
  Pack smaller;
};
template <bool Rolls>
[[gnu::always_inline]] inline void meet_block(const Sphere* spheres, const PairBlock& block, double share,
                                              MeetingLanes* out) {
  for (int part = 0; part < kParts; ++part) {
    const SphereLanes i = load_spheres(spheres, block.owner, part * kWidth),
                      j = load_spheres(spheres, block.other, part * kWidth);
    Touch a;
    for (int d = 0; d < 3; ++d) {
      a.n[d] = i.x[d] - j.x[d];
      a.v[d] = i.v[d] - j.v[d];
      a.w_i[d] = i.w[d], a.w_j[d] = j.w[d];
    }
    const Pack d2 = dot3(a.n, a.n), inv = rsqrt(d2);
    for (int d = 0; d < 3; ++d) a.n[d] = a.n[d] * inv;
    a.overlap = i.r + j.r - d2 * inv;
    a.r_i = i.r, a.r_j = j.r, a.m_i = i.m, a.m_j = j.m;
    out[part] = {meet<true, Rolls>(share, a), min(i.r, j.r)};
  }
}

/// The law on one block whose first `count` lanes are in use; their memory is updated. Lanes beyond repeat the first
/// pair, are cleared from the sums and must not be added.
template <bool Rolls, bool Book, class L>
[[gnu::always_inline]] inline void evaluate_block(const L& law, double reach, double elapsed, const MeetingLanes* lanes,
                                                  const BlockMemory& memory, std::uint32_t count, BlockResult& out) {
  const Pack zero(0.0), one(1.0);
  for (int part = 0; part < kParts; ++part) {
    const int first = part * kWidth;
    const Meeting& a = lanes[part].meeting;
    History<kOwn<L>> h = load_history<kOwn<L>, Rolls, Book>(memory, first, law.friction.remembers_slip());
    const Response c = respond<true, Rolls>(law, a, h, elapsed);
    store_history<kOwn<L>, Rolls, Book>(h, memory, first, law.friction.remembers_slip());
    store_response(c, select(a.overlap > zero, one, zero), out.f + first, out.t_i + first, out.t_j + first);
    if constexpr (Book) {
      Pack sums[6] = {c.damped,
                      c.slid,
                      c.rolled,
                      c.stored,
                      select(a.overlap > Pack(-reach), one, zero),
                      a.overlap / lanes[part].smaller};
      if (count < kBlock) {
        const PackMask used = lanes_below(count, first);
        for (Pack& s : sums) s = select(used, s, zero);
      }
      for (int k = 0; k < 6; ++k) store(sums[k], out.sums[k] + first);
    }
    store(a.overlap, out.overlap + first);
  }
}

/// BlockResult::sums of many blocks, lane by lane.
struct alignas(64) BlockSums {
  double of[6][kBlock] = {};
};

/// Adds a block's forces lane by lane, in the order of the list, and its sums.
template <bool Book>
[[gnu::always_inline]] inline void add_block(const BlockResult& r, const PairBlock& block, std::uint32_t count,
                                             Accumulator* ring, std::uint32_t mask, BlockSums& sums) {
  const Offsets own = offsets_of<sizeof(Accumulator)>(block.owner, mask),
                other = offsets_of<sizeof(Accumulator)>(block.other, mask);
  char* const base = reinterpret_cast<char*>(ring);
  const auto add = [&](std::uint32_t l) {
    Accumulator& a = *reinterpret_cast<Accumulator*>(base + own.at[l]);
    a.f += r.f[l];
    a.t += r.t_i[l];
    Accumulator& b = *reinterpret_cast<Accumulator*>(base + other.at[l]);
    b.f -= r.f[l];
    b.t += r.t_j[l];
  };
  if (count == kBlock) {
    for (std::uint32_t l = 0; l < kBlock; ++l) add(l);
  } else {
    for (std::uint32_t l = 0; l < count; ++l) add(l);
  }
  if constexpr (!Book) return;
  for (int k = 0; k < 5; ++k)
    for (int first = 0; first < static_cast<int>(kBlock); first += kWidth)
      store(load(sums.of[k] + first) + load(r.sums[k] + first), sums.of[k] + first);
  for (int first = 0; first < static_cast<int>(kBlock); first += kWidth)
    store(max(load(sums.of[5] + first), load(r.sums[5] + first)), sums.of[5] + first);
}

inline double largest_overlap(const BlockResult& r) {
  double largest = r.overlap[0];
  for (const double x : r.overlap)
    if (!(x <= largest)) largest = x;
  return largest;
}

/// All blocks of a run, or those that `border` names: then results are kept and not added. One loop for both, since two
/// copies of the law might be fused differently by the compiler, and the last bits would follow the threads.
template <bool Rolls, bool Book, class L>
void run_pairs(const L& by_reference, PairJob& job) {
  const L law = by_reference;  // nothing can point to it: its constants stay in registers
  const double share = lever_share(law);
  const MemoryShape shape{.rolls = Rolls, .own = kOwn<L>};
  BlockSums sums;
  BlockResult results[kGroup];
  MeetingLanes lanes[kGroup][kParts];
  BlockResult* result[kGroup] = {};
  bool evaluate[kGroup] = {};
  std::uint32_t which[kGroup] = {};
  std::uint32_t next_ready = 0;
  const bool border = job.border != nullptr;
  const std::uint32_t count = border ? job.border_count : job.count;
  const auto lanes_of = [&](std::uint32_t b) { return b + 1 < job.count ? kBlock : job.pairs - b * kBlock; };
  const char* ahead = reinterpret_cast<const char*>(job.ahead);
  const char* const ahead_end = reinterpret_cast<const char*>(job.ahead + job.ahead_count);
  const std::ptrdiff_t stride = count > 0 ? ((ahead_end - ahead) / count + 1) * kGroup : 0;
  for (std::uint32_t k = 0; k < count;) {
    for (const char* until = ahead + stride; ahead < until && ahead < ahead_end; ahead += 64)
      __builtin_prefetch(ahead, 0, 2);
    int n = 0;
    for (; n < kGroup && k < count; ++k) {
      const std::uint32_t b = border ? job.border[k] : k;
      const bool ready = !border && next_ready < job.ready_count && job.ready_block[next_ready] == b;
      if (!border && !ready && job.wake != nullptr && job.path < job.wake[b]) continue;
      which[n] = b;
      evaluate[n] = !ready;
      result[n] = ready || border ? job.ready + (border ? k : next_ready++) : &results[n];
      if (!ready) meet_block<Rolls>(job.spheres, job.blocks[b], share, lanes[n]);
      ++n;
    }
    for (int g = 0; g < n; ++g) {
      if (!evaluate[g]) continue;
      const std::uint32_t b = which[g];
      evaluate_block<Rolls, Book>(law, job.reach, job.elapsed, lanes[g],
                                  BlockMemory::at(job.lines, job.count, shape, b), lanes_of(b), *result[g]);
      // Each of two spheres may go half their gap before they can be in reach. A block at a border never sleeps.
      if (job.wake != nullptr) job.wake[b] = job.path + 0.5 * (-largest_overlap(*result[g]) - job.reach);
    }
    if (border) continue;
    for (int g = 0; g < n; ++g)
      add_block<Book>(*result[g], job.blocks[which[g]], lanes_of(which[g]), job.ring, job.mask, sums);
  }
  const auto total = [](const double(&lanes)[kBlock]) {
    double t = 0;
    for (const double x : lanes) t += x;
    return t;
  };
  for (int k = 0; k < 3; ++k) job.sums.lost[k] += total(sums.of[k]);
  job.sums.stored += total(sums.of[3]);
  job.sums.in_reach += total(sums.of[4]);
  for (const double x : sums.of[5])
    if (x > job.sums.overlap) job.sums.overlap = x;
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
