// No usual step of a bed may ask for memory.

#include <gtest/gtest.h>

#include "tests/tools/counted_heap.hpp"
#include "tests/tools/dem_beds.hpp"

#if defined(SUBSOIL_COUNTS_HEAP)

namespace subsoil::dem::test {
namespace {

// 1,000 spheres, some of which touch, in five walls. The lists hold by paths alone; work is divided again 16 steps
// after they were built, which asks for memory, as measuring the drift does in place of a rebuild: neither falls into
// the steps that are counted.
TEST(Heap, NoneInAUsualStep) {
  for (const int threads : {1, 2})
    for (const Precision precision : {Precision::doubles, Precision::mixed})
      for (const auto& [name, law] : every_law()) {
        SCOPED_TRACE(testing::Message() << name << ", " << threads << " threads, "
                                        << (precision == Precision::mixed ? "mixed" : "double"));
        BedOptions options = quiet({0, -9.81, 0}, threads);
        options.precision = precision;
        Bed bed(table(law), options);
        Dice dice(4);
        add_bin(bed, 0.2, 0.2);
        bed.add(loose_lattice({}, 10, 10, 10, 0.02, 0.0097, 0.05, 0.01, dice));
        for (int n = 0; n < 20; ++n) bed.step(1e-6);
        const long rebuilds = bed.rebuilds(), before = subsoil::test::allocations;
        for (int n = 0; n < 130; ++n) bed.step(1e-6);
        EXPECT_EQ(subsoil::test::allocations - before, 0);
        EXPECT_EQ(bed.rebuilds(), rebuilds);
        EXPECT_GT(bed.max_overlap(), 0);
      }
}

}  // namespace
}  // namespace subsoil::dem::test

#endif
