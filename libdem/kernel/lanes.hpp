#pragma once
#include <type_traits>

#include "libdem/contacts/blocks.hpp"
#include "libdem/kernel/contact_core.hpp"

/// Records and contact memory to SIMD vectors and back.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

/// A sphere's record or sum, its address worked out by the integer units: GCC would multiply eight indices as a vector,
/// and these operations would queue behind the arithmetic of the contacts before.
template <class Record>
[[gnu::always_inline]] inline Record* record(Record* records, SphereIndex index) {
  std::size_t eightfold = index.eightfold();
#if defined(__x86_64__)
  asm("" : "+r"(eightfold));
#endif
  static_assert(sizeof(Record) % 8 == 0);
  using Byte = std::conditional_t<std::is_const_v<Record>, const char, char>;
  return reinterpret_cast<Record*>(reinterpret_cast<Byte*>(records) + eightfold * (sizeof(Record) / 8));
}

/// Blocks that a SIMD vector of P spans, and SIMD vectors that a block needs.
template <class P>
inline constexpr int kSpan = P::kLanes > 8 ? 2 : 1;
template <class P>
inline constexpr int kParts = P::kLanes < 8 ? 8 / P::kLanes : 1;

struct SphereLanes {
  VecD x[3], r, v[3], m, w[3];
  VecD name;  ///< of records in double: bits that are no number, moved only
};

/// Whole sphere records of kLanesD lanes: (x, r), (v, m), (w, id). Reading records and transposing them in registers
/// costs a third of a gather per number.
[[gnu::always_inline]] inline SphereLanes load_spheres(const Sphere* const* sphere) {
  const double* row[kLanesD];
  VecD group[4];
  SphereLanes s;
  for (int part = 0; part < 3; ++part) {
    for (int l = 0; l < kLanesD; ++l) row[l] = reinterpret_cast<const double*>(sphere[l]) + 4 * part;
    load4(row, group);
    VecD(&vector)[3] = part == 0 ? s.x : part == 1 ? s.v : s.w;
    for (int d = 0; d < 3; ++d) vector[d] = group[d];
    if (part == 0) s.r = group[3];
    if (part == 1) s.m = group[3];
    if (part == 2) s.name = group[3];
  }
  return s;
}
/// Records of kLanesF lanes, as two SIMD vectors of doubles.
[[gnu::always_inline]] inline void load_spheres(const MixedSphere* const* sphere, SphereLanes (&out)[2]) {
  const float* motion[kLanesF];
  for (int l = 0; l < kLanesF; ++l) motion[l] = sphere[l]->v;
  VecF column[8];
  load8(motion, column);
  for (int half = 0; half < 2; ++half) {
    const double* place[kLanesD];
    for (int l = 0; l < kLanesD; ++l) place[l] = &sphere[half * kLanesD + l]->x.x;
    VecD x[4];
    load4(place, x);
    SphereLanes& s = out[half];
    for (int d = 0; d < 3; ++d) s.x[d] = x[d], s.v[d] = half_of(column[d], half), s.w[d] = half_of(column[4 + d], half);
    s.r = x[3], s.m = half_of(column[3], half);
  }
}
[[gnu::always_inline]] inline SphereLanes load_spheres(const MixedSphere* const* sphere) {
  const MixedSphere* twice[kLanesF];
  for (int l = 0; l < kLanesF; ++l) twice[l] = sphere[l % kLanesD];
  SphereLanes s[2];
  load_spheres(twice, s);
  return s[0];
}
/// Of a job at surfaces, in either precision.
template <class Job>
inline SphereLanes load_spheres(const Job& job, const std::uint32_t* index, int first) {
  const auto of = [&](const auto* spheres) {
    decltype(spheres) sphere[kLanesD];
    for (int l = 0; l < kLanesD; ++l) sphere[l] = spheres + index[first + l];
    return load_spheres(sphere);
  };
  return job.mixed != nullptr ? of(job.mixed) : of(job.spheres);
}

/// kLanes of P from the blocks that a SIMD vector spans: `at(k)` points into block k.
template <class P, class At>
[[gnu::always_inline]] inline P load_each(const At& at) {
  if constexpr (kSpan<P> == 1)
    return load<P>(at(0));
  else
    return load_halves(at(0), at(1));
}
template <class P, class At>
[[gnu::always_inline]] inline P load_diagnostics(const At& at) {
  if constexpr (kSpan<P> == 1)
    return load_floats<P>(at(0));
  else
    return load_halves(at(0), at(1));
}
template <class P, class At>
[[gnu::always_inline]] inline void store_each(P p, const At& at) {
  if constexpr (kSpan<P> == 1)
    store(p, at(0));
  else
    store_halves(p, at(0), at(1));
}
template <class P, class At>
[[gnu::always_inline]] inline void store_diagnostics(P p, const At& at) {
  if constexpr (kSpan<P> == 1)
    store_floats(p, at(0));
  else
    store_halves(p, at(0), at(1));
}
/// As doubles, whatever P is.
template <class At>
[[gnu::always_inline]] inline void store_doubles(VecD p, const At& at) {
  store(p, at(0));
}
template <class At>
[[gnu::always_inline]] inline void store_doubles(VecF p, const At& at) {
  for (int half = 0; half < 2; ++half) store(half_of(p, half), kSpan<VecF> == 2 ? at(half) : at(0) + half * kLanesD);
}

/// What contacts of a law remember, as far as it is known when the kernel is compiled, as MemoryShape for the rest.
template <class L, bool Rolls>
struct Remembers {
  static constexpr bool rolls = Rolls;
  static constexpr int own = L::has.memory;
  bool twists, slip;  ///< slip: whether the law asks if a contact slipped

  explicit Remembers(const L& law)
      : twists(Rolls && law.friction.resists_twist()), slip(law.friction.remembers_slip()) {}
  MemoryShape shape(bool bonds, bool single) const {
    return {.rolls = rolls, .twists = twists, .bonds = bonds, .own = own, .single = single};
  }
};

/// `first`: lane of the block that the SIMD vector begins with. Without `Record` what only the energy balance needs
/// stays behind, and whether a contact slipped is read only where the law asks for it.
template <class P, bool Record, class Has>
[[gnu::always_inline]] inline ContactMemory<P> load_memory(const Has& has, const BlockMemory (&block)[kSpan<P>],
                                                           int first) {
  ContactMemory<P> m;
  each_field(
      has, m,
      [&](P& field, int k) [[gnu::always_inline]] {
        field = load_each<P>([&](int b) { return block[b].template state<typename P::Real>(k) + first; });
      },
      [&](P& field, int k) [[gnu::always_inline]] {
        const bool wanted = k == kSlipping ? has.slip : Record;
        field = wanted ? load_diagnostics<P>([&](int b) { return block[b].diagnostic(k) + first; }) : P(0.0);
      });
  return m;
}

template <class P, bool Record, class Has>
[[gnu::always_inline]] inline void store_memory(const Has& has, const ContactMemory<P>& m,
                                                const BlockMemory (&block)[kSpan<P>], int first) {
  each_field(
      has, m,
      [&](const P& field, int k) [[gnu::always_inline]] {
        store_each(field, [&](int b) { return block[b].template state<typename P::Real>(k) + first; });
      },
      [&](const P& field, int k) [[gnu::always_inline]] {
        if (k == kSlipping ? has.slip : Record)
          store_diagnostics(field, [&](int b) { return block[b].diagnostic(k) + first; });
      });
}

/// What a bond that broke released is written only.
template <class P, bool Record>
[[gnu::always_inline]] inline BondMemory<P> load_bond(const BlockMemory (&block)[kSpan<P>], int first) {
  BondMemory<P> b;
  BondMemory<P>::each_state(b, [&](P& field, int k) {
    if (k == BondMemory<P>::kReleased) return;
    field = load_each<P>(
        [&](int s) { return block[s].template state<typename P::Real>(block[s].first_bond_state + k) + first; });
  });
  BondMemory<P>::each_diagnostic(b, [&](P& field, int k) {
    field = Record ? load_diagnostics<P>(
                         [&](int s) { return block[s].diagnostic(block[s].first_bond_diagnostic + k) + first; })
                   : P(0.0);
  });
  return b;
}

template <class P, bool Record>
[[gnu::always_inline]] inline void store_bond(const BondMemory<P>& b, bool broke, const BlockMemory (&block)[kSpan<P>],
                                              int first) {
  BondMemory<P>::each_state(b, [&](const P& field, int k) {
    if (k == BondMemory<P>::kReleased && !broke) return;
    store_each(field,
               [&](int s) { return block[s].template state<typename P::Real>(block[s].first_bond_state + k) + first; });
  });
  if constexpr (Record)
    BondMemory<P>::each_diagnostic(b, [&](const P& field, int k) {
      store_diagnostics(field, [&](int s) { return block[s].diagnostic(block[s].first_bond_diagnostic + k) + first; });
    });
}

/// Forces and torques of kLanesD lanes as rows; `touching` rides along with the torques.
[[gnu::always_inline]] inline void store_response(const Response<VecD>& c, VecD touching, Four* f, Four* t_i,
                                                  Four* t_j) {
  double* row[kLanesD];
  const VecD groups[3][4] = {{c.f[0], c.f[1], c.f[2], VecD(0.0)},
                             {c.t_i[0], c.t_i[1], c.t_i[2], touching},
                             {c.t_j[0], c.t_j[1], c.t_j[2], touching}};
  Four* const to[3] = {f, t_i, t_j};
  for (int part = 0; part < 3; ++part) {
    for (int l = 0; l < kLanesD; ++l) row[l] = reinterpret_cast<double*>(to[part] + l);
    store4(groups[part], row);
  }
}

/// 1 in lanes below `count`, where `first` is the block's lane that the SIMD vector begins with.
template <class P = VecD>
inline typename P::Mask lanes_below(std::uint32_t count, int first) {
  typename P::Real lane[P::kLanes];
  for (int l = 0; l < P::kLanes; ++l) lane[l] = static_cast<typename P::Real>(first + l);
  return P(static_cast<double>(count)) > load<P>(lane);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
