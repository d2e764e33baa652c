#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libdem/base/vec3.hpp"
#include "libdem/geometry/cutting_edges.hpp"
#include "libdem/geometry/shapes.hpp"
#include "libdem/geometry/surface_loads.hpp"

namespace subsoil::dem {

/// Force and moment, world axes, N and N m; about the point that its user names.
struct Wrench {
  Vec3 force, moment;

  Wrench& operator+=(const Wrench& b) { return force += b.force, moment += b.moment, *this; }
  friend Wrench operator*(Wrench a, double s) { return a.force *= s, a.moment *= s, a; }
  template <class A>
  void archive(A& a) {
    a("force", force)("moment", moment);
  }
};

/// The same wrench about another point: M_to = M_from + (from - to) x F.
inline Wrench about(const Wrench& w, const Vec3& from, const Vec3& to) {
  return {w.force, w.moment + cross(from - to, w.force)};
}

/// A surface that spheres meet. Its pose and velocity are given from outside at every step (coupling, prescribed
/// motion); the bed answers with the wrench of the spheres on it.
struct Boundary {
  std::string name;
  Shape shape = Plane({}, {0, 1, 0});
  int material = 0;
  Pose pose;              ///< of the shape's axes in the world, at t_n
  Vec3 velocity;          ///< of pose.position, m/s, at t_n - dt/2 like the spheres'
  Vec3 angular_velocity;  ///< rad/s
  bool active = true;     ///< an opened wall is kept but touches nothing
  /// Whether fixed spheres meet it. Of a surface at rest against them the contact would be a constant load: a rough
  /// floor of fixed spheres may be laid into its walls.
  bool meets_fixed = true;
  std::vector<CuttingEdge> edges;  ///< of its triangles, those that cut fibres

  // answers
  Wrench wrench;               ///< of the spheres on the surface at t_n, about pose.position
  std::vector<Wrench> meshes;  ///< its share on each mesh of a MeshSurface; empty where there is only one
  double work = 0;             ///< J done by the surface on the spheres since the start, mean wrench times displacement
  int contacts = 0;            ///< spheres in contact at t_n
  std::optional<SurfaceLoads> loads;  ///< what its triangles have borne up to t_n; kept where its user makes it

  /// Of the spheres on one mesh of its shape, or on the whole of another shape.
  const Wrench& on_mesh(std::size_t index) const { return meshes.empty() ? wrench : meshes[index]; }

  // kept from the step before
  Wrench wrench_before;
  Pose pose_before;
};

}  // namespace subsoil::dem
