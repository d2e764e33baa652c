#pragma once
#include <vector>

#include "libdem/base/archive.hpp"
#include "libdem/bed.hpp"
#include "libdem/geometry/bounds.hpp"
#include "libdem/packing/measure.hpp"

namespace subsoil::sim {

/// A bed at one depth: means over points of the coarse-grained fields (base/coarse_graining.hpp).
struct DepthRow {
  double depth = 0;            ///< m below the mean surface
  double density = 0;          ///< kg/m3
  double coordination = 0;     ///< contacts per sphere, those with surfaces left out
  double vertical_stress = 0;  ///< Pa, compressive
  double stress_ratio = 0;     ///< mean of both horizontal stresses over the vertical one
  void archive(Archive& a) {
    a("depth", depth)("density", density)("coordination", coordination);
    a("vertical stress", vertical_stress)("stress ratio", stress_ratio);
  }
};

/// Rows two mean diameters apart, twelve at most, each with what lies within two diameters. Points of a row are a
/// diameter apart, 24 along a side at most. They keep two diameters from walls where the bed is wide enough, and from
/// floor and surface: nearer, they would count empty space. Across periodic sides they count the images. A bed that is
/// not eight diameters deep has one row, of its middle. Of spheres with numbers below `below` only.
std::vector<DepthRow> profile_by_depth(dem::Bed& bed, const dem::Bounds& region,
                                       std::uint32_t below = dem::kAllSpheres);

}  // namespace subsoil::sim
