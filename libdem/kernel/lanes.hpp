#pragma once
#include "libdem/kernel/contact_core.hpp"
#include "libdem/kernel/streams.hpp"

/// Records and contact memory to packs and back.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

/// Where 8 records begin, in units of 8 bytes; the numbers of the records are `index & mask`.
struct alignas(32) Offsets {
  std::uint32_t at[8];
};
template <class Record>
[[gnu::always_inline]] inline Offsets offsets_of(const std::uint32_t* index, std::uint32_t mask) {
  static_assert(sizeof(Record) % 8 == 0);
  using Eight = std::uint32_t __attribute__((vector_size(32)));
  Eight which;
  __builtin_memcpy(&which, index, sizeof which);
  which = (which & mask) * static_cast<std::uint32_t>(sizeof(Record) / 8);
  Offsets o;
  __builtin_memcpy(o.at, &which, sizeof which);
  // Worked out together and read back one by one; GCC would take them out of the register one by one, at three times
  // the cost.
  asm volatile("" : "+m"(o));
  return o;
}
template <class Record>
[[gnu::always_inline]] inline Record* record(Record* records, std::uint32_t offset) {
  using Byte = std::conditional_t<std::is_const_v<Record>, const char, char>;
  return reinterpret_cast<Record*>(reinterpret_cast<Byte*>(records) + 8 * static_cast<std::size_t>(offset));
}

/// Blocks that a pack of P spans, and packs that a block needs.
template <class P>
inline constexpr int kSpan = P::kLanes > 8 ? 2 : 1;
template <class P>
inline constexpr int kParts = P::kLanes < 8 ? 8 / P::kLanes : 1;

struct SphereLanes {
  Doubles x[3], r, v[3], m, w[3];
};

/// Whole sphere records of kDoubles lanes: (x, r), (v, m), (w, id). Reading records and transposing them in registers
/// costs a third of a gather per number.
[[gnu::always_inline]] inline SphereLanes load_spheres(const Sphere* const* sphere) {
  const double* row[kDoubles];
  Doubles group[4];
  SphereLanes s;
  for (int part = 0; part < 3; ++part) {
    for (int l = 0; l < kDoubles; ++l) row[l] = reinterpret_cast<const double*>(sphere[l]) + 4 * part;
    load4(row, group);
    Doubles(&vector)[3] = part == 0 ? s.x : part == 1 ? s.v : s.w;
    for (int d = 0; d < 3; ++d) vector[d] = group[d];
    if (part == 0) s.r = group[3];
    if (part == 1) s.m = group[3];
  }
  return s;
}
[[gnu::always_inline]] inline SphereLanes load_spheres(const MixedSphere* const* sphere) {
  const double* row[kDoubles];
  Doubles group[4];
  for (int l = 0; l < kDoubles; ++l) row[l] = &sphere[l]->x.x;
  load4(row, group);
  SphereLanes s;
  s.r = group[3];
  float column[8][kDoubles];
  for (int l = 0; l < kDoubles; ++l) {
    const float* numbers = sphere[l]->v;
    for (int c = 0; c < 7; ++c) column[c][l] = numbers[c];
  }
  for (int d = 0; d < 3; ++d) {
    s.x[d] = group[d];
    s.v[d] = load_floats<Doubles>(column[d]);
    s.w[d] = load_floats<Doubles>(column[4 + d]);
  }
  s.m = load_floats<Doubles>(column[3]);
  return s;
}
/// Of a job at surfaces, in either precision.
template <class Job>
inline SphereLanes load_spheres(const Job& job, const std::uint32_t* index, int first) {
  const auto of = [&](const auto* spheres) {
    decltype(spheres) sphere[kDoubles];
    for (int l = 0; l < kDoubles; ++l) sphere[l] = spheres + index[first + l];
    return load_spheres(sphere);
  };
  return job.mixed != nullptr ? of(job.mixed) : of(job.spheres);
}

/// kLanes of P from the blocks that a pack spans: `at(k)` points into block k.
template <class P, class At>
[[gnu::always_inline]] inline P load_each(const At& at) {
  if constexpr (kSpan<P> == 1)
    return load<P>(at(0));
  else
    return load_halves(at(0), at(1));
}
template <class P, class At>
[[gnu::always_inline]] inline P load_notes(const At& at) {
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
[[gnu::always_inline]] inline void store_notes(P p, const At& at) {
  if constexpr (kSpan<P> == 1)
    store_floats(p, at(0));
  else
    store_halves(p, at(0), at(1));
}
/// As doubles, whatever P is.
template <class At>
[[gnu::always_inline]] inline void store_doubles(Doubles p, const At& at) {
  store(p, at(0));
}
template <class At>
[[gnu::always_inline]] inline void store_doubles(Singles p, const At& at) {
  for (int half = 0; half < 2; ++half)
    store(half_of(p, half), kSpan<Singles> == 2 ? at(half) : at(0) + half * kDoubles);
}

/// MemoryShape::of where what the law is made of is known.
template <class L, bool Rolls, bool Bonds>
MemoryShape shape_of(const L& law, bool single) {
  return {.rolls = Rolls,
          .twists = Rolls && law.friction.resists_twist(),
          .bonds = Bonds,
          .own = kOwn<L>,
          .single = single};
}

/// What of a contact's memory only some laws have; the same for all contacts of a job.
struct Remembers {
  bool slip, twist;
  template <class L>
  explicit Remembers(const L& law) : slip(law.friction.remembers_slip()), twist(law.friction.resists_twist()) {}
};

/// `first`: lane of the block that the pack begins with. Without `Book` what only the energy book needs stays behind,
/// and whether a contact slipped is read only where the law asks for it.
template <class P, int Own, bool Rolls, bool Book>
[[gnu::always_inline]] inline History<P, Own> load_history(const BlockMemory (&block)[kSpan<P>], int first,
                                                           const Remembers& what) {
  using Real = typename P::Real;
  const auto number = [&](int k) {
    return load_each<P>([&](int b) { return block[b].template number<Real>(k) + first; });
  };
  const auto note = [&](int k) { return load_notes<P>([&](int b) { return block[b].note(k) + first; }); };
  History<P, Own> h;
  for (int k = 0; k < Own; ++k) h.own[k] = number((Rolls ? 6 : 3) + k);
  for (int d = 0; d < 3; ++d) {
    h.xi[d] = number(d);
    if constexpr (Rolls) h.rho[d] = number(3 + d);
    h.dash_t[d] = Book ? note(2 + d) : P(0.0);
    h.dash_r[d] = Book && Rolls ? note(5 + d) : P(0.0);
  }
  h.dash_n = Book ? note(1) : P(0.0);
  h.slipping = what.slip ? note(0) : P(0.0);
  if (Rolls && what.twist) {
    h.twist = number(6 + Own);
    h.dash_w = Book ? note(8) : P(0.0);
  }
  return h;
}

template <class P, int Own, bool Rolls, bool Book>
[[gnu::always_inline]] inline void store_history(const History<P, Own>& h, const BlockMemory (&block)[kSpan<P>],
                                                 int first, const Remembers& what) {
  using Real = typename P::Real;
  const auto number = [&](int k, P p) {
    store_each(p, [&](int b) { return block[b].template number<Real>(k) + first; });
  };
  const auto note = [&](int k, P p) { store_notes(p, [&](int b) { return block[b].note(k) + first; }); };
  for (int k = 0; k < Own; ++k) number((Rolls ? 6 : 3) + k, h.own[k]);
  for (int d = 0; d < 3; ++d) {
    number(d, h.xi[d]);
    if constexpr (Rolls) number(3 + d, h.rho[d]);
    if constexpr (Book) note(2 + d, h.dash_t[d]);
    if constexpr (Book && Rolls) note(5 + d, h.dash_r[d]);
  }
  if constexpr (Book) note(1, h.dash_n);
  if (what.slip) note(0, h.slipping);
  if (Rolls && what.twist) {
    number(6 + Own, h.twist);
    if constexpr (Book) note(8, h.dash_w);
  }
}

template <class P, bool Book>
[[gnu::always_inline]] inline BondMemory<P> load_bond(const BlockMemory (&block)[kSpan<P>], int first) {
  BondMemory<P> b;
  BondMemory<P>::each_number(b, [&](P& p, int k) {
    p = load_each<P>(
        [&](int s) { return block[s].template number<typename P::Real>(block[s].first_bond + k) + first; });
  });
  BondMemory<P>::each_note(b, [&](P& p, int k) {
    p = Book ? load_notes<P>([&](int s) { return block[s].note(block[s].first_bond_note + k) + first; }) : P(0.0);
  });
  return b;
}

template <class P, bool Book>
[[gnu::always_inline]] inline void store_bond(const BondMemory<P>& b, const BlockMemory (&block)[kSpan<P>], int first) {
  BondMemory<P>::each_number(b, [&](const P& p, int k) {
    store_each(p, [&](int s) { return block[s].template number<typename P::Real>(block[s].first_bond + k) + first; });
  });
  if constexpr (Book)
    BondMemory<P>::each_note(b, [&](const P& p, int k) {
      store_notes(p, [&](int s) { return block[s].note(block[s].first_bond_note + k) + first; });
    });
}

/// Forces and torques of kDoubles lanes as rows; `touching` rides along with the torques.
[[gnu::always_inline]] inline void store_response(const Response<Doubles>& c, Doubles touching, Four* f, Four* t_i,
                                                  Four* t_j) {
  double* row[kDoubles];
  const Doubles groups[3][4] = {{c.f[0], c.f[1], c.f[2], Doubles(0.0)},
                                {c.t_i[0], c.t_i[1], c.t_i[2], touching},
                                {c.t_j[0], c.t_j[1], c.t_j[2], touching}};
  Four* const to[3] = {f, t_i, t_j};
  for (int part = 0; part < 3; ++part) {
    for (int l = 0; l < kDoubles; ++l) row[l] = reinterpret_cast<double*>(to[part] + l);
    store4(groups[part], row);
  }
}

/// 1 in lanes below `count`, where `first` is the block's lane that the pack begins with.
inline DoublesMask lanes_below(std::uint32_t count, int first) {
  double lane[kDoubles];
  for (int l = 0; l < kDoubles; ++l) lane[l] = first + l;
  return Doubles(static_cast<double>(count)) > load<Doubles>(lane);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
