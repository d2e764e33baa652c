#include "libdem/geometry/cutting_edges.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "libdem/geometry/mesh_edges.hpp"

namespace subsoil::dem {
namespace {

Vec3 far_corner(const TriangleMesh& mesh, const EdgeUse& use) {
  return mesh.corner(use.triangle, static_cast<int>((use.side + 2) % 3));
}

/// At the rim of a sheet.
WedgeEdge rim(const TriangleMesh& mesh, const EdgeUse& use) {
  const Vec3 &from = mesh.vertices()[use.low], &to = mesh.vertices()[use.high];
  const Vec3 across = normalized(cross(to - from, mesh.normal(use.triangle)));
  const double side = dot(across, far_corner(mesh, use) - from);
  return {{from, to, side > 0 ? -across : across}, 0};
}

/// Between two faces of a solid, whose normals point out of it.
std::optional<WedgeEdge> wedge(const TriangleMesh& mesh, const EdgeUse& a, const EdgeUse& b) {
  constexpr double flat = 1e-3;  // rad, as of faces that are one (MeshSurface)
  const Vec3 normal = mesh.normal(a.triangle), other = mesh.normal(b.triangle);
  const Vec3 &from = mesh.vertices()[b.low], &to = mesh.vertices()[b.high];
  const double turn = std::atan2(norm(cross(normal, other)), dot(normal, other));
  if (turn < flat || dot(normal, far_corner(mesh, b) - from) > 0) return std::nullopt;
  return WedgeEdge{{from, to, normalized(normal + other)}, std::numbers::pi - turn};
}

}  // namespace

std::vector<WedgeEdge> wedge_edges(const TriangleMesh& mesh) {
  std::vector<WedgeEdge> out;
  const MeshEdges edges(mesh.triangles());
  for (const MeshEdge& e : edges.edges) {
    if (e.end - e.begin == 1) out.push_back(rim(mesh, edges.uses[e.begin]));
    if (e.end - e.begin != 2 || !mesh.closed()) continue;
    if (const auto found = wedge(mesh, edges.uses[e.begin], edges.uses[e.begin + 1])) out.push_back(*found);
  }
  return out;
}

std::vector<CuttingEdge> cutting_edges(const TriangleMesh& mesh, double angle) {
  std::vector<CuttingEdge> out;
  for (const WedgeEdge& e : wedge_edges(mesh))
    if (e.angle <= angle * (1 + 1e-6)) out.push_back(e.edge);
  return out;
}

const CuttingEdge* edge_at(std::span<const CuttingEdge> edges, const Vec3& point, double within) {
  const CuttingEdge* nearest = nullptr;
  for (const CuttingEdge& e : edges) {
    const Vec3 span = e.to - e.from;
    const double part = std::clamp(dot(point - e.from, span) / dot(span, span), 0.0, 1.0);
    const double distance = norm(point - e.from - part * span);
    if (distance <= within) nearest = &e, within = distance;
  }
  return nearest;
}

}  // namespace subsoil::dem
