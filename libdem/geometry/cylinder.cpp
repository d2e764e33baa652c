#include "libdem/geometry/cylinder.hpp"

#include <algorithm>

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::dem {

Cylinder::Cylinder(const Vec3& centre, const Vec3& axis, double radius, double length)
    : centre_(centre), axis_(unit_vector(axis, "cylinder: axis")), radius_(radius), length_(length) {
  if (!(radius > 0) || !(length > 0) || !std::isfinite(radius + length))
    throw std::invalid_argument("cylinder: radius " + std::to_string(radius) + " m and length " +
                                std::to_string(length) + " m must be above 0");
}

size_t Cylinder::contacts(const Vec3& c, double cutoff, SurfaceContact* out, size_t max) const {
  if (max == 0) return 0;
  const Vec3 from_centre = c - centre_;
  const double along = dot(from_centre, axis_);
  const Vec3 aside = from_centre - along * axis_;
  const double off_axis = norm(aside);
  const double beyond_side = off_axis - radius_, beyond_cap = std::abs(along) - length_ / 2;
  // On the axis every direction is as near; one of them stands for all.
  const Vec3 radial = off_axis > 1e-12 * radius_ ? (1 / off_axis) * aside : square_to(axis_);
  const double end = along < 0 ? -1 : 1;
  if (beyond_side > 0 && beyond_cap > 0) {
    const double distance = std::hypot(beyond_side, beyond_cap);
    if (distance > cutoff) return 0;
    const Vec3 u = beyond_side * radial + (end * beyond_cap) * axis_;
    out[0] = {c - u, (1 / distance) * u, distance, end > 0 ? 3u : 4u, 0};
  } else if (beyond_side >= beyond_cap) {
    if (beyond_side > cutoff) return 0;
    out[0] = {c - beyond_side * radial, radial, beyond_side, 0, 0};
  } else {
    if (beyond_cap > cutoff) return 0;
    out[0] = {c - (end * beyond_cap) * axis_, end * axis_, beyond_cap, end > 0 ? 1u : 2u, 0};
  }
  return 1;
}

Bounds Cylinder::bounds() const {
  // A disc square to a reaches radius sqrt(1 - a_i^2) along axis i.
  const auto half_extent = [&](double ai) {
    return length_ / 2 * std::abs(ai) + radius_ * std::sqrt(std::max(0.0, 1 - ai * ai));
  };
  const Vec3 half{half_extent(axis_.x), half_extent(axis_.y), half_extent(axis_.z)};
  Bounds b;
  b.include(centre_ - half), b.include(centre_ + half);
  return b;
}

std::vector<TriangleMesh> Cylinder::drawing(double) const { return {cylinder_mesh(centre_, axis_, radius_, length_)}; }

}  // namespace subsoil::dem
