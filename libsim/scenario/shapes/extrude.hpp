#pragma once
#include <vector>

#include "libsim/scenario/shapes/shape.hpp"

namespace subsoil::sim {

/// Closed outline in x-y, extruded symmetrically about z = 0.
struct ExtrudeShape {
  std::vector<Vec2> outline;
  double width = required;

  static constexpr bool bounded = true;
  void describe(Fields& v);
  ShapeFault fault() const { return {}; }
  dem::TriangleMesh mesh() const;
};

}  // namespace subsoil::sim
