#include "libdem/geometry/plane.hpp"

#include <utility>

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::dem {

Plane::Plane(const Vec3& point, const Vec3& normal) : point_(point), normal_(unit_vector(normal, "plane: normal")) {}

size_t Plane::contacts(const Vec3& c, double cutoff, SurfaceContact* out, size_t max) const {
  const double distance = dot(c - point_, normal_);
  if (distance > cutoff || max == 0) return 0;
  out[0] = {c - distance * normal_, normal_, distance, 0, 0};
  return 1;
}

std::optional<FlatFace> Plane::flat_face(const Vec3&, double, std::span<const uint32_t>) const {
  return FlatFace{normal_, dot(normal_, point_)};
}

Bounds Plane::bounds() const {
  Bounds b;
  std::swap(b.low, b.high);
  return b;
}

std::vector<TriangleMesh> Plane::drawing(double plane_size) const {
  const Vec3 u = plane_size * square_to(normal_), v = cross(normal_, u);
  return {rectangle_mesh(point_ - 0.5 * (u + v), u, v)};
}

}  // namespace subsoil::dem
