#pragma once
#include "libsim/scenario/shapes/shape.hpp"

namespace subsoil::sim {

/// Half-space; the normal points to the free side.
struct PlaneShape {
  Vec3 point{};
  Vec3 normal{0, 1, 0};

  static constexpr bool bounded = false;
  void describe(Fields& v);
  ShapeFault fault() const;
  dem::Shape surface(const dem::Pose& placed) const;
};

}  // namespace subsoil::sim
