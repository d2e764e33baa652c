#pragma once
#include "libdem/laws/bond.hpp"

/// A law whose spheres may be bonded, as the sweep evaluates it. Users write the law and its `bond`; make_law() puts
/// this around laws that have one, so that the others carry neither its arithmetic nor its memory. At surfaces it is
/// the law alone: bonds join spheres with spheres.
namespace subsoil::dem {

template <class Normal>
struct Bonded : Normal {
  static constexpr bool bonds = true;
  double pair_cutoff(double largest_radius) const {
    return std::max(contact_cutoff(0.5 * largest_radius), this->bond.cutoff(largest_radius));
  }

 private:
  double contact_cutoff(double r_eff) const {
    if constexpr (Normal::has.cutoff_by_radius)
      return Normal::cutoff(r_eff);
    else
      return Normal::cutoff();
  }
};

/// Whether pairs of spheres of this law may be bonded.
template <class L>
inline constexpr bool kBonds = requires {
  L::bonds;
};

}  // namespace subsoil::dem
