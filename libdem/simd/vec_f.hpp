#pragma once
#include "libdem/simd/vec_d.hpp"

/// A SIMD vector of floats, twice as many as of doubles: what pairs of spheres are computed with in mixed precision.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

using VecF = Vec<float, kLanesF>;
using VecFMask = VecF::Mask;
using VecFData = VecF::Data;

#if defined(__AVX512F__)
inline VecF select(VecFMask m, VecF a, VecF b) {
  return VecF(VecFData(_mm512_mask_blend_ps(m.bits, __m512(b.v), __m512(a.v))));
}
inline VecF max(VecF a, VecF b) { return VecF(VecFData(_mm512_maskz_max_ps(0xFFFF, __m512(a.v), __m512(b.v)))); }
inline VecF min(VecF a, VecF b) { return VecF(VecFData(_mm512_maskz_min_ps(0xFFFF, __m512(a.v), __m512(b.v)))); }
/// 14 bits of it.
inline VecF rough_rsqrt(VecF a) { return VecF(VecFData(_mm512_maskz_rsqrt14_ps(0xFFFF, __m512(a.v)))); }
/// One Newton step from those: an ulp or two, as in vec_d.hpp.
inline VecF refined_rsqrt(VecF a, VecF rough) { return rough * (VecF(-0.5) * a * rough * rough + VecF(1.5)); }
inline VecF rsqrt(VecF a) { return refined_rsqrt(a, rough_rsqrt(a)); }
inline VecF over_root(VecF k, VecF a) { return k * rsqrt(a); }
inline VecF sqrt(VecF a) {
  const VecF root = max(VecF(0.0), a) * rsqrt(max(VecF(1e-37), a));
  return root;
}
inline VecF operator/(VecF a, VecF b) {
  VecF y(VecFData(_mm512_maskz_rcp14_ps(0xFFFF, __m512(b.v))));
  y = y * (VecF(2.0) - b * y);
  const VecF q = a * y;
  return q + y * (a - b * q);
}
/// a/b to an ulp or two, where b is known to 13 bits before it is known: the inverse is looked up meanwhile.
inline VecF quotient(VecF a, VecF b, VecF nearly_b) {
  const VecF y(VecFData(_mm512_maskz_rcp14_ps(0xFFFF, __m512(nearly_b.v)))), q = a * y;
  return q + q * (VecF(1.0) - b * y);
}
#else
inline VecF sqrt(VecF a) {
#if defined(__AVX2__)
  return VecF(reinterpret_cast<VecFData>(_mm256_sqrt_ps(reinterpret_cast<__m256>(a.v))));
#elif defined(__x86_64__)
  return VecF(reinterpret_cast<VecFData>(_mm_sqrt_ps(reinterpret_cast<__m128>(a.v))));
#else
  VecF r;
  for (int i = 0; i < kLanesF; ++i) r.v[i] = __builtin_sqrtf(a.v[i]);
  return r;
#endif
}
#endif

/// Two SIMD vectors of doubles, rounded, as one of floats.
inline VecF join(VecD low, VecD high) {
#if defined(__AVX512F__)
  const __m256 a = _mm512_maskz_cvtpd_ps(0xFF, __m512d(low.v)), b = _mm512_maskz_cvtpd_ps(0xFF, __m512d(high.v));
  return VecF(VecFData(_mm512_maskz_insertf32x8(0xFFFF, _mm512_zextps256_ps512(a), b, 1)));
#elif defined(__AVX2__)
  const __m128 a = _mm256_cvtpd_ps(__m256d(low.v)), b = _mm256_cvtpd_ps(__m256d(high.v));
  return VecF(VecFData(_mm256_insertf128_ps(_mm256_castps128_ps256(a), b, 1)));
#else
  VecF r;
  for (int l = 0; l < kLanesD; ++l) {
    r.v[l] = static_cast<float>(low.v[l]);
    r.v[l + kLanesD] = static_cast<float>(high.v[l]);
  }
  return r;
#endif
}

/// Halves of a SIMD vector, as doubles.
inline VecD half_of(VecF p, int half) {
#if defined(__AVX512F__)
  const __m256 f = half == 0 ? _mm512_castps512_ps256(__m512(p.v)) : _mm512_maskz_extractf32x8_ps(0xFF, __m512(p.v), 1);
  return VecD(VecDData(_mm512_maskz_cvtps_pd(0xFF, f)));
#else
  VecD r;
  for (int l = 0; l < kLanesD; ++l) r.v[l] = static_cast<double>(p.v[l + half * kLanesD]);
  return r;
#endif
}

/// kLanesF floats of which the second half lies elsewhere when the SIMD vector is wider than a block.
template <>
inline VecF load_floats<VecF>(const float* from) {
  return load<VecF>(from);
}
inline void store_floats(VecF p, float* to) { store(p, to); }

#if defined(__AVX512F__)
inline VecF load_halves(const float* low, const float* high) {
  return VecF(VecFData(
      _mm512_maskz_insertf32x8(0xFFFF, _mm512_zextps256_ps512(_mm256_loadu_ps(low)), _mm256_loadu_ps(high), 1)));
}
inline void store_halves(VecF p, float* low, float* high) {
  _mm256_storeu_ps(low, _mm512_castps512_ps256(__m512(p.v)));
  _mm256_storeu_ps(high, _mm512_maskz_extractf32x8_ps(0xFF, __m512(p.v), 1));
}

/// 4 x 4 transpose within each 128 bits.
inline void transpose4(const __m512* in, __m512* out) {
  const __m512 a = _mm512_maskz_unpacklo_ps(0xFFFF, in[0], in[1]), b = _mm512_maskz_unpackhi_ps(0xFFFF, in[0], in[1]);
  const __m512 c = _mm512_maskz_unpacklo_ps(0xFFFF, in[2], in[3]), d = _mm512_maskz_unpackhi_ps(0xFFFF, in[2], in[3]);
  const auto low = [](__m512 x, __m512 y) {
    return _mm512_castpd_ps(_mm512_maskz_unpacklo_pd(0xFF, _mm512_castps_pd(x), _mm512_castps_pd(y)));
  };
  const auto high = [](__m512 x, __m512 y) {
    return _mm512_castpd_ps(_mm512_maskz_unpackhi_pd(0xFF, _mm512_castps_pd(x), _mm512_castps_pd(y)));
  };
  out[0] = low(a, c), out[1] = high(a, c), out[2] = low(b, d), out[3] = high(b, d);
}
#endif
#if defined(__AVX2__)
inline void transpose4(const __m256* in, __m256* out) {
  const __m256 a = _mm256_unpacklo_ps(in[0], in[1]), b = _mm256_unpackhi_ps(in[0], in[1]);
  const __m256 c = _mm256_unpacklo_ps(in[2], in[3]), d = _mm256_unpackhi_ps(in[2], in[3]);
  const auto low = [](__m256 x, __m256 y) {
    return _mm256_castpd_ps(_mm256_unpacklo_pd(_mm256_castps_pd(x), _mm256_castps_pd(y)));
  };
  const auto high = [](__m256 x, __m256 y) {
    return _mm256_castpd_ps(_mm256_unpackhi_pd(_mm256_castps_pd(x), _mm256_castps_pd(y)));
  };
  out[0] = low(a, c), out[1] = high(a, c), out[2] = low(b, d), out[3] = high(b, d);
}
#endif

/// Eight floats from each of kLanesF rows, transposed: out[c] holds element c of every row.
#if !defined(__AVX512F__)
inline void load8(const float* const* row, VecF* out) {
#if defined(__AVX2__)
  for (int part = 0; part < 2; ++part) {
    __m256 in[4], columns[4];
    for (int k = 0; k < 4; ++k)
      in[k] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(row[k] + 4 * part)),
                                   _mm_loadu_ps(row[k + 4] + 4 * part), 1);
    transpose4(in, columns);
    for (int c = 0; c < 4; ++c) out[4 * part + c] = VecF(VecFData(columns[c]));
  }
#else
  for (int c = 0; c < 8; ++c) {
    VecFData column{};
    for (int l = 0; l < kLanesF; ++l) column[l] = row[l][c];
    out[c] = VecF(column);
  }
#endif
}
#endif

/// Likewise of rows that come in two halves: their addresses need not stay in registers until the others are known.
class EightColumns {
 public:
  /// @param row kLanesD of them
  [[gnu::always_inline]] void take(int half, const float* const* row) {
#if defined(__AVX512F__)
    // Rows k and k + 4 share a register: after the transpose within 128 bits its quarters are the first four numbers of
    // rows 0 to 3, their last four, and both of rows 4 to 7.
    __m512 in[4];
    for (int k = 0; k < 4; ++k)
      in[k] = _mm512_maskz_insertf32x8(0xFFFF, _mm512_zextps256_ps512(_mm256_loadu_ps(row[k])),
                                       _mm256_loadu_ps(row[k + 4]), 1);
    transpose4(in, half_[half]);
#else
    for (int k = 0; k < kLanesD; ++k) row_[half * kLanesD + k] = row[k];
#endif
  }
  [[gnu::always_inline]] void give(VecF* out) const {
#if defined(__AVX512F__)
    for (int c = 0; c < 4; ++c) {
      out[c] = VecF(VecFData(_mm512_maskz_shuffle_f32x4(0xFFFF, half_[0][c], half_[1][c], 0x88)));
      out[c + 4] = VecF(VecFData(_mm512_maskz_shuffle_f32x4(0xFFFF, half_[0][c], half_[1][c], 0xDD)));
    }
#else
    load8(row_, out);
#endif
  }

 private:
#if defined(__AVX512F__)
  __m512 half_[2][4];
#else
  const float* row_[kLanesF];
#endif
};
#if defined(__AVX512F__)
inline void load8(const float* const* row, VecF* out) {
  EightColumns columns;
  columns.take(0, row), columns.take(1, row + kLanesD);
  columns.give(out);
}
#endif

}  // namespace SUBSOIL_ISA

/// From 1e-28 N or N m to 1.8e10.
template <>
struct SquareRange<VecF> {
  static constexpr double unit = 1e9, least = 1e-37;
};

}  // namespace subsoil::dem
