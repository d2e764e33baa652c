#pragma once
#include <zlib.h>

#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace subsoil::sim::test {

/// Bytes of a text in base64 that holds a zlib stream, as a page reads them.
inline std::vector<unsigned char> unpacked(const std::string& text) {
  std::vector<unsigned char> zipped;
  unsigned word = 0;
  int bits = 0;
  for (const char c : text) {
    static const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    if (c == '=') break;
    const std::size_t value = letters.find(c);
    if (value == std::string::npos) throw std::runtime_error("no base64");
    word = word << 6U | static_cast<unsigned>(value), bits += 6;
    if (bits >= 8) bits -= 8, zipped.push_back(static_cast<unsigned char>(word >> static_cast<unsigned>(bits) & 255U));
  }
  for (std::vector<unsigned char> out(1U << 16U);; out.resize(2 * out.size())) {
    uLongf size = out.size();
    const int result = uncompress(out.data(), &size, zipped.data(), zipped.size());
    if (result == Z_BUF_ERROR) continue;
    if (result != Z_OK) throw std::runtime_error("no zlib stream");
    out.resize(size);
    return out;
  }
}

template <class T>
std::vector<T> unpacked_numbers(const std::string& text) {
  const std::vector<unsigned char> bytes = unpacked(text);
  std::vector<T> out(bytes.size() / sizeof(T));
  std::memcpy(out.data(), bytes.data(), out.size() * sizeof(T));
  return out;
}

}  // namespace subsoil::sim::test
