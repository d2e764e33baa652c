#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "libdem/geometry/cylinder.hpp"
#include "libdem/geometry/mesh_surface.hpp"
#include "libdem/geometry/plane.hpp"

/// What a sphere may touch. A new shape is its own file, which has the members of `ContactShape`, and one word in the
/// list at the end.
namespace subsoil::dem {

template <class S>
concept ContactShape = requires(const S& s, const Vec3& c, double d, std::span<const uint32_t> candidates,
                                std::vector<uint32_t>& found, SurfaceContact* out, size_t max) {
  { s.contacts(c, d, candidates, out, max) } -> std::same_as<size_t>;
  { s.candidates(c, d, found) } -> std::same_as<void>;
  { s.flat_face(c, d, candidates) } -> std::same_as<std::optional<FlatFace>>;
  { s.bounds() } -> std::convertible_to<Bounds>;
  { s.drawing(d) } -> std::convertible_to<std::vector<TriangleMesh>>;
};

template <ContactShape... S>
using ShapeOf = std::variant<S...>;

/// A body with several triangulated surfaces is one MeshSurface; different shapes on one body know nothing of each
/// other (a cylinder let into a mesh gives a contact with each).
using Shape = ShapeOf<Plane, Cylinder, MeshSurface>;

/// Contacts of a sphere centre in the axes of the shape; `candidates` as found by the function below.
size_t contacts(const Shape& shape, const Vec3& c, double cutoff, std::span<const uint32_t> candidates,
                SurfaceContact* out, size_t max);

/// Appends what can be touched within the cutoff of c: triangles of a mesh in ascending order, a single 0 for the
/// others.
void candidates(const Shape& shape, const Vec3& c, double cutoff, std::vector<uint32_t>& out);

/// The flat face that alone can be touched while the centre stays within `margin` of c (MeshSurface::flat_face).
std::optional<FlatFace> flat_face(const Shape& shape, const Vec3& c, double margin,
                                  std::span<const uint32_t> candidates);

/// Box around the shape in its own axes; infinite in every direction for a plane.
Bounds bounds(const Shape& shape);

/// Triangles that draw the shape, one mesh per surface; a plane becomes a square of side `plane_size` about its point.
std::vector<TriangleMesh> drawing(const Shape& shape, double plane_size);

}  // namespace subsoil::dem
