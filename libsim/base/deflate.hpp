#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

namespace subsoil::sim {

/// zlib stream (RFC 1950) of `bytes`; level 0 (stored) to 12. Throws std::bad_alloc.
std::vector<unsigned char> deflated(std::span<const unsigned char> bytes, int level);

/// Likewise of planes: first bytes of all numbers, second bytes of all, and so on. Of rounded numbers the first planes
/// are zeros, or noise, on which deflate spends nine tenths of its time and gains an eighth at most. Up to the first
/// plane that has other content these are written as zeros and as stored blocks, and the level is for the rest.
/// Levels above 4, of those who want few bytes at any price, deflate all.
/// @param plane bytes of each; the stream of the same bytes is the same for any machine and number of threads
std::vector<unsigned char> deflated_planes(std::span<const unsigned char> bytes, std::size_t plane, int level);

/// CRC-32 of `bytes` (that of gzip and PNG), which continues that of the bytes before.
std::uint32_t crc32(std::span<const unsigned char> bytes, std::uint32_t before = 0);
/// Of the first `length` bytes of a file, or of all.
std::uint32_t crc32_of_file(const std::filesystem::path& file,
                            std::uint64_t length = std::numeric_limits<std::uint64_t>::max());

/// The bytes of a text.
inline std::span<const unsigned char> bytes_of(std::string_view text) {
  return {reinterpret_cast<const unsigned char*>(text.data()), text.size()};
}

}  // namespace subsoil::sim
