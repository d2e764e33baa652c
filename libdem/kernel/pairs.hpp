#pragma once
#include "libdem/kernel/lanes.hpp"

/// Pairs of spheres, block by block, in stages over a few packs at a time: read and meet, law, add. A stage is short
/// enough for the processor to have several packs under way, so that none waits for the square roots of another.
///
/// P is Doubles with records Sphere, or Singles with MixedSphere: mixed precision. A pack of 16 floats spans two
/// blocks.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

inline constexpr int kGroup = 4;  ///< packs per stage

/// The spheres of a pack as they lie in memory, and the differences that must be taken in double.
template <class P>
struct Gap {
  P n[3], d2;  ///< from j to i, m; its square
  P excess;    ///< (r_i + r_j)^2 - d2, mixed precision only
  P v[3], w_i[3], w_j[3];
  P r_i, m_i, r_j, m_j;
};

/// Offsets of the records of a block.
struct PairOffsets {
  Offsets own, other;
};

[[gnu::always_inline]] inline void read(const Sphere* spheres, const PairOffsets (&at)[1], int first,
                                        Gap<Doubles>& out) {
  const Sphere *i[kDoubles], *j[kDoubles];
  for (int l = 0; l < kDoubles; ++l) {
    i[l] = record(spheres, at[0].own.at[first + l]);
    j[l] = record(spheres, at[0].other.at[first + l]);
  }
  const SphereLanes a = load_spheres(i), b = load_spheres(j);
  for (int d = 0; d < 3; ++d) {
    out.n[d] = a.x[d] - b.x[d];
    out.v[d] = a.v[d] - b.v[d];
    out.w_i[d] = a.w[d], out.w_j[d] = b.w[d];
  }
  out.d2 = dot3(out.n, out.n);
  out.r_i = a.r, out.m_i = a.m, out.r_j = b.r, out.m_j = b.m;
}

[[gnu::always_inline]] inline void read(const MixedSphere* spheres, const PairOffsets (&at)[kSpan<Singles>], int first,
                                        Gap<Singles>& out) {
  const float *i[kSingles], *j[kSingles];
  Doubles n[2][3], d2[2], excess[2];
  for (int half = 0; half < 2; ++half) {
    const double *x_i[kDoubles], *x_j[kDoubles];
    for (int l = 0; l < kDoubles; ++l) {
      const int lane = half * kDoubles + l, block = kSpan<Singles> == 2 ? half : 0;
      const int in_block = kSpan<Singles> == 2 ? l : first + lane;
      const MixedSphere *a = record(spheres, at[block].own.at[in_block]),
                        *b = record(spheres, at[block].other.at[in_block]);
      x_i[l] = &a->x.x, x_j[l] = &b->x.x;
      i[lane] = a->v, j[lane] = b->v;
    }
    Doubles a[4], b[4];
    load4(x_i, a), load4(x_j, b);
    for (int d = 0; d < 3; ++d) n[half][d] = a[d] - b[d];
    d2[half] = dot3(n[half], n[half]);
    const Doubles reach = a[3] + b[3];
    excess[half] = reach * reach - d2[half];
  }
  Singles a[8], b[8];
  load8(i, a), load8(j, b);
  for (int d = 0; d < 3; ++d) {
    out.n[d] = join(n[0][d], n[1][d]);
    out.v[d] = a[d] - b[d];
    out.w_i[d] = a[4 + d], out.w_j[d] = b[4 + d];
  }
  out.d2 = join(d2[0], d2[1]), out.excess = join(excess[0], excess[1]);
  out.m_i = a[3], out.r_i = a[7], out.m_j = b[3], out.r_j = b[7];
}

inline Doubles overlap_of(const Gap<Doubles>& g, Doubles distance) { return g.r_i + g.r_j - distance; }
inline Singles overlap_of(const Gap<Singles>& g, Singles distance) { return g.excess / (g.r_i + g.r_j + distance); }

template <bool Rolls, class L, class P>
[[gnu::always_inline]] inline void meet_pair(double share, const Gap<P>& g, MeetingOf<true, L, P>& out) {
  const P inverse = rsqrt(g.d2);
  Touch<P> a;
  a.overlap = overlap_of(g, g.d2 * inverse);
  for (int d = 0; d < 3; ++d) {
    a.n[d] = g.n[d] * inverse;
    a.v[d] = g.v[d], a.w_i[d] = g.w_i[d], a.w_j[d] = g.w_j[d];
  }
  a.r_i = g.r_i, a.m_i = g.m_i, a.r_j = g.r_j, a.m_j = g.m_j;
  meet<true, Rolls, L>(share, a, out);
  out.smaller = min(a.r_i, a.r_j);
}

/// What a contact gives to both spheres, as rows that are added whole. The other takes its row off, so its torque has
/// the sign turned.
[[gnu::always_inline]] inline void store_pushes(const Response<Doubles>& c, Doubles touching,
                                                BlockResult* const (&out)[1], int first) {
  const Doubles f[4] = {c.f[0], c.f[1], c.f[2], Doubles(0.0)}, t_i[4] = {c.t_i[0], c.t_i[1], c.t_i[2], touching},
                t_j[4] = {-c.t_j[0], -c.t_j[1], -c.t_j[2], -touching};
  double *own[kDoubles], *other[kDoubles];
  for (int l = 0; l < kDoubles; ++l) own[l] = out[0]->own[first + l].f, other[l] = out[0]->other[first + l].f;
  store_rows(f, t_i, t_j, own, other);
}
[[gnu::always_inline]] inline void store_pushes(const Response<Singles>& c, Singles touching,
                                                BlockResult* const (&out)[kSpan<Singles>], int first) {
  const Singles f[4] = {c.f[0], c.f[1], c.f[2], Singles(0.0)}, t_i[4] = {c.t_i[0], c.t_i[1], c.t_i[2], touching},
                t_j[4] = {-c.t_j[0], -c.t_j[1], -c.t_j[2], -touching};
  float *own[kSingles], *other[kSingles];
  for (int l = 0; l < kSingles; ++l) {
    BlockResult& r = *out[l / static_cast<int>(kBlock)];
    own[l] = r.own_single[first + l % static_cast<int>(kBlock)].f;
    other[l] = r.other_single[first + l % static_cast<int>(kBlock)].f;
  }
  store_rows(f, t_i, t_j, own, other);
}

/// The law on one pack; the memory of its contacts is updated. Lanes that no pair uses repeat the first pair of their
/// block and must not be added. Returns whether a bond broke.
template <bool Rolls, bool Book, class P, class L>
[[gnu::always_inline]] inline bool evaluate(const L& law, const PairJob& job, const MeetingOf<true, L, P>& a,
                                            const BlockMemory (&memory)[kSpan<P>], BlockResult* const (&out)[kSpan<P>],
                                            int first) {
  const P zero(0.0), one(1.0);
  const Remembers what(law);
  auto h = load_history<P, kOwn<L>, Rolls, Book>(memory, first, what);
  Response<P> c = respond<true, Rolls, P>(law, a, h, job.elapsed);
  store_history<P, kOwn<L>, Rolls, Book>(h, memory, first, what);
  bool broke = false;
  if constexpr (kBonds<L>) {
    BondMemory<P> bond = load_bond<P, Book>(memory, first);
    broke = respond_bond(law, a, bond, job.elapsed, c);
    store_bond<P, Book>(bond, memory, first);
  }
  store_pushes(c, select(a.overlap > zero, one, zero), out, first);
  if constexpr (Book) {
    const P sums[6] = {
        c.damped, c.slid, c.rolled, c.stored, select(a.overlap > P(-job.reach), one, zero), a.overlap / a.smaller};
    for (int k = 0; k < 6; ++k) store_doubles(sums[k], [&](int b) { return out[b]->sums[k] + first; });
  }
  if (job.wake != nullptr) store_doubles(a.overlap, [&](int b) { return out[b]->overlap + first; });
  return broke;
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
};

[[gnu::always_inline]] inline void add_push(Accumulator& own, const Push& a, Accumulator& other, const Push& b) {
#if defined(__AVX512F__)
  const auto sum = [](Accumulator& s) { return reinterpret_cast<double*>(&s); };
  _mm512_store_pd(sum(own), _mm512_add_pd(_mm512_load_pd(sum(own)), _mm512_load_pd(a.f)));
  _mm512_store_pd(sum(other), _mm512_sub_pd(_mm512_load_pd(sum(other)), _mm512_load_pd(b.f)));
#else
  own.f += *reinterpret_cast<const Four*>(a.f);
  own.t += *reinterpret_cast<const Four*>(a.t);
  other.f -= *reinterpret_cast<const Four*>(b.f);
  other.t -= *reinterpret_cast<const Four*>(b.t);
#endif
}
[[gnu::always_inline]] inline void add_push(Accumulator& own, const SinglePush& a, Accumulator& other,
                                            const SinglePush& b) {
#if defined(__AVX512F__)
  const auto sum = [](Accumulator& s) { return reinterpret_cast<double*>(&s); };
  const auto row = [](const SinglePush& p) { return _mm512_maskz_cvtps_pd(0xFF, _mm256_loadu_ps(p.f)); };
  _mm512_store_pd(sum(own), _mm512_add_pd(_mm512_load_pd(sum(own)), row(a)));
  _mm512_store_pd(sum(other), _mm512_sub_pd(_mm512_load_pd(sum(other)), row(b)));
#elif defined(__AVX2__)
  const auto four = [](const float* f) { return Four(_mm256_cvtps_pd(_mm_loadu_ps(f))); };
  own.f += four(a.f), own.t += four(a.t), other.f -= four(b.f), other.t -= four(b.t);
#else
  for (int k = 0; k < 4; ++k) {
    own.f[k] += static_cast<double>(a.f[k]), own.t[k] += static_cast<double>(a.t[k]);
    other.f[k] -= static_cast<double>(b.f[k]), other.t[k] -= static_cast<double>(b.t[k]);
  }
#endif
}

template <class P>
const auto& pushes(const BlockResult& r, bool own) {
  if constexpr (std::is_same_v<P, Doubles>)
    return own ? r.own : r.other;
  else
    return own ? r.own_single : r.other_single;
}

/// Adds a block's forces lane by lane, in the order of the list.
template <class P>
[[gnu::always_inline]] inline void add_block(const BlockResult& r, const PairBlock& block, std::uint32_t count,
                                             Accumulator* ring, std::uint32_t mask) {
  const Offsets own = offsets_of<Accumulator>(block.owner, mask), other = offsets_of<Accumulator>(block.other, mask);
  const auto add = [&](std::uint32_t l) {
    add_push(*record(ring, own.at[l]), pushes<P>(r, true)[l], *record(ring, other.at[l]), pushes<P>(r, false)[l]);
  };
  if (count == kBlock) {
    for (std::uint32_t l = 0; l < kBlock; ++l) add(l);
  } else {
    for (std::uint32_t l = 0; l < count; ++l) add(l);
  }
}

/// Until when a block may sleep: each of two spheres may go half their gap before they can be in reach. In mixed
/// precision the gap is known to a few 1e-7 of itself.
template <class P>
double wakes_at(const PairJob& job, const BlockResult& r) {
  constexpr double margin = std::is_same_v<P, Doubles> ? 0 : 1e-6;
  double largest = r.overlap[0];
  for (const double x : r.overlap) largest = largest > x ? largest : x;
  return job.path + 0.5 * (-largest - margin * (largest > 0 ? largest : -largest) - job.reach);
}

inline const Sphere* records(const PairJob& job, Doubles) { return job.spheres; }
inline const MixedSphere* records(const PairJob& job, Singles) { return job.mixed; }

/// All blocks of a run, or those that `border` names: then results are kept and not added. One loop for both, since two
/// copies of the law might be fused differently by the compiler, and the last bits would follow the threads.
template <class P, bool Rolls, bool Book, class L>
void run_pairs(const L& by_reference, PairJob& job) {
  constexpr int span = kSpan<P>, room = kGroup * span, lanes = P::kLanes;
  const L law = by_reference;  // nothing can point to it: its constants stay in registers
  const double share = lever_share(law);
  const MemoryShape shape = shape_of<L, Rolls, kBonds<L>>(law, std::is_same_v<P, Singles>);
  const auto* const spheres = records(job, P{});
  BlockSums sums;
  BlockResult results[room];
  MeetingOf<true, L, P> meeting[kGroup][kParts<P>];
  BlockResult* result[room] = {};
  std::uint32_t which[room] = {}, todo[room] = {};  // blocks of the group; those of them that are to be evaluated
  std::uint32_t next_ready = 0;
  const bool border = job.border != nullptr;
  const std::uint32_t count = border ? job.border_count : job.count;
  const auto lanes_of = [&](std::uint32_t b) { return b + 1 < job.count ? kBlock : job.pairs - b * kBlock; };
  const char* ahead = reinterpret_cast<const char*>(spheres + job.ahead);
  const char* const ahead_end = reinterpret_cast<const char*>(spheres + job.ahead + job.ahead_count);
  const std::ptrdiff_t stride = count > 0 ? ((ahead_end - ahead) / count + 1) * room : 0;
  for (std::uint32_t k = 0; k < count;) {
    for (const char* until = ahead + stride; ahead < until && ahead < ahead_end; ahead += 64)
      __builtin_prefetch(ahead, 0, 2);
    std::uint32_t blocks = 0, fresh = 0;
    for (; blocks < room && k < count; ++k) {
      const std::uint32_t b = border ? job.border[k] : k;
      const bool ready = !border && next_ready < job.ready_count && job.ready_block[next_ready] == b;
      if (!border && !ready && job.wake != nullptr && job.path < job.wake[b]) continue;
      which[blocks] = b;
      result[blocks] = ready || border ? job.ready + (border ? k : next_ready++) : &results[blocks];
      if (!ready) todo[fresh++] = blocks;
      ++blocks;
    }
    // A pack with only one block left computes it twice over.
    if (span == 2 && fresh % 2 == 1) todo[fresh] = todo[fresh - 1];
    const int packs = static_cast<int>((fresh + span - 1) / span);
    for (int g = 0; g < packs; ++g) {
      PairOffsets at[span];
      for (int s = 0; s < span; ++s) {
        const PairBlock& block = job.blocks[which[todo[g * span + s]]];
        at[s] = {offsets_of<std::remove_reference_t<decltype(*spheres)>>(block.owner, ~std::uint32_t{0}),
                 offsets_of<std::remove_reference_t<decltype(*spheres)>>(block.other, ~std::uint32_t{0})};
      }
      for (int part = 0; part < kParts<P>; ++part) {
        Gap<P> gap;
        read(spheres, at, part * lanes, gap);
        meet_pair<Rolls, L>(share, gap, meeting[g][part]);
      }
    }
    for (int g = 0; g < packs; ++g) {
      BlockMemory memory[span];
      BlockResult* out[span];
      for (int s = 0; s < span; ++s) {
        const std::uint32_t at = todo[g * span + s];
        memory[s] = BlockMemory::at(job.lines, job.count, shape, which[at]);
        out[s] = result[at];
      }
      for (int part = 0; part < kParts<P>; ++part)
        if (evaluate<Rolls, Book, P>(law, job, meeting[g][part], memory, out, part * lanes)) job.broke = true;
    }
    // A block at a border never sleeps.
    if (job.wake != nullptr)
      for (std::uint32_t f = 0; f < fresh; ++f) job.wake[which[todo[f]]] = wakes_at<P>(job, *result[todo[f]]);
    if (border) continue;
    for (std::uint32_t n = 0; n < blocks; ++n) {
      add_block<P>(*result[n], job.blocks[which[n]], lanes_of(which[n]), job.ring, job.mask);
      if constexpr (Book) sums.add(*result[n], lanes_of(which[n]));
    }
  }
  if constexpr (!Book) return;
  for (int k = 0; k < 3; ++k) job.sums.lost[k] += sums.total(k);
  job.sums.stored += sums.total(3);
  job.sums.in_reach += sums.total(4);
  job.sums.overlap = std::max(job.sums.overlap, sums.largest(5));
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
