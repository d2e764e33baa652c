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

/// a b + c with one rounding; with two where the set has no such instruction. T is a vector of GCC.
template <class T>
[[gnu::always_inline]] inline T multiply_add(const T& a, const T& b, const T& c) {
  [[maybe_unused]] constexpr bool doubles = sizeof a[0] == 8;
  if constexpr (false) {
    return a;
#if defined(__AVX512F__)
  } else if constexpr (sizeof(T) == 64 && doubles) {
    return T(_mm512_fmadd_pd(__m512d(a), __m512d(b), __m512d(c)));
  } else if constexpr (sizeof(T) == 64) {
    return T(_mm512_fmadd_ps(__m512(a), __m512(b), __m512(c)));
#endif
#if defined(__FMA__)
  } else if constexpr (sizeof(T) == 32 && doubles) {
    return T(_mm256_fmadd_pd(__m256d(a), __m256d(b), __m256d(c)));
  } else if constexpr (sizeof(T) == 32) {
    return T(_mm256_fmadd_ps(__m256(a), __m256(b), __m256(c)));
#endif
  } else {
    return a * b + c;
  }
}

/// c - a b, likewise: with the sign in the instruction. GCC takes it for one of a's uses only.
template <class T>
[[gnu::always_inline]] inline T take_product(const T& a, const T& b, const T& c) {
  [[maybe_unused]] constexpr bool doubles = sizeof a[0] == 8;
  if constexpr (false) {
    return a;
#if defined(__AVX512F__)
  } else if constexpr (sizeof(T) == 64 && doubles) {
    return T(_mm512_fnmadd_pd(__m512d(a), __m512d(b), __m512d(c)));
  } else if constexpr (sizeof(T) == 64) {
    return T(_mm512_fnmadd_ps(__m512(a), __m512(b), __m512(c)));
#endif
#if defined(__FMA__)
  } else if constexpr (sizeof(T) == 32 && doubles) {
    return T(_mm256_fnmadd_pd(__m256d(a), __m256d(b), __m256d(c)));
  } else if constexpr (sizeof(T) == 32) {
    return T(_mm256_fnmadd_ps(__m256(a), __m256(b), __m256(c)));
#endif
  } else {
    return -a * b + c;
  }
}

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
#elif defined(__AVX2__)
    if constexpr (sizeof(R) == 8)
      return _mm256_movemask_pd(__m256d(m.bits)) != 0;
    else
      return _mm256_movemask_ps(__m256(m.bits)) != 0;
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

  /// a b, not rounded yet: what it is added to or taken from takes it with one rounding where the set has such an
  /// instruction. The compiler fuses nothing by itself (-ffp-contract=off): which of two multiplications it takes
  /// depends on the code around, and loops that differ in what they record would differ in the last bits.
  struct Product {
    Data a, b;
  };

  Vec() = default;
  Vec(double s) : v(static_cast<R>(s) - Data{}) {}  // s - 0 is s, which + 0 is not: the compiler leaves it out
  explicit Vec(Data d) : v(d) {}
  Vec(Product p) : v(p.a * p.b) {}

  friend Vec operator+(Vec a, Vec b) { return Vec(a.v + b.v); }
  friend Vec operator-(Vec a, Vec b) { return Vec(a.v - b.v); }
  friend Product operator*(Vec a, Vec b) { return {a.v, b.v}; }
  friend Vec operator-(Vec a) { return Vec(-a.v); }
  friend Vec operator+(Product p, Vec c) { return Vec(multiply_add(p.a, p.b, c.v)); }
  friend Vec operator+(Vec c, Product p) { return Vec(multiply_add(p.a, p.b, c.v)); }
  friend Vec operator-(Product p, Vec c) { return Vec(multiply_add(p.a, p.b, -c.v)); }
  friend Vec operator-(Vec c, Product p) { return Vec(take_product(p.a, p.b, c.v)); }
  friend Vec operator+(Product p, Product q) { return Vec(multiply_add(p.a, p.b, q.a * q.b)); }
  friend Vec operator-(Product p, Product q) { return Vec(multiply_add(p.a, p.b, -(q.a * q.b))); }
  friend Product operator-(Product p) { return {-p.a, p.b}; }
  Vec& operator+=(Vec b) { return *this = *this + b; }
  Vec& operator+=(Product p) { return *this = *this + p; }
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
  friend Vec max(Vec a, Vec b) {
#if defined(__AVX2__)  // GCC compares and masks where one of them is 0
    if constexpr (sizeof(R) == 8)
      return Vec(Data(_mm256_max_pd(__m256d(a.v), __m256d(b.v))));
    else
      return Vec(Data(_mm256_max_ps(__m256(a.v), __m256(b.v))));
#else
    return Vec(a.v > b.v ? a.v : b.v);
#endif
  }
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
