#include "libsim/scenario/shapes/extrude.hpp"

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::sim {

void ExtrudeShape::describe(Fields& v) {
  v.card("extrude", "outline in x-y, extruded by `width`");
  v.outline("extrude", outline, "points `x y` of the outline, or a CSV file of them whose header names the unit");
  v.quantity("width", width, "m", "(0, inf)",
             "width along the shape's own z axis, half of it on either side of its x-y plane");
}

dem::TriangleMesh ExtrudeShape::mesh() const {
  std::vector<dem::Point2> points;
  for (const Vec2& p : outline) points.push_back({p[0], p[1]});
  return dem::extruded_mesh(points, width);
}

}  // namespace subsoil::sim
