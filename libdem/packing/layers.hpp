#pragma once
#include <span>
#include <vector>

#include "libdem/packing/measure.hpp"
#include "libdem/packing/placement.hpp"

/// Beds of several materials, one above the other: lists of layers from below.
namespace subsoil::dem {

struct BedLayer {
  double top = 0;  ///< height of its upper face over the region's floor, m; the bed's depth for the highest
  RadiusDistribution radius = EqualRadius{};
  ShareOf shares = ShareOf::number;
  BedMaterial of;
  std::vector<ClumpPart> clumps{};  ///< among its grains; of a random fill
};

/// A layer that is placed on a lattice of its own.
struct LatticeLayer : BedLayer {
  double pitch = 0;  ///< m
  double rise = 0;  ///< from the centres of the highest row below it to those of its lowest, m; not of the lowest layer
};

/// Lattices one upon the other. The plan gives region, jitter, seed and the overlap with the floor. An interface lies
/// where a row of spheres ends nearest to it, since a row that it cuts belongs to one of two materials; the highest
/// layer ends below its face, as a bed without layers does. Throws std::invalid_argument for a layer that holds no row.
/// `numbers`: how many spheres each layer has got.
std::vector<SphereSpec> layered_lattice(const LatticePlan& plan, std::span<const LatticeLayer> layers,
                                        std::vector<std::size_t>& numbers);

/// Layer of each sphere of a bed that lies, by the depth of its centre below the bed's mean surface. What lies above
/// belongs to the highest layer, what lies below all of them to the lowest.
std::vector<int> layers_by_depth(std::span<const Sphere> spheres, const Bounds& region,
                                 std::span<const BedLayer> layers);

/// What a layer has become: its upper face is the mean surface of everything up to it, its thickness the distance to
/// that of the layer below, the floor's under the lowest.
struct LayerReport {
  std::size_t spheres = 0;
  double mass = 0;             ///< kg
  double top = 0, spread = 0;  ///< m, world y; standard deviation over the columns
  double thickness = 0;        ///< m
};
/// @param layer of each sphere, by its id
std::vector<LayerReport> report_layers(std::span<const Sphere> spheres, const Bounds& region,
                                       std::span<const int> layer, std::size_t layers);

}  // namespace subsoil::dem
