#include "libdem/contacts/lane_copy.hpp"

#include <algorithm>
#include <cstring>

namespace subsoil::dem {

LaneCopy::LaneCopy(const MemoryShape& shape) : single_(shape.single) {
  PairState ones;
  const auto set = [](auto& number, int) { number = 1; };
  each_field(shape, ones, set, set);
  PairState turned = ones.turned_over();
  each_field(
      shape, turned, [&](double number, int) { turns_state_[states_++] = number < 0; },
      [&](float number, int) { turns_diagnostic_[diagnostics_++] = number < 0; });
}

namespace {

/// Of each lane whether a number is there, of which -0 is none: as the bits of all without their signs.
template <class Word>
void gather(const unsigned char* from, std::size_t numbers, std::uint64_t* lanes) {
  Word any[kBlock] = {};
  for (std::size_t k = 0; k < numbers; ++k) {
    Word of_field[kBlock];
    std::memcpy(of_field, from + k * sizeof of_field, sizeof of_field);
    for (std::size_t l = 0; l < kBlock; ++l) any[l] |= of_field[l];
  }
  for (std::size_t l = 0; l < kBlock; ++l) lanes[l] |= static_cast<Word>(any[l] << 1);
}

}  // namespace

std::uint32_t LaneCopy::filled(const BlockMemory& block, std::uint32_t lanes) const {
  std::uint64_t found[kBlock] = {};
  single_ ? gather<std::uint32_t>(block.states, states_, found) : gather<std::uint64_t>(block.states, states_, found);
  gather<std::uint32_t>(block.diagnostics, diagnostics_, found);
  std::uint64_t any = 0;
  for (const std::uint64_t lane : found) any |= lane;
  if (any == 0) return 0;  // most blocks of candidates
  std::uint32_t out = 0;
  for (std::uint32_t l = 0; l < lanes; ++l) out |= static_cast<std::uint32_t>(found[l] != 0) << l;
  return out;
}

template <class Word>
void LaneCopy::copy_as(const BlockMemory& from, std::uint32_t lane, const BlockMemory& to, std::uint32_t to_lane,
                       bool turned_over) const {
  const auto move = [&](const unsigned char* a, unsigned char* b, std::size_t numbers, const auto& turns, auto word) {
    constexpr std::size_t bytes = sizeof word;
    constexpr auto sign = static_cast<decltype(word)>(decltype(word){1} << (8 * bytes - 1));
    a += lane * bytes, b += to_lane * bytes;
    for (std::size_t k = 0; k < numbers; ++k, a += kBlock * bytes, b += kBlock * bytes) {
      std::memcpy(&word, a, bytes);
      if (turned_over && turns[k]) word ^= sign;
      std::memcpy(b, &word, bytes);
    }
  };
  move(from.states, to.states, states_, turns_state_, Word{});
  move(from.diagnostics, to.diagnostics, diagnostics_, turns_diagnostic_, std::uint32_t{});
}

template void LaneCopy::copy_as<std::uint32_t>(const BlockMemory&, std::uint32_t, const BlockMemory&, std::uint32_t,
                                               bool) const;
template void LaneCopy::copy_as<std::uint64_t>(const BlockMemory&, std::uint32_t, const BlockMemory&, std::uint32_t,
                                               bool) const;

}  // namespace subsoil::dem
