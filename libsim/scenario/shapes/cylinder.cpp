#include "libsim/scenario/shapes/cylinder.hpp"

namespace subsoil::sim {

void CylinderShape::describe(Fields& v) {
  v.card("cylinder", "circular cylinder");
  v.group("cylinder", "circular cylinder, centred on its place", [&](auto& g) {
    g.quantity("radius", radius, "m", "(0, inf)", "radius");
    g.quantity("length", length, "m", "(0, inf)", "length along the axis");
    g.vector("axis", axis, "1", "direction of the axis; any length");
    g.quantity("inner radius", inner_radius, "m", "[0, inf)",
               "of a bore from end to end, wider than every sphere that comes to it: a tube, a drum; 0: solid");
  });
}

ShapeFault CylinderShape::fault() const {
  if (inner_radius >= radius) return {"cylinder.inner radius", "must be below the cylinder's radius"};
  return direction_fault("cylinder.axis", axis);
}

dem::Shape CylinderShape::surface(const dem::Pose& placed) const {
  return dem::Cylinder(placed.position, placed.attitude.rotate(axis), radius, length, inner_radius);
}

}  // namespace subsoil::sim
