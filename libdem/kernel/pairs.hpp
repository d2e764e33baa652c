#pragma once
#include "libdem/kernel/lanes.hpp"

/// Pairs of spheres, block by block: read, law, add. Three stages over a few blocks at a time, so that the processor
/// reads the next block's spheres while the law of this one waits for its square roots.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

inline constexpr int kGroup = 4;  ///< blocks per stage; 1 loses a quarter, 8 gains nothing

/// What the law needs of a block's spheres.
struct PairLanes {
  Pack n[3], v[3], w_i[3], w_j[3], r_i, r_j, m_i, m_j;  ///< n is the distance vector still
};
inline constexpr int kParts = static_cast<int>(kBlock) / kWidth;  ///< packs of a block

[[gnu::always_inline]] inline void read_spheres(const Sphere* spheres, const PairBlock& block, PairLanes* out) {
  for (int part = 0; part < kParts; ++part) {
    const SphereLanes i = load_spheres(spheres, block.owner, part * kWidth),
                      j = load_spheres(spheres, block.other, part * kWidth);
    PairLanes& p = out[part];
    for (int d = 0; d < 3; ++d) {
      p.n[d] = i.x[d] - j.x[d];
      p.v[d] = i.v[d] - j.v[d];
      p.w_i[d] = i.w[d], p.w_j[d] = j.w[d];
    }
    p.r_i = i.r, p.r_j = j.r, p.m_i = i.m, p.m_j = j.m;
  }
}

/// The law on one block whose first `count` lanes are in use; their memory is updated. Lanes beyond repeat the first
/// pair, are cleared from the sums and must not be added.
template <bool Rolls, class L>
[[gnu::always_inline]] inline void evaluate_block(const L& law, double share, double reach, double elapsed,
                                                  const PairLanes* lanes, Row* rows, std::uint32_t count,
                                                  BlockResult& out) {
  const Pack zero(0.0), one(1.0);
  for (int part = 0; part < kParts; ++part) {
    const int first = part * kWidth;
    const PairLanes& p = lanes[part];
    Touch a;
    const Pack d2 = dot3(p.n, p.n), inv = rsqrt(d2);
    for (int d = 0; d < 3; ++d) a.n[d] = p.n[d] * inv, a.v[d] = p.v[d], a.w_i[d] = p.w_i[d], a.w_j[d] = p.w_j[d];
    a.overlap = p.r_i + p.r_j - d2 * inv;
    a.r_i = p.r_i, a.r_j = p.r_j, a.m_i = p.m_i, a.m_j = p.m_j;
    History h = load_history<Rolls>(rows, first);
    const Response c = respond<true, Rolls>(law, share, a, h, elapsed);
    store_history<Rolls>(h, rows, first);
    store_response(c, select(a.overlap > zero, one, zero), out.f + first, out.t_i + first, out.t_j + first);
    Pack sums[6] = {c.damped,
                    c.slid,
                    c.rolled,
                    c.stored,
                    select(a.overlap > Pack(-reach), one, zero),
                    a.overlap / min(a.r_i, a.r_j)};
    if (count < kBlock) {
      const PackMask used = lanes_below(count, first);
      for (Pack& s : sums) s = select(used, s, zero);
    }
    for (int k = 0; k < 6; ++k) store(sums[k], out.sums[k] + first);
    store(a.overlap, out.overlap + first);
  }
}

/// Adds a block's forces lane by lane, in the order of the list, and its sums.
[[gnu::always_inline]] inline void add_block(const BlockResult& r, const PairBlock& block, std::uint32_t count,
                                             Accumulator* ring, std::uint32_t mask, Row* sums) {
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
  for (int k = 0; k < 5; ++k)
    for (int first = 0; first < static_cast<int>(kBlock); first += kWidth)
      store(load(sums[k].x + first) + load(r.sums[k] + first), sums[k].x + first);
  for (int first = 0; first < static_cast<int>(kBlock); first += kWidth)
    store(max(load(sums[5].x + first), load(r.sums[5] + first)), sums[5].x + first);
}

inline double largest_overlap(const BlockResult& r) {
  double largest = r.overlap[0];
  for (const double x : r.overlap)
    if (!(x <= largest)) largest = x;
  return largest;
}

template <bool Rolls, class L>
void run_pairs(const L& by_reference, PairJob& job) {
  const L law = by_reference;  // nothing can point to it: its constants stay in registers
  const double share = lever_share(law);
  constexpr std::size_t rows = Rolls ? HistoryRows::rolling : HistoryRows::sliding;
  Row sums[6] = {};
  BlockResult results[kGroup];
  PairLanes lanes[kGroup][kParts];
  const BlockResult* result[kGroup];
  std::uint32_t which[kGroup];
  std::uint32_t next_ready = 0;
  const auto lanes_of = [&](std::uint32_t b) { return b + 1 < job.count ? kBlock : job.pairs - b * kBlock; };
  const char* ahead = reinterpret_cast<const char*>(job.ahead);
  const char* const ahead_end = reinterpret_cast<const char*>(job.ahead + job.ahead_count);
  const std::ptrdiff_t stride = job.count > 0 ? ((ahead_end - ahead) / job.count + 1) * kGroup : 0;
  for (std::uint32_t b = 0; b < job.count;) {
    for (const char* until = ahead + stride; ahead < until && ahead < ahead_end; ahead += 64)
      __builtin_prefetch(ahead, 0, 2);
    int n = 0;
    for (; n < kGroup && b < job.count; ++b) {
      const bool is_ready = next_ready < job.ready_count && job.ready_block[next_ready] == b;
      if (!is_ready && job.wake != nullptr && job.path < job.wake[b]) continue;
      result[n] = is_ready ? &job.ready[next_ready++] : nullptr;
      if (!is_ready) read_spheres(job.spheres, job.blocks[b], lanes[n]);
      which[n++] = b;
    }
    for (int k = 0; k < n; ++k) {
      if (result[k] != nullptr) continue;
      const std::uint32_t at = which[k];
      evaluate_block<Rolls>(law, share, job.reach, job.elapsed, lanes[k], job.rows + rows * at, lanes_of(at),
                            results[k]);
      // Each of two spheres may go half their gap before they can be in reach.
      if (job.wake != nullptr) job.wake[at] = job.path + 0.5 * (-largest_overlap(results[k]) - job.reach);
      result[k] = &results[k];
    }
    for (int k = 0; k < n; ++k)
      add_block(*result[k], job.blocks[which[k]], lanes_of(which[k]), job.ring, job.mask, sums);
  }
  const auto total = [](const Row& r) {
    double t = 0;
    for (const double x : r.x) t += x;
    return t;
  };
  for (int k = 0; k < 3; ++k) job.sums.lost[k] += total(sums[k]);
  job.sums.stored += total(sums[3]);
  job.sums.in_reach += total(sums[4]);
  for (const double x : sums[5].x)
    if (x > job.sums.overlap) job.sums.overlap = x;
}

/// One block whose partners belong to another thread, to be added by both later.
template <bool Rolls, class L>
void run_ready(const L& law, PairJob& job, std::uint32_t b, BlockResult& out) {
  constexpr std::size_t rows = Rolls ? HistoryRows::rolling : HistoryRows::sliding;
  const std::uint32_t lanes = b + 1 < job.count ? kBlock : job.pairs - b * kBlock;
  PairLanes spheres[kParts];
  read_spheres(job.spheres, job.blocks[b], spheres);
  evaluate_block<Rolls>(law, lever_share(law), job.reach, job.elapsed, spheres, job.rows + rows * b, lanes, out);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
