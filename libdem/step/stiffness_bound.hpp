#pragma once
#include "libdem/laws/contact.hpp"
#include "libdem/laws/law_table.hpp"

namespace subsoil::dem {

/// Bounds of a law with the rolling part and bonds filled in.
/// @param i_roll series of both bodies' moments against rolling, kg m2 @param arm of tangential forces, m, out
StiffnessBound stiffness_bound(const Law& law, const WorstContact& worst, double i_roll, bool between_spheres,
                               double& arm);

}  // namespace subsoil::dem
