#pragma once
#include <cstddef>
#include <vector>

#include "libdem/laws/law.hpp"

namespace subsoil::dem {

/// Energy that contacts lost, J.
struct Losses {
  double damping = 0;  ///< normal and tangential dashpots
  double sliding = 0;
  double rolling = 0;   ///< rolling spring at its limit and its dashpot
  double yielding = 0;  ///< plastic bending of bonds; plastic work of contacts is in damping
  double breaking = 0;  ///< what bonds stored when they broke

  double total() const { return damping + sliding + rolling + yielding + breaking; }
  Losses& operator+=(const Losses& b) {
    damping += b.damping, sliding += b.sliding, rolling += b.rolling;
    yielding += b.yielding, breaking += b.breaking;
    return *this;
  }
};

/// The laws of all pairs of materials, by index; `of(a, b)` is symmetric.
struct LawTable {
  int materials = 0;
  std::vector<int> index;  ///< materials x materials -> entry of laws, -1: none given
  std::vector<Law> laws;
  int of(int a, int b) const { return index[static_cast<std::size_t>(a * materials + b)]; }
};

}  // namespace subsoil::dem
