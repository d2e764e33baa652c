#pragma once
#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// Maximum extent at the start of what forces between two points tie together, not by way of the ground: of their
/// points and of the bodies' centres of gravity (m); 0 without such forces. Contacts tie nothing: they may start at any
/// distance.
double extent_by_forces(const Model& model);

}  // namespace subsoil::mbd
