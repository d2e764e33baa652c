#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "libdem/neighbours/cell_sort.hpp"
#include "libdem/neighbours/neighbour_list.hpp"
#include "tests/tools/dem_beds.hpp"

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

/// A cloud, and beside its spheres partners at the cutoff to the last bits, a kilometre from the origin.
std::vector<Sphere> cloud_with_partners_at(double cutoff, double spread) {
  Dice dice(3);
  std::vector<Sphere> out;
  const auto add = [&](const Vec3& x, double r) {
    out.push_back({x, r, {}, 1, {}, static_cast<std::uint32_t>(out.size()), 0, SphereKind::free, 0});
  };
  for (int k = 0; k < 700; ++k) {
    const Vec3 x = Vec3{1000, 0, 0} + dice.in_box({0, 0, 0}, {0.3, 0.1, 0.12});
    const double r = 0.005 * (1 - dice.between(0, spread)), further = dice.between(-1, 1) * 1e-12;
    add(x, r);
    add(x + (2 * r + cutoff + further) * normalized(dice.ball(1)), r);
  }
  if (spread > 0.5) add({1000.1, 0.05, 0.06}, 0.03);  // one that does not fit the cells
  return out;
}

/// All pairs that a search of all with all finds, each once and in order; gaps are as exact as the list states.
TEST(NeighbourList, HasEveryPairWithinTheCutoffAndNoOther) {
  constexpr double cutoff = 0.002;
  for (const double spread : {0.0, 0.3, 0.9})
    for (const int threads : {1, 3}) {
      std::vector<Sphere> spheres = cloud_with_partners_at(cutoff, spread);
      Bounds box;
      double largest = 0;
      for (const Sphere& s : spheres) box.include(s.x), largest = std::max(largest, s.r);
      Grid grid;
      grid.fits = radius_that_fits(spheres, 0, largest);
      sort_by_cell(spheres, 2 * grid.fits + cutoff, box, 0, threads, grid);
      const NeighbourList list = find_neighbours(spheres, grid, cutoff, threads);
      std::vector<std::pair<std::size_t, std::uint32_t>> expected, found;
      for (std::size_t i = 0; i < spheres.size(); ++i) {
        for (std::size_t j = i + 1; j < spheres.size(); ++j) {
          const Vec3 d = spheres[i].x - spheres[j].x;
          const double limit = spheres[i].r + spheres[j].r + cutoff;
          if (dot(d, d) < limit * limit) expected.push_back({i, static_cast<std::uint32_t>(j)});
        }
        for (std::uint32_t p = list.start[i]; p < list.start[i + 1]; ++p) {
          found.push_back({i, list.j[p]});
          const Sphere &a = spheres[i], &b = spheres[list.j[p]];
          if (std::isnan(list.gap[p])) continue;  // beside the one that does not fit
          EXPECT_NEAR(static_cast<double>(list.gap[p]), norm(a.x - b.x) - a.r - b.r,
                      static_cast<double>(list.gap_error));
        }
      }
      EXPECT_EQ(found, expected) << spread << ", " << threads << " threads";
      EXPECT_GT(expected.size(), 500u);
      EXPECT_LT(list.gap_error, 0.001 * cutoff);
    }
}

}  // namespace
}  // namespace subsoil::dem::test::engine_cache_blocks
