#pragma once

#include <algorithm>
#include <vector>

#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// A redundant equation, Phi_q,row = sum of w_i Phi_q,i: any share x of the load may go through it, x w_i less then
/// through each of the others. The multipliers of all of them are not determined, all others are.
struct Dependency {
  int row = -1;
  std::vector<int> on;  ///< independent equations with w_i not zero
  bool has(int equation) const { return row == equation || std::find(on.begin(), on.end(), equation) != on.end(); }
  bool operator==(const Dependency&) const = default;
};

/// Which equations and coordinates a partition works with.
struct Choice {
  std::vector<int> rows;                 ///< independent equations, in the order in which they were eliminated
  std::vector<int> dependent;            ///< the coordinate that each of them was solved for
  std::vector<int> redundant;            ///< equations that depend on those, ascending
  std::vector<int> independent;          ///< all other coordinates, ascending
  std::vector<Dependency> dependencies;  ///< of the redundant equations whose joints are not open
  bool operator==(const Choice&) const = default;
};

/// Gaussian elimination of the scaled Phi_q, equation by equation from the ground outwards, each pivoting on a column.
/// Among the entries above a fifth of the equation's maximum remaining one the pivot is a translation before an angle:
/// angles then are independent, which never turns singular in an open chain, where any other choice does; and the body
/// farther from the ground, so that a tree has no fill. An equation that keeps less than 1e-9 of itself is redundant.
/// Where some are, those that keep little are left to the end, since others may hold the same and more: a linkage
/// beside its flat pose that is locked there is held by what locks it. Full pivoting, the textbook's choice, costs n^3
/// at 300 links and binds them all together.
Choice choose_coordinates(const System& system, const SparseConstraints& c);

}  // namespace subsoil::mbd
