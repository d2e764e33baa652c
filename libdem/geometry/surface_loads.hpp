#pragma once
#include <optional>
#include <vector>

#include "libdem/geometry/shapes.hpp"

namespace subsoil::dem {

/// What spheres have done to one triangle of a surface since the start. With F the force of a contact on the surface,
/// F_n its part along the normal, v the velocity of the sphere against the surface at the contact, v_n towards it and
/// v_t along it:
///   impulse      = int F_n dt               N s   (over area and time: mean pressure)
///   normal work  = int F_n max(v_n, 0) dt   J     (of approach; what a rebound gives back is not taken off)
///   shear work   = int F_t . v_t dt         J     (friction, and what tangential springs hold)
///   rubbing      = int F_n |v_t| dt         J     (Archard 1953: worn volume = K/H times this)
///   cutting      = int |F| |v| f(a) dt      J     (Finnie 1960: worn volume = k times this), tan a = v_n/v_t,
///                  f = sin 2a - 3 sin^2 a for tan a <= 1/3, else cos^2(a)/3, 0 where the sphere recedes
/// A contact on an edge or corner counts for one of its triangles. Each step adds F(t_n) times the path from t_{n-1} to
/// t_n: of first order in the step.
struct FaceLoad {
  double impulse = 0, normal_work = 0, shear_work = 0, rubbing = 0, cutting = 0;
  template <class A>
  void archive(A& a) {
    a("impulse", impulse)("normal work", normal_work)("shear work", shear_work)("rubbing", rubbing)("cutting", cutting);
  }
  FaceLoad& operator+=(const FaceLoad& b);
};

/// What a contact adds to the triangle that it is on. @param force on the surface @param normal out of it
/// @param velocity of the sphere against the surface
FaceLoad load_of(const Vec3& force, const Vec3& normal, const Vec3& velocity, double elapsed);

/// f of Finnie's law: share of the work that cuts, by the velocity's parts towards the surface and along it.
double finnie_share(double towards, double along);

/// The loads of all triangles of a surface; of a shape without any (a cylinder) those that draw it.
class SurfaceLoads {
 public:
  explicit SurfaceLoads(const Shape& shape);
  /// @param point in the axes of the shape
  void add(const Shape& shape, const Vec3& point, const FaceLoad& load);

  std::vector<FaceLoad> faces;  ///< by triangle, of all meshes of the shape one after the other

 private:
  std::optional<MeshSurface> drawn_;
};

}  // namespace subsoil::dem
