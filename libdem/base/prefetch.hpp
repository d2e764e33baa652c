#pragma once
#include <cstddef>

namespace subsoil::dem {

/// Asks for the cache lines of an array while other work is done: for arrays too short or too scattered for the
/// processor to see them coming.
inline void prefetch(const void* from, std::size_t bytes = 1) {
  constexpr std::size_t line = 64;
  for (std::size_t at = 0; at < bytes; at += line) __builtin_prefetch(static_cast<const char*>(from) + at, 0, 2);
}

}  // namespace subsoil::dem
