#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/geometry/bounds.hpp"
#include "libdem/particles/particles.hpp"
#include "libdem/particles/periodic.hpp"

/// What a bed is like, from the places of its spheres alone: always reported, since packing decides the draft.
namespace subsoil::dem {

/// Columns of four mean radii of the free spheres across (of all, where none is free) stand on the region's floor; each
/// takes the spheres whose centres it holds. Its height is its highest sphere's top (that of the floor where it is
/// empty); the surface is the mean of the columns, its spread their standard deviation.
struct SurfaceHeight {
  double mean = 0, spread = 0;     ///< m, world y
  double lowest = 0, highest = 0;  ///< m
};
SurfaceHeight surface_height(std::span<const Sphere> spheres, const Bounds& region);
/// The same with columns of a width of one's own (m).
SurfaceHeight surface_height(std::span<const Sphere> spheres, const Bounds& region, double across);
/// The same for the part of the region with x in [from, to].
SurfaceHeight surface_height(std::span<const Sphere> spheres, Bounds region, double x_from, double x_to);

/// Top of the highest sphere (m, world y), or `otherwise` where that is higher.
double highest_top(std::span<const Sphere> spheres, double otherwise);

/// Mass per volume in the middle of the bed, kg/m3, fixed spheres counted by their matter: sum of m W(x) over the
/// integral of W, W a product of one weight per direction, between the region's sides (floor and mean surface in y):
///   6 mean diameters and more   a window sin^2(pi s), s in [0, 1], which leaves out one mean diameter at either side.
///                               A box with hard faces lost: which lattice planes fall inside decides percents. Through
///                               n pitches a lattice shows its density m/pitch^3 within 2/(pi n (n^2 - 1)), here 1.1 %
///   4 to 6                      the mean of that window over the sphere's volume: of centres alone a lattice of
///                               2 pitches would lose 3 % or gain it
///   narrower                    what of the sphere's volume lies between the sides: there is no middle, so the looser
///                               layers at walls, floor and surface count, too
///   a period of the cell        1: mass per period
double bulk_density(std::span<const Sphere> spheres, const Bounds& region, const PeriodicCell& cell = {});
double bulk_density(const Bed& bed, const Bounds& region);

/// Mean number of spheres that touch a free sphere (overlap above zero), walls not counted; across periodic sides, too.
double coordination_number(std::span<const Sphere> spheres, const PeriodicCell& cell = {});

inline constexpr std::uint32_t kAllSpheres = std::numeric_limits<std::uint32_t>::max();
/// Those with lower numbers.
std::vector<Sphere> spheres_below(std::span<const Sphere> spheres, std::uint32_t below);

struct BedReport {
  std::size_t spheres = 0;
  double mass = 0;          ///< kg, of all, fixed ones too
  double bulk_density = 0;  ///< kg/m3
  SurfaceHeight surface;
  double coordination = 0;
};
BedReport report(std::span<const Sphere> spheres, const Bounds& region, const PeriodicCell& cell = {});
/// Of a bed with clumps: `spheres` counts their members, contacts between these are left out, and the mass of a clump
/// lies where its members are. Of spheres with numbers below `below` only: what was laid on the bed has higher ones.
BedReport report(const Bed& bed, const Bounds& region, std::uint32_t below = kAllSpheres);

double mean_radius(std::span<const Sphere> spheres);  ///< m; 0 of none

/// That all of them fill, surfaces included.
Bounds box_of(std::span<const Sphere> spheres);

}  // namespace subsoil::dem
