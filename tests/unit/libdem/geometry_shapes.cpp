// Analytic shapes against closed forms and against their own triangles.
#include <algorithm>
#include <array>
#include <numbers>
#include <stdexcept>

#include "libdem/geometry/shapes.hpp"
#include "tests/unit/libdem/geometry_support.hpp"

namespace subsoil::dem::test::geometry_shapes {
namespace {

std::vector<SurfaceContact> touch(const Shape& shape, const Vec3& c, double reach) {
  std::vector<uint32_t> near;
  candidates(shape, c, reach, near);
  std::vector<SurfaceContact> found(8);
  found.resize(contacts(shape, c, reach, near, found.data(), found.size()));
  return found;
}

TEST(GeometryShapes, PlaneIsAHalfSpace) {
  const Vec3 n = normalized({1, 2, -0.5}), point{0.1, 0.2, 0.3};
  const Shape plane = Plane(point, 5.0 * n);
  Random random(1);
  for (int k = 0; k < 200; ++k) {
    const double d = random.between(-0.05, 0.02);
    Vec3 along = random.direction();
    along -= dot(along, n) * n;
    const auto found = touch(plane, point + along + d * n, 0.012);
    ASSERT_EQ(found.size(), d <= 0.012 ? 1u : 0u);
    if (found.empty()) continue;
    EXPECT_NEAR(found[0].distance, d, 1e-15);
    EXPECT_LE(norm(found[0].normal - n), 1e-15);
    EXPECT_LE(norm(found[0].point - (point + along)), 1e-15);
  }
  EXPECT_THROW(Plane({}, {}), std::invalid_argument);
  EXPECT_EQ(bounds(plane).low.x, -Bounds::infinity);
  EXPECT_NEAR(drawing(plane, 2)[0].area(), 4, 1e-14);
}

/// A cylinder with a bore of the inner radius, 0 for none, against its rectangle in the half-plane of the distance rho
/// from the axis and the height z.
void compare_with_a_revolved_rectangle(double inner) {
  const double outer = 0.2, half = 0.06, reach = 0.05;
  const Pose pose{{1, -2, 0.5}, Quaternion::from_rotation_vector({0.3, 1.1, -0.2})};
  const Shape cylinder = Cylinder(pose.position, pose.attitude.rotate({0, 0, 3}), outer, 2 * half, inner);
  Random random(2);
  std::array<int, 8> counted{};
  for (int k = 0; k < 5000; ++k) {
    const double rho = random.between(0.08, 0.27), z = random.between(-0.12, 0.12), angle = random.between(0, 7);
    const Vec3 out{std::cos(angle), std::sin(angle), 0};
    const Vec3 c = pose.to_world(rho * out + Vec3{0, 0, z});
    const double in_bore = inner - rho, outside = rho - outer, past_end = std::abs(z) - half;
    const double side = inner > 0 ? std::max(in_bore, outside) : outside;
    const bool inside = side <= 0 && past_end <= 0;
    const double d = inside ? std::max(side, past_end) : std::hypot(std::max(side, 0.0), std::max(past_end, 0.0));
    const auto found = touch(cylinder, c, reach);
    ASSERT_EQ(found.size(), d <= reach ? 1u : 0u);
    if (found.empty()) continue;
    EXPECT_NEAR(found[0].distance, d, 2e-15);
    EXPECT_NEAR(norm(c - found[0].distance * found[0].normal - found[0].point), 0, 2e-15);
    EXPECT_NEAR(norm(found[0].normal), 1, 1e-14);
    ++counted[found[0].feature];
    if (inside) continue;
    const Vec3 p = pose.to_world(std::clamp(rho, inner, outer) * out + Vec3{0, 0, std::clamp(z, -half, half)});
    EXPECT_LE(norm(found[0].point - p), 2e-15);
    const unsigned lower = z < 0 ? 1 : 0;
    const unsigned lateral = in_bore > 0 ? 5 : 0, rim = (in_bore > 0 ? 6 : 3) + lower;
    EXPECT_EQ(found[0].feature, past_end <= 0 ? lateral : side <= 0 ? 1 + lower : rim);
  }
  const auto often = [&](unsigned first, unsigned last) {
    return std::all_of(&counted[first], &counted[last] + 1, [](int n) { return n > 50; });
  };
  EXPECT_TRUE(often(0, inner > 0 ? 7 : 4)) << "places of all kinds";
}

TEST(GeometryShapes, CylinderIsARevolvedRectangle) {
  compare_with_a_revolved_rectangle(0);
  const Pose pose{{1, -2, 0.5}, Quaternion::from_rotation_vector({0.3, 1.1, -0.2})};
  const Shape cylinder = Cylinder(pose.position, pose.attitude.rotate({0, 0, 3}), 0.2, 0.12);
  const auto on_axis = touch(cylinder, pose.to_world({0, 0, 0.01}), 0.05);
  ASSERT_EQ(on_axis.size(), 1u);
  EXPECT_NEAR(on_axis[0].distance, -0.05, 1e-15);
  EXPECT_THROW(Cylinder({}, {0, 0, 1}, 0, 1), std::invalid_argument);
}

TEST(GeometryShapes, CylinderWithABoreIsARevolvedRectangle) {
  compare_with_a_revolved_rectangle(0.15);
  EXPECT_THROW(Cylinder({}, {0, 0, 1}, 0.2, 1, 0.2), std::invalid_argument);
  EXPECT_THROW(Cylinder({}, {0, 0, 1}, 0.2, 1, -0.1), std::invalid_argument);
}

TEST(GeometryShapes, CylinderBoundsHoldItsDrawingTightly) {
  Random random(3);
  for (int k = 0; k < 20; ++k) {
    const Shape cylinder = Cylinder({1, 2, 3}, random.direction(), 0.2, 0.1);
    const Bounds exact = bounds(cylinder), drawn = drawing(cylinder, 1)[0].bounds();
    // 48 segments: the drawn circle is inside the true one by at most r (1 - cos(pi/48)) = 0.43 mm.
    for (int i = 0; i < 3; ++i) {
      EXPECT_LE(exact.low[i], drawn.low[i] + 1e-15);
      EXPECT_GE(exact.high[i], drawn.high[i] - 1e-15);
      EXPECT_NEAR(exact.low[i], drawn.low[i], 4.3e-4);
      EXPECT_NEAR(exact.high[i], drawn.high[i], 4.3e-4);
    }
  }
}

TEST(GeometryShapes, FineMeshOfACylinderActsLikeTheCylinder) {
  const int segments = 400;
  const Shape exact = Cylinder({}, {0, 0, 1}, 0.2, 0.12);
  const Shape mesh = MeshSurface(cylinder_mesh({}, {0, 0, 1}, 0.2, 0.12, segments));
  const double flat = 0.2 * (1 - std::cos(std::numbers::pi / segments));  // 6 um: depth of the sides below the radius
  Random random(4);
  for (int k = 0; k < 3000; ++k) {
    const double rho = random.between(0.15, 0.215), z = random.between(-0.075, 0.075), angle = random.between(0, 7);
    const Vec3 c{rho * std::cos(angle), rho * std::sin(angle), z};
    const auto a = touch(exact, c, 0.012), b = touch(mesh, c, 0.0125);
    if (a.empty() || a[0].distance < 0.001) continue;
    ASSERT_EQ(b.size(), 1u);
    EXPECT_NEAR(a[0].distance, b[0].distance, 1.01 * flat);
    // On the flat sides the normal is off by half a segment at most; at the rims the same turns about it.
    EXPECT_GE(dot(a[0].normal, b[0].normal), std::cos(1.5 * std::numbers::pi / segments));
  }
}

/// A regular polygon of n sides on a circle has the area n/2 sin(2 pi/n) r^2.
TEST(GeometryShapes, CylinderWithABoreIsDrawnAsATube) {
  const Shape tube = Cylinder({1, 2, 3}, {1, 1, 0}, 0.2, 0.3, 0.15);
  const TriangleMesh drawn = drawing(tube, 1).at(0);
  const double n = 48, polygon = n / 2 * std::sin(2 * std::numbers::pi / n), chord = 2 * std::sin(std::numbers::pi / n);
  const double section = polygon * (0.2 * 0.2 - 0.15 * 0.15);
  EXPECT_NEAR(drawn.volume(), 0.3 * section, 1e-13);
  EXPECT_NEAR(drawn.area(), 2 * section + 0.3 * n * chord * (0.2 + 0.15), 1e-12);
  EXPECT_TRUE(drawn.closed());
}

TEST(GeometryShapes, MeshGoesThroughTheSameDoors) {
  const Shape mesh = MeshSurface(box_mesh({1, 1, 1}));
  EXPECT_EQ(touch(mesh, {0.1, 0.505, 0.2}, 0.01).size(), 1u);
  EXPECT_EQ(touch(mesh, {0.1, 0.52, 0.2}, 0.01).size(), 0u);
  EXPECT_EQ(bounds(mesh).high.y, 0.5);
  EXPECT_EQ(drawing(mesh, 1).size(), 1u);
}

}  // namespace
}  // namespace subsoil::dem::test::geometry_shapes
