#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "libdem/contacts/contact_memory.hpp"

namespace subsoil::dem {

/// What contacts of one shape keep, from lane to lane as it lies there: a rebuild moves nearly all of it, and as
/// PairState on the way each would be 27 numbers, of which few laws have more than eight. Bonds are not part of it.
class LaneCopy {
 public:
  explicit LaneCopy(const MemoryShape& shape);
  /// The first lanes of a block that keep something (PairState::empty() of the others), as bits.
  std::uint32_t filled(const BlockMemory& block, std::uint32_t lanes) const;
  /// @param turned_over with i and j exchanged
  void copy(const BlockMemory& from, std::uint32_t lane, const BlockMemory& to, std::uint32_t to_lane,
            bool turned_over) const {
    single_ ? copy_as<std::uint32_t>(from, lane, to, to_lane, turned_over)
            : copy_as<std::uint64_t>(from, lane, to, to_lane, turned_over);
  }

 private:
  template <class Word>
  void copy_as(const BlockMemory& from, std::uint32_t lane, const BlockMemory& to, std::uint32_t to_lane,
               bool turned_over) const;

  static constexpr std::size_t kMost = sizeof(ContactMemory<char>);
  bool single_;
  std::size_t states_ = 0, diagnostics_ = 0;
  std::array<bool, kMost> turns_state_{}, turns_diagnostic_{};  ///< whether it changes its sign with i and j
};

}  // namespace subsoil::dem
