#pragma once
#include <cstdint>
#include <type_traits>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

/// A SIMD vector of doubles or floats for the sweep: the number type that laws are instantiated with. GCC vector
/// extensions carry the arithmetic, so one source serves SSE2, AVX2 and AVX-512 by the flags it is compiled with
/// (kernels are compiled once per instruction set, each in its own inline namespace, so no two sets share a symbol).
/// vec_d.hpp and vec_f.hpp have what the two do in different ways.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

#if defined(__AVX512F__)
inline constexpr int kLanesD = 8;
#elif defined(__AVX2__)
inline constexpr int kLanesD = 4;
#else
inline constexpr int kLanesD = 2;
#endif
inline constexpr int kLanesF = 2 * kLanesD;

template <class R, int N>
struct VecMask {
#if defined(__AVX512F__)
  /// A mask register: GCC 12 keeps comparisons of its own vectors as vectors and pays for both conversions.
  using Bits = std::conditional_t<N == 8, __mmask8, __mmask16>;
#else
  using Lane = std::conditional_t<sizeof(R) == 8, std::int64_t, std::int32_t>;
  typedef Lane Bits __attribute__((vector_size(sizeof(R) * N)));
#endif
  Bits bits;

  friend VecMask both(VecMask a, VecMask b) { return {static_cast<Bits>(a.bits & b.bits)}; }
  friend bool any(VecMask m) {
#if defined(__AVX512F__)
    return m.bits != 0;
#else
    Lane all = 0;
    for (int l = 0; l < N; ++l) all |= m.bits[l];
    return all != 0;
#endif
  }
};

template <class R, int N>
struct Vec {
  using Real = R;
  using Mask = VecMask<R, N>;
  typedef R Data __attribute__((vector_size(sizeof(R) * N)));
  static constexpr int kLanes = N;
  Data v;

  Vec() = default;
  Vec(double s) : v(static_cast<R>(s) - Data{}) {}  // s - 0 is s, which + 0 is not: the compiler leaves it out
  explicit Vec(Data d) : v(d) {}

  friend Vec operator+(Vec a, Vec b) { return Vec(a.v + b.v); }
  friend Vec operator-(Vec a, Vec b) { return Vec(a.v - b.v); }
  friend Vec operator*(Vec a, Vec b) { return Vec(a.v * b.v); }
  friend Vec operator-(Vec a) { return Vec(-a.v); }
  Vec& operator+=(Vec b) { return *this = *this + b; }
  friend void store(Vec p, R* to) { __builtin_memcpy(to, &p.v, sizeof p.v); }

#if defined(__AVX512F__)
  friend Mask operator>(Vec a, Vec b) {
    if constexpr (sizeof(R) == 8)
      return {_mm512_cmp_pd_mask(__m512d(a.v), __m512d(b.v), _CMP_GT_OQ)};
    else
      return {_mm512_cmp_ps_mask(__m512(a.v), __m512(b.v), _CMP_GT_OQ)};
  }
  friend Mask operator>=(Vec a, Vec b) {
    if constexpr (sizeof(R) == 8)
      return {_mm512_cmp_pd_mask(__m512d(a.v), __m512d(b.v), _CMP_GE_OQ)};
    else
      return {_mm512_cmp_ps_mask(__m512(a.v), __m512(b.v), _CMP_GE_OQ)};
  }
#else
  friend Mask operator>(Vec a, Vec b) { return {a.v > b.v}; }
  friend Mask operator>=(Vec a, Vec b) { return {a.v >= b.v}; }
  friend Vec select(Mask m, Vec a, Vec b) { return Vec(m.bits ? a.v : b.v); }
  friend Vec max(Vec a, Vec b) { return Vec(a.v > b.v ? a.v : b.v); }
  friend Vec min(Vec a, Vec b) { return Vec(a.v < b.v ? a.v : b.v); }
  friend Vec operator/(Vec a, Vec b) { return Vec(a.v / b.v); }
  friend Vec rsqrt(Vec a) { return Vec(1.0) / sqrt(a); }
  friend Vec over_root(Vec k, Vec a) { return k / sqrt(a); }
#endif

  /// Lane by lane: see power() in number.hpp.
  friend Vec pow(Vec a, double n) {
    Vec r;
    for (int i = 0; i < N; ++i) r.v[i] = static_cast<R>(__builtin_pow(static_cast<double>(a.v[i]), n));
    return r;
  }
  friend Vec log(Vec a) {
    Vec r;
    for (int i = 0; i < N; ++i) {
      if constexpr (sizeof(R) == 8)
        r.v[i] = __builtin_log(a.v[i]);
      else
        r.v[i] = __builtin_logf(a.v[i]);
    }
    return r;
  }
};

template <class P>
P load(const typename P::Real* from) {
  P p;
  __builtin_memcpy(&p.v, from, sizeof p.v);
  return p;
}

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
