#pragma once
#include <array>
#include <vector>

#include "libdem/geometry/triangle_mesh.hpp"
#include "libdem/particles/periodic.hpp"

/// Surfaces that span a periodic bed reach beyond its sides, and meet its spheres within them.
namespace subsoil::dem {

/// What of a convex polygon (corners in m) lies in the cell, in those of its periodic directions that are wanted.
std::vector<Vec3> within(std::vector<Vec3> polygon, const PeriodicCell& cell,
                         const std::array<bool, 3>& wanted = {true, true, true});

/// The periodic directions in which a box, in m, reaches from one side of the cell to the other.
std::array<bool, 3> spanned(const Bounds& box, const PeriodicCell& cell);

/// The area of each triangle that spheres can meet, m2: of a mesh that spans the cell what lies in it, else all.
/// @param mesh in the axes of the world
std::vector<double> areas_met(const TriangleMesh& mesh, const PeriodicCell& cell);

}  // namespace subsoil::dem
