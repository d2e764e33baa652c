#include <gtest/gtest.h>

#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_law.hpp"
#include "tests/tools/verified.hpp"

/// Two wet spheres of the source (r 10 mm, 1800 kg/m3): pull-apart curve, work of separation, period, creep; momentum.
namespace subsoil::dem::test::wet_pair {
namespace {

using subsoil::test::absolute;
using subsoil::test::share;
using subsoil::test::Verified;
using subsoil::test::Worst;

const std::string kField = "Wet particles", kSource = "Yuan & Yu 2020, doi:10.6041/j.issn.1000-1298.2020.S1.003";
constexpr double kR = 0.01, kDensity = 1800;
const double kMass = kDensity * 4 / 3 * pi * kR * kR * kR;

std::vector<SphereSpec> pair_at(double overlap) {
  return {{{-kR + overlap / 2, 0, 0}, {}, {}, kR, kDensity, 0}, {{kR - overlap / 2, 0, 0}, {}, {}, kR, kDensity, 0}};
}

/// Quasi-static: a fresh bed at rest for each gap, so the force is the law's alone.
TEST(WetPair, PullApartCurveThroughTheEngine) {
  const Verified row(kField, "Force over the gap of two spheres of 10 mm", kSource + ", eq. (12) to (21)");
  Worst worst;
  for (int k = -450; k <= 450; ++k) {
    const double overlap = k * 1e-5 + 3.3e-6;
    Bed bed(table(soil()), quiet());
    bed.add(pair_at(overlap));
    const double force = -observe(bed, 1e-6).force[0].x;  // on the left sphere: compression pushes to -x
    const double want = overlap > 2e-3    ? 1e4 * (overlap - 2e-3)
                        : overlap >= 0    ? -7e3 * (2e-3 - overlap)
                        : overlap > -2e-3 ? -7e3 * (2e-3 + overlap)
                                          : 0;
    char at[32];
    std::snprintf(at, sizeof at, "overlap %g mm", overlap * 1e3);
    worst.take(at, force, want);
  }
  worst.near(row, "force at 901 overlaps from -4.5 to 4.5 mm", "N", absolute(1e-12),
             "overlap is a difference of lengths of 20 mm: 3e-18 m times 10 kN/m");
}

/// Work that a plate does which draws a sphere off slowly: (K_C dc^2 + K_B dB^2)/2 = 28 mJ, sphere held by a pair.
TEST(WetPair, WorkOfSeparation) {
  Bed bed(table(soil()), quiet());
  // The sphere hangs between two planes at rest overlap; a heavy one does not follow the plane that leaves.
  const SphereSpec s{{0, kR - 2e-3, 0}, {}, {}, kR, kDensity * 1e9, 0};
  bed.add(std::span(&s, 1));
  const Motion away{add_plane(bed, {}, {0, 1, 0}), {}, {0, -0.05, 0}, {}};
  const double dt = 1e-5;
  for (int n = 0; n < 8200; ++n) {  // 4.1 mm: from the rest overlap of 2 mm over the gap of 2 mm
    away.place(bed);
    bed.step(dt);
  }
  EXPECT_EQ(bed.boundary(away.boundary).contacts, 0);
  // Trapezoidal over 8000 steps across two kinks: error K (v dt)^2, 2e-9 J; damping is zero in the attractive bands.
  const Verified row(kField, "Work of separation from the rest overlap", kSource + ": (K_C dc^2 + K_B dB^2)/2");
  row.near("work", "J", bed.boundary(away.boundary).work, 28e-3, absolute(1e-7),
           "trapezoids over 8000 steps, two kinks");
}

TEST(WetPair, SmallOscillationPeriod) {
  Wet law = soil();
  law.C_X = 0;
  Bed bed(table(law), quiet());
  bed.add(pair_at(2e-3 + 1e-6));
  const double dt = 1e-6, want = pi * std::sqrt(kMass / 2) * (1 / std::sqrt(1e4) + 1 / std::sqrt(7e3));
  EXPECT_NEAR(want, 4.2344e-3, 5e-8);
  // Period between crossings of the rest overlap in the same direction, interpolated.
  double before = 1e-6, first = 0, last = 0;
  int crossings = 0;
  for (int n = 0; crossings < 11; ++n) {
    bed.step(dt);
    const double now = 2 * kR - norm(sphere(bed, 0).x - sphere(bed, 1).x) - 2e-3;
    if (before > 0 && now <= 0) (crossings++ == 0 ? first : last) = bed.time() - dt * now / (now - before);
    before = now;
  }
  // Leapfrog shortens by (omega dt)^2/24 = 1e-7; the kink at rest adds a step's random share.
  const Verified row(kField, "Small oscillation about the rest overlap, C_X 0",
                     "pi sqrt(m_eff) (1/sqrt(K_X) + 1/sqrt(K_C))");
  row.near("period", "s", (last - first) / 10, want, share(1e-5), "the kink at rest adds a step's random share");
}

TEST(WetPair, CreepsBackWithoutOvershoot) {
  const Verified row(kField, "Creep back from 10 um beyond rest, damping ratio 1.63",
                     "two real roots of the overdamped pair");
  // x'' + b x' + a x = 0: a = 2K/m, b = 2C/m.
  const double a = 1e4 / (kMass / 2), b = 20 / (kMass / 2), slow = b / 2 - std::sqrt(b * b / 4 - a);
  const double fast = b / 2 + std::sqrt(b * b / 4 - a);
  Bed bed(table(soil()), quiet());
  bed.add(pair_at(2e-3 + 1e-5));
  double before = 1e-5;
  for (int n = 1; n <= 20000; ++n) {
    bed.step(1e-6);
    const double now = 2 * kR - norm(sphere(bed, 0).x - sphere(bed, 1).x) - 2e-3;
    EXPECT_LT(now, before + 1e-17);
    EXPECT_GT(now, -1e-17) << "overdamped, ratio 1.63: no overshoot";
    before = now;
    if (n != 1000 && n != 5000 && n != 20000) continue;
    const double t = n * 1e-6;
    const double want = 1e-5 * (fast * std::exp(-slow * t) - slow * std::exp(-fast * t)) / (fast - slow);
    row.near("overlap beyond rest after " + std::to_string(n / 1000) + " ms", "m", now, want, share(5e-3),
             "damping lags by half a step of 1 us, which shifts the slow root by 3e-4");
  }
}

/// A cluster of five unequal spheres thrown together, no gravity: momentum and angular momentum to rounding. The force
/// at the middle of the overlap acts on both at one point, so angular momentum is kept exactly at every step:
/// x += v dt adds dt v x m v = 0, and force pairs share their line but for the tangential moment arm.
TEST(Momentum, ClusterWithEveryLaw) {
  const Verified row("Momentum", "Cluster of five unequal spheres, every law, 3000 steps", "conservation");
  Worst linear, angular;
  for (const auto& [name, law] : every_law()) {
    Bed bed(table(law), quiet());
    Dice dice(23);
    std::vector<SphereSpec> specs;
    const Vec3 corners[] = {{0, 0, 0}, {.018, 0, 0}, {.009, .016, 0}, {.009, .005, .014}, {.01, .005, -.015}};
    for (const Vec3& x : corners)
      specs.push_back({x + dice.ball(5e-4), dice.ball(0.4) - 20.0 * (x - Vec3{.009, .005, 0}), dice.ball(60),
                       dice.between(0.007, 0.01), 1800, 0});
    bed.add(specs);
    const auto sums = [&] {
      Vec3 p, l;
      double scale_p = 0, scale_l = 0;
      for (const Sphere& s : bed.spheres()) {
        p += s.m * s.v;
        l += s.m * cross(s.x, s.v) + inertia(s) * s.w;
        scale_p += s.m * norm(s.v);
        scale_l += s.m * norm(s.x) * norm(s.v) + inertia(s) * norm(s.w);
      }
      return std::tuple(p, l, scale_p, scale_l);
    };
    bed.step(1e-5);
    const auto [p0, l0, scale_p, scale_l] = sums();
    std::size_t touched = 0;
    for (int n = 0; n < 3000; ++n) {
      bed.step(1e-5);
      touched += bed.touching_pairs();
    }
    const auto [p1, l1, unused_p, unused_l] = sums();
    EXPECT_GT(touched, 100u) << name;
    linear.take(name, norm(p1 - p0) / scale_p, 0);
    // Arms that do not meet at one point let the pair's torques differ; other programs have such conventions.
    if (law->friction().moment_arm == MomentArm::mid_overlap) angular.take(name, norm(l1 - l0) / scale_l, 0);
  }
  const char* const rounding = "rounding of 3000 steps";
  linear.near(row, "change of momentum, over the sum of its parts", "1", absolute(1e-12), rounding);
  angular.near(row, "change of angular momentum, over the sum of its parts", "1", absolute(1e-12), rounding);
}

/// Unequal spheres head-on, linear law: they part after pi/omega_d with velocities of the collision law.
TEST(UnequalPair, CollisionLaw) {
  for (const double e : {0.4, 0.9}) {
    const double r1 = 4e-3, r2 = 12e-3, k = 1e5;
    Bed bed(table(grains(k, e, 0.3)), quiet());
    const std::vector<SphereSpec> two{{{-r1 - 1e-9, 0, 0}, {1.5, 0, 0}, {}, r1, 2000, 0},
                                      {{r2 + 1e-9, 0, 0}, {-0.5, 0, 0}, {}, r2, 1500, 0}};
    bed.add(two);
    const double m1 = sphere(bed, 0).m, m2 = sphere(bed, 1).m;
    for (int n = 0; n < 100000 && (n < 10 || bed.touching_pairs() > 0); ++n) bed.step(2e-8);
    const double centre = (m1 * 1.5 - m2 * 0.5) / (m1 + m2);
    const Verified row("Momentum", "Unequal spheres head-on, linear spring", "collision law");
    const std::string given = e < 0.5 ? ", e 0.4" : ", e 0.9";
    const char* const why = "damping lags by half a step";
    row.near("speed of the small one" + given, "m/s", sphere(bed, 0).v.x, centre - e * 2 * m2 / (m1 + m2),
             absolute(2e-3), why);
    row.near("speed of the large one" + given, "m/s", sphere(bed, 1).v.x, centre + e * 2 * m1 / (m1 + m2),
             absolute(2e-3), why);
  }
}

}  // namespace
}  // namespace subsoil::dem::test::wet_pair
