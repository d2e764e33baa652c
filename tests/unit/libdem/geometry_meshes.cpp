// Builders and the mesh itself: volumes, areas, orientation, refusals.
#include <numbers>
#include <stdexcept>
#include <string>

#include "libdem/geometry/boundary.hpp"
#include "libdem/geometry/mesh_surface.hpp"
#include "libdem/geometry/polygon.hpp"
#include "libdem/packing/carve.hpp"
#include "tests/unit/libdem/geometry_support.hpp"

namespace subsoil::dem::test::geometry_meshes {
namespace {

template <class F>
std::string refusal(F&& f) {
  try {
    f();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "accepted";
}

void expect_text(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

/// Shoelace formula as printed in a handbook: sum of x_i y_{i+1} - x_{i+1} y_i.
double shoelace(const std::vector<Point2>& p) {
  double twice = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    const Point2& q = p[(i + 1) % p.size()];
    twice += p[i][0] * q[1] - q[0] * p[i][1];
  }
  return std::abs(twice) / 2;
}

TEST(GeometryMesh, ClosedBuildersHaveTheirVolumeAndArea) {
  const TriangleMesh box = box_mesh({0.2, 0.3, 0.5}, {3, -4, 5});
  EXPECT_TRUE(box.closed());
  EXPECT_NEAR(box.volume(), 0.03, 1e-15);
  EXPECT_NEAR(box.area(), 2 * (.06 + .10 + .15), 1e-14);
  EXPECT_NEAR(norm(box.bounds().centre() - Vec3{3, -4, 5}), 0, 1e-15);

  const int n = 40;  // area of a regular n-gon with its corners on the radius
  const TriangleMesh cylinder = cylinder_mesh({1, 2, 3}, {1, 1, 0}, 0.2, 0.12, n);
  const double gon = n / 2.0 * 0.04 * std::sin(2 * std::numbers::pi / n);
  EXPECT_TRUE(cylinder.closed());
  EXPECT_NEAR(cylinder.volume(), gon * 0.12, 1e-14);
  EXPECT_NEAR(cylinder.area(), 2 * gon + n * 0.12 * 2 * 0.2 * std::sin(std::numbers::pi / n), 1e-13);

  EXPECT_EQ(icosphere_mesh(1, 2).triangles().size(), 320u);
  EXPECT_NEAR(icosphere_mesh(2, 5).volume(), 4.0 / 3 * std::numbers::pi * 8, 0.05);
  EXPECT_NEAR(icosphere_mesh(2, 0).volume(), 8 * 2.536150, 1e-5);  // unit icosahedron, circumradius 1
}

TEST(GeometryMesh, NormalsOfClosedMeshesPointOutward) {
  for (const TriangleMesh& mesh :
       {box_mesh({1, 2, 3}), cylinder_mesh({}, {0, 0, 1}, 1, 2), icosphere_mesh(1, 2)})  // all convex about the origin
    for (size_t t = 0; t < mesh.triangles().size(); ++t) EXPECT_GT(dot(mesh.normal(t), mesh.corner(t, 0)), 0);
}

TEST(GeometryMesh, TurnedTrianglesAreTurnedBack) {
  const TriangleMesh box = box_mesh({1, 1, 1});
  Random random(1);
  for (int k = 0; k < 20; ++k) {
    std::vector<Triangle> triangles = box.triangles();
    for (Triangle& t : triangles)
      if (random.below(2) == 1) std::swap(t[0], t[1]);
    const TriangleMesh mesh(box.vertices(), triangles);
    EXPECT_TRUE(mesh.closed());
    EXPECT_NEAR(mesh.volume(), 1, 1e-15);
    for (size_t t = 0; t < triangles.size(); ++t) EXPECT_GT(dot(mesh.normal(t), mesh.corner(t, 0)), 0);
  }
}

/// Boxes about one centre, each wound outward (1) or inward (-1).
TriangleMesh nested(const std::vector<std::pair<double, int>>& boxes, const Vec3& apart = {}) {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const auto [size, sense] = boxes[k];
    const TriangleMesh box = box_mesh({size, size, size});
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (const Vec3& v : box.vertices()) vertices.push_back(v + static_cast<double>(k) * apart);
    for (const Triangle& t : box.triangles()) {
      triangles.push_back({first + t[0], first + t[1], first + t[2]});
      if (sense < 0) std::swap(triangles.back()[1], triangles.back()[2]);
    }
  }
  return {vertices, triangles};
}

/// What is wound against the component around it is a cavity, whichever of them the file names first and whether all
/// of it is inside out. Volumes are those of the cubes.
TEST(GeometryMesh, AComponentWoundAgainstTheOneAroundItIsACavity) {
  EXPECT_NEAR(nested({{3, 1}, {2, -1}}).volume(), 27 - 8, 1e-12);
  EXPECT_NEAR(nested({{2, -1}, {3, 1}}).volume(), 27 - 8, 1e-12);
  EXPECT_NEAR(nested({{2, 1}, {3, -1}}).volume(), 27 - 8, 1e-12) << "inside out";
  EXPECT_NEAR(nested({{3, 1}, {2, -1}, {1, 1}}).volume(), 27 - 8 + 1, 1e-12) << "a kernel in the cavity";
  EXPECT_NEAR(nested({{3, 1}, {2, 1}}).volume(), 27 + 8, 1e-12) << "two solids";
  EXPECT_NEAR(nested({{3, 1}, {2, -1}}, {9, 0, 0}).volume(), 27 + 8, 1e-12) << "beside it";
  EXPECT_NEAR(nested({{3, 1}, {2, -1}}, {1, 0, 0}).volume(), 27 + 8, 1e-12) << "partly in it";
}

/// In the cavity the distance is that to its wall, 1 from the centre; in the material it is negative.
TEST(GeometryMesh, ACavityIsOutsideOfTheSolid) {
  Boundary hollow;
  hollow.shape = MeshSurface(nested({{4, 1}, {2, -1}}));
  const auto in_the_way = [&](double x, double r) {
    Sphere s;
    s.x = {x, 0.1, 0.2}, s.r = r;
    return inside_or_overlapping(s, hollow);
  };
  EXPECT_FALSE(in_the_way(0, 0.5));
  EXPECT_FALSE(in_the_way(0.49, 0.5));
  EXPECT_TRUE(in_the_way(0.51, 0.5));
  EXPECT_TRUE(in_the_way(1.5, 0.1)) << "in the wall";
  EXPECT_FALSE(in_the_way(2.6, 0.5));
}

TEST(GeometryMesh, OpenMeshesAreToldApart) {
  EXPECT_FALSE(rectangle_mesh({}, {1, 0, 0}, {0, 1, 0}).closed());
  EXPECT_NEAR(rectangle_mesh({}, {2, 0, 0}, {0, 3, 0}).area(), 6, 1e-15);
  std::vector<Triangle> triangles = box_mesh({1, 1, 1}).triangles();
  triangles.pop_back();
  const TriangleMesh torn(box_mesh({1, 1, 1}).vertices(), triangles);
  EXPECT_FALSE(torn.closed());
  expect_text(refusal([&] { torn.volume(); }), "an open surface has no volume");
}

TEST(GeometryMesh, RefusesBadTrianglesWithTheirNumber) {
  const std::vector<Vec3> v{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0, 0}};
  expect_text(refusal([&] {
                TriangleMesh(v, {{0, 1, 2}, {0, 1, 3}, {1, 1, 2}});
              }),
              "2 of 3 triangles have no area (the first is triangle 2)");
  expect_text(refusal([&] { TriangleMesh(v, {{0, 1, 4}}); }), "triangle 1 names vertex 5 of 4");
  expect_text(refusal([&] { TriangleMesh(v, {}); }), "no triangles");
  expect_text(refusal([&] {
                TriangleMesh({{0, 0, 0}, {1, 0, 0}, {0, NAN, 0}}, {{0, 1, 2}});
              }),
              "vertex 3 is not finite");
  // Just above and below the limit of flatness.
  EXPECT_EQ(refusal([&] { TriangleMesh({{0, 0, 0}, {1, 0, 0}, {0.5, 1.1e-8, 0}}, {{0, 1, 2}}); }), "accepted");
  expect_text(refusal([&] { TriangleMesh({{0, 0, 0}, {1, 0, 0}, {0.5, 0.9e-8, 0}}, {{0, 1, 2}}); }), "no area");
}

TEST(GeometryMesh, WeldsLooseTriangles) {
  const TriangleMesh sphere = icosphere_mesh(0.1, 3);
  Random random(2);
  std::vector<std::array<Vec3, 3>> soup;
  for (size_t t = 0; t < sphere.triangles().size(); ++t) {
    const auto shaken = [&](int i) { return sphere.corner(t, i) + 1e-8 * random.direction(); };
    soup.push_back({shaken(0), shaken(1), shaken(2)});
  }
  const TriangleMesh welded = welded_mesh(soup);
  EXPECT_EQ(welded.vertices().size(), sphere.vertices().size());
  EXPECT_TRUE(welded.closed());
  EXPECT_NEAR(welded.volume(), sphere.volume(), 1e-8);
  EXPECT_FALSE(welded_mesh(soup, 1e-10).closed());
}

TEST(GeometryMesh, PlacedMovesAndScales) {
  const Pose pose{{1, 2, 3}, Quaternion::from_rotation_vector({0.1, 0.7, -0.4})};
  const TriangleMesh mesh = box_mesh({1, 1, 1}).placed(pose, 2);
  EXPECT_NEAR(mesh.volume(), 8, 1e-13);
  EXPECT_NEAR(norm(mesh.bounds().centre() - Vec3{1, 2, 3}), 0, 1e-14);
  expect_text(refusal([&] { mesh.placed(pose, -1); }), "must be above 0");
}

TEST(GeometryExtrusion, ShovelHasTheVolumeOfItsOutline) {
  std::vector<Point2> outline = shovel_outline();
  for (int round = 0; round < 2; ++round) {
    const TriangleMesh mesh = extruded_mesh(outline, 0.03);
    EXPECT_TRUE(mesh.closed());
    EXPECT_NEAR(mesh.volume(), 0.03 * shoelace(outline), 1e-16);
    EXPECT_NEAR(mesh.bounds().low.z, -0.015, 0);
    EXPECT_NEAR(mesh.bounds().high.z, 0.015, 0);
    std::reverse(outline.begin(), outline.end());  // clockwise then
  }
  const auto parts = shovel_surfaces();
  EXPECT_NEAR(parts[0].volume() / 0.05 + parts[1].volume() / 0.03, shoelace(outline), 1e-15);
}

TEST(GeometryExtrusion, EveryOutlineIsFilledOnce) {
  // Random stars, combs, and outlines with points in the middle of straight sides: n - 2 triangles, whole area.
  Random random(3);
  for (int k = 0; k < 200; ++k) {
    std::vector<Point2> outline;
    const int n = 3 + static_cast<int>(random.below(40));
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * (i + random.between(0, 0.8)) / n, r = random.between(0.2, 1);
      outline.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    if (k % 2 == 0)
      for (size_t i = outline.size(); i-- > 0;) {
        const Point2 &p = outline[i], &q = outline[(i + 1) % outline.size()];
        outline.insert(outline.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                       Point2{(p[0] + q[0]) / 2, (p[1] + q[1]) / 2});
      }
    const auto triangles = triangulate_polygon(outline);
    EXPECT_EQ(triangles.size(), outline.size() - 2);
    EXPECT_NEAR(extruded_mesh(outline, 1).volume(), shoelace(outline), 1e-14);
  }
  std::vector<Point2> comb;
  for (int i = 0; i < 20; ++i) comb.insert(comb.end(), {{i + 0.0, 0}, {i + 0.1, 5}, {i + 0.4, 5}, {i + 0.5, 0}});
  comb.insert(comb.end(), {{20, 0}, {20, -1}, {0, -1}});
  EXPECT_NEAR(extruded_mesh(comb, 2).volume(), 2 * shoelace(comb), 1e-12);
  comb.push_back(comb.front());  // repeated first point
  EXPECT_NEAR(extruded_mesh(comb, 2).volume(), 2 * shoelace(comb), 1e-12);
}

TEST(GeometryExtrusion, RefusesOutlinesThatAreNoPolygon) {
  const auto text = [](std::vector<Point2> p) { return refusal([&] { extruded_mesh(p, 1); }); };
  expect_text(text({{0, 0}, {1, 1}, {1, 0}, {0, 1}}),
              "the side from point 1 (0, 0) to 2 (1, 1) meets the side from point 3 (1, 0) to 4 (0, 1)");
  expect_text(text({{0, 0}, {1, 0}, {1, 1}, {0.5, 0}, {0, 1}}), "point 1 (0, 0) to 2 (1, 0) meets");
  expect_text(text({{0, 0}, {1, 0}}), "2 points; a polygon needs at least 3");
  expect_text(text({{0, 0}, {1, 0}, {1, 0}, {0, 1}}), "points 2 (1, 0) and 3 (1, 0) lie at the same place");
  expect_text(text({{0, 0}, {1, 0}, {2, 0}}), "turns back on itself");
  expect_text(text({{0, 0}, {1, 0}, {1, 1}, {1, 0.5}, {0, 1}}), "turns back on itself at point 3 (1, 1)");
  expect_text(text({{0, 0}, {1, 0}, {0, INFINITY}}), "point 3 is not finite");
  expect_text(refusal([] { extruded_mesh(shovel_outline(), 0); }), "extrusion: width");
}

}  // namespace
}  // namespace subsoil::dem::test::geometry_meshes
