#pragma once
#include <cstdint>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

/// A pack of W doubles for the sweep: the number type that laws are instantiated with.
/// GCC vector extensions carry the arithmetic, so one source serves SSE2, AVX2 and AVX-512 by the flags it is compiled
/// with (kernel.cpp is compiled once per instruction set, each in its own inline namespace, so no two sets share a symbol).
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
using PackFloats = float __attribute__((vector_size(4 * kWidth)));
using PackBits = std::int64_t __attribute__((vector_size(8 * kWidth)));

struct PackMask {
  PackBits bits;
};

struct Pack {
  PackData v;

  Pack() = default;
  Pack(double s) : v(PackData{} + s) {}
  explicit Pack(PackData d) : v(d) {}
  static Pack load(const double* p) { return Pack(*reinterpret_cast<const PackData*>(p)); }
  static Pack load(const float* p) {
    return Pack(__builtin_convertvector(*reinterpret_cast<const PackFloats*>(p), PackData));
  }
  void store(float* p) const { *reinterpret_cast<PackFloats*>(p) = __builtin_convertvector(v, PackFloats); }
  void store(double* p) const { *reinterpret_cast<PackData*>(p) = v; }

  friend Pack operator+(Pack a, Pack b) { return Pack(a.v + b.v); }
  friend Pack operator-(Pack a, Pack b) { return Pack(a.v - b.v); }
  friend Pack operator*(Pack a, Pack b) { return Pack(a.v * b.v); }
  friend Pack operator/(Pack a, Pack b) { return Pack(a.v / b.v); }
  friend Pack operator-(Pack a) { return Pack(-a.v); }
  friend PackMask operator>(Pack a, Pack b) { return {a.v > b.v}; }
  friend PackMask operator>=(Pack a, Pack b) { return {a.v >= b.v}; }
  friend PackMask operator==(Pack a, Pack b) { return {a.v == b.v}; }
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

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
