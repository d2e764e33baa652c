#include "libdem/geometry/triangle_tree.hpp"

#include <algorithm>

namespace subsoil::dem {

TriangleTree::TriangleTree(std::span<const Facet> facets) {
  if (facets.empty()) return;
  std::vector<Bounds> boxes(facets.size());
  order_.resize(facets.size());
  for (uint32_t t = 0; t < facets.size(); ++t) {
    for (const Vec3& p : facets[t].corner) boxes[t].include(p);
    order_[t] = t;
  }
  nodes_.emplace_back();
  build(0, 0, static_cast<uint32_t>(facets.size()), boxes);
}

void TriangleTree::build(uint32_t node, uint32_t first, uint32_t count, std::span<const Bounds> boxes) {
  constexpr uint32_t leaf_size = 4;
  Bounds bounds, centres;
  for (uint32_t i = first; i < first + count; ++i) {
    bounds.include(boxes[order_[i]]);
    centres.include(boxes[order_[i]].centre());
  }
  nodes_[node] = {bounds, first, count};
  if (count <= leaf_size) return;
  const Vec3 size = centres.high - centres.low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const uint32_t half = count / 2;
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + half, begin + count, [&](uint32_t a, uint32_t b) {
    const double ca = boxes[a].centre()[axis], cb = boxes[b].centre()[axis];
    return ca < cb || (ca == cb && a < b);
  });
  const auto children = static_cast<uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node] = {bounds, children, 0};
  build(children, first, half, boxes);
  build(children + 1, first + half, count - half, boxes);
}

}  // namespace subsoil::dem
