#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/geometry/bounds.hpp"
#include "libdem/packing/placement.hpp"

/// Flexible fibres (straw, roots): rows of spheres that touch, each bonded to its neighbours (`bond: fibre`,
/// laws/bond.hpp). A row of spheres with smaller distances lost: the section of the bond is that of the fibre, and a
/// bond as long as two radii makes the row a beam of the modulus given.
namespace subsoil::dem {

struct FibreShape {
  double length = 0, diameter = 0;  ///< m
  BedMaterial of;                   ///< density of the fibre's matter, kg/m3

  /// Spheres in a row: as many diameters as come nearest to the length.
  int spheres() const;
  double chain_length() const { return spheres() * diameter; }  ///< m
  /// Of a round rod of that length, kg; spheres fill two thirds of the rod and are denser by as much.
  double mass() const;
};

struct FibrePose {
  Vec3 centre;     ///< m
  Vec3 direction;  ///< of unit length
};

/// Where fibres begin: their centres evenly over the region, all of each fibre inside it, none closer to another than a
/// tenth of a diameter.
struct FibreField {
  FibreShape shape;
  std::size_t count = 0;
  Bounds region;  ///< m; along y without an upper end where they are piled up
  /// Orientation: any; in the horizontal plane; or a cone about an axis.
  enum class Orientation { random, horizontal, along } orientation = Orientation::random;
  Vec3 axis{1, 0, 0};   ///< of `along`
  double scatter = 0;   ///< standard deviation of the angle to the axis about either of two directions across it, rad
  bool piles = false;   ///< fibres that find no room within the region come higher
  PeriodicCell cell{};  ///< along its periods, which the region spans, fibres may lie across the sides
  std::uint64_t seed = 1;
};

/// Throws std::invalid_argument for a field without sense, or one that has not room enough.
/// @param taken fibres that are there already, of a shape each
struct PlacedFibre {
  FibreShape shape;
  FibrePose pose;
};
std::vector<FibrePose> place_fibres(const FibreField& field, std::span<const PlacedFibre> taken = {});

/// The spheres of fibres with their bonds, free of load, for Bed::insert. Fibre k has the numbers from
/// first_id + k spheres() on.
Bed::State fibres_at(const FibreShape& shape, std::span<const FibrePose> poses, std::uint32_t first_id);

}  // namespace subsoil::dem
