#include "libdem/geometry/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::dem {
namespace {

Vec3 unit(const Vec3& v, const char* what) {
  const double length = norm(v);
  if (!(length > 0) || !std::isfinite(length))
    throw std::invalid_argument(std::string(what) + " has no direction; give a vector of any length above 0");
  return (1 / length) * v;
}

/// Any unit vector square to the unit vector a.
Vec3 square_to(const Vec3& a) { return normalized(cross(a, std::abs(a.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0})); }

}  // namespace

Plane::Plane(const Vec3& point, const Vec3& normal) : point_(point), normal_(unit(normal, "plane: normal")) {}

size_t Plane::contacts(const Vec3& c, double reach, SurfaceContact* out, size_t max) const {
  const double distance = dot(c - point_, normal_);
  if (distance > reach || max == 0) return 0;
  out[0] = {c - distance * normal_, normal_, distance, 0, 0};
  return 1;
}

Cylinder::Cylinder(const Vec3& centre, const Vec3& axis, double radius, double length)
    : centre_(centre), axis_(unit(axis, "cylinder: axis")), radius_(radius), length_(length) {
  if (!(radius > 0) || !(length > 0) || !std::isfinite(radius + length))
    throw std::invalid_argument("cylinder: radius " + std::to_string(radius) + " m and length " +
                                std::to_string(length) + " m must be above 0");
}

size_t Cylinder::contacts(const Vec3& c, double reach, SurfaceContact* out, size_t max) const {
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
    if (distance > reach) return 0;
    const Vec3 u = beyond_side * radial + (end * beyond_cap) * axis_;
    out[0] = {c - u, (1 / distance) * u, distance, end > 0 ? 3u : 4u, 0};
  } else if (beyond_side >= beyond_cap) {
    if (beyond_side > reach) return 0;
    out[0] = {c - beyond_side * radial, radial, beyond_side, 0, 0};
  } else {
    if (beyond_cap > reach) return 0;
    out[0] = {c - (end * beyond_cap) * axis_, end * axis_, beyond_cap, end > 0 ? 1u : 2u, 0};
  }
  return 1;
}

size_t contacts(const Shape& shape, const Vec3& c, double reach, std::span<const uint32_t> candidates,
                SurfaceContact* out, size_t max) {
  if (const auto* mesh = std::get_if<MeshSurface>(&shape)) return mesh->contacts(c, reach, candidates, out, max);
  if (candidates.empty()) return 0;
  if (const auto* plane = std::get_if<Plane>(&shape)) return plane->contacts(c, reach, out, max);
  return std::get<Cylinder>(shape).contacts(c, reach, out, max);
}

void candidates(const Shape& shape, const Vec3& c, double reach, std::vector<uint32_t>& out) {
  if (const auto* mesh = std::get_if<MeshSurface>(&shape)) return mesh->candidates(c, reach, out);
  constexpr uint32_t whole_shape[1] = {0};
  SurfaceContact any;
  if (contacts(shape, c, reach, whole_shape, &any, 1) > 0) out.push_back(0);
}

std::optional<FlatFace> flat_face(const Shape& shape, const Vec3& c, double margin,
                                  std::span<const uint32_t> candidates) {
  if (const auto* mesh = std::get_if<MeshSurface>(&shape)) return mesh->flat_face(c, margin, candidates);
  if (const auto* plane = std::get_if<Plane>(&shape))
    return FlatFace{plane->normal(), dot(plane->normal(), plane->point())};
  return std::nullopt;
}

Bounds bounds(const Shape& shape) {
  Bounds b;
  if (const auto* mesh = std::get_if<MeshSurface>(&shape)) return mesh->bounds();
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    const Vec3& a = cylinder->axis();
    // A disc square to a reaches radius sqrt(1 - a_i^2) along axis i.
    const auto reach = [&](double ai) {
      return cylinder->length() / 2 * std::abs(ai) + cylinder->radius() * std::sqrt(std::max(0.0, 1 - ai * ai));
    };
    const Vec3 half{reach(a.x), reach(a.y), reach(a.z)};
    b.include(cylinder->centre() - half), b.include(cylinder->centre() + half);
    return b;
  }
  std::swap(b.low, b.high);
  return b;
}

std::vector<TriangleMesh> drawing(const Shape& shape, double plane_size) {
  if (const auto* mesh = std::get_if<MeshSurface>(&shape)) return mesh->surfaces();
  if (const auto* c = std::get_if<Cylinder>(&shape))
    return {cylinder_mesh(c->centre(), c->axis(), c->radius(), c->length())};
  const auto& plane = std::get<Plane>(shape);
  const Vec3 u = plane_size * square_to(plane.normal()), v = cross(plane.normal(), u);
  return {rectangle_mesh(plane.point() - 0.5 * (u + v), u, v)};
}

}  // namespace subsoil::dem
