#include "libdem/geometry/cylinder.hpp"

#include <algorithm>

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::dem {

Cylinder::Cylinder(const Vec3& centre, const Vec3& axis, double radius, double length, double inner_radius)
    : centre_(centre),
      axis_(unit_vector(axis, "cylinder: axis")),
      radius_(radius),
      length_(length),
      inner_radius_(inner_radius) {
  if (!(radius > 0) || !(length > 0) || !std::isfinite(radius + length))
    throw std::invalid_argument("cylinder: radius " + std::to_string(radius) + " m and length " +
                                std::to_string(length) + " m must be above 0");
  if (!(inner_radius >= 0 && inner_radius < radius))
    throw std::invalid_argument("cylinder: inner radius " + std::to_string(inner_radius) +
                                " m must be 0 or above, and below the radius " + std::to_string(radius) + " m");
}

size_t Cylinder::contacts(const Vec3& c, double cutoff, SurfaceContact* out, size_t max) const {
  if (max == 0) return 0;
  const Vec3 from_centre = c - centre_;
  const double along = dot(from_centre, axis_);
  const Vec3 aside = from_centre - along * axis_;
  const double off_axis = norm(aside);
  const bool in_bore = inner_radius_ > 0 && off_axis < (inner_radius_ + radius_) / 2;  // the inner surface is nearer
  const double beyond_side = in_bore ? inner_radius_ - off_axis : off_axis - radius_;
  const double beyond_cap = std::abs(along) - length_ / 2;
  // On the axis every direction is as near; one of them stands for all.
  const Vec3 outward = off_axis > 1e-12 * radius_ ? (1 / off_axis) * aside : square_to(axis_);
  const Vec3 radial = in_bore ? -outward : outward;
  const double end = along < 0 ? -1 : 1;
  if (beyond_side > 0 && beyond_cap > 0) {
    const double distance = std::hypot(beyond_side, beyond_cap);
    if (distance > cutoff) return 0;
    const Vec3 u = beyond_side * radial + (end * beyond_cap) * axis_;
    out[0] = {c - u, (1 / distance) * u, distance, (in_bore ? 6u : 3u) + (end > 0 ? 0u : 1u), 0};
  } else if (beyond_side >= beyond_cap) {
    if (beyond_side > cutoff) return 0;
    out[0] = {c - beyond_side * radial, radial, beyond_side, in_bore ? 5u : 0u, 0};
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

std::vector<TriangleMesh> Cylinder::drawing(double) const {
  if (inner_radius_ > 0) return {tube_mesh(centre_, axis_, inner_radius_, radius_, length_)};
  return {cylinder_mesh(centre_, axis_, radius_, length_)};
}

}  // namespace subsoil::dem
