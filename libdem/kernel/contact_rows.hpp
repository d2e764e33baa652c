#pragma once
#include "libdem/kernel/accumulators.hpp"
#include "libdem/kernel/lanes.hpp"

/// Force and torque of a contact as one row, made of the columns of a SIMD vector, and its way to the sums of a sphere.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

/// Some lanes of a block, as wide as the sums they are added to: SIMD vectors of P, but floats of one block only.
#if defined(__AVX512F__)
struct HalfVecF {
  static constexpr int kLanes = 8;
  __m256 v;

  HalfVecF() = default;
  HalfVecF(double s) : v(_mm256_set1_ps(static_cast<float>(s))) {}
  explicit HalfVecF(__m256 f) : v(f) {}
  HalfVecF& operator+=(HalfVecF b) { return v = _mm256_add_ps(v, b.v), *this; }
};
using VecFPart = HalfVecF;
/// With zeros from lane `count` of the block on, in which `from` is lane `first`.
inline HalfVecF load_part(const float* from, std::uint32_t count, int) {
  return HalfVecF(_mm256_maskz_loadu_ps(static_cast<__mmask8>((1u << count) - 1), from));
}
inline VecD load_part(const double* from, std::uint32_t count, int) {
  return VecD(VecDData(_mm512_maskz_loadu_pd(static_cast<__mmask8>((1u << count) - 1), from)));
}
#else
using VecFPart = VecF;
/// Lanes that hold no pair have been set to zero (blank).
inline VecF load_part(const float* from, std::uint32_t, int) { return load<VecF>(from); }
inline VecD load_part(const double* from, std::uint32_t, int) { return load<VecD>(from); }
#endif
/// Whether empty lanes cost nothing to leave out when pushes are loaded: else they are set to zero when stored.
#if defined(__AVX512F__)
inline constexpr bool kMaskedLoads = true;
#else
inline constexpr bool kMaskedLoads = false;
#endif
template <class P>
using Part = std::conditional_t<std::is_same_v<P, VecD>, VecD, VecFPart>;
template <class P>
inline constexpr int kPart = Part<P>::kLanes;

/// Force and torque of one lane.
template <class Part>
struct Row;
template <>
struct Row<VecD> {
#if defined(__AVX512F__)
  __m512d all;
#else
  Four f, t;
#endif
};
template <>
struct Row<VecFPart> {
#if defined(__AVX2__)
  __m256 all;
#else
  FourFloats f, t;
#endif
};

/// Rows from the columns of force and torque.
[[gnu::always_inline]] inline void make_rows(const VecD (&f)[4], const VecD (&t)[4], Row<VecD> (&row)[kLanesD]) {
#if defined(__AVX512F__)
  __m512d rows_f[4], rows_t[4];
  transpose4(f, rows_f), transpose4(t, rows_t);
  for (int l = 0; l < 4; ++l) {
    row[l].all = _mm512_maskz_shuffle_f64x2(0xFF, rows_f[l], rows_t[l], 0x44);
    row[l + 4].all = _mm512_maskz_shuffle_f64x2(0xFF, rows_f[l], rows_t[l], 0xEE);
  }
#else
  double* rows_f[kLanesD];
  double* rows_t[kLanesD];
  for (int l = 0; l < kLanesD; ++l)
    rows_f[l] = reinterpret_cast<double*>(&row[l].f), rows_t[l] = reinterpret_cast<double*>(&row[l].t);
  store4(f, rows_f), store4(t, rows_t);
#endif
}
[[gnu::always_inline]] inline void make_rows(const VecFPart (&f)[4], const VecFPart (&t)[4],
                                             Row<VecFPart> (&row)[VecFPart::kLanes]) {
#if defined(__AVX2__)
  const auto across = [](const VecFPart* in, __m256* out) {
    const __m256 columns[4] = {__m256(in[0].v), __m256(in[1].v), __m256(in[2].v), __m256(in[3].v)};
    transpose4(columns, out);  // rows k and k + 4
  };
  __m256 rows_f[4], rows_t[4];
  across(f, rows_f), across(t, rows_t);
  for (int l = 0; l < 4; ++l) {
    row[l].all = _mm256_insertf128_ps(rows_f[l], _mm256_castps256_ps128(rows_t[l]), 1);
    row[l + 4].all = _mm256_permute2f128_ps(rows_f[l], rows_t[l], 0x31);
  }
#else
  for (int l = 0; l < VecFPart::kLanes; ++l) {
    row[l].f = FourFloats{f[0].v[l], f[1].v[l], f[2].v[l], f[3].v[l]};
    row[l].t = FourFloats{t[0].v[l], t[1].v[l], t[2].v[l], t[3].v[l]};
  }
#endif
}

#if defined(__AVX2__) && !defined(__AVX512F__)
/// Rows of four lanes from the columns in memory: loads put halves of two columns into one register, which half of the
/// exchanges of make_rows do. @param column of force, torque, touching contacts, each of a whole block
template <bool Count>
[[gnu::always_inline]] inline void rows_in_memory(const double* const (&column)[7], int first, Row<VecD> (&row)[4]) {
  const auto two = [&](int k, int lane) { return _mm_loadu_pd(column[k] + first + lane); };
  const auto with = [](__m128d low, __m128d high) {
    return _mm256_insertf128_pd(_mm256_castpd128_pd256(low), high, 1);
  };
#pragma GCC unroll 2
  for (int l = 0; l < 4; l += 2) {
    const __m256d f_even = with(two(0, l), two(2, l)), t_even = with(two(3, l), two(5, l));
    const __m256d f_odd = _mm256_zextpd128_pd256(two(1, l));
    const __m256d t_odd = Count ? with(two(4, l), two(6, l)) : _mm256_zextpd128_pd256(two(4, l));
    row[l].f = Four(_mm256_unpacklo_pd(f_even, f_odd)), row[l].t = Four(_mm256_unpacklo_pd(t_even, t_odd));
    row[l + 1].f = Four(_mm256_unpackhi_pd(f_even, f_odd)), row[l + 1].t = Four(_mm256_unpackhi_pd(t_even, t_odd));
  }
}
template <bool Count>
[[gnu::always_inline]] inline void rows_in_memory(const float* const (&column)[7], int first, Row<VecFPart> (&row)[4]) {
  const auto four = [&](int k) { return _mm_loadu_ps(column[k] + first); };
  __m256 in[4], out[4];
  for (int d = 0; d < 3; ++d) in[d] = _mm256_insertf128_ps(_mm256_castps128_ps256(four(d)), four(3 + d), 1);
  in[3] = Count ? _mm256_insertf128_ps(_mm256_setzero_ps(), four(6), 1) : _mm256_setzero_ps();
  transpose4(in, out);
  for (int l = 0; l < 4; ++l) row[l].all = out[l];
}
#endif

/// For those who take it later: in double in either precision.
[[gnu::always_inline]] inline void write(const Row<VecD>& row, Accumulator& to) {
#if defined(__AVX512F__)
  _mm512_store_pd(reinterpret_cast<double*>(&to), row.all);
#else
  to.f = row.f, to.t = row.t;
#endif
}
[[gnu::always_inline]] inline void write(const Row<VecFPart>& row, Accumulator& to) {
#if defined(__AVX2__)
  to.f = doubles_of(_mm256_castps256_ps128(row.all)), to.t = doubles_of(_mm256_extractf128_ps(row.all, 1));
#else
  to.f = doubles_of(row.f), to.t = doubles_of(row.t);
#endif
}
/// For sphere i of a pair.
[[gnu::always_inline]] inline void add(Accumulator& sum, const Row<VecD>& row) {
#if defined(__AVX512F__)
  auto* of = reinterpret_cast<double*>(&sum);
  _mm512_store_pd(of, _mm512_add_pd(_mm512_load_pd(of), row.all));
#else
  sum.f += row.f, sum.t += row.t;
#endif
}
[[gnu::always_inline]] inline void add(MixedAccumulator& sum, const Row<VecFPart>& row) {
#if defined(__AVX2__)
  auto* of = reinterpret_cast<float*>(&sum);
  _mm256_store_ps(of, _mm256_add_ps(_mm256_load_ps(of), row.all));
#else
  sum.f += row.f, sum.t += row.t;
#endif
}
/// For sphere j: the force is taken off, the torque is its own.
[[gnu::always_inline]] inline void react(Accumulator& sum, const Row<VecD>& row) {
#if defined(__AVX512F__)
  auto* of = reinterpret_cast<double*>(&sum);
  const __m512d sign = _mm512_set_pd(1, 1, 1, 1, -1, -1, -1, -1);
  _mm512_store_pd(of, _mm512_fmadd_pd(sign, row.all, _mm512_load_pd(of)));
#else
  sum.f -= row.f, sum.t += row.t;
#endif
}
[[gnu::always_inline]] inline void react(MixedAccumulator& sum, const Row<VecFPart>& row) {
#if defined(__AVX2__)
  auto* of = reinterpret_cast<float*>(&sum);
  const __m256 sign = _mm256_set_ps(1, 1, 1, 1, -1, -1, -1, -1);
  _mm256_store_ps(of, _mm256_fmadd_ps(sign, row.all, _mm256_load_ps(of)));
#else
  sum.f -= row.f, sum.t += row.t;
#endif
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
