#include "libsim/scenario/shapes/plane.hpp"

namespace subsoil::sim {

void PlaneShape::describe(Fields& v) {
  v.card("plane", "half-space behind an infinite plane");
  v.group("plane", "half-space behind an infinite plane", [&](auto& g) {
    g.vector("point", point, "m", "a point of the plane");
    g.vector("normal", normal, "1", "points to the free side; any length");
  });
}

ShapeFault PlaneShape::fault() const { return direction_fault("plane.normal", normal); }

dem::Shape PlaneShape::surface(const dem::Pose& placed) const {
  return dem::Plane(placed.to_world(point), placed.attitude.rotate(normal));
}

}  // namespace subsoil::sim
