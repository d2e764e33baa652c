#pragma once
#include "libdem/kernel/accumulation.hpp"
#include "libdem/kernel/contact_core.hpp"
#include "libdem/kernel/loading.hpp"

/// Pairs of spheres, block by block, in stages over a few SIMD vectors at a time: read and meet, law, add. A stage is
/// short enough for the processor to have several SIMD vectors under way, so that none waits for the square roots of
/// another.
///
/// P is VecD with records Sphere, or VecF with MixedSphere: mixed precision. A SIMD vector of 16 floats spans two
/// blocks.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

inline constexpr int kGroup = 6;  ///< SIMD vectors per stage; more crowd the first-level cache
inline constexpr int kAhead = 8;  ///< SIMD vectors between one and that which is fetched with it

/// Overlap, and the inverse of the distance.
inline VecD overlap_of(const Gap<VecD>& g, VecD& inverse) {
  inverse = rsqrt(g.d2);
  return g.r_i + g.r_j - g.d2 * inverse;
}
inline VecF overlap_of(const Gap<VecF>& g, VecF& inverse) {
  const VecF sum = g.r_i + g.r_j;
#if defined(__AVX512F__)
  const VecF rough = rough_rsqrt(g.d2);
  inverse = refined_rsqrt(g.d2, rough);
  return quotient(g.excess, sum + g.d2 * inverse, sum + g.d2 * rough);
#else
  const VecF distance = sqrt(g.d2);  // two quotients that do not wait for each other
  inverse = VecF(1.0) / distance;
  return g.excess / (sum + distance);
#endif
}

template <bool Equal, bool Rolls, class L, class P>
[[gnu::always_inline]] inline void meet_pair(const MomentArmShares& share, P half_dt, const Gap<P>& g,
                                             MeetingOf<true, L, P>& out) {
  P inverse;
  Touch<P> a;
  a.overlap = overlap_of(g, inverse);
  for (int d = 0; d < 3; ++d) {
    a.n[d] = g.n[d] * inverse;
    a.v[d] = g.v[d], a.w_i[d] = g.w_i[d], a.w_j[d] = g.w_j[d];
  }
  a.r_i = g.r_i, a.r_j = g.r_j, a.turn_rate = half_dt * inverse;
  a.v_n = dot3(g.v, g.n) * inverse;
  if constexpr (Equal) {
    for (int d = 0; d < 3; ++d) a.w[d] = g.w_i[d] + g.w_j[d];
    a.w_n = dot3(a.w, g.n) * inverse;
  }
  meet<true, Equal, Rolls, L>(share, half_dt, a, out);
}

/// What a contact gives to both spheres, as columns.
template <bool Count, class P>
[[gnu::always_inline]] inline void store_pushes(const Response<P>& c, P overlap, bool same_torque,
                                                BlockResult* const (&out)[kSpan<P>], int first) {
  const auto column = [&](int k, P p) {
    store_each(p, [&](int b) {
      if constexpr (std::is_same_v<P, VecD>)
        return out[b]->push[k] + first;
      else
        return out[b]->push_single[k] + first;
    });
  };
  for (int d = 0; d < 3; ++d) column(d, c.f[d]), column(3 + d, c.t_i[d]);
  if (!same_torque)
    for (int d = 0; d < 3; ++d) column(6 + d, c.t_j[d]);
  if constexpr (Count) column(BlockResult::kTouching, select(overlap > P(0.0), P(1.0), P(0.0)));
}

/// Sets what a block of fewer than eight pairs gives to zero in its other lanes, which have computed a pair again. By
/// whole SIMD vectors: after a narrower store a load of the vector waits until that is in the cache.
template <class P, bool Count>
[[gnu::noinline]] void blank(BlockResult& r, std::uint32_t lanes, bool same_torque) {
  for (int first = 0; first < static_cast<int>(kBlock); first += P::kLanes) {
    const auto used = lanes_below<P>(lanes, first);
    const auto blank_column = [&](int k) {
      typename P::Real* column;
      if constexpr (std::is_same_v<P, VecD>)
        column = r.push[k] + first;
      else
        column = r.push_single[k] + first;
      store(select(used, load<P>(column), P(0.0)), column);
    };
    for (int k = 0; k < (same_torque ? 6 : 9); ++k) blank_column(k);
    if constexpr (Count) blank_column(BlockResult::kTouching);
  }
}

/// The law on one SIMD vector; the memory of its contacts is updated. What comes out in lanes that hold no pair must
/// not be added. Returns whether a bond broke.
template <bool Rolls, bool Accumulate, class P, class L>
[[gnu::always_inline]] inline bool evaluate(const L& law, const PairJob& job, double elapsed,
                                            const MeetingOf<true, L, P>& a, bool same_torque,
                                            const BlockMemory (&memory)[kSpan<P>], BlockResult* const (&out)[kSpan<P>],
                                            int first) {
  const Remembers<L, Rolls> has(law);
  ContactMemory<P> h = load_memory<P, Accumulate>(has, memory, first);
  Response<P> c = respond<true, Rolls, !Accumulate, P>(law, a, h, elapsed);
  P touching = a.overlap;
  bool broke = false;
  if constexpr (kBonds<L>) {
    BondMemory<P> bond = load_bond<P, Accumulate>(memory, first);
    if (law.bond.replaces_contact()) {
      const auto bonded = bond.state > P(0.5);
      vanish(bonded, has, c, h);
      touching = select(bonded, P(-1.0), touching);
    }
    broke = respond_bond(law, a, bond, job.elapsed, c);
    store_bond<P, Accumulate>(bond, broke, memory, first);
  }
  store_memory<P, Accumulate>(has, h, memory, first);
  store_pushes<Accumulate>(c, touching, same_torque, out, first);
  if constexpr (Accumulate) {
    if (job.accumulate) {
      using Columns = decltype(BlockResult::sums);
      const auto put = [&](double(Columns::*column)[kBlock], P p) {
        store_doubles(p, [&](int b) { return out[b]->sums.*column + first; });
      };
      put(&Columns::damped, c.damped), put(&Columns::slid, c.slid), put(&Columns::rolled, c.rolled);
      put(&Columns::yielded, c.yielded), put(&Columns::stored, c.stored);
      put(&Columns::within_cutoff, select(a.overlap > P(-job.cutoff), P(1.0), P(0.0)));
      put(&Columns::overlap, a.overlap / a.effective.smaller);
    }
  }
  if (job.activation != nullptr) store_doubles(a.overlap, [&](int b) { return out[b]->overlap + first; });
  return broke;
}

/// Into the cache, for later: memory answers after some hundred nanoseconds, in which the processor would run through
/// several blocks if it knew of them.
[[gnu::always_inline]] inline void fetch(const void* from, std::size_t bytes) {
  for (std::size_t at = 0; at < bytes; at += sizeof(Line))
    __builtin_prefetch(static_cast<const char*>(from) + at, 0, 3);
}

/// For some pairs of the run at a block interface, from one on; `bytes` of memory in a block. Returns the next pair.
template <class Record>
[[gnu::noinline]] std::uint32_t fetch_for_interface(const PairJob& job, const Record* spheres, std::size_t bytes,
                                                    std::uint32_t pair, std::uint32_t pairs) {
  const std::uint32_t end = std::min(pair + pairs, kBlock * job.interface_count);
  for (; pair < end; ++pair) {
    fetch(record(spheres, job.interface_blocks[pair / kBlock].j[pair % kBlock]), sizeof *spheres);
    fetch(job.interface_pushes + pair, sizeof *job.interface_pushes);
    fetch(reinterpret_cast<const char*>(job.interface_lines) + pair * bytes / kBlock, bytes / kBlock);
  }
  return end;
}

/// Until when a block may stay inactive: each of two spheres may go half their gap before they can be within the
/// cutoff. In mixed precision the gap is known to a few 1e-7 of itself.
template <class P>
double activation_path(const PairJob& job, const BlockResult& r) {
  constexpr double margin = std::is_same_v<P, VecD> ? 0 : 1e-6;
  double largest = r.overlap[0];
  for (const double x : r.overlap) largest = largest > x ? largest : x;
  return job.path + 0.5 * (-largest - margin * (largest > 0 ? largest : -largest) - job.cutoff);
}

/// All blocks of a run, or those at a halo: then results are kept and not added. Without `Accumulate` the law's
/// friction is the usual one (Friction::usual). Loops with and without give the same bits: products are fused where
/// the source states it (Vec::Product), not where the compiler likes.
template <class P, bool Rolls, bool Accumulate, class L>
void run_pairs(const L& by_reference, PairJob& job) {
  constexpr int span = kSpan<P>, room = kGroup * span, further = kAhead * span, lanes = P::kLanes;
  L law = by_reference;  // nothing can point to it: its constants stay in registers
  if constexpr (!Accumulate) law.friction = law.friction.as_usual();
  const MomentArmShares share = by_reference.friction.shares(true);
  const MemoryShape shape = Remembers<L, Rolls>(law).shape(kBonds<L>, std::is_same_v<P, VecF>);
  const auto* const spheres = records(job, P{});
  const std::size_t bytes = shape.state_bytes(), diagnostic_bytes = shape.diagnostic_bytes();
  const BlockMemory first_memory = BlockMemory::at(job.lines, job.count, shape, 0);
  BlockSums sums;
  SumsOfI<P, Accumulate> sums_of_i;
  BlockResult results[room];
  MeetingOf<true, L, P> meeting[kGroup][kParts<P>];
  SpheresI<P>
      spheres_i[room + 1];  // of the SELL chunks of a group, the first of which may have begun in the group before
  int chunk = 0;
  BlockResult* result[room] = {};
  const SpheresI<P>* own[room] = {};
  std::uint32_t which[room] = {}, todo[room] = {};  // blocks of the group; those of them that are to be evaluated
  std::uint32_t next_halo = 0;
  const bool halo = job.halo, uniform = job.uniform;
  const bool plain = !halo && job.halo_count == 0 && job.activation == nullptr;  // most runs: every block counts
  const Ring ring = job.ring;
  const double elapsed = job.elapsed;
  const P half_dt(0.5 * elapsed);
  // Tangential forces alone turn both spheres equally where their moment arms are the same.
  const bool same_torque = !Rolls && !kBonds<L> && uniform;
  job.same_torque = same_torque;
  const std::uint32_t count = halo ? job.halo_count : job.count;
  using Record = std::remove_cvref_t<decltype(*spheres)>;
  const std::uint32_t any = job.count > 0 ? std::uint32_t{job.blocks[0].i[0]} : 0;
  const OfAll<P> all(job.count > 0 ? spheres[any] : Record{}, job.masses != nullptr ? job.masses + any : nullptr);
  if (uniform) {
    Effective<P> e;
    effective<true, Rolls, L>(all.r, all.m, all.r, all.m, e);
    for (auto& of_vector : meeting)
      for (auto& m : of_vector) m.effective = e;
  }
  const char* ahead = reinterpret_cast<const char*>(spheres + job.ahead);
  const char* const ahead_end = reinterpret_cast<const char*>(spheres + job.ahead + job.ahead_count);
  const std::size_t stride =
      count > 0 ? (static_cast<std::size_t>(ahead_end - ahead) / count / sizeof(Line) + 1) * sizeof(Line) : 0;
  std::uint32_t interface_pair = 0;
  for (std::uint32_t k = 0; k < count;) {
    // With each block of touching pairs one further on is fetched; here what the next run begins
    // with.
    if (k + room + further >= count && k + further < count && job.next_blocks != nullptr) {
      fetch(job.next_blocks, further * sizeof(PairBlock));
      fetch(job.next_lines, further * bytes);
    }
    if (interface_pair < kBlock * job.interface_count)
      interface_pair = fetch_for_interface(job, spheres, bytes, interface_pair, room);
    const int begun = chunk;
    int next_chunk = 0;  // the same few again and again stay in the first-level cache
    std::uint32_t blocks = 0, fresh = 0;
    const auto take = [&](std::uint32_t b, BlockResult* into) {
      which[blocks] = b, result[blocks] = into;
      if (halo || job.shapes[b].begins) {
        next_chunk += next_chunk == begun;
        chunk = next_chunk++;
        SpheresI<P>* here = &spheres_i[chunk];
#if defined(__x86_64__)
        asm("" : "+r"(here));  // one register for the addresses of all columns: GCC would keep each on the stack
#endif
        read(spheres, job.masses, job.blocks[b].i, *here);
      }
      own[blocks] = &spheres_i[chunk];
    };
    if (plain)
      for (; blocks < room && k < count; ++k, ++blocks) take(k, &results[blocks]), todo[fresh++] = blocks;
    for (; blocks < room && k < count; ++k) {
      const std::uint32_t b = halo ? job.halo_block[k] : k;
      const bool in_halo = next_halo < job.halo_count && job.halo_block[next_halo] == b;
      const std::uint32_t place = next_halo;
      next_halo += in_halo;
      // One at a halo has been evaluated, and told anew how long to stay inactive, before the sweep comes to it.
      const bool ready = in_halo && !halo;
      const bool active =
          ready ? job.halo_active[place] != 0 : job.activation == nullptr || !(job.path < job.activation[b]);
      if (halo) job.halo_active[place] = active;
      if (!active) continue;
      take(b, in_halo ? job.halo_result + place : &results[blocks]);
      if (!ready) todo[fresh++] = blocks;
      ++blocks;
    }
    job.evaluated += blocks;
    // A SIMD vector with only one block left computes it twice over.
    if (span == 2 && fresh % 2 == 1) todo[fresh] = todo[fresh - 1];
    const int vectors = static_cast<int>((fresh + span - 1) / span);
    const auto meet_all = [&](auto same) {
      for (int g = 0; g < vectors; ++g) {
        const SpheresI<P>* i[span];
        const SphereIndex* j[span];
        for (int s = 0; s < span; ++s) {
          const std::uint32_t at = todo[g * span + s];
          i[s] = own[at], j[s] = job.blocks[which[at]].j;
          fetch(job.blocks + which[at] + further, sizeof(PairBlock));
          if (ahead < ahead_end) fetch(ahead, stride), ahead += stride;
        }
        for (int part = 0; part < kParts<P>; ++part) {
          Gap<P> gap;
          read<same.value>(spheres, job.masses, i, j, part * lanes, all, gap);
          meet_pair<same.value, Rolls, L>(share, half_dt, gap, meeting[g][part]);
          if (!same.value) effective<true, Rolls, L>(gap.r_i, gap.m_i, gap.r_j, gap.m_j, meeting[g][part].effective);
        }
      }
    };
    uniform ? meet_all(std::true_type()) : meet_all(std::false_type());
    for (int g = 0; g < vectors; ++g) {
      BlockMemory memory[span];
      BlockResult* out[span];
      for (int s = 0; s < span; ++s) {
        const std::uint32_t at = todo[g * span + s];
        memory[s] = first_memory.further(which[at], bytes, diagnostic_bytes);
        out[s] = result[at];
        fetch(memory[s].states + further * bytes, bytes);
        if constexpr (Accumulate) fetch(memory[s].diagnostics + further * diagnostic_bytes, diagnostic_bytes);
      }
      for (int part = 0; part < kParts<P>; ++part)
        if (evaluate<Rolls, Accumulate, P>(law, job, elapsed, meeting[g][part], same_torque, memory, out, part * lanes))
          job.broke = true;
      if constexpr (!kMaskedLoads)
        for (int s = 0; s < span; ++s)
          if (const std::uint32_t lanes = job.shapes[which[todo[g * span + s]]].lanes; lanes < kBlock)
            blank<P, Accumulate>(*out[s], lanes, same_torque);
    }
    if (job.activation != nullptr)
      for (std::uint32_t f = 0; f < fresh; ++f)
        job.activation[which[todo[f]]] = activation_path<P>(job, *result[todo[f]]);
    if (halo) continue;
    // In registers here, in memory elsewhere: held through the law as well they would crowd out its numbers (half as
    // much time again with rolling resistance).
    for (std::uint32_t n = 0; n < blocks; ++n)
      add_to_j<P, Accumulate>(*result[n], job.blocks[which[n]], job.shapes[which[n]], same_torque, ring);
    const PairBlock* begun_by = nullptr;
    for (int part = 0; part < SumsOfI<P, Accumulate>::kParts; ++part) {
      SumsOfPart<P, Accumulate> in_registers(sums_of_i, part);
      for (std::uint32_t n = 0; n < blocks; ++n) {
        const BlockShape& of = job.shapes[which[n]];
        in_registers.come_to(job.blocks[which[n]], of, ring);
        in_registers.add(push_on_i<P, Accumulate>(*result[n], of.lanes, in_registers.first));
      }
      begun_by = in_registers.give_back(sums_of_i);
    }
    sums_of_i.block = begun_by;
    if constexpr (Accumulate)
      if (job.accumulate)
        for (std::uint32_t n = 0; n < blocks; ++n) sums.add(*result[n], job.shapes[which[n]].lanes);
    asm volatile("" : "+m"(sums_of_i));
  }
  if (!halo)
    for (int part = 0; part < SumsOfI<P, Accumulate>::kParts; ++part)
      SumsOfPart<P, Accumulate>(sums_of_i, part).give(ring);
  if constexpr (!Accumulate) return;
  sums.give(job.sums);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
