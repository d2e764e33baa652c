#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_kernel.hpp"
#include "tests/tools/every_law.hpp"

/// A SELL chunk longer than the kernel's groups, whose lanes run out one after the other, by each instruction set: what
/// its spheres i get is what their spheres j give, and neither blocks that were evaluated before the sweep nor spheres
/// j that take theirs later change a bit of it.
namespace subsoil::dem::test::kernel_chunks {
namespace {

constexpr std::array<std::uint8_t, 11> kLanes{8, 8, 7, 7, 6, 5, 4, 3, 2, 1, 1};

constexpr std::size_t kSums = 64;  ///< a power of two, no less than the spheres

/// Spheres i 0 to 7, and one sphere j of its own for every pair.
struct Chunk {
  std::vector<Sphere> spheres;
  std::vector<MixedSphere> mixed;
  std::vector<PairBlock> blocks{kLanes.size()};
  std::vector<BlockShape> shapes;
  std::vector<std::uint32_t> i_of;  ///< by sphere
  bool uniform = false;             ///< whether the kernel is told that they all are

  Chunk() {
    Dice dice(11);
    for (std::uint32_t i = 0; i < kBlock; ++i) take({0.1 * i, 0.3, -0.2}, dice, i);
    for (std::size_t b = 0; b < kLanes.size(); ++b) {
      shapes.push_back({.lanes = kLanes[b], .begins = b == 0});
      for (std::uint32_t l = 0; l < kBlock; ++l) {
        blocks[b].i[l] = l, blocks[b].j[l] = static_cast<std::uint32_t>(spheres.size());
        if (l >= kLanes[b]) {
          blocks[b].j[l] = blocks[b - 1].j[l];
          continue;
        }
        const Vec3 d = normalized(dice.ball(1));
        take(spheres[l].x - dice.between(0.0185, 0.0199) * d, dice, l);
      }
    }
    for (const Sphere& s : spheres) mixed.push_back(rounded(s, s.m));
  }
  void take(const Vec3& x, Dice& dice, std::uint32_t i) {
    const auto id = static_cast<std::uint32_t>(spheres.size());
    spheres.push_back({x, 0.01, dice.between(0, 0.3) * normalized(dice.ball(1)), 0.0075, 9.0 * normalized(dice.ball(1)),
                       id, 0, SphereKind::free, 0});
    i_of.push_back(i);
  }
};

struct Result {
  Sums sums{kSums};
  std::vector<Line> memory;
};

/// @param before blocks that are worked out before the sweep, as those at a halo are
/// @param across_interface all are; what spheres j get is kept and added afterwards
Result evaluate(const Kernel& kernel, const Law& law, const Chunk& chunk, bool mixed, bool sampled,
                std::vector<std::uint32_t> before, bool across_interface = false) {
  const MemoryShape shape = MemoryShape::of(law, mixed);
  // Unusual friction is evaluated as in sampled steps.
  const bool counted = sampled || !law->friction().usual();
  Result out{.memory = std::vector<Line>(shape.lines(kLanes.size()), Line{})};
  std::vector<BlockResult> ready(before.size());
  std::vector<BlockRows> rows(before.size()), interface_rows(kLanes.size());
  std::vector<std::uint8_t> given(kLanes.size(), 0);
  std::vector<std::uint8_t> awake(before.size());
  PairJob job{};
  job.record = job.accumulate = sampled;
  job.spheres = chunk.spheres.data(), job.mixed = mixed ? chunk.mixed.data() : nullptr;
  job.blocks = chunk.blocks.data(), job.shapes = chunk.shapes.data(), job.lines = out.memory.data();
  job.count = static_cast<std::uint32_t>(kLanes.size());
  job.uniform = chunk.uniform;
  job.elapsed = 1e-5;
  job.halo_block = before.data(), job.halo_count = static_cast<std::uint32_t>(before.size());
  job.halo_result = ready.data(), job.halo_rows = rows.data(), job.halo_active = awake.data();
  if (across_interface) job.interface_rows = interface_rows.data(), job.interface_given = given.data();
  if (!before.empty()) {
    job.halo = true;
    kernel.pairs(law, job);
    job.record = counted;
    kernel.keep(job);
    job.record = sampled;
    job.halo = false;
  }
  job.ring = out.sums.ring();
  job.record = across_interface ? counted : sampled;
  across_interface ? kernel.add_interface(job) : kernel.pairs(law, job);
  if (!across_interface) return out;
  EXPECT_EQ(std::count(given.begin(), given.end(), 1), static_cast<long>(kLanes.size()));
  for (std::size_t b = 0; b < kLanes.size(); ++b)
    for (std::uint32_t l = 0; l < kLanes[b]; ++l) {
      const std::uint32_t partner = chunk.blocks[b].j[l];
      const Accumulator before = out.sums.of(partner, mixed);
      EXPECT_EQ(before.f[0] + before.f[1] + before.f[2], 0);
      out.sums.add(partner, -interface_rows[b].of[l].f, interface_rows[b].of[l].t);
    }
  return out;
}

template <class Run>
void each_kernel_and_law(const Run& run) {
  for (const Kernel& kernel : every_kernel())
    for (const auto& [name, law] : every_law())
      for (const bool mixed : {false, true}) {
        SCOPED_TRACE(testing::Message() << kernel.name << ", " << name << (mixed ? ", mixed" : ""));
        run(kernel, table(law).laws[0], mixed);
      }
}

TEST(KernelChunks, SpheresIGetWhatSpheresJGive) {
  const Chunk chunk;
  ASSERT_EQ(chunk.spheres.size(), kBlock + std::accumulate(kLanes.begin(), kLanes.end(), 0u));
  each_kernel_and_law([&](const Kernel& kernel, const Law& law, bool mixed) {
    const Result r = evaluate(kernel, law, chunk, mixed, true, {});
    Vec3 sum[kBlock] = {};
    double scale = 0, touching[kBlock] = {};
    for (std::uint32_t p = kBlock; p < chunk.spheres.size(); ++p) {
      const Accumulator a = r.sums.of(p, mixed);
      const Vec3 force{a.f[0], a.f[1], a.f[2]};
      ASSERT_TRUE(std::isfinite(norm(force)));
      EXPECT_EQ(a.t[3], 1);  // a contact each
      sum[chunk.i_of[p]] += force, touching[chunk.i_of[p]] += a.t[3];
      scale = std::max(scale, norm(force));
    }
    EXPECT_GT(scale, 0);
    for (std::uint32_t i = 0; i < kBlock; ++i) {
      const Accumulator a = r.sums.of(i, mixed);
      // At most 11 forces, of which each addition rounds a sum no larger than all of them by half an ulp.
      const double rounding = mixed ? 6e-8 : 1.2e-16;
      EXPECT_LE(norm(Vec3{a.f[0], a.f[1], a.f[2]} + sum[i]), 2 * 11 * 11 * rounding * scale);
      EXPECT_EQ(a.t[3], touching[i]);
    }
  });
}

void compare_with_blocks_done_before(const Chunk& chunk) {
  const std::vector<std::uint32_t> sets[] = {{0}, {5}, {10}, {0, 3}, {1, 2, 6, 9}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}};
  each_kernel_and_law([&](const Kernel& kernel, const Law& law, bool mixed) {
    for (const bool sampled : {false, true}) {
      const Result whole = evaluate(kernel, law, chunk, mixed, sampled, {});
      const auto same_sums = [&](const Result& other) { return other.sums.same_bits(whole.sums, mixed, kSums); };
      EXPECT_TRUE(same_sums(evaluate(kernel, law, chunk, mixed, sampled, sets[5], true)));
      for (const auto& before : sets) {
        const Result parted = evaluate(kernel, law, chunk, mixed, sampled, before);
        EXPECT_TRUE(same_sums(parted)) << before.size() << " from " << before[0];
        for (std::uint32_t b = 0; b < kLanes.size(); ++b)
          for (std::uint32_t l = 0; l < kLanes[b]; ++l) {
            const auto state = [&](const Result& r) {
              const BlockMemory block =
                  BlockMemory::at(const_cast<Line*>(r.memory.data()), kLanes.size(), MemoryShape::of(law, mixed), b);
              return read_lane(block, MemoryShape::of(law, mixed), l);
            };
            EXPECT_EQ(norm(Vec3{state(parted).xi[0], state(parted).xi[1], state(parted).xi[2]}),
                      norm(Vec3{state(whole).xi[0], state(whole).xi[1], state(whole).xi[2]}));
          }
      }
    }
  });
}

TEST(KernelChunks, BlocksDoneBeforeChangeNoBit) {
  Chunk chunk;
  compare_with_blocks_done_before(chunk);
  chunk.uniform = true;
  compare_with_blocks_done_before(chunk);
}

}  // namespace
}  // namespace subsoil::dem::test::kernel_chunks
