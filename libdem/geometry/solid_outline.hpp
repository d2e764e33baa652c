#pragma once
#include <array>
#include <vector>

#include "libdem/geometry/boundary.hpp"

namespace subsoil::dem {

/// Triangles of a boundary that may stand in another one's way: boundaries meet spheres and not each other.
class SolidOutline {
 public:
  explicit SolidOutline(const Boundary& b);

  /// Whether the surfaces cut each other, or one lies inside the other, as both stand now. Faces that touch do not cut.
  bool meets(const SolidOutline& other) const;

 private:
  using Triangles = std::vector<std::array<Vec3, 3>>;
  /// Those that reach into a box, world axes, as the boundary stands now.
  Triangles within(const Bounds& box) const;
  bool holds(const Vec3& point) const;  ///< a closed body

  const Boundary* boundary_;
  Triangles triangles_;  ///< shape axes; none of a plane
};

}  // namespace subsoil::dem
