#pragma once
#include <algorithm>
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

/// Numbers that a contact may keep for its law at most.
inline constexpr int kOwnMemory = 2;

/// Numbers that each contact of a law keeps: `static constexpr int memory` of laws that need any.
template <class L>
constexpr int own_memory() {
  if constexpr (requires { L::memory; }) {
    static_assert(L::memory <= kOwnMemory);
    return L::memory;
  } else {
    return 0;
  }
}

/// The law's normal force; `own` holds the contact's numbers, in and out (one that is not used where there are none).
template <class L, class T, int Numbers>
[[gnu::always_inline]] inline NormalForce<T> normal_force(const L& law, const Approach<T>& a, T (&own)[Numbers]) {
  static_assert(Numbers >= own_memory<L>());
  if constexpr (own_memory<L>() == 0) {
    return law.normal(a);
  } else if constexpr (own_memory<L>() == Numbers) {
    return law.normal(a, own);
  } else {
    T mine[own_memory<L>()];
    std::copy_n(own, own_memory<L>(), mine);
    const NormalForce<T> out = law.normal(a, mine);
    std::copy_n(mine, own_memory<L>(), own);
    return out;
  }
}

/// Whether a law has a rolling spring or torque.
inline bool rolls(const Law& law) {
  return std::visit([](const auto& l) { return l.friction.resists_rolling(); }, law);
}

}  // namespace subsoil::dem
