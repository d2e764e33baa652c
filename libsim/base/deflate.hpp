#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace subsoil::sim {

/// zlib stream (RFC 1950) of `bytes`; level 0 (stored) to 12. Throws std::bad_alloc.
std::vector<unsigned char> deflated(std::span<const unsigned char> bytes, int level);

/// CRC-32 of `bytes` (that of gzip and PNG), which continues that of the bytes before.
std::uint32_t crc32(std::span<const unsigned char> bytes, std::uint32_t before = 0);

/// The bytes of a text.
inline std::span<const unsigned char> bytes_of(std::string_view text) {
  return {reinterpret_cast<const unsigned char*>(text.data()), text.size()};
}

}  // namespace subsoil::sim
