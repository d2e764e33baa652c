#pragma once
#include <vector>

#include "libdem/laws/laws.hpp"

namespace subsoil::dem {

/// Energy that contacts lost, J.
struct Losses {
  double damping = 0;  ///< normal and tangential dashpots
  double sliding = 0;
  double rolling = 0;   ///< rolling spring at its limit and its dashpot
  double breaking = 0;  ///< what bonds held when they broke

  double total() const { return damping + sliding + rolling + breaking; }
  Losses& operator+=(const Losses& b) {
    return damping += b.damping, sliding += b.sliding, rolling += b.rolling, breaking += b.breaking, *this;
  }
};

/// The laws of all pairs of materials, by index; `of(a, b)` is symmetric.
struct LawTable {
  int materials = 0;
  std::vector<int> index;  ///< materials x materials -> entry of laws, -1: none given
  std::vector<Law> laws;   ///< resolved() ones
  int of(int a, int b) const { return index[static_cast<std::size_t>(a * materials + b)]; }
};

/// Whether a law has a rolling spring or torque, or needs for its bonds what those need.
template <class L>
bool rolls(const L& law) {
  return kBonds<L> || law.friction.resists_rolling();
}

/// The bond of a law whose spheres may be bonded; null for the others.
inline const Bond* bond_of(const Law& law) {
  return std::visit(
      []<class L>(const L& l) -> const Bond* {
        if constexpr (kBonds<L>)
          return &l.bond;
        else
          return nullptr;
      },
      law);
}

/// Largest gap across which a law acts without bonds, between bodies whose effective radius is r_eff at most, m: at
/// surfaces the spheres' own.
inline double reach_of(const Law& law, double r_eff) {
  return std::visit(
      [r_eff](const auto& l) {
        if constexpr (requires { l.reach(r_eff); })
          return l.reach(r_eff);
        else
          return l.reach();
      },
      law);
}

/// Largest gap across which a law acts between spheres up to a radius, m; of a pair r_eff is half of it at most.
inline double reach_between(const Law& law, double largest_radius) {
  return std::visit(
      [&]<class L>(const L& l) {
        if constexpr (kBonds<L>)
          return l.reach_between(largest_radius);
        else
          return reach_of(law, 0.5 * largest_radius);
      },
      law);
}

}  // namespace subsoil::dem
