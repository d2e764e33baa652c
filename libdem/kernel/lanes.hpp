#pragma once
#include "libdem/kernel/contact_core.hpp"
#include "libdem/kernel/streams.hpp"

/// Records and contact memory to packs and back.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

struct SphereLanes {
  Pack x[3], r, v[3], m, w[3];
};

/// Whole sphere records of kWidth lanes, by their byte offsets: (x, r), (v, m), (w, id). Reading records and
/// transposing them in registers costs a third of a gather per number.
[[gnu::always_inline]] inline SphereLanes load_spheres(const Sphere* spheres, const std::uint64_t* offset) {
  const char* base = reinterpret_cast<const char*>(spheres);
  const double* row[kWidth];
  Pack group[4];
  SphereLanes s;
  for (int part = 0; part < 3; ++part) {
    for (int l = 0; l < kWidth; ++l) row[l] = reinterpret_cast<const double*>(base + offset[l]) + 4 * part;
    load4(row, group);
    Pack(&vector)[3] = part == 0 ? s.x : part == 1 ? s.v : s.w;
    for (int d = 0; d < 3; ++d) vector[d] = group[d];
    if (part == 0) s.r = group[3];
    if (part == 1) s.m = group[3];
  }
  return s;
}
[[gnu::always_inline]] inline SphereLanes load_spheres(const Sphere* spheres, const std::uint32_t* index, int first) {
  const Offsets o = offsets_of<sizeof(Sphere)>(index, ~std::uint32_t{0});
  return load_spheres(spheres, o.at + first);
}

/// `first`: lane of the block that the pack begins with. Without `Book` what only the energy book needs stays behind,
/// and whether a contact slipped is read only where the law asks for it.
template <int Own, bool Rolls, bool Book>
[[gnu::always_inline]] inline History<Own> load_history(const BlockMemory& block, int first, bool remembers_slip) {
  History<Own> h;
  for (int k = 0; k < Own; ++k) h.own[k] = load(block.own(k) + first);
  for (int d = 0; d < 3; ++d) {
    h.xi[d] = load(block.xi(d) + first);
    if constexpr (Rolls) h.rho[d] = load(block.rho(d) + first);
    h.dash_t[d] = Book ? load_floats(block.note(2 + d) + first) : Pack(0.0);
    h.dash_r[d] = Book && Rolls ? load_floats(block.note(5 + d) + first) : Pack(0.0);
  }
  h.dash_n = Book ? load_floats(block.note(1) + first) : Pack(0.0);
  h.slipping = remembers_slip ? load_floats(block.note(0) + first) : Pack(0.0);
  return h;
}

template <int Own, bool Rolls, bool Book>
[[gnu::always_inline]] inline void store_history(const History<Own>& h, const BlockMemory& block, int first,
                                                 bool remembers_slip) {
  for (int k = 0; k < Own; ++k) store(h.own[k], block.own(k) + first);
  for (int d = 0; d < 3; ++d) {
    store(h.xi[d], block.xi(d) + first);
    if constexpr (Rolls) store(h.rho[d], block.rho(d) + first);
    if constexpr (Book) store_floats(h.dash_t[d], block.note(2 + d) + first);
    if constexpr (Book && Rolls) store_floats(h.dash_r[d], block.note(5 + d) + first);
  }
  if constexpr (Book) store_floats(h.dash_n, block.note(1) + first);
  if (remembers_slip) store_floats(h.slipping, block.note(0) + first);
}

/// Forces and torques of kWidth lanes as rows; `touching` rides along with the torques.
[[gnu::always_inline]] inline void store_response(const Response& c, Pack touching, Four* f, Four* t_i, Four* t_j) {
  double* row[kWidth];
  const Pack groups[3][4] = {{c.f[0], c.f[1], c.f[2], Pack(0.0)},
                             {c.t_i[0], c.t_i[1], c.t_i[2], touching},
                             {c.t_j[0], c.t_j[1], c.t_j[2], touching}};
  Four* const to[3] = {f, t_i, t_j};
  for (int part = 0; part < 3; ++part) {
    for (int l = 0; l < kWidth; ++l) row[l] = reinterpret_cast<double*>(to[part] + l);
    store4(groups[part], row);
  }
}

/// 1 in lanes below `count`, where `first` is the block's lane that the pack begins with.
inline PackMask lanes_below(std::uint32_t count, int first) {
  double lane[kWidth];
  for (int l = 0; l < kWidth; ++l) lane[l] = first + l;
  return Pack(static_cast<double>(count)) > load(lane);
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
