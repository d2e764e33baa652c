#pragma once
#include <cstdint>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

/// A pack of W doubles for the sweep: the number type that laws are instantiated with.
/// GCC vector extensions carry the arithmetic, so one source serves SSE2, AVX2 and AVX-512 by the flags it is compiled
/// with (kernel.cpp is compiled once per instruction set, each in its own inline namespace, so no two sets share a
/// symbol).
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

#if defined(__AVX512F__)
inline constexpr int kWidth = 8;
#elif defined(__AVX2__)
inline constexpr int kWidth = 4;
#else
inline constexpr int kWidth = 2;
#endif

using PackData = double __attribute__((vector_size(8 * kWidth)));
using PackBits = std::int64_t __attribute__((vector_size(8 * kWidth)));
using PackFloats = float __attribute__((vector_size(4 * kWidth)));
using PackHalves = std::uint32_t __attribute__((vector_size(4 * kWidth)));
using PackWords = std::uint64_t __attribute__((vector_size(8 * kWidth)));

struct PackMask {
  PackBits bits;
};

struct Pack {
  PackData v;

  Pack() = default;
  Pack(double s) : v(PackData{} + s) {}
  explicit Pack(PackData d) : v(d) {}

  friend Pack operator+(Pack a, Pack b) { return Pack(a.v + b.v); }
  friend Pack operator-(Pack a, Pack b) { return Pack(a.v - b.v); }
  friend Pack operator*(Pack a, Pack b) { return Pack(a.v * b.v); }
  friend Pack operator/(Pack a, Pack b) { return Pack(a.v / b.v); }
  friend Pack operator-(Pack a) { return Pack(-a.v); }
  friend PackMask operator>(Pack a, Pack b) { return {a.v > b.v}; }
  friend PackMask operator>=(Pack a, Pack b) { return {a.v >= b.v}; }
};

inline Pack select(PackMask m, Pack a, Pack b) { return Pack(m.bits ? a.v : b.v); }
inline PackMask both(PackMask a, PackMask b) { return {a.bits & b.bits}; }
inline Pack max(Pack a, Pack b) { return Pack(a.v > b.v ? a.v : b.v); }
inline Pack min(Pack a, Pack b) { return Pack(a.v < b.v ? a.v : b.v); }
inline Pack sqrt(Pack a) {
#if defined(__AVX512F__)
  return Pack(reinterpret_cast<PackData>(_mm512_maskz_sqrt_pd(0xFF, reinterpret_cast<__m512d>(a.v))));
#elif defined(__AVX2__)
  return Pack(reinterpret_cast<PackData>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(a.v))));
#elif defined(__x86_64__)
  return Pack(reinterpret_cast<PackData>(_mm_sqrt_pd(reinterpret_cast<__m128d>(a.v))));
#else
  Pack r;
  for (int i = 0; i < kWidth; ++i) r.v[i] = __builtin_sqrt(a.v[i]);
  return r;
#endif
}

/// Lane by lane: see power() in laws/number.hpp.
inline Pack pow(Pack a, double n) {
  Pack r;
  for (int i = 0; i < kWidth; ++i) r.v[i] = __builtin_pow(a.v[i], n);
  return r;
}

/// Four doubles from each of kWidth rows, transposed: out[c] holds element c of every row.
inline void load4(const double* const* row, Pack* out) {
#if defined(__AVX512F__)
  // Rows l and l + 4 share a register; a 4 x 4 transpose in each half then gives all eight lanes.
  const auto pair = [&](int l) {
    return _mm512_maskz_insertf64x4(0xFF, _mm512_zextpd256_pd512(_mm256_loadu_pd(row[l])), _mm256_loadu_pd(row[l + 4]),
                                    1);
  };
  const __m512d a = pair(0), b = pair(1), c = pair(2), d = pair(3);
  const __m512d ab0 = _mm512_maskz_unpacklo_pd(0xFF, a, b), ab1 = _mm512_maskz_unpackhi_pd(0xFF, a, b);
  const __m512d cd0 = _mm512_maskz_unpacklo_pd(0xFF, c, d), cd1 = _mm512_maskz_unpackhi_pd(0xFF, c, d);
  const __m512i low = _mm512_set_epi64(13, 12, 5, 4, 9, 8, 1, 0), high = _mm512_set_epi64(15, 14, 7, 6, 11, 10, 3, 2);
  out[0] = Pack(PackData(_mm512_permutex2var_pd(ab0, low, cd0)));
  out[1] = Pack(PackData(_mm512_permutex2var_pd(ab1, low, cd1)));
  out[2] = Pack(PackData(_mm512_permutex2var_pd(ab0, high, cd0)));
  out[3] = Pack(PackData(_mm512_permutex2var_pd(ab1, high, cd1)));
#elif defined(__AVX2__)
  const __m256d a = _mm256_loadu_pd(row[0]), b = _mm256_loadu_pd(row[1]), c = _mm256_loadu_pd(row[2]),
                d = _mm256_loadu_pd(row[3]);
  const __m256d ab0 = _mm256_unpacklo_pd(a, b), ab1 = _mm256_unpackhi_pd(a, b);
  const __m256d cd0 = _mm256_unpacklo_pd(c, d), cd1 = _mm256_unpackhi_pd(c, d);
  out[0] = Pack(PackData(_mm256_permute2f128_pd(ab0, cd0, 0x20)));
  out[1] = Pack(PackData(_mm256_permute2f128_pd(ab1, cd1, 0x20)));
  out[2] = Pack(PackData(_mm256_permute2f128_pd(ab0, cd0, 0x31)));
  out[3] = Pack(PackData(_mm256_permute2f128_pd(ab1, cd1, 0x31)));
#else
  for (int c = 0; c < 4; ++c) {
    PackData column{};
    for (int l = 0; l < kWidth; ++l) column[l] = row[l][c];
    out[c] = Pack(column);
  }
#endif
}

/// The reverse of load4.
inline void store4(const Pack* in, double* const* row) {
#if defined(__AVX512F__)
  const __m512d a(in[0].v), b(in[1].v), c(in[2].v), d(in[3].v);
  const __m512d ab0 = _mm512_maskz_unpacklo_pd(0xFF, a, b), ab1 = _mm512_maskz_unpackhi_pd(0xFF, a, b);
  const __m512d cd0 = _mm512_maskz_unpacklo_pd(0xFF, c, d), cd1 = _mm512_maskz_unpackhi_pd(0xFF, c, d);
  const __m512i low = _mm512_set_epi64(13, 12, 5, 4, 9, 8, 1, 0), high = _mm512_set_epi64(15, 14, 7, 6, 11, 10, 3, 2);
  const __m512d r[4] = {_mm512_permutex2var_pd(ab0, low, cd0), _mm512_permutex2var_pd(ab1, low, cd1),
                        _mm512_permutex2var_pd(ab0, high, cd0), _mm512_permutex2var_pd(ab1, high, cd1)};
  for (int l = 0; l < 4; ++l) {
    _mm256_storeu_pd(row[l], _mm512_castpd512_pd256(r[l]));
    _mm256_storeu_pd(row[l + 4], _mm512_maskz_extractf64x4_pd(0xF, r[l], 1));
  }
#elif defined(__AVX2__)
  const __m256d a(in[0].v), b(in[1].v), c(in[2].v), d(in[3].v);
  const __m256d ab0 = _mm256_unpacklo_pd(a, b), ab1 = _mm256_unpackhi_pd(a, b);
  const __m256d cd0 = _mm256_unpacklo_pd(c, d), cd1 = _mm256_unpackhi_pd(c, d);
  _mm256_storeu_pd(row[0], _mm256_permute2f128_pd(ab0, cd0, 0x20));
  _mm256_storeu_pd(row[1], _mm256_permute2f128_pd(ab1, cd1, 0x20));
  _mm256_storeu_pd(row[2], _mm256_permute2f128_pd(ab0, cd0, 0x31));
  _mm256_storeu_pd(row[3], _mm256_permute2f128_pd(ab1, cd1, 0x31));
#else
  for (int c = 0; c < 4; ++c)
    for (int l = 0; l < kWidth; ++l) row[l][c] = in[c].v[l];
#endif
}

/// Two floats that share the place of a double in each lane.
inline void split(Pack both_floats, Pack& low, Pack& high) {
#if defined(__AVX512F__)
  // GCC 12 takes vector conversions between 32 and 64 bits apart lane by lane.
  const __m512i bits = _mm512_castpd_si512(__m512d(both_floats.v));
  const __m256 a = _mm256_castsi256_ps(_mm512_maskz_cvtepi64_epi32(0xFF, bits));
  const __m256 b = _mm256_castsi256_ps(_mm512_maskz_cvtepi64_epi32(0xFF, _mm512_maskz_srli_epi64(0xFF, bits, 32)));
  low = Pack(PackData(_mm512_maskz_cvtps_pd(0xFF, a)));
  high = Pack(PackData(_mm512_maskz_cvtps_pd(0xFF, b)));
#else
  const PackWords words = reinterpret_cast<PackWords>(both_floats.v);
  const PackHalves a = __builtin_convertvector(words, PackHalves), b = __builtin_convertvector(words >> 32, PackHalves);
  low = Pack(__builtin_convertvector(reinterpret_cast<PackFloats>(a), PackData));
  high = Pack(__builtin_convertvector(reinterpret_cast<PackFloats>(b), PackData));
#endif
}
inline Pack join(Pack low, Pack high) {
#if defined(__AVX512F__)
  const __m512i a = _mm512_maskz_cvtepu32_epi64(0xFF, _mm256_castps_si256(_mm512_maskz_cvtpd_ps(0xFF, __m512d(low.v))));
  const __m512i b =
      _mm512_maskz_cvtepu32_epi64(0xFF, _mm256_castps_si256(_mm512_maskz_cvtpd_ps(0xFF, __m512d(high.v))));
  return Pack(PackData(_mm512_castsi512_pd(_mm512_or_si512(a, _mm512_maskz_slli_epi64(0xFF, b, 32)))));
#else
  const PackFloats a = __builtin_convertvector(low.v, PackFloats), b = __builtin_convertvector(high.v, PackFloats);
  const PackWords words = __builtin_convertvector(reinterpret_cast<PackHalves>(a), PackWords) |
                          (__builtin_convertvector(reinterpret_cast<PackHalves>(b), PackWords) << 32);
  return Pack(reinterpret_cast<PackData>(words));
#endif
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
