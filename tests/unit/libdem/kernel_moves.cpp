#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_kernel.hpp"

/// Kick, drift and energies of spheres, by each instruction set and in either precision, against the formulas in
/// extended precision.
namespace subsoil::dem::test::kernel_moves {
namespace {

using Real = long double;
constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kBefore = 1.7e-5, kDt = 2.3e-5, kGravity[3] = {0.4, -9.81, 0.2};
constexpr std::uint32_t kBegin = 512, kRing = 1024;  // a tile somewhere in the bed

/// Spheres from kBegin on, in both kinds of record, and sums in a ring that has come round.
struct Tile {
  std::vector<Sphere> spheres{kBegin};
  std::vector<MixedSphere> mixed{kBegin};
  Sums sums{kRing};

  Tile(std::uint32_t count, bool uniform, std::uint32_t seed) {
    Dice dice(seed);
    for (std::uint32_t k = 0; k < count; ++k) {
      Sphere s{};
      s.x = dice.ball(2), s.v = dice.ball(0.5), s.w = dice.ball(40);
      s.r = uniform ? 0.01 : dice.between(0.002, 0.02), s.m = 7500 * s.r * s.r * s.r;
      s.id = 0xFFFFFFF0u + k, s.material = static_cast<std::uint16_t>(k % 3 == 0 ? 0x7FF8 : k);  // no number, or tiny
      spheres.push_back(s), mixed.push_back(rounded(s, s.m));
      const Vec3 force = dice.ball(3), torque = dice.ball(0.02);
      sums.add((kBegin + k) & (kRing - 1), Four{force.x, force.y, force.z, 0},
               Four{torque.x, torque.y, torque.z, static_cast<double>(k % 12)});
    }
  }
  std::uint32_t end() const { return static_cast<std::uint32_t>(spheres.size()); }
  template <class Job>
  Job job(bool in_mixed, bool uniform) {
    Job j{};
    j.spheres = spheres.data(), j.mixed = in_mixed ? mixed.data() : nullptr;
    j.begin = kBegin, j.end = end();
    j.ring = sums.ring(), j.uniform = uniform;
    for (int d = 0; d < 3; ++d) j.gravity[d] = kGravity[d];
    return j;
  }
};

/// A sphere as the kernel reads it.
struct State {
  Real x[3], v[3], w[3], m, r;
};
State state_of(const Tile& t, std::uint32_t i, bool in_mixed) {
  State s{};
  const Sphere& a = t.spheres[i];
  const MixedSphere& b = t.mixed[i];
  for (int d = 0; d < 3; ++d) {
    s.x[d] = in_mixed ? b.x[d] : a.x[d];
    s.v[d] = in_mixed ? static_cast<Real>(b.v[d]) : static_cast<Real>(a.v[d]);
    s.w[d] = in_mixed ? static_cast<Real>(b.w[d]) : static_cast<Real>(a.w[d]);
  }
  s.m = in_mixed ? static_cast<Real>(b.m) : static_cast<Real>(a.m), s.r = in_mixed ? b.r : a.r;
  return s;
}

template <class Run>
void each_case(const Run& run) {
  for (const Kernel& kernel : every_kernel())
    for (const std::uint32_t count : {1u, 7u, 32u, 33u, 250u, 256u})
      for (const bool mixed : {false, true})
        for (const bool uniform : {false, true}) {
          SCOPED_TRACE(testing::Message()
                       << kernel.name << ", " << count << (mixed ? ", mixed" : "") << (uniform ? ", uniform" : ""));
          run(kernel, count, mixed, uniform);
        }
}

// A few roundings of the largest term: sums of two or three products.
void expect_close(Real value, Real expected, Real largest, Real unit = 4 * kEps) {
  EXPECT_LE(std::abs(value - expected), unit * largest)
      << static_cast<double>(value) << " against " << static_cast<double>(expected);
}

TEST(KernelMoves, KicksAndDrifts) {
  each_case([](const Kernel& kernel, std::uint32_t count, bool mixed, bool uniform) {
    const Tile before(count, uniform, 5);
    Tile after = before;
    MoveJob job = after.job<MoveJob>(mixed, uniform);
    job.kick = 0.5 * (kBefore + kDt), job.dt = kDt;
    kernel.move(job);
    Real fastest = 0, squares = 0;
    const Real unit = mixed ? static_cast<Real>(0.5001) * std::numeric_limits<float>::epsilon() : 4 * kEps;
    for (std::uint32_t i = kBegin; i < before.end(); ++i) {
      const State s = state_of(before, i, mixed), now = state_of(after, i, mixed);
      const Accumulator a = before.sums.of(i & (kRing - 1), mixed);
      Real v2 = 0, w2 = 0;
      const Real inertia = static_cast<Real>(0.4) * s.m * s.r * s.r;
      for (int d = 0; d < 3; ++d) {
        const Real kick = a.f[d] / s.m * job.kick, fall = static_cast<Real>(kGravity[d]) * job.kick;
        const Real v = s.v[d] + kick + fall, spin = a.t[d] / inertia * job.kick, w = s.w[d] + spin;
        // What is left of larger terms is rounded once more in mixed precision.
        expect_close(now.v[d], v, std::max(std::abs(v), mixed ? 0 : std::abs(kick) + std::abs(s.v[d])), unit);
        expect_close(now.w[d], w, std::max(std::abs(w), mixed ? 0 : std::abs(spin) + std::abs(s.w[d])), unit);
        expect_close(now.x[d], s.x[d] + v * kDt, 2 + std::abs(v));
        v2 += v * v, w2 += w * w;
      }
      fastest = std::max(fastest, v2), squares += v2 + w2;
      const Accumulator left = after.sums.of(i & (kRing - 1), mixed);
      for (int k = 0; k < 4; ++k) {
        EXPECT_EQ(left.f[k], 0);
        EXPECT_EQ(left.t[k], 0);
      }
      EXPECT_EQ(after.spheres[i].id, before.spheres[i].id);
      EXPECT_EQ(after.spheres[i].material, before.spheres[i].material);
      EXPECT_EQ(after.spheres[i].r, before.spheres[i].r);
      EXPECT_EQ(after.spheres[i].m, before.spheres[i].m);
      EXPECT_EQ(after.mixed[i].m, before.mixed[i].m);
      EXPECT_EQ(after.mixed[i].r_single, before.mixed[i].r_single);
    }
    expect_close(job.speed2, fastest, fastest, 16 * kEps);
    expect_close(job.squares, squares, squares, count * kEps + 16 * kEps);
    // The rest of the ring is not its own.
    for (const bool either : {false, true}) EXPECT_TRUE(after.sums.same_bits(before.sums, either, kBegin));
  });
}

TEST(KernelMoves, BrokenNumbersShowInTheSumOfSquares) {
  each_case([](const Kernel& kernel, std::uint32_t count, bool mixed, bool uniform) {
    const Four broken{0, std::numeric_limits<double>::quiet_NaN(), 0, 0};
    for (const bool turns : {false, true}) {
      Tile t(count, uniform, 6);
      t.sums.add((kBegin + count / 2) & (kRing - 1), turns ? Four{} : broken, turns ? broken : Four{});
      MoveJob job = t.job<MoveJob>(mixed, uniform);
      job.kick = job.dt = kDt;
      kernel.move(job);
      EXPECT_TRUE(std::isnan(job.squares));
    }
  });
}

TEST(KernelMoves, EnergiesAreThoseAtTheInstant) {
  each_case([](const Kernel& kernel, std::uint32_t count, bool mixed, bool uniform) {
    for (const double since : {kBefore, 0.0}) {
      Tile t(count, uniform, 7);
      ObserveJob job = t.job<ObserveJob>(mixed, uniform);
      job.before = since, job.dt = kDt;
      kernel.observe(job);
      Real kinetic = 0, spin = 0, potential = 0, moved = 0, turned = 0, high = 0;
      for (std::uint32_t i = kBegin; i < t.end(); ++i) {
        const State s = state_of(t, i, mixed);
        const Accumulator a = t.sums.of(i & (kRing - 1), mixed);
        const Real inertia = static_cast<Real>(0.4) * s.m * s.r * s.r;
        for (int d = 0; d < 3; ++d) {
          // (m/2) v_{n-1/2} . v_{n+1/2} where steps are even: by the mean velocity at t_n otherwise.
          const Real push = a.f[d] / s.m + static_cast<Real>(kGravity[d]), turn = a.t[d] / inertia;
          const Real v = s.v[d] + push * since / 2, w = s.w[d] + turn * since / 2;
          kinetic += s.m / 2 * (v * v - since * kDt / 4 * push * push), moved += s.m / 2 * v * v;
          spin += inertia / 2 * (w * w - since * kDt / 4 * turn * turn), turned += inertia / 2 * w * w;
          potential -= s.m * kGravity[d] * s.x[d], high += std::abs(s.m * kGravity[d] * s.x[d]);
        }
      }
      expect_close(job.kinetic, kinetic, moved, (count + 16) * kEps);
      expect_close(job.rotational, spin, turned, (count + 16) * kEps);
      expect_close(job.potential, potential, high, (count + 16) * kEps);
    }
  });
}

}  // namespace
}  // namespace subsoil::dem::test::kernel_moves
