#pragma once
#include "libdem/kernel/doubles.hpp"

/// A pack of floats, twice as many as of doubles: what pairs of spheres are computed with in mixed precision.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

inline constexpr int kSingles = 2 * kDoubles;

using SinglesData = float __attribute__((vector_size(4 * kSingles)));
using SinglesBits = std::int32_t __attribute__((vector_size(4 * kSingles)));

#if defined(__AVX512F__)
struct SinglesMask {
  __mmask16 bits;
};
#else
struct SinglesMask {
  SinglesBits bits;
};
#endif

struct Singles {
  using Real = float;
  static constexpr int kLanes = kSingles;
  SinglesData v;

  Singles() = default;
  Singles(double s) : v(static_cast<float>(s) - SinglesData{}) {}
  explicit Singles(SinglesData d) : v(d) {}

  friend Singles operator+(Singles a, Singles b) { return Singles(a.v + b.v); }
  friend Singles operator-(Singles a, Singles b) { return Singles(a.v - b.v); }
  friend Singles operator*(Singles a, Singles b) { return Singles(a.v * b.v); }
  friend Singles operator-(Singles a) { return Singles(-a.v); }
#if defined(__AVX512F__)
  friend SinglesMask operator>(Singles a, Singles b) {
    return {_mm512_cmp_ps_mask(__m512(a.v), __m512(b.v), _CMP_GT_OQ)};
  }
  friend SinglesMask operator>=(Singles a, Singles b) {
    return {_mm512_cmp_ps_mask(__m512(a.v), __m512(b.v), _CMP_GE_OQ)};
  }
#else
  friend SinglesMask operator>(Singles a, Singles b) { return {a.v > b.v}; }
  friend SinglesMask operator>=(Singles a, Singles b) { return {a.v >= b.v}; }
#endif
  Singles& operator+=(Singles b) { return *this = *this + b; }
};

template <>
inline Singles load<Singles>(const float* from) {
  Singles p;
  __builtin_memcpy(&p.v, from, sizeof p.v);
  return p;
}
inline void store(Singles p, float* to) { __builtin_memcpy(to, &p.v, sizeof p.v); }

#if defined(__AVX512F__)
inline Singles select(SinglesMask m, Singles a, Singles b) {
  return Singles(SinglesData(_mm512_mask_blend_ps(m.bits, __m512(b.v), __m512(a.v))));
}
inline SinglesMask both(SinglesMask a, SinglesMask b) { return {static_cast<__mmask16>(a.bits & b.bits)}; }
inline bool any(SinglesMask m) { return m.bits != 0; }
inline Singles max(Singles a, Singles b) {
  return Singles(SinglesData(_mm512_maskz_max_ps(0xFFFF, __m512(a.v), __m512(b.v))));
}
inline Singles min(Singles a, Singles b) {
  return Singles(SinglesData(_mm512_maskz_min_ps(0xFFFF, __m512(a.v), __m512(b.v))));
}
/// 14 bits of it.
inline Singles rough_rsqrt(Singles a) { return Singles(SinglesData(_mm512_maskz_rsqrt14_ps(0xFFFF, __m512(a.v)))); }
/// One Newton step from those: an ulp or two, as in doubles.hpp.
inline Singles refined_rsqrt(Singles a, Singles rough) {
  return rough * (Singles(-0.5) * a * rough * rough + Singles(1.5));
}
inline Singles rsqrt(Singles a) { return refined_rsqrt(a, rough_rsqrt(a)); }
inline Singles over_root(Singles k, Singles a) { return k * rsqrt(a); }
inline Singles sqrt(Singles a) {
  const Singles root = max(Singles(0.0), a) * rsqrt(max(Singles(1e-37), a));
  return root;
}
inline Singles operator/(Singles a, Singles b) {
  Singles y(SinglesData(_mm512_maskz_rcp14_ps(0xFFFF, __m512(b.v))));
  y = y * (Singles(2.0) - b * y);
  const Singles q = a * y;
  return q + y * (a - b * q);
}
/// a/b to an ulp or two, where b is known to 13 bits before it is known: the inverse is looked up meanwhile.
inline Singles quotient(Singles a, Singles b, Singles nearly_b) {
  const Singles y(SinglesData(_mm512_maskz_rcp14_ps(0xFFFF, __m512(nearly_b.v)))), q = a * y;
  return q + q * (Singles(1.0) - b * y);
}
#else
inline Singles select(SinglesMask m, Singles a, Singles b) { return Singles(m.bits ? a.v : b.v); }
inline SinglesMask both(SinglesMask a, SinglesMask b) { return {a.bits & b.bits}; }
inline bool any(SinglesMask m) {
  std::int32_t all = 0;
  for (int l = 0; l < kSingles; ++l) all |= m.bits[l];
  return all != 0;
}
inline Singles max(Singles a, Singles b) { return Singles(a.v > b.v ? a.v : b.v); }
inline Singles min(Singles a, Singles b) { return Singles(a.v < b.v ? a.v : b.v); }
inline Singles operator/(Singles a, Singles b) { return Singles(a.v / b.v); }
inline Singles sqrt(Singles a) {
#if defined(__AVX2__)
  return Singles(reinterpret_cast<SinglesData>(_mm256_sqrt_ps(reinterpret_cast<__m256>(a.v))));
#elif defined(__x86_64__)
  return Singles(reinterpret_cast<SinglesData>(_mm_sqrt_ps(reinterpret_cast<__m128>(a.v))));
#else
  Singles r;
  for (int i = 0; i < kSingles; ++i) r.v[i] = __builtin_sqrtf(a.v[i]);
  return r;
#endif
}
inline Singles rsqrt(Singles a) { return Singles(1.0) / sqrt(a); }
inline Singles rough_rsqrt(Singles a) { return rsqrt(a); }
inline Singles refined_rsqrt(Singles, Singles rough) { return rough; }
inline Singles quotient(Singles a, Singles b, Singles) { return a / b; }
inline Singles over_root(Singles k, Singles a) { return k / sqrt(a); }
#endif

inline Singles pow(Singles a, double n) {
  Singles r;
  for (int i = 0; i < kSingles; ++i) r.v[i] = static_cast<float>(__builtin_pow(static_cast<double>(a.v[i]), n));
  return r;
}
inline Singles log(Singles a) {
  Singles r;
  for (int i = 0; i < kSingles; ++i) r.v[i] = __builtin_logf(a.v[i]);
  return r;
}

/// Two packs of doubles, rounded, as one of floats.
inline Singles join(Doubles low, Doubles high) {
#if defined(__AVX512F__)
  const __m256 a = _mm512_maskz_cvtpd_ps(0xFF, __m512d(low.v)), b = _mm512_maskz_cvtpd_ps(0xFF, __m512d(high.v));
  return Singles(SinglesData(_mm512_maskz_insertf32x8(0xFFFF, _mm512_zextps256_ps512(a), b, 1)));
#elif defined(__AVX2__)
  const __m128 a = _mm256_cvtpd_ps(__m256d(low.v)), b = _mm256_cvtpd_ps(__m256d(high.v));
  return Singles(SinglesData(_mm256_insertf128_ps(_mm256_castps128_ps256(a), b, 1)));
#else
  Singles r;
  for (int l = 0; l < kDoubles; ++l) {
    r.v[l] = static_cast<float>(low.v[l]);
    r.v[l + kDoubles] = static_cast<float>(high.v[l]);
  }
  return r;
#endif
}

/// Halves of a pack, as doubles.
inline Doubles half_of(Singles p, int half) {
#if defined(__AVX512F__)
  const __m256 f = half == 0 ? _mm512_castps512_ps256(__m512(p.v)) : _mm512_maskz_extractf32x8_ps(0xFF, __m512(p.v), 1);
  return Doubles(DoublesData(_mm512_maskz_cvtps_pd(0xFF, f)));
#else
  Doubles r;
  for (int l = 0; l < kDoubles; ++l) r.v[l] = static_cast<double>(p.v[l + half * kDoubles]);
  return r;
#endif
}

/// kSingles floats of which the second half lies elsewhere when the pack is wider than a block.
template <>
inline Singles load_floats<Singles>(const float* from) {
  return load<Singles>(from);
}
inline void store_floats(Singles p, float* to) { store(p, to); }

#if defined(__AVX512F__)
inline Singles load_halves(const float* low, const float* high) {
  return Singles(SinglesData(
      _mm512_maskz_insertf32x8(0xFFFF, _mm512_zextps256_ps512(_mm256_loadu_ps(low)), _mm256_loadu_ps(high), 1)));
}
inline void store_halves(Singles p, float* low, float* high) {
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

/// Eight floats from each of kSingles rows, transposed: out[c] holds element c of every row.
#if !defined(__AVX512F__)
inline void load8(const float* const* row, Singles* out) {
#if defined(__AVX2__)
  for (int part = 0; part < 2; ++part) {
    __m256 in[4], columns[4];
    for (int k = 0; k < 4; ++k)
      in[k] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(row[k] + 4 * part)),
                                   _mm_loadu_ps(row[k + 4] + 4 * part), 1);
    transpose4(in, columns);
    for (int c = 0; c < 4; ++c) out[4 * part + c] = Singles(SinglesData(columns[c]));
  }
#else
  for (int c = 0; c < 8; ++c) {
    SinglesData column{};
    for (int l = 0; l < kSingles; ++l) column[l] = row[l][c];
    out[c] = Singles(column);
  }
#endif
}
#endif

/// Likewise of rows that come in two halves: their addresses need not stay in registers until the others are known.
class EightColumns {
 public:
  /// @param row kDoubles of them
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
    for (int k = 0; k < kDoubles; ++k) row_[half * kDoubles + k] = row[k];
#endif
  }
  [[gnu::always_inline]] void give(Singles* out) const {
#if defined(__AVX512F__)
    for (int c = 0; c < 4; ++c) {
      out[c] = Singles(SinglesData(_mm512_maskz_shuffle_f32x4(0xFFFF, half_[0][c], half_[1][c], 0x88)));
      out[c + 4] = Singles(SinglesData(_mm512_maskz_shuffle_f32x4(0xFFFF, half_[0][c], half_[1][c], 0xDD)));
    }
#else
    load8(row_, out);
#endif
  }

 private:
#if defined(__AVX512F__)
  __m512 half_[2][4];
#else
  const float* row_[kSingles];
#endif
};
#if defined(__AVX512F__)
inline void load8(const float* const* row, Singles* out) {
  EightColumns columns;
  columns.take(0, row), columns.take(1, row + kDoubles);
  columns.give(out);
}
#endif

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
