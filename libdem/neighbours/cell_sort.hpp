#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "libdem/geometry/bounds.hpp"
#include "libdem/neighbours/grid.hpp"
#include "libdem/particles/particles.hpp"

namespace subsoil::dem {

/// Radius up to which spheres share the grid of cells. A few large ones among many small would make cells that hold
/// hundreds each; up to one in fifty, and no more than can be tried all with all, look for their neighbours themselves.
double radius_that_fits(std::span<const Sphere> spheres, double smallest, double largest);

/// Lays out the grid over the box of the centres and sorts the spheres by its cells: a stable counting sort.
/// @param edge of a cell, m; made longer where cells would be far more than spheres
/// @param cache_blocks into which a wide bed is cut (Grid); 0: by its size
/// @return for each new index the index before
std::vector<std::uint32_t> sort_by_cell(std::span<Sphere> spheres, double edge, const Bounds& box, int cache_blocks,
                                        int threads, Grid& grid);

}  // namespace subsoil::dem
