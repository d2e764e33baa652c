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

/// The owners of a slice, each number of all eight side by side.
template <class P>
struct alignas(64) Owners;
template <>
struct alignas(64) Owners<Doubles> {
  double x[3][kBlock], r[kBlock], v[3][kBlock], m[kBlock], w[3][kBlock];
};
template <>
struct alignas(64) Owners<Singles> {
  double x[3][kBlock], r[kBlock];
  float motion[8][kBlock];  ///< v, m, w, r
};

[[gnu::always_inline]] inline void read(const Sphere* spheres, const Offsets& at, Owners<Doubles>& out) {
  for (int first = 0; first < static_cast<int>(kBlock); first += kDoubles) {
    const Sphere* i[kDoubles];
    for (int l = 0; l < kDoubles; ++l) i[l] = record(spheres, at.at[first + l]);
    const SphereLanes a = load_spheres(i);
    for (int d = 0; d < 3; ++d) store(a.x[d], out.x[d] + first), store(a.v[d], out.v[d] + first);
    for (int d = 0; d < 3; ++d) store(a.w[d], out.w[d] + first);
    store(a.r, out.r + first), store(a.m, out.m + first);
  }
}
[[gnu::always_inline]] inline void read(const MixedSphere* spheres, const Offsets& at, Owners<Singles>& out) {
  for (int first = 0; first < static_cast<int>(kBlock); first += kDoubles) {
    const double* x[kDoubles];
    for (int l = 0; l < kDoubles; ++l) x[l] = &record(spheres, at.at[first + l])->x.x;
    Doubles a[4];
    load4(x, a);
    for (int d = 0; d < 3; ++d) store(a[d], out.x[d] + first);
    store(a[3], out.r + first);
  }
  float beyond[kSingles];  // of a pack wider than a block
  for (int first = 0; first < static_cast<int>(kBlock); first += kSingles) {
    const float* motion[kSingles];
    for (int l = 0; l < kSingles; ++l) motion[l] = record(spheres, at.at[(first + l) % static_cast<int>(kBlock)])->v;
    Singles a[8];
    load8(motion, a);
    for (int k = 0; k < 8; ++k) store_each(a[k], [&](int half) { return half == 0 ? out.motion[k] + first : beyond; });
  }
}

[[gnu::always_inline]] inline void read(const Sphere* spheres, const Owners<Doubles>* const (&own)[1],
                                        const Offsets (&other)[1], int first, Gap<Doubles>& out) {
  const Sphere* j[kDoubles];
  for (int l = 0; l < kDoubles; ++l) j[l] = record(spheres, other[0].at[first + l]);
  const SphereLanes b = load_spheres(j);
  const auto a = [&](const double* column) { return load<Doubles>(column + first); };
  for (int d = 0; d < 3; ++d) {
    out.n[d] = a(own[0]->x[d]) - b.x[d];
    out.v[d] = a(own[0]->v[d]) - b.v[d];
    out.w_i[d] = a(own[0]->w[d]), out.w_j[d] = b.w[d];
  }
  out.d2 = dot3(out.n, out.n);
  out.r_i = a(own[0]->r), out.m_i = a(own[0]->m), out.r_j = b.r, out.m_j = b.m;
}

[[gnu::always_inline]] inline void read(const MixedSphere* spheres, const Owners<Singles>* const (&own)[kSpan<Singles>],
                                        const Offsets (&other)[kSpan<Singles>], int first, Gap<Singles>& out) {
  const float* j[kSingles];
  Doubles n[2][3], d2[2], excess[2];
  for (int half = 0; half < 2; ++half) {
    const double* x_j[kDoubles];
    const int block = kSpan<Singles> == 2 ? half : 0, from = kSpan<Singles> == 2 ? 0 : first + half * kDoubles;
    for (int l = 0; l < kDoubles; ++l) {
      const MixedSphere* b = record(spheres, other[block].at[from + l]);
      x_j[l] = &b->x.x;
      j[half * kDoubles + l] = b->v;
    }
    Doubles b[4];
    load4(x_j, b);
    for (int d = 0; d < 3; ++d) n[half][d] = load<Doubles>(own[block]->x[d] + from) - b[d];
    d2[half] = dot3(n[half], n[half]);
    const Doubles reach = load<Doubles>(own[block]->r + from) + b[3];
    excess[half] = reach * reach - d2[half];
  }
  Singles a[8], b[8];
  for (int k = 0; k < 8; ++k) a[k] = load_each<Singles>([&](int half) { return own[half]->motion[k] + first; });
  load8(j, b);
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

/// What a contact gives to both spheres: to the owner as columns, which are summed over the blocks of a slice, to its
/// partner as a row that is added whole. The partner takes its row off, so its torque has the sign turned.
[[gnu::always_inline]] inline void store_pushes(const Response<Doubles>& c, Doubles touching,
                                                BlockResult* const (&out)[1], int first) {
  const Doubles f[4] = {c.f[0], c.f[1], c.f[2], Doubles(0.0)}, t_j[4] = {-c.t_j[0], -c.t_j[1], -c.t_j[2], -touching};
  double* other[kDoubles];
  for (int l = 0; l < kDoubles; ++l) other[l] = out[0]->other[first + l].f;
  store_rows(f, t_j, other);
  for (int d = 0; d < 3; ++d) store(c.f[d], out[0]->own[d] + first), store(c.t_i[d], out[0]->own[3 + d] + first);
  store(touching, out[0]->own[6] + first);
}
[[gnu::always_inline]] inline void store_pushes(const Response<Singles>& c, Singles touching,
                                                BlockResult* const (&out)[kSpan<Singles>], int first) {
  const Singles f[4] = {c.f[0], c.f[1], c.f[2], Singles(0.0)}, t_j[4] = {-c.t_j[0], -c.t_j[1], -c.t_j[2], -touching};
  float* other[kSingles];
  for (int l = 0; l < kSingles; ++l)
    other[l] = out[l / static_cast<int>(kBlock)]->other_single[first + l % static_cast<int>(kBlock)].f;
  store_rows(f, t_j, other);
  const auto column = [&](int k, Singles p) {
    store_each(p, [&](int half) { return out[half]->own_single[k] + first; });
  };
  for (int d = 0; d < 3; ++d) column(d, c.f[d]), column(3 + d, c.t_i[d]);
  column(6, touching);
}

/// The law on one pack; the memory of its contacts is updated. What comes out in lanes that hold no pair must not be
/// added. Returns whether a bond broke.
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

[[gnu::always_inline]] inline void add_row(Accumulator& sum, const Push& row) {
#if defined(__AVX512F__)
  auto* of = reinterpret_cast<double*>(&sum);
  _mm512_store_pd(of, _mm512_add_pd(_mm512_load_pd(of), _mm512_load_pd(row.f)));
#else
  sum.f += *reinterpret_cast<const Four*>(row.f);
  sum.t += *reinterpret_cast<const Four*>(row.t);
#endif
}
[[gnu::always_inline]] inline void take_off(Accumulator& sum, const Push& row) {
#if defined(__AVX512F__)
  auto* of = reinterpret_cast<double*>(&sum);
  _mm512_store_pd(of, _mm512_sub_pd(_mm512_load_pd(of), _mm512_load_pd(row.f)));
#else
  sum.f -= *reinterpret_cast<const Four*>(row.f);
  sum.t -= *reinterpret_cast<const Four*>(row.t);
#endif
}
[[gnu::always_inline]] inline void take_off(Accumulator& sum, const SinglePush& row) {
#if defined(__AVX512F__)
  auto* of = reinterpret_cast<double*>(&sum);
  _mm512_store_pd(of, _mm512_sub_pd(_mm512_load_pd(of), _mm512_maskz_cvtps_pd(0xFF, _mm256_loadu_ps(row.f))));
#elif defined(__AVX2__)
  const auto four = [](const float* f) { return Four(_mm256_cvtps_pd(_mm_loadu_ps(f))); };
  sum.f -= four(row.f), sum.t -= four(row.t);
#else
  for (int k = 0; k < 4; ++k) sum.f[k] -= static_cast<double>(row.f[k]), sum.t[k] -= static_cast<double>(row.t[k]);
#endif
}

/// Takes a block's forces off its partners lane by lane, in the order of the list.
template <class P>
[[gnu::always_inline]] inline void take_off_partners(const BlockResult& r, const PairBlock& block, std::uint32_t lanes,
                                                     Accumulator* ring, std::uint32_t mask) {
  const Offsets other = offsets_of<Accumulator>(block.other, mask);
  const auto take = [&](std::uint32_t l) {
    if constexpr (std::is_same_v<P, Doubles>)
      take_off(*record(ring, other.at[l]), r.other[l]);
    else
      take_off(*record(ring, other.at[l]), r.other_single[l]);
  };
  if (lanes == kBlock) {
    for (std::uint32_t l = 0; l < kBlock; ++l) take(l);
  } else {
    for (std::uint32_t l = 0; l < lanes; ++l) take(l);
  }
}

/// What the blocks of the present slice give to its owners, in double in either precision.
struct OwnerSums {
  static constexpr int kParts = static_cast<int>(kBlock) / kDoubles;
  Doubles column[BlockResult::kColumns][kParts];
  const PairBlock* block = nullptr;  ///< that began the slice
  std::uint32_t lanes = 0;

  template <class P>
  [[gnu::always_inline]] void add(const BlockResult& r, const PairBlock& b, const BlockShape& shape, Accumulator* ring,
                                  std::uint32_t mask) {
    if (shape.begins) {
      give(ring, mask);
      block = &b, lanes = shape.lanes;
      for (auto& parts : column)
        for (Doubles& part : parts) part = Doubles(0.0);
    }
    const auto from = [&](int k, int first) {
      if constexpr (std::is_same_v<P, Doubles>)
        return load<Doubles>(r.own[k] + first);
      else
        return load_floats<Doubles>(r.own_single[k] + first);
    };
    for (int part = 0; part < kParts; ++part) {
      const int first = part * kDoubles;
      if (shape.lanes == kBlock) {
        for (int k = 0; k < BlockResult::kColumns; ++k) column[k][part] += from(k, first);
      } else {
        const DoublesMask used = lanes_below(shape.lanes, first);
        for (int k = 0; k < BlockResult::kColumns; ++k) column[k][part] += select(used, from(k, first), Doubles(0.0));
      }
    }
  }

  /// To the ring; lane by lane, since a block of near pairs may have an owner twice.
  [[gnu::always_inline]] void give(Accumulator* ring, std::uint32_t mask) {
    if (block == nullptr) return;
    Push row[kBlock];
    for (int part = 0; part < kParts; ++part) {
      double* rows[kDoubles];
      for (int l = 0; l < kDoubles; ++l) rows[l] = row[part * kDoubles + l].f;
      const Doubles f[4] = {column[0][part], column[1][part], column[2][part], Doubles(0.0)},
                    t[4] = {column[3][part], column[4][part], column[5][part], column[6][part]};
      store_rows(f, t, rows);
    }
    const Offsets own = offsets_of<Accumulator>(block->owner, mask);
    if (lanes == kBlock) {
      for (std::uint32_t l = 0; l < kBlock; ++l) add_row(*record(ring, own.at[l]), row[l]);
    } else {
      for (std::uint32_t l = 0; l < lanes; ++l) add_row(*record(ring, own.at[l]), row[l]);
    }
    block = nullptr;
  }
};

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
  using Record = std::remove_reference_t<decltype(*spheres)>;
  BlockSums sums;
  OwnerSums owner_sums;
  BlockResult results[room];
  MeetingOf<true, L, P> meeting[kGroup][kParts<P>];
  Owners<P> owners[room + 1];  // of the slices of a group, the first of which may have begun in the group before
  int slice = 0;
  BlockResult* result[room] = {};
  const Owners<P>* own[room] = {};
  std::uint32_t which[room] = {}, todo[room] = {};  // blocks of the group; those of them that are to be evaluated
  std::uint32_t next_ready = 0;
  const bool border = job.border != nullptr;
  const std::uint32_t count = border ? job.border_count : job.count;
  const auto offsets = [](const std::uint32_t* spheres_of) {
    return offsets_of<Record>(spheres_of, ~std::uint32_t{0});
  };
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
      if (border || job.shapes[b].begins) {
        slice = slice < room ? slice + 1 : 0;
        read(spheres, offsets(job.blocks[b].owner), owners[slice]);
      }
      own[blocks] = &owners[slice];
      if (!ready) todo[fresh++] = blocks;
      ++blocks;
    }
    // A pack with only one block left computes it twice over.
    if (span == 2 && fresh % 2 == 1) todo[fresh] = todo[fresh - 1];
    const int packs = static_cast<int>((fresh + span - 1) / span);
    for (int g = 0; g < packs; ++g) {
      const Owners<P>* i[span];
      Offsets j[span];
      for (int s = 0; s < span; ++s) {
        const std::uint32_t at = todo[g * span + s];
        i[s] = own[at], j[s] = offsets(job.blocks[which[at]].other);
      }
      for (int part = 0; part < kParts<P>; ++part) {
        Gap<P> gap;
        read(spheres, i, j, part * lanes, gap);
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
      const BlockResult& r = *result[n];
      const PairBlock& block = job.blocks[which[n]];
      const BlockShape& of = job.shapes[which[n]];
      owner_sums.add<P>(r, block, of, job.ring, job.mask);
      take_off_partners<P>(r, block, of.lanes, job.ring, job.mask);
      if constexpr (Book) sums.add(r, of.lanes);
    }
  }
  if (!border) owner_sums.give(job.ring, job.mask);
  if constexpr (!Book) return;
  for (int k = 0; k < 3; ++k) job.sums.lost[k] += sums.total(k);
  job.sums.stored += sums.total(3);
  job.sums.in_reach += sums.total(4);
  job.sums.overlap = std::max(job.sums.overlap, sums.largest(5));
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
