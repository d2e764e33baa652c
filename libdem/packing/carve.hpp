#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "libdem/bed.hpp"

/// Spheres where a machine stands: refused or removed before a run.
namespace subsoil::dem {

/// Whether the sphere overlaps the surface (distance below its radius plus `clearance`, m) or its centre is inside a
/// closed body, however deep.
bool inside_or_overlapping(const Sphere& sphere, const Boundary& boundary, double clearance = 0);

/// Ids of the spheres for which that holds with any of the boundaries, ascending.
std::vector<std::uint32_t> spheres_in_the_way(const Bed& bed, std::span<const int> boundaries, double clearance = 0);

/// Takes them out; returns how many. Name tools only: a bed overlaps the walls that it lies against.
std::size_t carve(Bed& bed, std::span<const int> boundaries, double clearance = 0);

}  // namespace subsoil::dem
