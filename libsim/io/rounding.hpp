#pragma once
#include <bit>
#include <cmath>
#include <cstdint>

namespace subsoil::sim {

/// Nearest float with `bits` explicit mantissa bits (of 23): relative error at most 2^-(bits+1). The low bits become
/// zero, which is what makes shuffled bytes compress. Infinity and NaN stay what they are.
inline float round_mantissa(float x, int bits) {
  const auto word = std::bit_cast<std::uint32_t>(x);
  if ((word & 0x7f800000u) == 0x7f800000u) return x;
  const int dropped = 23 - bits;
  const std::uint32_t half = (1u << dropped) >> 1;
  return std::bit_cast<float>((word + half) & ~((1u << dropped) - 1u));
}

/// Maximum power of two up to x.
inline double power_of_two_below(double x) { return std::exp2(std::floor(std::log2(x))); }

}  // namespace subsoil::sim
