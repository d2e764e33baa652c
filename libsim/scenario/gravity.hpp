#pragma once
#include "libdem/base/vec3.hpp"

namespace subsoil::sim {

/// Whether depth and surface of a bed mean something: they are measured along y. Gravity acts down, -y, within 45
/// degrees, or not at all.
inline bool acts_down(const dem::Vec3& gravity) {
  constexpr double cosine = 0.7071067811865476;
  return !(-gravity.y < cosine * dem::norm(gravity));
}

}  // namespace subsoil::sim
