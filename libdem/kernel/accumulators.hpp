#pragma once
#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "libdem/contacts/blocks.hpp"

/// Sums that wait for spheres, which are double or float as the records of the spheres are.
namespace subsoil::dem {
inline namespace SUBSOIL_ISA {

[[gnu::always_inline]] inline Four doubles_of(const FourFloats& f) {
#if defined(__AVX2__)
  return _mm256_cvtps_pd(f);  // GCC 12 converts halves and puts them together
#else
  return __builtin_convertvector(f, Four);
#endif
}
[[gnu::always_inline]] inline Four doubles_of(const Four& f) { return f; }
[[gnu::always_inline]] inline FourFloats floats_of(const Four& f) {
#if defined(__AVX2__)
  return _mm256_cvtpd_ps(f);
#else
  return __builtin_convertvector(f, FourFloats);
#endif
}

inline Accumulator* sums_for(const Ring& ring, const Sphere*) { return ring.doubles; }
inline MixedAccumulator* sums_for(const Ring& ring, const MixedSphere*) { return ring.singles; }

inline void add(Accumulator& sum, const Four& f, const Four& t) { sum.f += f, sum.t += t; }
inline void add(MixedAccumulator& sum, const Four& f, const Four& t) { sum.f += floats_of(f), sum.t += floats_of(t); }

}  // namespace SUBSOIL_ISA
}  // namespace subsoil::dem
