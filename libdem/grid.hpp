#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "libdem/vec3.hpp"

namespace subsoil::dem {

/// Cells by which spheres are sorted.
struct Grid {
  Vec3 low;
  double cell = 1;
  double fits = 0;          ///< largest radius for which a neighbour is at most one cell away
  int axis[3] = {0, 1, 2};  ///< longest first: slabs across it are the sorted order
  int n[3] = {1, 1, 1};
  std::vector<std::uint32_t> start;  ///< first sphere of each cell

  int coordinate(const Vec3& x, int k) const {
    const double at = std::floor((x[axis[k]] - low[axis[k]]) / cell);
    return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(n[k] - 1)));
  }
  std::size_t index(int a, int b, int c) const {
    return (static_cast<std::size_t>(a) * static_cast<std::size_t>(n[1]) + static_cast<std::size_t>(b)) *
               static_cast<std::size_t>(n[2]) +
           static_cast<std::size_t>(c);
  }
  std::size_t index(const Vec3& x) const { return index(coordinate(x, 0), coordinate(x, 1), coordinate(x, 2)); }
};

}  // namespace subsoil::dem
