#pragma once
#include "apps/scenario/shapes/shape.hpp"

namespace subsoil::app {

/// Box with edges along its axes, centred on its placement.
struct BoxShape {
  Vec3 size{required, required, required};

  static constexpr bool bounded = true;
  void describe(Fields& v);
  ShapeFault fault() const;
  dem::TriangleMesh mesh() const;
};

}  // namespace subsoil::app
