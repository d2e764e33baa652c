#include "libsim/base/deflate.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <new>
#include <utility>

namespace subsoil::sim {

namespace {

using Bytes = std::span<const unsigned char>;

class Compressor {
 public:
  explicit Compressor(int level) : it_(libdeflate_alloc_compressor(level), libdeflate_free_compressor) {
    if (!it_) throw std::bad_alloc();
  }
  operator libdeflate_compressor*() const { return it_.get(); }  // NOLINT: every call takes one

 private:
  std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> it_;
};

/// A zlib stream block by block (RFC 1951).
class BlockStream {
 public:
  BlockStream() : out_{0x78, 0x5e} {}  // deflate, window of 32 kB, no dictionary

  /// Fixed codes: a zero, then copies of what is one byte back.
  void zeros(std::size_t count) {
    constexpr std::size_t longest = 258, ten = 10;
    put_bits(0b010, 3);  // not the last block; fixed codes
    if (count > 0) zero(), --count;
    for (; count >= longest; count -= longest) put_code(0b11000101, 8), put_code(0, 5);
    for (; count >= ten; count -= ten) put_code(0b0001000, 7), put_code(0, 5);
    for (; count > 0; --count) zero();
    put_code(0, 7);  // end of the block
  }
  void stored(Bytes bytes) {
    constexpr std::size_t most = 65535;
    for (std::size_t at = 0; at < bytes.size(); at += most) {
      const Bytes part = bytes.subspan(at, std::min(most, bytes.size() - at));
      put_bits(0b000, 3);
      align();
      for (const std::size_t n : {part.size(), ~part.size()})
        out_.push_back(static_cast<unsigned char>(n)), out_.push_back(static_cast<unsigned char>(n >> 8));
      out_.insert(out_.end(), part.begin(), part.end());
    }
  }
  /// The last blocks, and the checksum of `all`.
  std::vector<unsigned char> end(Bytes rest, Bytes all, int level) {
    if (bits_ > 0) stored_nothing();
    const Compressor compressor(level);
    const std::size_t before = out_.size(), room = libdeflate_deflate_compress_bound(compressor, rest.size());
    out_.resize(before + room);
    out_.resize(before + libdeflate_deflate_compress(compressor, rest.data(), rest.size(), out_.data() + before, room));
    const std::uint32_t sum = libdeflate_adler32(1, all.data(), all.size());
    for (int shift = 24; shift >= 0; shift -= 8) out_.push_back(static_cast<unsigned char>(sum >> shift));
    return std::move(out_);
  }

 private:
  void zero() { put_code(0b00110000, 8); }
  /// A block without bytes ends at a whole one.
  void stored_nothing() {
    put_bits(0b000, 3);
    align();
    out_.insert(out_.end(), {0, 0, 0xff, 0xff});
  }
  void put_bits(std::uint32_t bits, int count) {
    for (int k = 0; k < count; ++k) {
      if (bits_ == 0) out_.push_back(0);
      out_.back() |= static_cast<unsigned char>((bits >> k & 1) << bits_);
      bits_ = (bits_ + 1) % 8;
    }
  }
  /// Codes lie with their first bit first.
  void put_code(std::uint32_t code, int length) {
    for (int k = length - 1; k >= 0; --k) put_bits(code >> k & 1, 1);
  }
  void align() { bits_ = 0; }

  std::vector<unsigned char> out_;
  int bits_ = 0;  ///< of the last byte that are taken; 0: all
};

/// Whether deflate hardly shortens the bytes, by a piece of them.
bool is_noise(Bytes plane) {
  constexpr std::size_t piece = 4096;
  constexpr double worth_it = 0.85;
  if (plane.size() < piece) return false;
  const Compressor compressor(1);
  std::array<unsigned char, piece> packed;  // what does not fit is noise
  const Bytes some = plane.subspan((plane.size() - piece) / 2, piece);
  const std::size_t bytes =
      libdeflate_deflate_compress(compressor, some.data(), some.size(), packed.data(), packed.size());
  return bytes == 0 || static_cast<double>(bytes) > worth_it * static_cast<double>(piece);
}

}  // namespace

std::vector<unsigned char> deflated(Bytes bytes, int level) {
  const Compressor compressor(level);
  std::vector<unsigned char> packed(libdeflate_zlib_compress_bound(compressor, bytes.size()));
  packed.resize(libdeflate_zlib_compress(compressor, bytes.data(), bytes.size(), packed.data(), packed.size()));
  return packed;
}

std::vector<unsigned char> deflated_planes(Bytes bytes, std::size_t plane, int level) {
  constexpr int fast = 4;
  if (level > fast) return deflated(bytes, level);
  BlockStream out;
  std::size_t at = 0;
  for (; at + plane < bytes.size(); at += plane) {
    const Bytes next = bytes.subspan(at, plane);
    if (std::all_of(next.begin(), next.end(), [](unsigned char b) { return b == 0; }))
      out.zeros(plane);
    else if (is_noise(next))
      out.stored(next);
    else
      break;
  }
  return out.end(bytes.subspan(at), bytes, level);
}

std::uint32_t crc32(std::span<const unsigned char> bytes, std::uint32_t before) {
  return libdeflate_crc32(before, bytes.data(), bytes.size());
}

std::uint32_t crc32_of_file(const std::filesystem::path& file, std::uint64_t length) {
  std::ifstream in(file, std::ios::binary);
  std::vector<char> block(1 << 16);
  std::uint32_t sum = 0;
  while (in && length > 0) {
    in.read(block.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(block.size(), length)));
    const auto count = static_cast<std::size_t>(in.gcount());
    sum = crc32(bytes_of({block.data(), count}), sum), length -= count;
  }
  return sum;
}

}  // namespace subsoil::sim
