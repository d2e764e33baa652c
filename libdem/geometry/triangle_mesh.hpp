#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "libdem/base/vec3.hpp"
#include "libdem/geometry/bounds.hpp"

namespace subsoil::dem {

using Triangle = std::array<uint32_t, 3>;

/// A surface of flat triangles. Closed (every edge between exactly two triangles, or balanced in both directions) means
/// a solid: its triangles are then turned so that normals point outward, component by component. A component within
/// another and wound against it is a cavity: its normals point into the cavity, out of the material.
class TriangleMesh {
 public:
  TriangleMesh() = default;
  /// Throws std::invalid_argument for an index out of range, a vertex that is not finite, and triangles without area
  /// (height below `flatness` times the longest side), with their number.
  TriangleMesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles);

  /// A triangle flatter than this has a normal uncertain by eps / flatness = 2e-8 rad: below it there is no face.
  static constexpr double flatness = 1e-8;

  const std::vector<Vec3>& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  const Vec3& corner(size_t triangle, int i) const { return vertices_[triangles_[triangle][static_cast<size_t>(i)]]; }
  bool closed() const { return closed_; }
  double volume() const;  ///< m^3, positive for a closed mesh; throws std::invalid_argument for an open one
  double area() const;    ///< m^2
  Bounds bounds() const;
  /// Unit normal by the right-hand rule over the corners; outward for a closed mesh.
  Vec3 normal(size_t triangle) const;

  /// The same mesh placed by `pose` after a scaling about the origin (negative scales would mirror: refused).
  TriangleMesh placed(const Pose& pose, double scale = 1) const;

 private:
  void refuse_bad_triangles() const;
  void orient();
  void turn_outward(std::span<const std::vector<uint32_t>> components);
  bool encloses(std::span<const uint32_t> component, std::span<const uint32_t> other) const;
  double solid_angle(std::span<const uint32_t> component, const Vec3& from) const;
  Bounds bounds(std::span<const uint32_t> triangles) const;
  std::vector<uint32_t> every_triangle() const;
  double signed_volume(std::span<const uint32_t> triangles) const;

  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;
  bool closed_ = false;
};

/// Normal of the triangle a b c, not normalised (length = twice the area), from its two shortest sides: rounding then
/// turns it by eps (shortest side)/(height) instead of eps (longest side)/(height).
Vec3 area_vector(const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace subsoil::dem
