#include <gtest/gtest.h>

#include <vector>

#include "libdem/neighbours/grid.hpp"

namespace subsoil::dem::test::engine_cache_blocks {
namespace {

/// Cells are numbered cache block by cache block of one half, then of the other; in a cache block slab by slab, in a
/// slab row by row: counted here in that order.
TEST(CacheBlocks, CellsAreNumberedInTheOrderOfTheSweep) {
  constexpr int along = 5, across = 7, deep = 3;
  for (const int blocks : {1, 2, 3, 7}) {
    Grid grid;
    grid.n[0] = along, grid.n[1] = across, grid.n[2] = deep;
    grid.cut(blocks);
    std::vector<std::pair<int, int>> halves{{0, along}};
    if (blocks > 1) halves = {{0, 3}, {3, along}};
    std::size_t next = 0, part = 0;
    for (const auto& [from, to] : halves)
      for (int s = 0; s < blocks; ++s) {
        const int first = across * s / blocks, end = across * (s + 1) / blocks;
        for (int a = from; a < to; ++a)
          for (int b = first; b < end; ++b)
            for (int c = 0; c < deep; ++c) EXPECT_EQ(grid.index(a, b, c), next++) << blocks << " cache blocks";
        EXPECT_EQ(grid.cache_block_ends()[part++], next);
      }
    EXPECT_EQ(next, grid.cells());
    EXPECT_EQ(next, std::size_t{along * across * deep});
  }
}

}  // namespace
}  // namespace subsoil::dem::test::engine_cache_blocks
