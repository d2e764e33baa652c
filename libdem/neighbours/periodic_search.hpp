#pragma once
#include <span>

#include "libdem/geometry/bounds.hpp"
#include "libdem/neighbours/grid.hpp"
#include "libdem/neighbours/neighbour_list.hpp"
#include "libdem/particles/periodic.hpp"

namespace subsoil::dem {

/// Adds the pairs across periodic sides to a list of neighbours, each once: of two spheres that meet across a side the
/// one at its upper end is the first particle, an image of the other, one period up, the second. Where several
/// directions are periodic images are shifted in half of all combinations of them, those whose first shift is upwards.
/// @param spheres wrapped into the cell and sorted by the cells of `grid` @param box of their centres
/// @param `largest` radius, m @param cutoff as of `find_neighbours`
/// @return the images that some sphere is near to, in the order of shifts and spheres
PeriodicImages add_pairs_across(std::span<const Sphere> spheres, const Grid& grid, const Bounds& box,
                                const PeriodicCell& cell, double largest, double cutoff, NeighbourList& list);

/// Throws std::invalid_argument for a period in which a sphere could meet another one from both sides: less than twice
/// the distance `reach`, m, up to which pairs are listed.
void require_period(const PeriodicCell& cell, double reach);
/// And for one in which a clump could meet itself: less than `least`, m.
void require_period_of_clumps(const PeriodicCell& cell, double least);

/// The longest skin, from `least` to `usual`, with which no sphere of that range (two radii and the range of the law)
/// is listed from both sides of a period, and no clump, whose centres are `widest` apart, beside itself; `least` where
/// none fits.
double skin_within_period(const PeriodicCell& cell, double range, double widest, double least, double usual);

}  // namespace subsoil::dem
