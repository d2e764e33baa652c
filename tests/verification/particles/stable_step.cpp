#include <gtest/gtest.h>

#include "libdem/step/stability.hpp"
#include "tests/tools/dem_beds.hpp"

/// The stable step by experiment: a small random disturbance of a bed at rest either stays or grows. The limit found by
/// bisection must lie above stable_step (safe side; bisection stops within 2 %, hence 0.98) and within the stated
/// factor.
namespace subsoil::dem::test::stability {
namespace {

/// How a tiny random disturbance of all velocities and spins grows: the distance between a disturbed run and an
/// undisturbed one, so that the slow spreading of a pressed lattice does not count.
double growth(const Law& law, const std::vector<SphereSpec>& rest, double dt) {
  BedOptions options = quiet();
  options.speed_limit = 1e6, options.overlap_limit = 1e6;
  options.skin = 5e-3;  // one build: both runs keep the same order
  Bed still(table(law), options), disturbed(table(law), options);
  std::vector<SphereSpec> specs = rest;
  still.add(specs);
  Dice dice(51);
  for (SphereSpec& s : specs) s.velocity = dice.ball(1e-7), s.angular_velocity = dice.ball(1e-5);
  disturbed.add(specs);
  const auto apart = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < specs.size(); ++i) {
      const Vec3 v = still.spheres()[i].v - disturbed.spheres()[i].v,
                 w = still.spheres()[i].w - disturbed.spheres()[i].w;
      sum += dot(v, v) + 0.4e-4 * dot(w, w);
    }
    return std::sqrt(sum);
  };
  still.step(dt), disturbed.step(dt);
  const double start = apart();
  double largest = start;
  for (int n = 0; n < 150 && largest < 1e3 * start; ++n) {
    still.step(dt), disturbed.step(dt);
    largest = std::max(largest, apart());
  }
  return largest / start;
}

/// By bisection. Two per cent above the limit a mode grows by 1.04 a step when damping sets it, faster otherwise:
/// above 30 in 150 steps.
double measured_limit(const Law& law, const std::vector<SphereSpec>& rest, double guess) {
  double stable = 0.3 * guess, unstable = 4 * guess;
  EXPECT_LT(growth(law, rest, stable), 30);
  EXPECT_GT(growth(law, rest, unstable), 30);
  while (unstable > 1.02 * stable) {
    const double middle = std::sqrt(stable * unstable);
    (growth(law, rest, middle) < 30 ? stable : unstable) = middle;
  }
  return stable;
}

constexpr double kR = 0.01, kDensity = 1800;

StableStep predicted(const Law& law, int neighbours) {
  return stable_step(
      table(law).laws[0],
      {.smallest_radius = kR, .largest_radius = kR, .density = kDensity, .speed = 0.1, .neighbours = neighbours});
}

std::vector<SphereSpec> cubic(int n, double pitch) {
  std::vector<SphereSpec> out;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) out.push_back({{i * pitch, j * pitch, k * pitch}, {}, {}, kR, kDensity, 0});
  return out;
}

std::vector<SphereSpec> face_centred(int n, double distance) {
  std::vector<SphereSpec> out;
  const double a = distance * std::sqrt(2.0);
  const Vec3 basis[] = {{0, 0, 0}, {.5, .5, 0}, {.5, 0, .5}, {0, .5, .5}};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        for (const Vec3& b : basis)
          out.push_back({a * (b + Vec3{double(i), double(j), double(k)}), {}, {}, kR, kDensity, 0});
  return out;
}

struct Named {
  const char* name;
  Law law;
  double overlap;  ///< at which springs, friction and damping act
};

/// Springs that pull as they push, at their rest length: a packing without stress, whose steady state is exact. Grip
/// enough to stick. The soil law as printed is pressed by 0.2 mm, so that its repulsion and damping act.
std::vector<Named> laws() {
  Wet springs = soil();
  springs.K_B = springs.K_X, springs.C_X = springs.C_Y = 0, springs.friction.mu_r = 0.1;
  Wet dashpots = soil();
  dashpots.K_B = dashpots.K_X, dashpots.damping = Wet::Damping::all_bands, dashpots.C_X = 60;
  return {{"soil", soil(), 2.2e-3}, {"springs", springs, 2e-3}, {"dashpots", dashpots, 2e-3}};
}

void check(const Named& c, const char* packing, const std::vector<SphereSpec>& rest, int neighbours, double factor) {
  const StableStep limit = predicted(c.law, neighbours);
  const double measured = measured_limit(c.law, rest, limit.step);
  std::printf("  %-16s %-14s stable_step %.3g s (%s), measured %.3g s, ratio %.2f\n", c.name, packing, limit.step,
              limit.cause.c_str(), measured, measured / limit.step);
  EXPECT_GT(measured, 0.98 * limit.step) << c.name << ", " << packing;
  EXPECT_LT(measured, factor * limit.step) << c.name << ", " << packing;
}

TEST(StableStep, Pair) {
  for (const Named& c : laws())
    check(c, "pair", {{{0, 0, 0}, {}, {}, kR, kDensity, 0}, {{2 * kR - c.overlap, 0, 0}, {}, {}, kR, kDensity, 0}}, 1,
          1.1);
}

/// Free lattices push themselves apart by stress, slowly against the few hundred steps of a trial.
TEST(StableStep, CubicLattice) {
  for (const Named& c : laws()) check(c, "cubic", cubic(6, 2 * kR - c.overlap), 6, 1.3);
}

TEST(StableStep, DensePacking) {
  for (const Named& c : laws()) check(c, "dense", face_centred(4, 2 * kR - c.overlap), 12, 1.5);
}

/// One sphere in the corner of three planes: all of its translation and rotation is coupled.
TEST(StableStep, CornerOfSurfaces) {
  for (const Named& c : laws()) {
    const double x = kR - c.overlap;
    const auto diverges = [&](double dt) {
      Bed bed(table(c.law), quiet());
      const SphereSpec s{{x, x, x}, {1e-7, -3e-8, 2e-8}, {1e-5, 2e-5, -3e-5}, kR, kDensity, 0};
      bed.add(std::span(&s, 1));
      for (const Vec3& n : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) add_plane(bed, {}, n);
      bed.step(dt);
      // The spin of one undamped axis stays; what grows is unstable. Soil pressed by 0.2 mm creeps out along (1, 1, 1).
      const auto speed = [&] {
        const Sphere& q = bed.spheres()[0];
        return std::abs(q.v.x - q.v.y) + std::abs(q.v.y - q.v.z) + kR * norm(q.w);
      };
      const double start = speed();
      for (int n = 0; n < 150; ++n) {
        bed.step(dt);
        if (speed() > 30 * start) return true;
      }
      return false;
    };
    const double limit =
        stable_step_at_surface(
            table(c.law).laws[0],
            {.smallest_radius = kR, .largest_radius = kR, .density = kDensity, .speed = 0.1, .neighbours = 12})
            .step;
    EXPECT_FALSE(diverges(0.95 * limit)) << c.name;
    EXPECT_TRUE(diverges(1.5 * limit)) << c.name;
  }
}

/// The modes' formula against the exact characteristic polynomial of one leapfrog step.
TEST(StableStep, OneModeIsMarginalAtTheLimit) {
  for (const double a : {0.0, 1e6, 4e7})
    for (const double b : {0.0, 10.0, 5e3, 1e5}) {
      if (a == 0 && b == 0) continue;
      const auto spectral_radius = [&](double dt) {
        // (v, x) -> (v - dt(a x + b v), x + dt v'): trace 2 - a dt^2 - b dt, determinant 1 - b dt.
        const double trace = 2 - a * dt * dt - b * dt, det = 1 - b * dt, d = trace * trace / 4 - det;
        return d < 0 ? std::sqrt(det)
                     : std::max(std::abs(trace / 2 + std::sqrt(d)), std::abs(trace / 2 - std::sqrt(d)));
      };
      const double limit = stable_step_of_mode(a, b);
      EXPECT_LE(spectral_radius(0.999 * limit), 1 + 1e-12);
      EXPECT_GT(spectral_radius(1.001 * limit), 1 + 1e-6);
    }
}

/// model.md section 2: pair values read in N/m, cubic lattice with spin 3.7e-5 s (lever r) and 4.6e-5 s (mid-overlap);
/// dense packing 1.9e-5 and 2.3e-5 s.
TEST(StableStep, Table3InTheSourcesUnits) {
  Wet at_radius = soil();
  at_radius.friction.moment_arm = MomentArm::radius;
  at_radius.friction.mu_r = 0;
  Wet middle = soil();
  middle.friction.mu_r = 0;
  EXPECT_NEAR(predicted(at_radius, 6).step, 3.7e-5, 0.1e-5);
  EXPECT_NEAR(predicted(middle, 6).step, 4.6e-5, 0.1e-5);
  EXPECT_NEAR(predicted(at_radius, 12).step, 1.9e-5, 0.1e-5);
  EXPECT_NEAR(predicted(middle, 12).step, 2.3e-5, 0.1e-5);
}

}  // namespace
}  // namespace subsoil::dem::test::stability
