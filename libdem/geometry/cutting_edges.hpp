#pragma once
#include <span>
#include <vector>

#include "libdem/base/vec3.hpp"
#include "libdem/geometry/triangle_mesh.hpp"

namespace subsoil::dem {

/// A straight edge of a surface that cuts; axes of the surface.
struct CuttingEdge {
  Vec3 from, to;
  Vec3 outward;  ///< unit, halves the angle between its faces, out of the material; of a sheet in its plane
  Vec3 along() const { return normalized(to - from); }
};

/// Angle of the material between the faces at a convex edge, rad; 0 at the rim of a sheet. Edges within flat faces,
/// hollow ones and folds of a sheet are left out.
struct WedgeEdge {
  CuttingEdge edge;
  double angle = 0;
};
std::vector<WedgeEdge> wedge_edges(const TriangleMesh& mesh);

/// Those that are wedges of an angle or less, rad. A rounding above the angle of a drawing is that angle.
std::vector<CuttingEdge> cutting_edges(const TriangleMesh& mesh, double angle);

/// The edge nearest to a point of the surface, if it is as near as `within`, m; null: none is.
const CuttingEdge* edge_at(std::span<const CuttingEdge> edges, const Vec3& point, double within);

}  // namespace subsoil::dem
