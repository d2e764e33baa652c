#pragma once
#include "libdem/kernel/lanes.hpp"

/// Spheres of the pairs of a SIMD vector, from their records to columns.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

/// The spheres of a SIMD vector as they lie in memory, and the differences that must be taken in double.
template <class P>
struct Gap {
  P n[3], d2;  ///< from j to i, m; its square
  P excess;    ///< (r_i + r_j)^2 - d2, which must be taken in double; mixed precision only
  P v[3], w_i[3], w_j[3];
  P r_i, m_i, r_j, m_j;
};

/// The spheres i of a SELL chunk, each number of all eight side by side.
template <class P>
struct alignas(64) SpheresI;
template <>
struct alignas(64) SpheresI<VecD> {
  double x[3][kBlock], r[kBlock], v[3][kBlock], m[kBlock], w[3][kBlock];
};
template <>
struct alignas(64) SpheresI<VecF> {
  double x[3][kBlock], r[kBlock];
  float motion[8][kBlock];  ///< v, m, w, r
};

/// @param masses that contacts find; null: those in the records
[[gnu::always_inline]] inline void read(const Sphere* spheres, const double* masses, const SphereIndex* index_i,
                                        SpheresI<VecD>& out) {
  for (int first = 0; first < static_cast<int>(kBlock); first += kLanesD) {
    const Sphere* i[kLanesD];
    for (int l = 0; l < kLanesD; ++l) i[l] = record(spheres, index_i[first + l]);
    const SphereLanes a = load_spheres(i);
    for (int d = 0; d < 3; ++d) store(a.x[d], out.x[d] + first), store(a.v[d], out.v[d] + first);
    for (int d = 0; d < 3; ++d) store(a.w[d], out.w[d] + first);
    store(a.r, out.r + first), store(a.m, out.m + first);
  }
  if (masses != nullptr)
    for (std::uint32_t l = 0; l < kBlock; ++l) out.m[l] = masses[index_i[l]];
}
/// Records of mixed precision have these masses.
[[gnu::always_inline]] inline void read(const MixedSphere* spheres, const double*, const SphereIndex* index_i,
                                        SpheresI<VecF>& out) {
  for (int first = 0; first < static_cast<int>(kBlock); first += kLanesD) {
    const double* x[kLanesD];
    for (int l = 0; l < kLanesD; ++l) x[l] = &record(spheres, index_i[first + l])->x.x;
    VecD a[4];
    load4(x, a);
    for (int d = 0; d < 3; ++d) store(a[d], out.x[d] + first);
    store(a[3], out.r + first);
  }
  float beyond[kLanesF];  // of a SIMD vector wider than a block
  for (int first = 0; first < static_cast<int>(kBlock); first += kLanesF) {
    const float* motion[kLanesF];
    for (int l = 0; l < kLanesF; ++l) motion[l] = record(spheres, index_i[(first + l) % static_cast<int>(kBlock)])->v;
    VecF a[8];
    load8(motion, a);
    for (int k = 0; k < 8; ++k) store_each(a[k], [&](int half) { return half == 0 ? out.motion[k] + first : beyond; });
  }
}

/// Radius and mass of all spheres of a run, where they are uniform.
template <class P>
struct OfAll {
  P r, m;
  VecD radii2;  ///< (2 r)^2

  template <class Record>
  OfAll(const Record& any, const double* mass)
      : r(any.r), m(mass != nullptr ? *mass : any.m), radii2(4 * any.r * any.r) {}
};

template <bool Uniform>
[[gnu::always_inline]] inline void read(const Sphere* spheres, const double* masses,
                                        const SpheresI<VecD>* const (&own)[1], const SphereIndex* const (&other)[1],
                                        int first, const OfAll<VecD>& all, Gap<VecD>& out) {
  const Sphere* j[kLanesD];
  for (int l = 0; l < kLanesD; ++l) j[l] = record(spheres, other[0][first + l]);
  const SphereLanes b = load_spheres(j);
  const auto a = [&](const double* column) { return load<VecD>(column + first); };
  for (int d = 0; d < 3; ++d) {
    out.n[d] = a(own[0]->x[d]) - b.x[d];
    out.v[d] = a(own[0]->v[d]) - b.v[d];
    out.w_i[d] = a(own[0]->w[d]), out.w_j[d] = b.w[d];
  }
  out.d2 = dot3(out.n, out.n);
  if constexpr (Uniform) {
    out.r_i = out.r_j = all.r, out.m_i = out.m_j = all.m;
    return;
  }
  out.r_i = a(own[0]->r), out.m_i = a(own[0]->m), out.r_j = b.r, out.m_j = b.m;
  if (masses == nullptr) return;
  double m_j[kLanesD];
  for (int l = 0; l < kLanesD; ++l) m_j[l] = masses[other[0][first + l]];
  out.m_j = load<VecD>(m_j);
}

template <bool Uniform>
[[gnu::always_inline]] inline void read(const MixedSphere* spheres, const double*,
                                        const SpheresI<VecF>* const (&own)[kSpan<VecF>],
                                        const SphereIndex* const (&other)[kSpan<VecF>], int first,
                                        const OfAll<VecF>& all, Gap<VecF>& out) {
  EightColumns motion;
  VecD n[2][3], excess[2];
  for (int half = 0; half < 2; ++half) {
    const double* x_j[kLanesD];
    const float* j[kLanesD];
    const int block = kSpan<VecF> == 2 ? half : 0, from = kSpan<VecF> == 2 ? 0 : first + half * kLanesD;
    for (int l = 0; l < kLanesD; ++l) {
      const MixedSphere* b = record(spheres, other[block][from + l]);
      x_j[l] = &b->x.x;
      j[l] = b->v;
    }
    VecD b[4];
    load4(x_j, b);
    motion.take(half, j);
    for (int d = 0; d < 3; ++d) n[half][d] = load<VecD>(own[block]->x[d] + from) - b[d];
    const VecD d2 = dot3(n[half], n[half]), radii = load<VecD>(own[block]->r + from) + b[3];
    excess[half] = (Uniform ? all.radii2 : radii * radii) - d2;
  }
  const auto a = [&](int k) { return load_each<VecF>([&](int half) { return own[half]->motion[k] + first; }); };
  VecF b[8];
  motion.give(b);
  for (int d = 0; d < 3; ++d) {
    out.n[d] = join(n[0][d], n[1][d]);
    out.v[d] = a(d) - b[d];
    out.w_i[d] = a(4 + d), out.w_j[d] = b[4 + d];
  }
  out.d2 = dot3(out.n, out.n), out.excess = join(excess[0], excess[1]);
  if constexpr (Uniform)
    out.r_i = out.r_j = all.r, out.m_i = out.m_j = all.m;
  else
    out.m_i = a(3), out.r_i = a(7), out.m_j = b[3], out.r_j = b[7];
}

inline const Sphere* records(const PairJob& job, VecD) { return job.spheres; }
inline const MixedSphere* records(const PairJob& job, VecF) { return job.mixed; }

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
