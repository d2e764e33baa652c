#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/geometry/bounds.hpp"
#include "libdem/packing/sizes.hpp"
#include "libdem/particles/particles.hpp"

/// Where the spheres of a bed start. Regions are boxes along the axes, y up; the floor is the region's lower face.
namespace subsoil::dem {

/// What all spheres of a bed have in common.
struct BedMaterial {
  double density = 0;  ///< kg/m3
  int material = 0;    ///< index into the table of laws
};

/// Clumps among the grains of a bed: how many of all grains are of this shape.
struct ClumpPart {
  int shape = 0;      ///< index in the bed
  double share = 0;   ///< of the number of grains; what is left of 1 are spheres
  double reach = 0;   ///< radius of the sphere that holds it, m
  double volume = 0;  ///< m3
};
ClumpPart clump_part(const Bed& bed, int shape, double share);

/// The part that the next grain belongs to; null: it is a sphere. Without clumps no number is drawn.
const ClumpPart* draw_part(const std::vector<ClumpPart>& clumps, RandomNumbers& random);
/// Even over all attitudes (Shoemake 1992, Graphics Gems III).
Quaternion any_attitude(RandomNumbers& random);
/// Radius of the largest grain's bounding sphere, m. @param sizes of the spheres among them, if there are any
double largest_reach(const RadiusDistribution& sizes, const std::vector<ClumpPart>& clumps);

/// Spheres and clumps to be added to a bed.
struct Grains {
  std::vector<SphereSpec> spheres;
  std::vector<ClumpSpec> clumps;
  std::size_t count() const { return spheres.size() + clumps.size(); }
};
void add(Bed& bed, const Grains& grains);

/// Simple cubic lattice.
///
/// Per direction as many rows as stand free of the walls: n = 1 + floor((length - 2r)/pitch). Rows are centred in x and
/// z; the lowest layer is let into the floor by the floor's rest overlap, so that it does not start with a fall. Where
/// the region's sides are periodic there are no walls: rows continue beyond them, so that its length must be a whole
/// number of pitches.
struct LatticePlan {
  Bounds region;
  RadiusDistribution radius = EqualRadius{};
  ShareOf shares = ShareOf::number;
  double pitch = 0;                ///< m
  double floor_overlap = 0;        ///< rest overlap of the law between soil and floor, m
  double depth = 0;                ///< only layers whose spheres end below floor + depth, m; 0: the whole region
  std::array<bool, 3> periodic{};  ///< whether the region's sides in x, y, z are
  double jitter = 0;               ///< maximum random shift of a site, share of the radius; even in a ball
  std::uint64_t seed = 1;
  std::vector<ClumpPart> clumps{};  ///< in any attitude, their bounding spheres on the sites
};

/// Number of sites along x, y, z.
struct LatticeCount {
  std::size_t x, y, z;
  std::size_t total() const { return x * y * z; }
};
LatticeCount lattice_count(const LatticePlan& plan);

/// Throws std::invalid_argument for a plan without sense or a region that holds no sphere. Layer by layer from below,
/// in a layer along z, then x. With a distribution the maximum radius decides how many rows fit.
std::vector<SphereSpec> lattice(const LatticePlan& plan, const BedMaterial& of);
Grains lattice_of_grains(const LatticePlan& plan, const BedMaterial& of);  ///< likewise, clumps among them

/// Lattice whose pitch is the distance at which two spheres rest, 2r - rest overlap of their law: free of stress,
/// except that a row's last sphere may be within the cutoff of a wall's attraction. Equal spheres only: others have no
/// common distance.
std::vector<SphereSpec> rest_lattice(LatticePlan plan, double rest_overlap, const BedMaterial& of);

/// Spheres loosely in the air over the region's floor, ready to rain: one per cell of a grid, anywhere in its cell that
/// keeps it clear of its neighbours. The column may be higher than the region; walls must reach as high.
class LoosePlacer {
 public:
  LoosePlacer(const Bounds& region, RadiusDistribution sizes, ShareOf shares, std::uint64_t seed, const BedMaterial& of,
              std::vector<ClumpPart> clumps = {});

  std::vector<SphereSpec> place(std::size_t count, double from_height) { return grains(count, from_height).spheres; }
  /// As many spheres as have at least this volume together, m3.
  std::vector<SphereSpec> place_volume(double volume, double from_height) {
    return grains_of_volume(volume, from_height).spheres;
  }
  /// The same with the clumps among them, each in an attitude of its own.
  Grains grains(std::size_t count, double from_height);
  Grains grains_of_volume(double volume, double from_height);

 private:
  double add_next(Grains& to, double from_height);  ///< returns its volume, m3
  Vec3 place_in(std::size_t cell, double from_height, double radius);

  Bounds region_;
  RadiusSampler sampler_;
  RandomNumbers random_;
  BedMaterial of_;
  std::vector<ClumpPart> clumps_;
  Vec3 cell_;  ///< m; sides that hold the maximum grain with a tenth of its radius to spare
  std::size_t across_x_ = 0, across_z_ = 0;
};

}  // namespace subsoil::dem
