#pragma once
#include <span>
#include <stdexcept>
#include <string>

#include "libdem/geometry/triangle_mesh.hpp"

namespace subsoil::sim {

/// A closed surface that has lost a volume.
struct Recession {
  dem::TriangleMesh mesh;  ///< the same triangles in the same order; vertices have moved
  double removed = 0;      ///< m^3
  double factor = 0;       ///< of all depths, that meets the volume: 1 to first order
  int steps = 0;
};

/// A surface cannot recede as far as it should. What it can lose is found by halving, to a hundredth.
class RecessionLimit : public std::invalid_argument {
 public:
  RecessionLimit(const std::string& what, double share_in, double depth_in)
      : std::invalid_argument(what), share(share_in), depth(depth_in) {}
  double share;  ///< of the volumes that it can lose
  double depth;  ///< m, of its deepest place then
};

/// Moves the vertices of a closed mesh inward until it has lost the sum of `volumes` (m^3, by triangle).
///
/// A fan is what lies around a vertex between sharp edges, those that bend by 30 deg or more: one on a smooth surface,
/// two at an edge, three at the corner of a box. With A_t the area vectors and V_t the volumes of its triangles,
///   N = sum A_t / sum |A_t|,   d = sum V_t / sum |A_t|,   and the vertex moves by u with N . u = -d for each of its
/// fans, the shortest u that meets them (least squares for more than three). A face that is not worn keeps its plane.
/// The loss is then sum_t A_t . (u_0 + u_1 + u_2)/-3 = sum_t V_t to first order, on any mesh: d by area is the only
/// mean with this property. What is left is of second order in depth over edge length; one factor for all u, the root
/// of the cubic that the volume of a closed mesh is in it, removes it, so that the sum is met to rounding.
///
/// Fans are those of the mesh as given. N follows the mesh in steps; in each of them the vertices of a triangle move
/// against each other by a tenth of its height at most, so that none turns over. Vertices of triangles that have shrunk
/// to 0.6 of their height slide to the mean of their neighbours along the surface or the edge, so that an edge recedes
/// through the triangles behind it; d goes with the vertex. Of the same method: Jiao, J. Comput. Phys. 220 (2007) 612.
///
/// @param spread m, the standard deviation along the surface over which depths spread before (diffusion with linear
/// elements, cotangent weights, bounded to nonnegative: conserves the volume, makes no new extremes). Not across sharp
/// edges. 0: not at all.
/// Throws std::invalid_argument for an open mesh and for a volume below zero, and RecessionLimit where the surface
/// cannot recede so far: a triangle would shrink below a twentieth of its height, a vertex would come through the
/// opposite side, or the surface would pass through itself.
Recession recede(const dem::TriangleMesh& mesh, std::span<const double> volumes, double spread = 0);

/// How far a mesh has receded from one with the same triangles.
struct Recessed {
  double deepest = 0;   ///< m, of a corner, along the normal of a triangle before
  double farthest = 0;  ///< m, by which a vertex has moved; above `deepest` at edges and corners
  double area = 0;      ///< m^2, of triangles whose mean depth is above a hundredth of the deepest
};
Recessed recessed(const dem::TriangleMesh& before, const dem::TriangleMesh& after);

}  // namespace subsoil::sim
