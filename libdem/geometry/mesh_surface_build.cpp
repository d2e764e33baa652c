// Build of MeshSurface: facets, the directions and normals around edges and vertices, and the feature numbers.
#include <algorithm>
#include <limits>
#include <numeric>

#include "libdem/geometry/mesh_edges.hpp"
#include "libdem/geometry/mesh_surface.hpp"

namespace subsoil::dem {

Facet Facet::from(const Vec3& a, const Vec3& b, const Vec3& c) {
  Facet f{};
  f.corner[0] = a, f.corner[1] = b, f.corner[2] = c;
  f.normal = normalized(area_vector(a, b, c));
  for (const Vec3& p : f.corner) f.rounding = std::max({f.rounding, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  f.rounding *= 4 * std::numeric_limits<double>::epsilon();
  for (int i = 0; i < 3; ++i) {
    const Vec3 edge = f.corner[(i + 1) % 3] - f.corner[i];
    f.length[i] = norm(edge);
    f.along[i] = (1 / f.length[i]) * edge;
    f.aside[i] = normalized(cross(f.along[i], f.normal));
  }
  return f;
}

namespace {

/// Sets of numbers that only grow together.
class Groups {
 public:
  explicit Groups(size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }
  uint32_t find(uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(uint32_t i, uint32_t j) { parent_[std::max(find(i), find(j))] = std::min(find(i), find(j)); }

 private:
  std::vector<uint32_t> parent_;
};

}  // namespace

/// Adds one mesh to a MeshSurface. Triangles t, edges e and vertices v of the mesh become facets first_facet + t and
/// corners first_corner + e and first_corner + edges + v.
class MeshSurface::Builder {
 public:
  Builder(MeshSurface& target, const TriangleMesh& mesh, uint32_t surface)
      : target_(target),
        mesh_(mesh),
        sides_(mesh.triangles()),
        first_facet_(target.facets_.size()),
        first_corner_(target.corners_.size()) {
    for (size_t t = 0; t < mesh.triangles().size(); ++t) {
      Facet f = Facet::from(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
      f.surface = surface;
      f.sided = mesh.closed();
      target.facets_.push_back(f);
    }
    add_edges();
    add_vertices();
    number_features();
  }

 private:
  uint32_t triangles() const { return static_cast<uint32_t>(mesh_.triangles().size()); }
  uint32_t vertices() const { return static_cast<uint32_t>(mesh_.vertices().size()); }
  Facet& facet(size_t t) { return target_.facets_[first_facet_ + t]; }
  Corner& corner_of_edge(size_t e) { return target_.corners_[first_corner_ + e]; }
  Corner& corner_of_vertex(size_t v) { return target_.corners_[first_corner_ + edges_.size() + v]; }

  Corner start_corner() const {
    Corner corner;
    corner.begin = corner.end = static_cast<uint32_t>(target_.cone_.size());
    return corner;
  }

  /// The surface leaves an edge into each of its triangles, square to the edge.
  void add_edges() {
    for (size_t e = 0; e < edges_.size(); ++e) {
      Corner corner = start_corner();
      for (size_t k = edges_[e].begin; k < edges_[e].end; ++k) {
        Facet& f = facet(uses_[k].triangle);
        target_.cone_.push_back(-f.aside[uses_[k].side]);
        corner.outward += f.normal;
        f.part_corner[uses_[k].side] = static_cast<uint32_t>(first_corner_ + e);
      }
      finish(corner, facet(uses_[edges_[e].begin].triangle).normal);
    }
  }

  /// The surface leaves a vertex within the angles of its triangles: a direction of fall exists in one of them if and
  /// only if it exists along one of their sides.
  void add_vertices() {
    std::vector<std::vector<Vec3>> directions(vertices());
    std::vector<Vec3> outward(vertices());
    for (const MeshEdge& edge : edges_) {
      const Vec3 along = normalized(mesh_.vertices()[edge.high] - mesh_.vertices()[edge.low]);
      directions[edge.low].push_back(along);
      directions[edge.high].push_back(-along);
    }
    for (uint32_t t = 0; t < triangles(); ++t) {
      Facet& f = facet(t);
      for (uint32_t i = 0; i < 3; ++i) {
        const uint32_t v = mesh_.triangles()[t][i];
        f.part_corner[3 + i] = static_cast<uint32_t>(first_corner_ + edges_.size() + v);
        const Vec3 back = -f.along[(i + 2) % 3];
        outward[v] += std::atan2(norm(cross(f.along[i], back)), dot(f.along[i], back)) * f.normal;
      }
    }
    for (uint32_t v = 0; v < vertices(); ++v) {
      Corner corner = start_corner();
      target_.cone_.insert(target_.cone_.end(), directions[v].begin(), directions[v].end());
      corner.outward = outward[v];
      finish(corner, {0, 1, 0});
    }
  }

  void finish(Corner corner, const Vec3& if_none) {
    corner.end = static_cast<uint32_t>(target_.cone_.size());
    const double length = norm(corner.outward);
    corner.outward = length > 1e-6 ? (1 / length) * corner.outward : if_none;  // a sheet folded onto itself has none
    target_.corners_.push_back(corner);
  }

  /// One number for a flat face with the edges and vertices inside it, and one for a straight edge with the vertices
  /// on it; any other vertex has its own. Flat and straight mean within a milliradian.
  void number_features() {
    const double limit = same_direction;
    const auto edge_node = [&](size_t e) { return static_cast<uint32_t>(triangles() + e); };
    const auto vertex_node = [&](uint32_t v) { return static_cast<uint32_t>(triangles() + edges_.size() + v); };
    Groups groups(triangles() + edges_.size() + vertices());
    std::vector<std::vector<std::pair<size_t, Vec3>>> creases(vertices());  // edge and its direction from the vertex
    for (size_t e = 0; e < edges_.size(); ++e) {
      const MeshEdge& edge = edges_[e];
      const uint32_t t0 = uses_[edge.begin].triangle, t1 = uses_[edge.end - 1].triangle;
      // Two triangles in one plane on either side of the edge: their inward directions are opposite, whichever way
      // their normals point.
      if (edge.end - edge.begin == 2 &&
          norm(facet(t0).aside[uses_[edge.begin].side] + facet(t1).aside[uses_[edge.end - 1].side]) < limit) {
        groups.join(t0, t1);
        groups.join(t0, edge_node(e));
      } else {
        const Vec3 along = facet(t0).along[uses_[edge.begin].side];
        const bool forward = mesh_.triangles()[t0][uses_[edge.begin].side] == edge.low;
        creases[edge.low].push_back({e, forward ? along : -along});
        creases[edge.high].push_back({e, forward ? -along : along});
      }
    }
    for (uint32_t t = 0; t < triangles(); ++t)
      for (const uint32_t v : mesh_.triangles()[t])
        if (creases[v].empty()) groups.join(t, vertex_node(v));
    for (uint32_t v = 0; v < vertices(); ++v) {
      if (creases[v].size() != 2 || norm(creases[v][0].second + creases[v][1].second) >= limit) continue;
      groups.join(edge_node(creases[v][0].first), edge_node(creases[v][1].first));
      groups.join(edge_node(creases[v][0].first), vertex_node(v));
    }
    const auto base = static_cast<uint32_t>(first_facet_ + first_corner_);  // numbers used by the meshes before
    for (uint32_t t = 0; t < triangles(); ++t) target_.face_feature_.push_back(base + groups.find(t));
    for (size_t e = 0; e < edges_.size(); ++e) corner_of_edge(e).feature = base + groups.find(edge_node(e));
    for (uint32_t v = 0; v < vertices(); ++v) corner_of_vertex(v).feature = base + groups.find(vertex_node(v));
  }

  MeshSurface& target_;
  const TriangleMesh& mesh_;
  const MeshEdges sides_;
  const std::vector<EdgeUse>& uses_ = sides_.uses;
  const std::vector<MeshEdge>& edges_ = sides_.edges;
  size_t first_facet_, first_corner_;
};

MeshSurface::MeshSurface(std::span<const TriangleMesh> surfaces) : surfaces_(surfaces.begin(), surfaces.end()) {
  double largest = 0;
  for (uint32_t s = 0; s < surfaces.size(); ++s) {
    Builder(*this, surfaces[s], s);
    const Bounds b = surfaces[s].bounds();
    bounds_.include(b);
    for (int i = 0; i < 3; ++i) largest = std::max({largest, std::abs(b.low[i]), std::abs(b.high[i])});
  }
  tree_ = TriangleTree(facets_);
  // A point is a few dozen roundings away from the corners, each of them relative to a coordinate or a difference.
  rounding_ = 32 * std::numeric_limits<double>::epsilon() * largest;
}

}  // namespace subsoil::dem
