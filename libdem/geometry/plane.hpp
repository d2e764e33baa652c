#pragma once
#include "libdem/geometry/one_contact.hpp"

namespace subsoil::dem {

/// Solid half-space behind an infinite plane. One contact always within the cutoff: distance = normal . (c - point),
/// negative behind the plane at any depth.
class Plane : public OneContact<Plane> {
 public:
  Plane(const Vec3& point, const Vec3& normal);  ///< the normal points to the free side; any length
  using OneContact::contacts;
  size_t contacts(const Vec3& c, double cutoff, SurfaceContact* out, size_t max) const;
  std::optional<FlatFace> flat_face(const Vec3&, double, std::span<const uint32_t>) const;
  Bounds bounds() const;
  std::vector<TriangleMesh> drawing(double plane_size) const;
  const Vec3& point() const { return point_; }
  const Vec3& normal() const { return normal_; }

 private:
  Vec3 point_, normal_;
};

}  // namespace subsoil::dem
