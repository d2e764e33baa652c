#include "libdem/packing/carve.hpp"

#include <algorithm>

namespace subsoil::dem {
namespace {

bool touches_within(const Shape& shape, const Vec3& c, double cutoff) {
  std::vector<std::uint32_t> near;
  candidates(shape, c, cutoff, near);
  SurfaceContact nearest;  // contacts come nearest first, so one is enough
  return contacts(shape, c, cutoff, near, &nearest, 1) > 0 && nearest.distance < cutoff;
}

/// A centre deeper inside a mesh than its sphere's radius is beyond the cutoff of the surface: look as far as the mesh
/// goes.
bool deep_inside(const MeshSurface& mesh, const Vec3& c) {
  const double cutoff = mesh.bounds().diagonal();
  std::vector<std::uint32_t> near;
  mesh.candidates(c, cutoff, near);
  SurfaceContact nearest;
  return mesh.contacts(c, cutoff, near, &nearest, 1) > 0 && nearest.distance < 0;
}

}  // namespace

bool inside_or_overlapping(const Sphere& sphere, const Boundary& boundary, double clearance) {
  const Vec3 c = boundary.pose.to_local(sphere.x);
  const double cutoff = sphere.r + clearance;
  const double away = bounds(boundary.shape).distance_squared(c);
  if (away >= cutoff * cutoff) return false;
  if (touches_within(boundary.shape, c, cutoff)) return true;
  const auto* mesh = std::get_if<MeshSurface>(&boundary.shape);  // planes and cylinders know any depth
  return mesh != nullptr && away == 0 && deep_inside(*mesh, c);
}

std::vector<std::uint32_t> spheres_in_the_way(const Bed& bed, std::span<const int> boundaries, double clearance) {
  constexpr double rounding = 1e-9;  // of a radius: a surface that touches a sphere may lie this deep in it
  std::vector<std::uint32_t> ids;
  for (const Sphere& s : bed.spheres())
    if (std::any_of(boundaries.begin(), boundaries.end(),
                    [&](int b) { return inside_or_overlapping(s, bed.boundary(b), clearance - rounding * s.r); }))
      ids.push_back(s.id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::size_t carve(Bed& bed, std::span<const int> boundaries, double clearance) {
  const std::vector<std::uint32_t> gone = spheres_in_the_way(bed, boundaries, clearance);
  return bed.remove_if([&](const Sphere& s) { return std::binary_search(gone.begin(), gone.end(), s.id); });
}

}  // namespace subsoil::dem
