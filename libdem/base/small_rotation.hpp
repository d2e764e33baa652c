#pragma once
#include "libdem/base/vec3.hpp"

namespace subsoil::dem {

/// Rotation vector from one attitude to another, world axes, rad, for angles so small that the sine is the angle: 2 (x,
/// y, z) of q_to q_from^-1, of which w >= 0 is taken. Divided by dt, s: the mean angular velocity over dt, rad/s.
inline Vec3 small_rotation(const Quaternion& from, const Quaternion& to, double dt = 1) {
  const Quaternion rotation = to * from.conjugate();
  return Vec3{rotation.x, rotation.y, rotation.z} * ((rotation.w < 0 ? -2.0 : 2.0) / dt);
}

}  // namespace subsoil::dem
