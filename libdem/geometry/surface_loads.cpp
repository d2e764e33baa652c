#include "libdem/geometry/surface_loads.hpp"

#include <algorithm>
#include <cmath>

namespace subsoil::dem {

FaceLoad& FaceLoad::operator+=(const FaceLoad& b) {
  impulse += b.impulse, normal_work += b.normal_work, shear_work += b.shear_work;
  rubbing += b.rubbing, cutting += b.cutting;
  return *this;
}

double finnie_share(double towards, double along) {
  const double speed2 = towards * towards + along * along;
  if (!(towards > 0) || !(speed2 > 0)) return 0;
  const double sin2 = towards * towards / speed2, cos2 = along * along / speed2;
  if (3 * towards > along) return cos2 / 3;
  return 2 * towards * along / speed2 - 3 * sin2;
}

FaceLoad load_of(const Vec3& force, const Vec3& normal, const Vec3& velocity, double elapsed) {
  const double pressing = -dot(force, normal), towards = -dot(velocity, normal);
  const Vec3 slip = velocity + towards * normal, shear = force + pressing * normal;
  const double along = norm(slip);
  return {.impulse = pressing * elapsed,
          .normal_work = std::max(pressing, 0.0) * std::max(towards, 0.0) * elapsed,
          .shear_work = dot(shear, slip) * elapsed,
          .rubbing = std::max(pressing, 0.0) * along * elapsed,
          .cutting = norm(force) * std::hypot(towards, along) * finnie_share(towards, along) * elapsed};
}

SurfaceLoads::SurfaceLoads(const Shape& shape) {
  if (!std::holds_alternative<MeshSurface>(shape)) drawn_.emplace(drawing(shape, 1.0));
  faces.resize((drawn_ ? *drawn_ : std::get<MeshSurface>(shape)).triangle_count());
}

void SurfaceLoads::add(const Shape& shape, const Vec3& point, const FaceLoad& load) {
  faces[(drawn_ ? *drawn_ : std::get<MeshSurface>(shape)).nearest_triangle(point)] += load;
}

}  // namespace subsoil::dem
