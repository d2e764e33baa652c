#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "libdem/geometry/sphere_union.hpp"
#include "libdem/particles/clump.hpp"

/// Mass, centre and inertia of unions of spheres against integrals in closed form.
namespace subsoil::dem::test::clump_shapes {
namespace {

constexpr double pi = std::numbers::pi;

/// A polynomial p, lowest power first, integrated from a to b.
double integral(const std::vector<double>& p, double a, double b) {
  double sum = 0;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const double n = static_cast<double>(k + 1);
    sum += p[k] * (std::pow(b, n) - std::pow(a, n)) / n;
  }
  return sum;
}

struct Axial {
  double volume, first, axial, second;  ///< 1, z, x^2 + y^2 and z^2, integrated
};
/// Of the part of a ball of radius r about z = c that lies between z = a and b: slices are discs of radius^2 r^2 - (z -
/// c)^2.
Axial slab(double r, double c, double a, double b) {
  const double s = r * r - c * c;
  const std::vector<double> q{s, 2 * c, -1};  // r^2 - (z - c)^2
  const std::vector<double> zq{0, s, 2 * c, -1}, zzq{0, 0, s, 2 * c, -1};
  const std::vector<double> qq{s * s, 4 * c * s, 4 * c * c - 2 * s, -4 * c, 1};
  return {pi * integral(q, a, b), pi * integral(zq, a, b), 0.5 * pi * integral(qq, a, b), pi * integral(zzq, a, b)};
}

/// Two balls on an axis, at 0 and d, that meet in the plane z = p.
struct TwoBalls {
  double volume, centre, axial, transverse;
  TwoBalls(double r, double big, double d) {
    const double p = (d * d + r * r - big * big) / (2 * d);
    const Axial a = slab(r, 0, -r, p), b = slab(big, d, p, d + big);
    volume = a.volume + b.volume, centre = (a.first + b.first) / volume, axial = a.axial + b.axial;
    transverse = 0.5 * axial + a.second + b.second - volume * centre * centre;
  }
};

std::array<double, 3> principal(const SolidMoments& m) {
  auto values = symmetric_eigen<3>(m.inertia).values;
  std::sort(values.begin(), values.end());
  return values;
}

/// The lens that two equal spheres share counts once; in any direction. Gauss's rule reaches 1e-10 of it and says so.
TEST(UnionOfSpheres, TwoThatOverlapAreAsInClosedForm) {
  for (const auto& [r, big, d] : {std::array{1.0, 1.0, 1.2}, {1.0, 1.7, 1.1}, {0.4, 1.3, 1.6}, {1.0, 1.0, 0.01}})
    for (const Vec3& way : {Vec3{0, 0, 1}, {1, 0, 0}, {0.6, -0.48, 0.64}}) {
      const TwoBalls expected(r, big, d);
      const Vec3 at{0.3, -2, 5};
      const Ball balls[] = {{at, r}, {at + d * way, big}};
      const SolidMoments m = moments_of_union(balls);
      EXPECT_NEAR(m.volume, expected.volume, 1e-10 * expected.volume);
      EXPECT_LT(norm(m.centre - (at + expected.centre * way)), 1e-10 * big);
      auto j = std::array{expected.axial, expected.transverse, expected.transverse};
      std::sort(j.begin(), j.end());
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(principal(m)[k], j[k], 1e-10 * j[k]);
      EXPECT_LT(m.error, 1e-8);
      EXPECT_GT(m.error, 0);
    }
}

/// Apart they are sums, without any integration.
TEST(UnionOfSpheres, ThoseThatDoNotOverlapAreExact) {
  const Ball balls[] = {{{-1, 0, 0}, 1}, {{1, 0, 0}, 1}, {{0, 3, 0}, 0.5}};
  const SolidMoments m = moments_of_union(balls);
  const double v = 4 * pi / 3, w = v / 8;
  EXPECT_EQ(m.error, 0);
  EXPECT_NEAR(m.volume, 2 * v + w, 1e-14);
  const double y = 3 * w / (2 * v + w);
  EXPECT_NEAR(m.centre.y, y, 1e-15);
  // about z: 2/5 r^2 of each and its distance
  EXPECT_NEAR(m.inertia[2][2], 2 * v * (0.4 + 1 + y * y) + w * (0.4 * 0.25 + (3 - y) * (3 - y)), 1e-13);
}

TEST(UnionOfSpheres, WhatLiesWithinAddsNothing) {
  const Ball one[] = {{{0.1, 0.2, 0.3}, 1}};
  const Ball more[] = {one[0], {{0.1, 0.5, 0.3}, 0.3}, one[0], {{0.1, 0.2, 0.3}, 0.9}};
  const SolidMoments a = moments_of_union(one), b = moments_of_union(more);
  EXPECT_NEAR(a.volume, b.volume, 1e-11);
  EXPECT_LT(norm(a.centre - b.centre), 1e-11);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(principal(a)[k], principal(b)[k], 1e-11);
}

/// Of three that have a region in common, turned about any axis: the same volume and principal moments, though slices
/// lie in another way; and those of points drawn in the box, to three deviations of the draw.
TEST(UnionOfSpheres, ThreeInOneAnotherDoNotDependOnTheSlices) {
  const std::vector<Ball> balls{{{0, 0, 0}, 1}, {{0.9, 0.1, 0}, 0.8}, {{0.4, 0.8, 0.2}, 0.9}, {{0.2, 0.3, 1.1}, 0.6}};
  const SolidMoments m = moments_of_union(balls);
  for (const Vec3& turn : {Vec3{0.3, 0.4, -0.2}, {2, 1, 0.5}, {0, pi / 2, 0}}) {
    std::vector<Ball> turned = balls;
    for (Ball& b : turned) b.centre = Quaternion::from_rotation_vector(turn).rotate(b.centre);
    const SolidMoments n = moments_of_union(turned);
    EXPECT_NEAR(n.volume, m.volume, 1e-9 * m.volume);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(principal(n)[k], principal(m)[k], 1e-9 * principal(m)[k]);
  }
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> in(-2, 2);
  constexpr int draws = 400000;
  int inside = 0;
  double distance2 = 0;
  for (int k = 0; k < draws; ++k) {
    const Vec3 x{in(engine), in(engine), in(engine)};
    if (is_exposed(balls, x, balls.size())) continue;
    ++inside;
    distance2 += dot(x - m.centre, x - m.centre);
  }
  const double share = m.volume / 64, off = std::sqrt(share * (1 - share) / draws);
  EXPECT_NEAR(inside / double{draws}, share, 3 * off);
  const double trace = 0.5 * (m.inertia[0][0] + m.inertia[1][1] + m.inertia[2][2]);  // of |x|^2
  EXPECT_NEAR(64 * distance2 / draws, trace, 3 * trace * off / share);
}

/// 27 balls on a lattice along the axes: hundreds of points in which three meet lie at one height, circles are level.
/// Turned, no two heights are alike.
TEST(UnionOfSpheres, ALatticeOfBallsDoesNotDependOnTheSlices) {
  std::vector<Ball> balls, turned;
  for (int i = 0; i < 27; ++i)
    balls.push_back(
        {{static_cast<double>(i % 3) - 1, static_cast<double>(i / 3 % 3) - 1, static_cast<double>(i / 9) - 1}, 0.8});
  for (const Ball& b : balls)
    turned.push_back({Quaternion::from_rotation_vector({0.3, 0.4, -0.2}).rotate(b.centre), b.radius});
  const SolidMoments m = moments_of_union(balls), n = moments_of_union(turned);
  EXPECT_NEAR(n.volume, m.volume, 1e-9 * m.volume);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(principal(n)[k], principal(m)[k], 1e-9 * principal(m)[k]);
}

TEST(UnionOfSpheres, NoBodyIsRefused) {
  EXPECT_THROW(moments_of_union({}), std::invalid_argument);
  const Ball balls[] = {{{}, 1}, {{}, 0}};
  EXPECT_THROW(moments_of_union(balls), std::invalid_argument);
}

TEST(ClumpShape, PrincipalAxesGiveTheSpheresBack) {
  const std::vector<ClumpMember> members{{{0, 0, 0}, 3e-3}, {{4e-3, 1e-3, 0}, 2e-3}, {{5e-3, 3e-3, 2e-3}, 2e-3}};
  const ClumpShape shape = clump_shape("bean", members, 1200);
  for (std::size_t k = 0; k < members.size(); ++k)
    EXPECT_LT(norm(shape.centre + shape.axes.rotate(shape.members[k].at) - members[k].at), 1e-17);
  std::vector<Ball> own;
  for (const ClumpMember& m : shape.members) own.push_back({m.at, m.radius});
  const SolidMoments m = moments_of_union(own);
  EXPECT_LT(norm(m.centre), 1e-14);
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < 3; ++l)
      EXPECT_NEAR(1200 * m.inertia[static_cast<std::size_t>(k)][static_cast<std::size_t>(l)],
                  k == l ? shape.inertia[k] : 0, 1e-9 * shape.inertia.x);
  EXPECT_NEAR(shape.mass, 1200 * m.volume, 1e-12 * shape.mass);
}

/// As its matter does: contacts of the same sphere twice would be twice as stiff.
TEST(ClumpShape, ASphereThatStandsTwiceCountsOnce) {
  const ClumpMember a{{-1e-3, 0, 0}, 2e-3}, b{{1e-3, 0, 0}, 2e-3};
  const ClumpShape once = clump_shape("egg", {a, b}, 1200), twice = clump_shape("egg", {a, b, a, b, b}, 1200);
  ASSERT_EQ(twice.members.size(), 2U);
  EXPECT_EQ(twice.members[1].radius, b.radius);
  EXPECT_NEAR(twice.mass, once.mass, 1e-10 * once.mass);
}

TEST(ClumpShape, GivenMassPropertiesAreTaken) {
  const std::vector<ClumpMember> members{{{-1e-3, 0, 0}, 2e-3}, {{1e-3, 0, 0}, 2e-3}};
  const ClumpShape given = clump_shape(
      "egg", members, 0, GivenMass{2e-4, Vec3{5e-4, 0, 0}, SquareMatrix<3>{{{2, 0, 0}, {0, 3, 1}, {0, 1, 3}}}});
  EXPECT_EQ(given.mass, 2e-4);
  EXPECT_EQ(given.centre.x, 5e-4);
  std::array<double, 3> j{given.inertia.x, given.inertia.y, given.inertia.z};
  std::sort(j.begin(), j.end());
  EXPECT_NEAR(j[0], 2, 1e-14);
  EXPECT_NEAR(j[1], 2, 1e-14);
  EXPECT_NEAR(j[2], 4, 1e-14);
  EXPECT_THROW(clump_shape("no", members, 0, GivenMass{1, {}, SquareMatrix<3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 3}}}}),
               std::invalid_argument);
  EXPECT_THROW(clump_shape("no", {}, 1000), std::invalid_argument);
}

}  // namespace
}  // namespace subsoil::dem::test::clump_shapes
