#pragma once
#include "libdem/geometry/one_contact.hpp"

namespace subsoil::dem {

/// Circular cylinder of finite length, solid (a wheel) or with a bore (a tube, a drum). One contact: on the lateral
/// surface (feature 0, in the bore 5), an end (1 at the +axis end, 2) or a rim (3, 4; of the bore 6, 7). In its
/// material the nearest of these surfaces, distance negative. A sphere meets the bore in one point as long as it is
/// smaller than it; a larger one, which would lie on the whole rim, has one of the rim's points.
class Cylinder : public OneContact<Cylinder> {
 public:
  /// `inner_radius`: of the bore; 0: none. Throws std::invalid_argument unless 0 <= inner_radius < radius and the
  /// length is above 0.
  Cylinder(const Vec3& centre, const Vec3& axis, double radius, double length, double inner_radius = 0);
  using OneContact::contacts;
  size_t contacts(const Vec3& c, double cutoff, SurfaceContact* out, size_t max) const;
  Bounds bounds() const;
  std::vector<TriangleMesh> drawing(double plane_size) const;
  const Vec3& centre() const { return centre_; }
  const Vec3& axis() const { return axis_; }
  double radius() const { return radius_; }
  double inner_radius() const { return inner_radius_; }
  double length() const { return length_; }

 private:
  Vec3 centre_, axis_;
  double radius_, length_, inner_radius_;
};

}  // namespace subsoil::dem
