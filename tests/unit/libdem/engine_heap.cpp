// No step of a bed may ask for memory unless it builds lists.

#include <gtest/gtest.h>

#include "libdem/geometry/mesh_builders.hpp"
#include "tests/tools/counted_heap.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_law.hpp"

#if defined(SUBSOIL_COUNTS_HEAP)

namespace subsoil::dem::test::engine_heap {
namespace {

/// Allocations in steps that built no lists, and how many such steps there were.
struct Counted {
  long allocations = 0, steps = 0, longest_run = 0;
};

/// 1,000 spheres in touch that fly about in five walls, with a block of triangles pushed through them. Lists last for
/// tens of steps: work is divided again, and how far spheres have come is measured in place of a rebuild.
Counted count(const Law& law, int threads, Precision precision, int cache_blocks) {
  BedOptions options = quiet({0, -9.81, 0}, threads);
  options.precision = precision, options.cache_blocks = cache_blocks;
  Bed bed(table(law), options);
  Dice dice(4);
  add_bin(bed, 0.2, 0.2);
  Boundary block;
  block.shape = MeshSurface(box_mesh({0.03, 0.1, 0.05}));
  const Motion tool{bed.add(std::move(block)), {{-0.0155, 0.1, 0.1}, {}}, {1, 0, 0}, {0, 2, 0}};
  bed.add(loose_lattice({}, 10, 10, 10, 0.02, 0.0101, 0.05, 0.5, dice));
  Counted out;
  long run = 0;
  for (int n = 0; n < 150; ++n) {
    tool.place(bed);
    const long rebuilds = bed.rebuilds(), before = subsoil::test::allocations;
    bed.step(1e-5);
    const long asked = subsoil::test::allocations - before;
    if (bed.rebuilds() > rebuilds) {
      run = 0;
      continue;
    }
    out.allocations += asked, ++out.steps;
    out.longest_run = std::max(out.longest_run, ++run);
  }
  return out;
}

/// What memory a contact needs is the law's, how work is divided is the same for all: every law in two of the ways,
/// two laws in all.
TEST(Heap, OnlyForNewLists) {
  for (const int threads : {1, 2, 3})
    for (const Precision precision : {Precision::doubles, Precision::mixed})
      for (const int cache_blocks : {1, 3})
        for (const auto& [name, law] : every_law()) {
          const bool of_all = threads == 2 && (precision == Precision::mixed) == (cache_blocks == 3);
          if (!of_all && name != "linear" && name != "hertz-mindlin") continue;
          SCOPED_TRACE(testing::Message() << name << ", " << threads << " threads, " << cache_blocks
                                          << " cache blocks, " << (precision == Precision::mixed ? "mixed" : "double"));
          const Counted found = count(law, threads, precision, cache_blocks);
          EXPECT_EQ(found.allocations, 0);
          EXPECT_GT(found.steps, 100);
          EXPECT_GT(found.longest_run, 32);  // work was divided again within
        }
}

}  // namespace
}  // namespace subsoil::dem::test::engine_heap

#endif
