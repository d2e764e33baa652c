#pragma once
#include <bit>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace subsoil::sim {

/// zlib, then base64: how bytes stand in a page.
std::string packed(std::span<const unsigned char> bytes);

/// Numbers as they lie in memory; pages read them as little-endian.
template <class T>
std::string packed_numbers(const std::vector<T>& numbers) {
  static_assert(std::endian::native == std::endian::little);
  return packed({reinterpret_cast<const unsigned char*>(numbers.data()), numbers.size() * sizeof(T)});
}

}  // namespace subsoil::sim
