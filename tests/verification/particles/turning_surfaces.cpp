// Friction against surfaces that turn, and of very small grains, in closed form.
#include <cmath>
#include <numbers>

#include "libdem/bed.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/laws.hpp"

namespace subsoil::dem::test::turning_surfaces {
namespace {

constexpr double pi = std::numbers::pi;

/// A ball that rolls on a turntable goes in a circle at 2/7 Omega (Weltner, Am. J. Phys. 47, 984, 1979; with the arm r
/// - delta of the contact as in docs/verification/index.md). The step is coarse, of 1e-4 s: the arm of the step's end,
/// with velocities of its middle, drags the ball by (2/7) Omega v dt/2 = 5.7e-6 m/s, 17 um in 3 s; what is left is of
/// second order in the step.
void expect_circle(const Shape& table_shape, bool turned) {
  const double r = 0.02, spin = 2, start = 0.1, g = 9.81, k = 1e6, density = 7800;
  const double delta = density * 4 * pi / 3 * r * r * r * g / k, arm = 1 - delta / r;
  const double rate = spin * 0.4 / (0.4 + arm * arm), circle = spin * start / rate, dt = 1e-4;
  Bed bed(table(grains(k, 0.5, 0.5, 0)), quiet({0, -g, 0}));
  const SphereSpec ball{{start, r - delta, 0}, {0, 0, -spin * start}, {}, r, density, 0};
  bed.add(std::span(&ball, 1));
  Boundary b;
  b.shape = table_shape;
  b.angular_velocity = {0, spin, 0};
  const int index = bed.add(std::move(b));
  for (int n = 0; n < 30000; ++n) {
    bed.step(dt);
    if (turned) bed.boundary(index).pose.attitude = Quaternion::from_rotation_vector({0, spin * (n + 1) * dt, 0});
  }
  const double t = 3;
  const Vec3 x = sphere(bed, 0).x;
  const double off =
      std::hypot(x.x - (start - circle + circle * std::cos(rate * t)), x.z + circle * std::sin(rate * t));
  std::printf("    distance from the circle's point after 3 s %.2e m\n", off);
  EXPECT_LT(off, 5e-7);
}

TEST(TurningSurfaces, ABallOnAPlaneGoesInItsCircle) { expect_circle(Plane({}, {0, 1, 0}), false); }
TEST(TurningSurfaces, ABallOnADiskGoesInItsCircle) {
  expect_circle(Cylinder({0, -0.05, 0}, {0, 1, 0}, 0.8, 0.1), true);
}

/// Lengths times L, stiffness times L^2, times by sqrt(L): every force is L^3 times as large, and the motion the same.
/// With L a power of 4 each number of the computation is the same but for its exponent, so that the results agree to
/// the rounding of what is added to constants, if no threshold of a law has a size of its own. Torques of grains of 10
/// nm are 1e-27 N m. Spheres slide, roll, twist and hit each other on a floor.
void expect_same_motion(Precision precision, int power, double tolerance) {
  const auto positions_of = [&](int fours) {
    const double scale = std::ldexp(1.0, -2 * fours), root = std::ldexp(1.0, -fours), r = 0.01;
    Linear law = grains(1e4 * scale * scale, 0.5, 0.5, 0.1);
    law.friction.mu_t = 0.05;
    BedOptions options = quiet({0, -9.81, 0});
    options.precision = precision;
    Bed bed(table(law), options);
    for (int k = 0; k < 4; ++k) {
      const SphereSpec one{scale * Vec3{2.5 * r * k, r, 0},
                           root * Vec3{0.5 - 0.3 * k, 0, 0.05 * k},
                           (root / scale) * Vec3{3.0 * k, 20.0 - 11 * k, -20},
                           scale * r,
                           2500,
                           0};
      bed.add(std::span(&one, 1));
    }
    add_plane(bed, {}, {0, 1, 0});
    for (int n = 0; n < 4000; ++n) bed.step(5e-5 * root);
    std::vector<double> out;
    for (std::uint32_t id = 0; id < 4; ++id)
      for (int d = 0; d < 3; ++d)
        out.push_back(sphere(bed, id).x[d] / scale), out.push_back(sphere(bed, id).w[d] * root);
    return out;
  };
  const std::vector<double> large = positions_of(0), small = positions_of(power);
  for (std::size_t k = 0; k < large.size(); ++k)
    EXPECT_NEAR(small[k], large[k], tolerance * std::max(std::abs(large[k]), 1e-2)) << "number " << k;
}

TEST(FineGrains, MoveAsCoarseOnes) { expect_same_motion(Precision::doubles, 10, 1e-9); }
TEST(FineGrains, MoveAsCoarseOnesInMixedPrecision) { expect_same_motion(Precision::mixed, 8, 1e-4); }

}  // namespace
}  // namespace subsoil::dem::test::turning_surfaces
