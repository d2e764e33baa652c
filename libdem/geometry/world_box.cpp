#include "libdem/geometry/world_box.hpp"

#include <cmath>

namespace subsoil::dem {

Bounds world_box(const Bounds& box, const Pose& pose) {
  if (!std::isfinite(norm(box.low)) || !std::isfinite(norm(box.high))) return box;
  Bounds out;
  for (int corner = 0; corner < 8; ++corner)
    out.include(pose.to_world({(corner & 1) != 0 ? box.high.x : box.low.x, (corner & 2) != 0 ? box.high.y : box.low.y,
                               (corner & 4) != 0 ? box.high.z : box.low.z}));
  // A few roundings wider, so that what the box proper would take is never lost.
  const double more = 1e-12 * (norm(out.low) + norm(out.high));
  out.low -= Vec3{more, more, more}, out.high += Vec3{more, more, more};
  return out;
}

}  // namespace subsoil::dem
