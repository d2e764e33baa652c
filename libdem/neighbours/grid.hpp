#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "libdem/base/vec3.hpp"

namespace subsoil::dem {

/// Cells by which spheres are sorted: slab after slab across the longest axis.
///
/// Cache blocks: a wide bed is cut along that axis into blocks, one sorted after the other, so that the spheres of two
/// slabs, which lie between a sphere and its last partner, stay in the second-level cache. Each is cut in half: two
/// threads then meet across the bed and not along it. Contacts between two cache blocks cross a block interface.
///
/// Written by `sort_by_cell`; read by the neighbour search, by the layout of contacts (where cache blocks end) and by
/// RelativeDisplacement, which keeps it until the next rebuild.
struct Grid {
  Vec3 low;
  double cell = 1;
  double fits = 0;          ///< maximum radius for which a neighbour is at most one cell away
  int axis[3] = {0, 1, 2};  ///< longest first: slabs across it are the sorted order
  int n[3] = {1, 1, 1};
  bool around[3] = {false, false, false};  ///< whether the last cell along the axis is next to the first
  std::vector<std::uint32_t> start;        ///< first sphere of each cell

  /// Cuts into so many cache blocks of nearly equal width, each in half if there are several; after n is known.
  void cut(int cache_blocks) {
    half_ = cache_blocks > 1 ? (n[0] + 1) / 2 : n[0];
    columns_.clear();
    ends_.clear();
    std::size_t before = 0;
    for (const int length : {half_, n[0] - half_})
      for (int s = 0, b = 0; s < cache_blocks; ++s) {
        const int first = b, end = static_cast<int>(static_cast<long>(n[1]) * (s + 1) / cache_blocks);
        const std::size_t slab = size_of(end - first) * size_of(n[2]);
        for (; b < end; ++b) columns_.push_back({before + size_of(b - first) * size_of(n[2]), slab});
        before += size_of(length) * slab;
        ends_.push_back(before);
      }
  }
  /// Number of cells up to the end of each half of a cache block, in their order.
  const std::vector<std::size_t>& cache_block_ends() const { return ends_; }
  std::size_t cells() const { return size_of(n[0]) * size_of(n[1]) * size_of(n[2]); }

  int coordinate(const Vec3& x, int k) const {
    const double at = (x[axis[k]] - low[axis[k]]) / cell;
    return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(n[k] - 1)));
  }
  std::size_t index(int a, int b, int c) const {
    const bool second = a >= half_;
    const Column& column = columns_[size_of(second ? n[1] + b : b)];
    return column.first + size_of(second ? a - half_ : a) * column.slab + size_of(c);
  }
  std::size_t index(const Vec3& x) const { return index(coordinate(x, 0), coordinate(x, 1), coordinate(x, 2)); }

 private:
  /// Cells of one b in one half: where those of its first slab lie, and how far the next slab is.
  struct Column {
    std::size_t first, slab;
  };
  static std::size_t size_of(int k) { return static_cast<std::size_t>(k); }
  int half_ = 1;
  std::vector<Column> columns_{{0, 1}};
  std::vector<std::size_t> ends_{1};
};

}  // namespace subsoil::dem
