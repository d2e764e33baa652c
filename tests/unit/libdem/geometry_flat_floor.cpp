// A flat floor of triangles is a plane: one contact at every place and distance, however it is cut up.
#include "tests/unit/libdem/geometry_support.hpp"

namespace subsoil::dem::test::geometry_flat_floor {
namespace {

constexpr double reach = 0.012;  // radius 10 mm and a gap of 2 mm

/// The analytic plane through `origin` with unit normal n, against the mesh. 1e-12: a distance is one scalar product of
/// lengths below 2 m, so wrong by a few 1e-16 m; the normal of a triangle by eps times shortest side over height.
void expect_plane(const MeshSurface& floor, const Vec3& c, const Vec3& origin, const Vec3& n) {
  const auto found = touch(floor, c, reach);
  const double distance = dot(c - origin, n);
  if (distance > reach * (1 + 1e-9)) {
    EXPECT_TRUE(found.empty());
    return;
  }
  ASSERT_EQ(found.size(), 1u) << c.x << " " << c.y << " " << c.z;
  EXPECT_NEAR(found[0].distance, distance, 1e-12);
  EXPECT_LE(norm(found[0].normal - n), 1e-12);
  EXPECT_LE(norm(found[0].point - (c - distance * n)), 1e-12);
}

void slide(const MeshSurface& floor, Random& random, const Pose& pose) {
  const Vec3 n = pose.attitude.rotate({0, 1, 0});
  for (int path = 0; path < 40; ++path) {
    const Vec3 from = random.in_box({0, 1e-5, 0}, {1, 0.013, 1}), to = random.in_box({0, 1e-5, 0}, {1, 0.013, 1});
    for (int k = 0; k <= 100; ++k)
      expect_plane(floor, pose.to_world(from + (k / 100.0) * (to - from)), pose.position, n);
  }
}

TEST(GeometryFlatFloor, RandomTrianglesWithSliversActAsThePlane) {
  for (const double edge_gap : {0.3, 1e-2, 1e-4}) {
    Random random(7);
    slide(MeshSurface(random_floor(300, edge_gap, 11)), random, {});
  }
}

TEST(GeometryFlatFloor, TiltedFloorActsAsThePlane) {
  // Heights above a tenth of the sides: the corners of a tilted floor are rounded, which turns a triangle of height h
  // by 1e-16 m / h.
  Random random(8);
  const Pose pose{{0.3, -0.2, 0.1}, Quaternion::from_rotation_vector({0.4, 0.9, -0.3})};
  slide(MeshSurface(random_floor(12, 0.3, 5).placed(pose)), random, pose);
}

TEST(GeometryFlatFloor, CentreAboveSidesAndCorners) {
  const TriangleMesh mesh = random_floor(200, 1e-3, 3);
  const MeshSurface floor(mesh);
  for (size_t t = 0; t < mesh.triangles().size(); ++t) {
    for (const double height : {1e-9, 0.004, 0.010, 0.0119}) {
      const Vec3 up{0, height, 0};
      const Vec3 &a = mesh.corner(t, 0), &b = mesh.corner(t, 1);
      expect_plane(floor, a + up, {}, {0, 1, 0});
      expect_plane(floor, 0.5 * (a + b) + up, {}, {0, 1, 0});
      const Vec3 beside = 0.3 * a + 0.7 * b + up + Vec3{1e-13, 0, -1e-13};
      if (beside.x < 1 && beside.z > 0) expect_plane(floor, beside, {}, {0, 1, 0});  // still above the floor
    }
  }
}

TEST(GeometryFlatFloor, SurfacesThatMeetBetweenTheirVertices) {
  // Four surfaces side by side, no vertex of one on a vertex of the next, and two that lie one on the other.
  const std::vector<TriangleMesh> parts{rectangle_mesh({0, 0, 0}, {0, 0, 0.37}, {1, 0, 0}),
                                        rectangle_mesh({0, 0, 0.37}, {0, 0, 0.63}, {0.41, 0, 0}),
                                        rectangle_mesh({0.41, 0, 0.37}, {0, 0, 0.2}, {0.59, 0, 0}),
                                        rectangle_mesh({0.41, 0, 0.57}, {0, 0, 0.43}, {0.59, 0, 0}),
                                        rectangle_mesh({0.2, 0, 0.2}, {0, 0, 0.5}, {0.5, 0, 0})};
  Random random(9);
  const MeshSurface floor(parts);
  slide(floor, random, {});
  for (const double x : {0.1, 0.41, 0.7})
    for (const double z : {0.37, 0.37 + 1e-10, 0.57, 0.57 - 1e-7}) expect_plane(floor, {x, 0.009, z}, {}, {0, 1, 0});
}

TEST(GeometryFlatFloor, Float32CornersActAsThePlaneWithinTheirRounding) {
  // What a binary STL of a tilted plate holds: loose triangles, corners rounded to float32 (6e-8 of 1 m).
  const Pose pose{{}, Quaternion::from_rotation_vector({0.3, 0.2, 0.5})};
  const TriangleMesh exact = random_floor(60, 0.3, 21).placed(pose);
  std::vector<std::array<Vec3, 3>> soup;
  for (size_t t = 0; t < exact.triangles().size(); ++t) {
    const auto rounded = [&](int i) {
      const Vec3& p = exact.corner(t, i);
      return Vec3{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
    };
    soup.push_back({rounded(0), rounded(1), rounded(2)});
  }
  const MeshSurface floor(welded_mesh(soup));
  const Vec3 n = pose.attitude.rotate({0, 1, 0});
  Random random(4);
  int wrong = 0;
  for (int k = 0; k < 4000; ++k) {
    const Vec3 c = pose.to_world(random.in_box({0.02, 0.001, 0.02}, {0.98, 0.0115, 0.98}));
    const auto found = touch(floor, c, reach);
    if (found.size() != 1) ++wrong;
    EXPECT_NEAR(found[0].distance, dot(c, n), 3e-7);
  }
  // An inward bend from rounding is 2e-7 m over a height; only triangles lower than 0.2 mm can exceed a milliradian.
  EXPECT_EQ(wrong, 0);
}

TEST(GeometryFlatFloor, OneFeatureAcrossAllTriangles) {
  const MeshSurface floor(random_floor(100, 1e-2, 17));
  Random random(2);
  const uint32_t feature = touch(floor, {0.5, 0.01, 0.5}, reach)[0].feature;
  for (int k = 0; k < 500; ++k) {
    const auto found = touch(floor, random.in_box({0.01, 0.001, 0.01}, {0.99, 0.011, 0.99}), reach);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].feature, feature);
  }
}

}  // namespace
}  // namespace subsoil::dem::test::geometry_flat_floor
