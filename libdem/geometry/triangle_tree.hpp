#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "libdem/geometry/bounds.hpp"
#include "libdem/geometry/facet.hpp"

namespace subsoil::dem {

/// Tree of boxes over the triangles of one body (median split, four triangles a leaf), built once in body axes. A
/// uniform grid lost: an extruded shank of 12 long and a share of 1 mm triangles have no common cell size.
class TriangleTree {
 public:
  TriangleTree() = default;
  explicit TriangleTree(std::span<const Facet> facets);

  /// Calls visit(triangle) for each triangle whose box is within `cutoff` of c, in no particular order.
  template <class Visit>
  void visit_near(const Vec3& c, double cutoff, Visit&& visit) const {
    if (nodes_.empty()) return;
    const double cutoff2 = cutoff * cutoff;
    uint32_t stack[64];  // one entry per level; median splits of 2^32 triangles are 32 deep
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& node = nodes_[stack[--top]];
      if (node.bounds.distance_squared(c) > cutoff2) continue;
      if (node.count == 0) {
        stack[top++] = node.first;  // children stand side by side
        stack[top++] = node.first + 1;
        continue;
      }
      for (uint32_t i = 0; i < node.count; ++i) visit(order_[node.first + i]);
    }
  }

 private:
  struct Node {
    Bounds bounds;
    uint32_t first = 0;  // leaf: first entry of order_; else first of two children
    uint32_t count = 0;  // triangles of a leaf; 0 for an inner node
  };
  void build(uint32_t node, uint32_t first, uint32_t count, std::span<const Bounds> boxes);

  std::vector<Node> nodes_;
  std::vector<uint32_t> order_;
};

}  // namespace subsoil::dem
