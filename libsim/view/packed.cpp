#include "libsim/view/packed.hpp"

#include "libsim/base/deflate.hpp"

namespace subsoil::sim {

std::string packed(std::span<const unsigned char> bytes) {
  const std::vector<unsigned char> zipped = deflated(bytes, 6);
  const std::size_t size = zipped.size();
  static constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(size / 3 * 4 + 4);
  for (std::size_t i = 0; i < size; i += 3) {
    const unsigned a = zipped[i], b = i + 1 < size ? zipped[i + 1] : 0U, c = i + 2 < size ? zipped[i + 2] : 0U;
    const unsigned word = a << 16U | b << 8U | c;
    text += letters[word >> 18U];
    text += letters[word >> 12U & 63U];
    text += i + 1 < size ? letters[word >> 6U & 63U] : '=';
    text += i + 2 < size ? letters[word & 63U] : '=';
  }
  return text;
}

}  // namespace subsoil::sim
