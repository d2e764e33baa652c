#pragma once
#include "libdem/simd/vec.hpp"

/// A SIMD vector of doubles (in mixed precision: vec_f.hpp).
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

using VecD = Vec<double, kLanesD>;
using VecDMask = VecD::Mask;
using VecDData = VecD::Data;
using VecDFloats = float __attribute__((vector_size(4 * kLanesD)));

inline double sum_of(VecD p) {
#if defined(__AVX512F__)
  return _mm512_reduce_add_pd(__m512d(p.v));  // in halves: three additions after each other in place of eight
#else
  double total = 0;
  for (int l = 0; l < kLanesD; ++l) total += p.v[l];
  return total;
#endif
}

#if defined(__AVX512F__)
inline VecD select(VecDMask m, VecD a, VecD b) {
  return VecD(VecDData(_mm512_mask_blend_pd(m.bits, __m512d(b.v), __m512d(a.v))));
}
inline VecD max(VecD a, VecD b) { return VecD(VecDData(_mm512_maskz_max_pd(0xFF, __m512d(a.v), __m512d(b.v)))); }
inline VecD min(VecD a, VecD b) { return VecD(VecDData(_mm512_maskz_min_pd(0xFF, __m512d(a.v), __m512d(b.v)))); }

/// k/sqrt(a) to 2 units in the last place from the 14 bits of the instruction: y with a y^2 = 1 - e gives 1/sqrt(a) =
/// y (1 - e)^(-1/2), whose series ends here with 5/16 e^3; the next term is 2^-54. The exact square root and division
/// keep one port busy for 24 and 16 cycles.
inline VecD over_root(VecD k, VecD a) {
  const VecD y(VecDData(_mm512_maskz_rsqrt14_pd(0xFF, __m512d(a.v)))), ky = k * y, e = VecD(1.0) - a * y * y;
  return ky + ky * e * (VecD(0.5) + e * (VecD(0.375) + VecD(0.3125) * e));
}
inline VecD rsqrt(VecD a) {
  const VecD y(VecDData(_mm512_maskz_rsqrt14_pd(0xFF, __m512d(a.v)))), e = VecD(1.0) - a * y * y;
  return y + y * e * (VecD(0.5) + e * (VecD(0.375) + VecD(0.3125) * e));
}
/// sqrt(0) is 0, and so is that of a number negative by rounding; NaN stays NaN (the instruction's max gives its second
/// operand then).
inline VecD sqrt(VecD a) {
  const VecD y = rsqrt(max(VecD(1e-290), a));
  const VecD root = max(VecD(0.0), a) * y;
  return root + VecD(0.5) * y * (max(VecD(0.0), a) - root * root);
}
inline VecD operator/(VecD a, VecD b) {
  const VecD two(2.0);
  VecD y(VecDData(_mm512_maskz_rcp14_pd(0xFF, __m512d(b.v))));
  y = y * (two - b * y);
  y = y * (two - b * y);
  const VecD q = a * y;
  return q + y * (a - b * q);
}
#else
inline VecD sqrt(VecD a) {
#if defined(__AVX2__)
  return VecD(reinterpret_cast<VecDData>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(a.v))));
#elif defined(__x86_64__)
  return VecD(reinterpret_cast<VecDData>(_mm_sqrt_pd(reinterpret_cast<__m128d>(a.v))));
#else
  VecD r;
  for (int i = 0; i < kLanesD; ++i) r.v[i] = __builtin_sqrt(a.v[i]);
  return r;
#endif
}
#endif

/// Four doubles from each of kLanesD rows, transposed: out[c] holds element c of every row.
inline void load4(const double* const* row, VecD* out) {
#if defined(__AVX512F__)
  // Two rows per register, chosen so that lanes come out in order after one exchange within and one of 128-bit lanes.
  const auto rows = [&](int low, int high) {
    return _mm512_maskz_insertf64x4(0xFF, _mm512_zextpd256_pd512(_mm256_loadu_pd(row[low])), _mm256_loadu_pd(row[high]),
                                    1);
  };
  const __m512d a = rows(0, 2), b = rows(1, 3), c = rows(4, 6), d = rows(5, 7);
  const __m512d ab0 = _mm512_maskz_unpacklo_pd(0xFF, a, b), ab1 = _mm512_maskz_unpackhi_pd(0xFF, a, b);
  const __m512d cd0 = _mm512_maskz_unpacklo_pd(0xFF, c, d), cd1 = _mm512_maskz_unpackhi_pd(0xFF, c, d);
  out[0] = VecD(VecDData(_mm512_maskz_shuffle_f64x2(0xFF, ab0, cd0, 0x88)));
  out[1] = VecD(VecDData(_mm512_maskz_shuffle_f64x2(0xFF, ab1, cd1, 0x88)));
  out[2] = VecD(VecDData(_mm512_maskz_shuffle_f64x2(0xFF, ab0, cd0, 0xDD)));
  out[3] = VecD(VecDData(_mm512_maskz_shuffle_f64x2(0xFF, ab1, cd1, 0xDD)));
#elif defined(__AVX2__)
  // Halves of two rows per register: loads put them there, and only the exchange within is left to the shuffle units.
  const auto halves = [&](int low, int high, int from) {
    return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(row[low] + from)), _mm_loadu_pd(row[high] + from),
                                1);
  };
  for (int part = 0; part < 2; ++part) {
    const __m256d even = halves(0, 2, 2 * part), odd = halves(1, 3, 2 * part);
    out[2 * part] = VecD(VecDData(_mm256_unpacklo_pd(even, odd)));
    out[2 * part + 1] = VecD(VecDData(_mm256_unpackhi_pd(even, odd)));
  }
#else
  for (int c = 0; c < 4; ++c) {
    VecDData column{};
    for (int l = 0; l < kLanesD; ++l) column[l] = row[l][c];
    out[c] = VecD(column);
  }
#endif
}

#if defined(__AVX512F__)
/// Rows of four from four columns: out[l] holds row l, then row l + 4.
inline void transpose4(const VecD* in, __m512d* out) {
  const __m512d a(in[0].v), b(in[1].v), c(in[2].v), d(in[3].v);
  const __m512d ab0 = _mm512_maskz_unpacklo_pd(0xFF, a, b), ab1 = _mm512_maskz_unpackhi_pd(0xFF, a, b);
  const __m512d cd0 = _mm512_maskz_unpacklo_pd(0xFF, c, d), cd1 = _mm512_maskz_unpackhi_pd(0xFF, c, d);
  const __m512i low = _mm512_set_epi64(13, 12, 5, 4, 9, 8, 1, 0), high = _mm512_set_epi64(15, 14, 7, 6, 11, 10, 3, 2);
  out[0] = _mm512_permutex2var_pd(ab0, low, cd0), out[1] = _mm512_permutex2var_pd(ab1, low, cd1);
  out[2] = _mm512_permutex2var_pd(ab0, high, cd0), out[3] = _mm512_permutex2var_pd(ab1, high, cd1);
}
#elif defined(__AVX2__)
inline void transpose4(const VecD* in, __m256d* out) {
  const __m256d a(in[0].v), b(in[1].v), c(in[2].v), d(in[3].v);
  const __m256d ab0 = _mm256_unpacklo_pd(a, b), ab1 = _mm256_unpackhi_pd(a, b);
  const __m256d cd0 = _mm256_unpacklo_pd(c, d), cd1 = _mm256_unpackhi_pd(c, d);
  out[0] = _mm256_permute2f128_pd(ab0, cd0, 0x20), out[1] = _mm256_permute2f128_pd(ab1, cd1, 0x20);
  out[2] = _mm256_permute2f128_pd(ab0, cd0, 0x31), out[3] = _mm256_permute2f128_pd(ab1, cd1, 0x31);
}
#endif

/// The reverse of load4.
inline void store4(const VecD* in, double* const* row) {
#if defined(__AVX512F__)
  __m512d r[4];
  transpose4(in, r);
  for (int l = 0; l < 4; ++l) {
    _mm256_storeu_pd(row[l], _mm512_castpd512_pd256(r[l]));
    _mm256_storeu_pd(row[l + 4], _mm512_maskz_extractf64x4_pd(0xF, r[l], 1));
  }
#elif defined(__AVX2__)
  __m256d r[4];
  transpose4(in, r);
  for (int l = 0; l < 4; ++l) _mm256_storeu_pd(row[l], r[l]);
#else
  for (int c = 0; c < 4; ++c)
    for (int l = 0; l < kLanesD; ++l) row[l][c] = in[c].v[l];
#endif
}

/// kLanes floats as numbers of the SIMD vector, and back.
template <class P>
P load_floats(const float* from);
template <>
inline VecD load_floats<VecD>(const float* from) {
#if defined(__AVX512F__)
  // GCC 12 takes conversions of its own vectors between 32 and 64 bits apart lane by lane.
  return VecD(VecDData(_mm512_maskz_cvtps_pd(0xFF, _mm256_loadu_ps(from))));
#else
  VecDFloats f;
  __builtin_memcpy(&f, from, sizeof f);
  return VecD(__builtin_convertvector(f, VecDData));
#endif
}
inline void store_floats(VecD p, float* to) {
#if defined(__AVX512F__)
  _mm256_storeu_ps(to, _mm512_maskz_cvtpd_ps(0xFF, __m512d(p.v)));
#else
  const VecDFloats f = __builtin_convertvector(p.v, VecDFloats);
  __builtin_memcpy(to, &f, sizeof f);
#endif
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
