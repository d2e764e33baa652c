#pragma once

#include <vector>

#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// Maximum extent at the start of what forces between two points tie together, not by way of the ground: of their
/// points and of the bodies' centres of gravity (m); 0 without such forces. Contacts tie nothing: they may start at any
/// distance.
double extent_by_forces(const Model& model);

/// What joints hang together, the ground apart: a number that is the same for all bodies and joints of a chain. That of
/// joints which hold the ground alone is none.
struct Chains {
  std::vector<int> of_bodies, of_joints;  ///< bodies with the ground at 0
};
Chains chains_of(const Model& model);

/// Kinetic energy of all bodies at a ten-thousandth of the machine's length in a second, and their weights over 1e-10
/// of it, to which no tolerance holds a pose. A machine held at rest moves none, and one that begins to move has work
/// of the size of what the first steps, of low order, may err by: that is no share of anything.
double energy_at_rest(const System& system);

}  // namespace subsoil::mbd
