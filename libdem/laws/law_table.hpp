#pragma once
#include <vector>

#include "libdem/laws/laws.hpp"

namespace subsoil::dem {

/// Energy that contacts lost, J.
struct Losses {
  double damping = 0;  ///< normal and tangential dashpots
  double sliding = 0;
  double rolling = 0;  ///< rolling spring at its limit and its dashpot

  Losses& operator+=(const Losses& b) {
    return damping += b.damping, sliding += b.sliding, rolling += b.rolling, *this;
  }
};

/// The laws of all pairs of materials, by index; `of(a, b)` is symmetric.
struct LawTable {
  int materials = 0;
  std::vector<int> index;  ///< materials x materials -> entry of laws, -1: none given
  std::vector<Law> laws;   ///< resolved() ones
  int of(int a, int b) const { return index[static_cast<std::size_t>(a * materials + b)]; }
};

/// Whether a law has a rolling spring or torque.
inline bool rolls(const Law& law) {
  return std::visit([](const auto& l) { return l.friction.resists_rolling(); }, law);
}

}  // namespace subsoil::dem
