#include <gtest/gtest.h>

#include <vector>

#include "libdem/grid.hpp"

namespace subsoil::dem::test {
namespace {

Grid grid_of(int along, int across, int deep, int strips) {
  Grid grid;
  grid.n[0] = along, grid.n[1] = across, grid.n[2] = deep;
  grid.cut(strips);
  return grid;
}

/// Cells are numbered strip by strip, in a strip slab by slab, in a slab row by row: counted here in that order.
TEST(Strips, CellsAreNumberedInTheOrderOfTheSweep) {
  for (const int strips : {1, 2, 3, 7}) {
    const Grid grid = grid_of(5, 7, 3, strips);
    std::size_t next = 0;
    int first = 0;
    for (int s = 0; s < strips; ++s) {
      int end = first;
      while (end < 7 && grid.strip(end) == s) ++end;
      EXPECT_GE(end - first, 7 / strips);
      EXPECT_LE(end - first, 7 / strips + 1);
      for (int a = 0; a < 5; ++a)
        for (int b = first; b < end; ++b)
          for (int c = 0; c < 3; ++c) EXPECT_EQ(grid.index(a, b, c), next++) << strips << " strips";
      EXPECT_EQ(grid.strip_ends()[static_cast<std::size_t>(s)], next);
      first = end;
    }
    EXPECT_EQ(first, 7);
    EXPECT_EQ(next, grid.cells());
  }
}

}  // namespace
}  // namespace subsoil::dem::test
