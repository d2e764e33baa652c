#pragma once
#include "apps/scenario/shapes/shape.hpp"

namespace subsoil::app {

/// Circular cylinder, centred on its placement.
struct CylinderShape {
  double radius = required, length = required;
  Vec3 axis{0, 0, 1};

  static constexpr bool bounded = true;
  void describe(Fields& v);
  ShapeFault fault() const;
  dem::Shape surface(const dem::Pose& placed) const;
};

}  // namespace subsoil::app
