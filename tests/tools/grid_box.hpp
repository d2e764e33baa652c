#pragma once
#include <array>
#include <vector>

#include "libdem/geometry/mesh_builders.hpp"

namespace subsoil::test {

/// A box about the origin, each face a grid of n x n squares of two triangles.
inline dem::TriangleMesh grid_box(const dem::Vec3& size, int n) {
  std::vector<std::array<dem::Vec3, 3>> soup;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-0.5, 0.5})
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto point = [&](int k, int l) {
            dem::Vec3 p;
            p[axis] = side * size[axis];
            p[(axis + 1) % 3] = (static_cast<double>(k) / n - 0.5) * size[(axis + 1) % 3];
            p[(axis + 2) % 3] = (static_cast<double>(l) / n - 0.5) * size[(axis + 2) % 3];
            return p;
          };
          const dem::Vec3 a = point(i, j), b = point(i + 1, j), c = point(i + 1, j + 1), d = point(i, j + 1);
          if (side > 0) {
            soup.push_back({a, b, c}), soup.push_back({a, c, d});
          } else {
            soup.push_back({a, c, b}), soup.push_back({a, d, c});
          }
        }
  return dem::welded_mesh(soup);
}

}  // namespace subsoil::test
