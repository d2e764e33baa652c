#pragma once
#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

#include "libdem/geometry/triangle_mesh.hpp"

namespace subsoil::dem {

/// Side `side` (from corner side to the next) of a triangle as an undirected edge between two vertices.
struct EdgeUse {
  uint32_t low, high, triangle, side;
  bool forward;  // the triangle runs along it from low to high
};

/// An edge and the triangles at it: uses[begin .. end) of MeshEdges.
struct MeshEdge {
  uint32_t low, high;
  size_t begin, end;
};

struct MeshEdges {
  std::vector<EdgeUse> uses;
  std::vector<MeshEdge> edges;

  explicit MeshEdges(const std::vector<Triangle>& triangles) {
    uses.reserve(3 * triangles.size());
    for (uint32_t t = 0; t < triangles.size(); ++t) {
      for (uint32_t i = 0; i < 3; ++i) {
        const uint32_t a = triangles[t][i], b = triangles[t][(i + 1) % 3];
        uses.push_back({std::min(a, b), std::max(a, b), t, i, a < b});
      }
    }
    std::sort(uses.begin(), uses.end(), [](const EdgeUse& p, const EdgeUse& q) {
      return std::tie(p.low, p.high, p.triangle) < std::tie(q.low, q.high, q.triangle);
    });
    for (size_t i = 0; i < uses.size(); i = edges.back().end) {
      size_t end = i;
      while (end < uses.size() && uses[end].low == uses[i].low && uses[end].high == uses[i].high) ++end;
      edges.push_back({uses[i].low, uses[i].high, i, end});
    }
  }
};

}  // namespace subsoil::dem
