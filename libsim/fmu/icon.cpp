#include "libsim/fmu/icon.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "libsim/base/deflate.hpp"

namespace subsoil::sim {
namespace {

constexpr int kSize = 128, kSamples = 3;  // pixels along a side; samples along a pixel, against stairs

using Colour = std::array<double, 4>;  // red, green, blue, opacity
constexpr Colour soil{0.62, 0.45, 0.28, 1}, rim{0.38, 0.26, 0.15, 1}, steel{0.24, 0.30, 0.37, 1},
    pin{0.95, 0.95, 0.95, 1};

double to_segment(double x, double y, std::array<double, 4> s) {
  const double dx = s[2] - s[0], dy = s[3] - s[1];
  const double share = std::clamp(((x - s[0]) * dx + (y - s[1]) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  return std::hypot(x - s[0] - share * dx, y - s[1] - share * dy);
}

/// x to the right and y down, in units of the side.
Colour colour_at(double x, double y, bool with_machine) {
  if (with_machine) {
    for (const auto& [px, py] : {std::pair{0.2, 0.14}, std::pair{0.56, 0.14}, std::pair{0.56, 0.36}})
      if (std::hypot(x - px, y - py) < 0.025) return pin;
    if (to_segment(x, y, {0.2, 0.14, 0.56, 0.14}) < 0.05 || to_segment(x, y, {0.2, 0.14, 0.56, 0.36}) < 0.04)
      return steel;
  }
  if (to_segment(x, y, {0.56, with_machine ? 0.14 : 0.06, 0.56, 0.5}) < 0.05) return steel;
  if (to_segment(x, y, {0.56, 0.5, 0.74, 0.74}) < 0.05) return steel;
  constexpr double radius = 0.085;
  for (int row = 0; row < 4; ++row) {
    const double cy = 0.56 + 0.147 * row, first = row % 2 == 0 ? 0.085 : 0.17;
    if (std::abs(y - cy) > radius) continue;
    for (double cx = first; cx < 1; cx += 0.17) {
      const double away = std::hypot(x - cx, y - cy);
      if (away < radius) return away < 0.8 * radius ? soil : rim;
    }
  }
  return {0, 0, 0, 0};
}

/// Scan lines of RGBA, each behind the byte of its filter, which is none.
std::string scan_lines(bool with_machine) {
  std::string out;
  for (int row = 0; row < kSize; ++row) {
    out += '\0';
    for (int column = 0; column < kSize; ++column) {
      Colour sum{};
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const double x = (column + (k % kSamples + 0.5) / kSamples) / kSize;
        const double y = (row + (k / kSamples + 0.5) / kSamples) / kSize;
        const Colour c = colour_at(x, y, with_machine);
        for (std::size_t d = 0; d < 3; ++d) sum[d] += c[3] * c[d];
        sum[3] += c[3];
      }
      const double covered = std::max(sum[3], 1.0);  // colours of what is covered alone
      for (std::size_t d = 0; d < 3; ++d) out += static_cast<char>(std::lround(255 * sum[d] / covered));
      out += static_cast<char>(std::lround(255 * sum[3] / (kSamples * kSamples)));
    }
  }
  return out;
}

void put_number(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift);
}

/// A chunk of PNG: length, type, data, checksum of type and data.
void put_chunk(std::string& out, const std::string& type, const std::string& data) {
  put_number(out, static_cast<std::uint32_t>(data.size()));
  const std::string checked = type + data;
  out += checked;
  put_number(out, crc32(bytes_of(checked)));
}

}  // namespace

std::string fmu_icon(bool with_machine) {
  const std::string lines = scan_lines(with_machine);
  const std::vector<unsigned char> packed = deflated(bytes_of(lines), 9);
  std::string out = "\x89PNG\r\n\x1a\n", head;
  put_number(head, kSize), put_number(head, kSize);
  head += {8, 6, 0, 0, 0};  // bits, RGBA, deflate, the one filter method, not interlaced
  put_chunk(out, "IHDR", head), put_chunk(out, "IDAT", {packed.begin(), packed.end()}), put_chunk(out, "IEND", "");
  return out;
}

}  // namespace subsoil::sim
