#pragma once
#include "libsim/scenario/shapes/shape.hpp"

namespace subsoil::sim {

/// Box with edges along its axes, centred on its placement.
struct BoxShape {
  Vec3 size{required, required, required};

  static constexpr bool bounded = true;
  void describe(Fields& v);
  ShapeFault fault() const;
  dem::TriangleMesh mesh() const;
};

}  // namespace subsoil::sim
