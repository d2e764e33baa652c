#pragma once
#include "libdem/base/vec3.hpp"
#include "libdem/geometry/bounds.hpp"

namespace subsoil::dem {

/// Box in world axes around a box in those of a body; infinite if the box is.
Bounds world_box(const Bounds& box, const Pose& pose);

}  // namespace subsoil::dem
