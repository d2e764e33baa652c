#pragma once
#include "libdem/geometry/one_contact.hpp"

namespace subsoil::dem {

/// Solid circular cylinder of finite length: a wheel. Convex, so one contact: on the lateral surface (feature 0), a
/// cap (1 at the +axis end, 2) or a rim (3, 4). Inside it the nearest of lateral surface and caps, distance negative.
class Cylinder : public OneContact<Cylinder> {
 public:
  Cylinder(const Vec3& centre, const Vec3& axis, double radius, double length);
  using OneContact::contacts;
  size_t contacts(const Vec3& c, double cutoff, SurfaceContact* out, size_t max) const;
  Bounds bounds() const;
  std::vector<TriangleMesh> drawing(double plane_size) const;
  const Vec3& centre() const { return centre_; }
  const Vec3& axis() const { return axis_; }
  double radius() const { return radius_; }
  double length() const { return length_; }

 private:
  Vec3 centre_, axis_;
  double radius_, length_;
};

}  // namespace subsoil::dem
