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

#if defined(__AVX512F__)
/// A mask register: GCC 12 keeps comparisons of its own vectors as vectors and pays for both conversions.
struct PackMask {
  __mmask8 bits;
};
#else
struct PackMask {
  PackBits bits;
};
#endif

struct Pack {
  PackData v;

  Pack() = default;
  Pack(double s) : v(PackData{} + s) {}
  explicit Pack(PackData d) : v(d) {}

  friend Pack operator+(Pack a, Pack b) { return Pack(a.v + b.v); }
  friend Pack operator-(Pack a, Pack b) { return Pack(a.v - b.v); }
  friend Pack operator*(Pack a, Pack b) { return Pack(a.v * b.v); }
  friend Pack operator-(Pack a) { return Pack(-a.v); }
#if defined(__AVX512F__)
  friend PackMask operator>(Pack a, Pack b) { return {_mm512_cmp_pd_mask(__m512d(a.v), __m512d(b.v), _CMP_GT_OQ)}; }
  friend PackMask operator>=(Pack a, Pack b) { return {_mm512_cmp_pd_mask(__m512d(a.v), __m512d(b.v), _CMP_GE_OQ)}; }
#else
  friend PackMask operator>(Pack a, Pack b) { return {a.v > b.v}; }
  friend PackMask operator>=(Pack a, Pack b) { return {a.v >= b.v}; }
#endif
  Pack& operator+=(Pack b) { return *this = *this + b; }
};

inline Pack load(const double* from) {
  Pack p;
  __builtin_memcpy(&p.v, from, sizeof p.v);
  return p;
}
inline void store(Pack p, double* to) { __builtin_memcpy(to, &p.v, sizeof p.v); }
inline double sum_of(Pack p) {
  double total = 0;
  for (int l = 0; l < kWidth; ++l) total += p.v[l];
  return total;
}

#if defined(__AVX512F__)
inline Pack select(PackMask m, Pack a, Pack b) {
  return Pack(PackData(_mm512_mask_blend_pd(m.bits, __m512d(b.v), __m512d(a.v))));
}
inline PackMask both(PackMask a, PackMask b) { return {static_cast<__mmask8>(a.bits & b.bits)}; }
inline bool any(PackMask m) { return m.bits != 0; }
inline Pack max(Pack a, Pack b) { return Pack(PackData(_mm512_maskz_max_pd(0xFF, __m512d(a.v), __m512d(b.v)))); }
inline Pack min(Pack a, Pack b) { return Pack(PackData(_mm512_maskz_min_pd(0xFF, __m512d(a.v), __m512d(b.v)))); }

/// 1/sqrt(a) to 2 units in the last place from the 14 bits of the instruction: two Newton steps. The exact square root
/// and division keep one port busy for 24 and 16 cycles, this takes 10 operations on two.
inline Pack rsqrt(Pack a) {
  const Pack half_a = Pack(-0.5) * a, three_halves(1.5);
  Pack y(PackData(_mm512_maskz_rsqrt14_pd(0xFF, __m512d(a.v))));
  y = y * (half_a * y * y + three_halves);
  return y * (half_a * y * y + three_halves);
}
/// sqrt(0) is 0, and so is that of a number negative by rounding; NaN stays NaN (the instruction's max gives its second
/// operand then).
inline Pack sqrt(Pack a) {
  const Pack y = rsqrt(max(Pack(1e-290), a));
  const Pack root = max(Pack(0.0), a) * y;
  return root + Pack(0.5) * y * (max(Pack(0.0), a) - root * root);
}
inline Pack operator/(Pack a, Pack b) {
  const Pack two(2.0);
  Pack y(PackData(_mm512_maskz_rcp14_pd(0xFF, __m512d(b.v))));
  y = y * (two - b * y);
  y = y * (two - b * y);
  const Pack q = a * y;
  return q + y * (a - b * q);
}
#else
inline Pack select(PackMask m, Pack a, Pack b) { return Pack(m.bits ? a.v : b.v); }
inline PackMask both(PackMask a, PackMask b) { return {a.bits & b.bits}; }
inline bool any(PackMask m) {
  std::int64_t all = 0;
  for (int l = 0; l < kWidth; ++l) all |= m.bits[l];
  return all != 0;
}
inline Pack max(Pack a, Pack b) { return Pack(a.v > b.v ? a.v : b.v); }
inline Pack min(Pack a, Pack b) { return Pack(a.v < b.v ? a.v : b.v); }
inline Pack operator/(Pack a, Pack b) { return Pack(a.v / b.v); }
inline Pack sqrt(Pack a) {
#if defined(__AVX2__)
  return Pack(reinterpret_cast<PackData>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(a.v))));
#elif defined(__x86_64__)
  return Pack(reinterpret_cast<PackData>(_mm_sqrt_pd(reinterpret_cast<__m128d>(a.v))));
#else
  Pack r;
  for (int i = 0; i < kWidth; ++i) r.v[i] = __builtin_sqrt(a.v[i]);
  return r;
#endif
}
inline Pack rsqrt(Pack a) { return Pack(1.0) / sqrt(a); }
#endif

/// Byte offsets of 8 records of `size` bytes, whose numbers are `index & mask`: computed together, not one by one
/// beside the loads that wait for them.
struct Offsets {
  std::uint64_t at[8];
};
template <std::uint64_t size>
[[gnu::always_inline]] inline Offsets offsets_of(const std::uint32_t* index, std::uint32_t mask) {
  Offsets o;
  for (int l = 0; l < 8; ++l) o.at[l] = static_cast<std::uint64_t>(index[l] & mask) * size;
  return o;
}

/// Lane by lane: see power() in laws/number.hpp.
inline Pack pow(Pack a, double n) {
  Pack r;
  for (int i = 0; i < kWidth; ++i) r.v[i] = __builtin_pow(a.v[i], n);
  return r;
}

inline Pack log(Pack a) {
  Pack r;
  for (int i = 0; i < kWidth; ++i) r.v[i] = __builtin_log(a.v[i]);
  return r;
}

/// Four doubles from each of kWidth rows, transposed: out[c] holds element c of every row.
inline void load4(const double* const* row, Pack* out) {
#if defined(__AVX512F__)
  // Two rows per register, chosen so that lanes come out in order after one exchange within and one of 128-bit lanes.
  const auto rows = [&](int low, int high) {
    return _mm512_maskz_insertf64x4(0xFF, _mm512_zextpd256_pd512(_mm256_loadu_pd(row[low])), _mm256_loadu_pd(row[high]),
                                    1);
  };
  const __m512d a = rows(0, 2), b = rows(1, 3), c = rows(4, 6), d = rows(5, 7);
  const __m512d ab0 = _mm512_maskz_unpacklo_pd(0xFF, a, b), ab1 = _mm512_maskz_unpackhi_pd(0xFF, a, b);
  const __m512d cd0 = _mm512_maskz_unpacklo_pd(0xFF, c, d), cd1 = _mm512_maskz_unpackhi_pd(0xFF, c, d);
  out[0] = Pack(PackData(_mm512_maskz_shuffle_f64x2(0xFF, ab0, cd0, 0x88)));
  out[1] = Pack(PackData(_mm512_maskz_shuffle_f64x2(0xFF, ab1, cd1, 0x88)));
  out[2] = Pack(PackData(_mm512_maskz_shuffle_f64x2(0xFF, ab0, cd0, 0xDD)));
  out[3] = Pack(PackData(_mm512_maskz_shuffle_f64x2(0xFF, ab1, cd1, 0xDD)));
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

/// kWidth floats as doubles, and back.
inline Pack load_floats(const float* from) {
#if defined(__AVX512F__)
  // GCC 12 takes conversions of its own vectors between 32 and 64 bits apart lane by lane.
  return Pack(PackData(_mm512_maskz_cvtps_pd(0xFF, _mm256_loadu_ps(from))));
#else
  PackFloats f;
  __builtin_memcpy(&f, from, sizeof f);
  return Pack(__builtin_convertvector(f, PackData));
#endif
}
inline void store_floats(Pack p, float* to) {
#if defined(__AVX512F__)
  _mm256_storeu_ps(to, _mm512_maskz_cvtpd_ps(0xFF, __m512d(p.v)));
#else
  const PackFloats f = __builtin_convertvector(p.v, PackFloats);
  __builtin_memcpy(to, &f, sizeof f);
#endif
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
