#include "libdem/geometry/shapes.hpp"

namespace subsoil::dem {

size_t contacts(const Shape& shape, const Vec3& c, double cutoff, std::span<const uint32_t> candidates,
                SurfaceContact* out, size_t max) {
  return std::visit([&](const auto& s) { return s.contacts(c, cutoff, candidates, out, max); }, shape);
}

void candidates(const Shape& shape, const Vec3& c, double cutoff, std::vector<uint32_t>& out) {
  std::visit([&](const auto& s) { s.candidates(c, cutoff, out); }, shape);
}

std::optional<FlatFace> flat_face(const Shape& shape, const Vec3& c, double margin,
                                  std::span<const uint32_t> candidates) {
  return std::visit([&](const auto& s) { return s.flat_face(c, margin, candidates); }, shape);
}

Bounds bounds(const Shape& shape) {
  return std::visit([](const auto& s) -> Bounds { return s.bounds(); }, shape);
}

std::vector<TriangleMesh> drawing(const Shape& shape, double plane_size) {
  return std::visit([&](const auto& s) -> std::vector<TriangleMesh> { return s.drawing(plane_size); }, shape);
}

}  // namespace subsoil::dem
