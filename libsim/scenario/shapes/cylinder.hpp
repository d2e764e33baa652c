#pragma once
#include "libsim/scenario/shapes/shape.hpp"

namespace subsoil::sim {

/// Circular cylinder, solid or with a bore, centred on its placement.
struct CylinderShape {
  double radius = required, length = required;
  Vec3 axis{0, 0, 1};
  double inner_radius = 0;  ///< of the bore; 0: solid

  static constexpr bool bounded = true;
  void describe(Fields& v);
  ShapeFault fault() const;
  dem::Shape surface(const dem::Pose& placed) const;
};

}  // namespace subsoil::sim
