#pragma once
#include "libdem/geometry/boundary.hpp"
#include "libdem/particles/periodic.hpp"

namespace subsoil::sim {

/// Area that a surface shows along a unit vector, m^2: that of its shadow, of a cylinder that of the round one. What
/// lies beyond periodic sides meets no spheres and does not count.
double shown_area(const dem::Boundary& boundary, const Vec3& along, const dem::PeriodicCell& cell);

}  // namespace subsoil::sim
