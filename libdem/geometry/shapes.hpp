#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "libdem/geometry/bounds.hpp"
#include "libdem/geometry/mesh_surface.hpp"
#include "libdem/geometry/surface_contact.hpp"
#include "libdem/geometry/triangle_mesh.hpp"

namespace subsoil::dem {

/// Solid half-space behind an infinite plane. One contact always within reach: distance = normal . (c - point),
/// negative behind the plane at any depth.
class Plane {
 public:
  Plane(const Vec3& point, const Vec3& normal);  ///< the normal points to the free side; any length
  size_t contacts(const Vec3& c, double reach, SurfaceContact* out, size_t max) const;
  const Vec3& point() const { return point_; }
  const Vec3& normal() const { return normal_; }

 private:
  Vec3 point_, normal_;
};

/// Solid circular cylinder of finite length: a wheel. Convex, so one contact: on the lateral surface (feature 0), a
/// cap (1 at the +axis end, 2) or a rim (3, 4). Inside it the nearest of lateral surface and caps, distance negative.
class Cylinder {
 public:
  Cylinder(const Vec3& centre, const Vec3& axis, double radius, double length);
  size_t contacts(const Vec3& c, double reach, SurfaceContact* out, size_t max) const;
  const Vec3& centre() const { return centre_; }
  const Vec3& axis() const { return axis_; }
  double radius() const { return radius_; }
  double length() const { return length_; }

 private:
  Vec3 centre_, axis_;
  double radius_, length_;
};

/// What a sphere may touch. A body with several triangulated surfaces is one MeshSurface; different shapes on one body
/// know nothing of each other (a cylinder let into a mesh gives a contact with each).
using Shape = std::variant<Plane, Cylinder, MeshSurface>;

/// Contacts of a sphere centre in the axes of the shape; `candidates` as found by the function below.
size_t contacts(const Shape& shape, const Vec3& c, double reach, std::span<const uint32_t> candidates,
                SurfaceContact* out, size_t max);

/// Appends what can be touched within reach of c: triangles of a mesh in ascending order, a single 0 for the others.
void candidates(const Shape& shape, const Vec3& c, double reach, std::vector<uint32_t>& out);

/// The flat face that alone can be touched while the centre stays within `margin` of c (MeshSurface::flat_face).
std::optional<FlatFace> flat_face(const Shape& shape, const Vec3& c, double margin,
                                  std::span<const uint32_t> candidates);

/// Box around the shape in its own axes; infinite in every direction for a plane.
Bounds bounds(const Shape& shape);

/// Triangles that draw the shape, one mesh per surface; a plane becomes a square of side `plane_size` about its point.
std::vector<TriangleMesh> drawing(const Shape& shape, double plane_size);

}  // namespace subsoil::dem
