#include "libsim/scenario/shapes/box.hpp"

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::sim {

void BoxShape::describe(Fields& v) {
  v.card("box", "box with edges along its axes");
  v.vector("box", size, "m", "edge lengths x y z; the box is centred on its place");
}

ShapeFault BoxShape::fault() const {
  if (size.x <= 0 || size.y <= 0 || size.z <= 0) return {"box", "all lengths must be above zero"};
  return {};
}

dem::TriangleMesh BoxShape::mesh() const { return dem::box_mesh(size); }

}  // namespace subsoil::sim
