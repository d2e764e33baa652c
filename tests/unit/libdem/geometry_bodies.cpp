// Convex edges, concave corners, thin plates and stacked solids against their closed forms.
#include <algorithm>

#include "tests/unit/libdem/geometry_support.hpp"

namespace subsoil::dem::test::geometry_bodies {
namespace {

constexpr double reach = 0.012;

Vec3 nearest_in_box(const Vec3& c, const Vec3& half) {
  return {std::clamp(c.x, -half.x, half.x), std::clamp(c.y, -half.y, half.y), std::clamp(c.z, -half.z, half.z)};
}

TEST(GeometryBox, OutsideEqualsTheRoundedBox) {
  const Vec3 half{0.05, 0.03, 0.02};
  const MeshSurface box(box_mesh(2.0 * half));
  Random random(1);
  for (int k = 0; k < 20000; ++k) {
    const Vec3 c = random.in_box(-half - Vec3{.013, .013, .013}, half + Vec3{.013, .013, .013});
    const Vec3 p = nearest_in_box(c, half);
    const double d = norm(c - p);
    if (d < 1e-9) continue;  // inside
    const auto found = touch(box, c, reach);
    ASSERT_EQ(found.size(), d <= reach ? 1u : 0u);
    if (found.empty()) continue;
    EXPECT_NEAR(found[0].distance, d, 1e-15);
    EXPECT_LE(norm(found[0].point - p), 1e-15);
    EXPECT_LE(norm(found[0].normal - (1 / d) * (c - p)), 1e-15 / d);
  }
}

TEST(GeometryBox, CentreInsideOrOnTheSurfaceIsPushedOut) {
  const Vec3 half{0.05, 0.03, 0.02};
  const MeshSurface box(box_mesh(2.0 * half));
  for (const double depth : {0.0, 1e-18, 1e-12, 1e-4, 0.003}) {
    const auto found = touch(box, {0.01, half.y - depth, 0.004}, reach);
    ASSERT_EQ(found.size(), 1u) << depth;
    EXPECT_NEAR(found[0].distance, -depth, 1e-16);
    EXPECT_LE(norm(found[0].normal - Vec3{0, 1, 0}), 1e-15);
  }
  // On a corner or an edge: one contact, along the normal of one of the faces that meet there.
  for (const Vec3& c : {half, Vec3{0.0123, half.y, half.z}}) {
    const auto found = touch(box, c, reach);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].distance, 0);
    EXPECT_EQ(std::max({found[0].normal.x, found[0].normal.y, found[0].normal.z}), 1);
  }
}

TEST(GeometryBox, NormalTurnsContinuouslyOverAnEdge) {
  // A sphere rolls over the edge: the normal turns by step / distance at most, distance stays, one contact throughout.
  const MeshSurface box(box_mesh({0.2, 0.2, 0.2}));
  const double d = 0.009, step = 1e-5;
  Vec3 previous{0, 1, 0};
  const auto at = [&](double s) -> Vec3 {  // path at constant distance d from the box, arc length s
    const double flat = 0.02, arc = d * std::acos(0.0);
    if (s < flat) return {0.08 + s, 0.1 + d, 0.013};
    if (s < flat + arc) return {0.1 + d * std::sin((s - flat) / d), 0.1 + d * std::cos((s - flat) / d), 0.013};
    return {0.1 + d, 0.1 - (s - flat - arc), 0.013};
  };
  for (double s = 0; s < 0.05; s += step) {
    const auto found = touch(box, at(s), reach);
    ASSERT_EQ(found.size(), 1u) << s;
    EXPECT_NEAR(found[0].distance, d, 1e-14);
    EXPECT_LE(norm(found[0].normal - previous), 1.001 * step / d);
    previous = found[0].normal;
  }
  EXPECT_LE(norm(previous - Vec3{1, 0, 0}), 1e-12);
}

/// Container of five rectangles, inside of side 0.2 m, floor at y = 0.
std::vector<TriangleMesh> container() {
  const double a = 0.1, h = 0.2;
  return {rectangle_mesh({-a, 0, -a}, {0, 0, 2 * a}, {2 * a, 0, 0}),
          rectangle_mesh({-a, 0, -a}, {0, h, 0}, {0, 0, 2 * a}), rectangle_mesh({a, 0, -a}, {0, 0, 2 * a}, {0, h, 0}),
          rectangle_mesh({-a, 0, -a}, {2 * a, 0, 0}, {0, h, 0}), rectangle_mesh({-a, 0, a}, {0, h, 0}, {2 * a, 0, 0})};
}

void expect_container(const MeshSurface& walls, Random& random) {
  for (int k = 0; k < 20000; ++k) {
    const Vec3 c = random.in_box({-.0999, 1e-4, -.0999}, {-.08, .02, -.08});
    std::vector<double> expected;
    for (const double d : {c.x + 0.1, c.y, c.z + 0.1})
      if (d <= reach) expected.push_back(d);
    std::sort(expected.begin(), expected.end());
    const auto found = touch(walls, c, reach);
    ASSERT_EQ(found.size(), expected.size());
    for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i].distance, expected[i], 1e-15);
  }
}

TEST(GeometryConcave, CornerHasOneContactPerWall) {
  Random random(3);
  expect_container(MeshSurface(container()), random);  // five surfaces of one body
  std::vector<std::array<Vec3, 3>> soup;
  for (const TriangleMesh& wall : container())
    for (size_t t = 0; t < wall.triangles().size(); ++t)
      soup.push_back({wall.corner(t, 0), wall.corner(t, 1), wall.corner(t, 2)});
  expect_container(MeshSurface(welded_mesh(soup)), random);  // one surface with shared vertices
}

TEST(GeometryConcave, AngleProfileHasTwoContactsInsideAndOneAroundItsOutside) {
  // L-shaped bar, legs 40 mm long and 10 mm thick, inner corner at the origin.
  const std::vector<Point2> outline{{-.01, -.01}, {.03, -.01}, {.03, 0}, {0, 0}, {0, .03}, {-.01, .03}};
  const MeshSurface bar(extruded_mesh(outline, 0.1));
  const auto inner = touch(bar, {0.009, 0.007, 0.01}, reach);
  ASSERT_EQ(inner.size(), 2u);
  EXPECT_NEAR(inner[0].distance, 0.007, 1e-15);
  EXPECT_LE(norm(inner[0].normal - Vec3{0, 1, 0}), 1e-12);
  EXPECT_NEAR(inner[1].distance, 0.009, 1e-15);
  EXPECT_LE(norm(inner[1].normal - Vec3{1, 0, 0}), 1e-12);
  // Around the outside: the legs are thinner than the reach, but what lies behind them does not act.
  for (const Vec3& c : {Vec3{-.012, -.012, 0}, Vec3{-.011, 0.02, 0}, Vec3{0.02, -.011, 0.03}, Vec3{-.011, 0, .052}})
    EXPECT_EQ(touch(bar, c, reach).size(), 1u);
}

TEST(GeometryThinPlate, FarSideDoesNotActThroughThePlate) {
  // 6 mm plate, radius 10 mm, reach 12 mm: at 5 mm from the near side the far one is within reach.
  const Vec3 half{0.1, 0.003, 0.1};
  const MeshSurface plate(box_mesh(2.0 * half));
  Random random(5);
  for (int k = 0; k < 20000; ++k) {
    const Vec3 c = random.in_box({.08, -.015, .08}, {.115, .015, .115});
    const Vec3 p = nearest_in_box(c, half);
    const double d = norm(c - p);
    if (d < 1e-9 || d > reach) continue;
    const auto found = touch(plate, c, reach);
    ASSERT_EQ(found.size(), 1u) << c.x << " " << c.y << " " << c.z;
    EXPECT_NEAR(found[0].distance, d, 1e-15);
  }
}

TEST(GeometryThinPlate, OpenSheetActsOnBothSidesAndHidesWhatLiesBehind) {
  const std::vector<TriangleMesh> sheets{rectangle_mesh({0, 0, 0}, {0, 0, 1}, {1, 0, 0}),
                                         rectangle_mesh({0, -.003, 0}, {0, 0, 1}, {1, 0, 0})};
  const MeshSurface both(sheets);
  const auto above = touch(both, {0.4, 0.006, 0.7}, reach), below = touch(both, {0.4, -0.009, 0.7}, reach);
  ASSERT_EQ(above.size(), 1u);
  ASSERT_EQ(below.size(), 1u);
  EXPECT_LE(norm(above[0].normal - Vec3{0, 1, 0}), 1e-12);
  EXPECT_EQ(above[0].surface, 0u);
  EXPECT_LE(norm(below[0].normal - Vec3{0, -1, 0}), 1e-12);
  EXPECT_EQ(below[0].surface, 1u);
}

TEST(GeometrySphere, IcosphereFromOutsideHasOneContactBetweenItsInnerAndOuterRadius) {
  const double radius = 0.05;
  const TriangleMesh mesh = icosphere_mesh(radius, 3);
  const MeshSurface sphere(mesh);
  double inner = radius;  // radius of the sphere that touches the faces from inside
  for (size_t t = 0; t < mesh.triangles().size(); ++t) inner = std::min(inner, dot(mesh.corner(t, 0), mesh.normal(t)));
  Random random(6);
  for (int k = 0; k < 5000; ++k) {
    const double d = random.between(1e-4, 0.0115);
    const Vec3 out = random.direction();
    const auto found = touch(sphere, (radius + d) * out, reach);
    if (d + radius - inner > reach && found.empty()) continue;
    ASSERT_EQ(found.size(), 1u);
    EXPECT_GE(found[0].distance, d - 1e-15);
    EXPECT_LE(found[0].distance, d + radius - inner);
    EXPECT_GE(dot(found[0].normal, out), 0.9);
  }
}

TEST(GeometryStackedSolids, LedgeOfTheShovelIsATSection) {
  // Share half width 25 mm below the cut, shank half width 15 mm above it; at x = 0.02 the front and rear faces are out
  // of reach, so the section in y-z is a T with closed-form contacts.
  const auto parts = shovel_surfaces();
  const MeshSurface shovel(parts);
  const double cut = -.365, narrow = .015, wide = .025;
  Random random(12);
  for (int k = 0; k < 20000; ++k) {
    const Vec3 c{0.02, random.between(cut - .01, cut + .02), random.between(narrow + 1e-4, wide + .015)};
    const double y = c.y - cut;
    if (y < 0 && c.z < wide) continue;  // inside the share
    std::vector<double> expected;
    if (y > 0 && c.z < wide) expected = {c.z - narrow, y};
    if (y > 0 && c.z >= wide) expected = {c.z - narrow, std::hypot(y, c.z - wide)};
    if (y <= 0) expected = {c.z - wide};
    std::erase_if(expected, [](double d) { return d > reach; });
    std::sort(expected.begin(), expected.end());
    const auto found = touch(shovel, c, reach);
    ASSERT_EQ(found.size(), expected.size()) << c.y << " " << c.z;
    for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i].distance, expected[i], 1e-15);
  }
}

TEST(GeometryStackedSolids, InnerFacesOfFlushBlocksAreNotFelt) {
  // Two blocks of the same section one on the other act as the one block that they make.
  const std::vector<TriangleMesh> parts{box_mesh({0.06, 0.004, 0.05}, {0, -0.002, 0}),
                                        box_mesh({0.06, 0.03, 0.05}, {0, 0.015, 0})};
  const MeshSurface stacked(parts), one(box_mesh({0.06, 0.034, 0.05}, {0, 0.013, 0}));
  Random random(13);
  for (int k = 0; k < 20000; ++k) {
    const Vec3 c = random.in_box({-.042, -.016, -.037}, {.042, .042, .037});
    if (std::abs(c.x) < .03 && std::abs(c.z) < .025 && c.y > -.004 && c.y < .03) continue;
    const auto a = touch(stacked, c, reach), b = touch(one, c, reach);
    ASSERT_EQ(a.size(), b.size()) << c.x << " " << c.y << " " << c.z;
    for (size_t i = 0; i < a.size(); ++i) {
      EXPECT_NEAR(a[i].distance, b[i].distance, 1e-15);
      EXPECT_LE(norm(a[i].normal - b[i].normal), 1e-12);
    }
  }
}

TEST(GeometryFeatures, StraightEdgeOfManyPiecesIsOne) {
  // The outline has points within its straight sides, so the upright faces and the edges of the caps are in pieces.
  const std::vector<Point2> outline{{0, 0}, {.02, 0}, {.05, 0}, {.1, 0}, {.1, .1}, {.04, .1}, {0, .1}};
  const MeshSurface block(extruded_mesh(outline, 0.04));
  const auto feature = [&](const Vec3& c) {
    const auto found = touch(block, c, reach);
    EXPECT_EQ(found.size(), 1u);
    return found.at(0).feature;
  };
  const uint32_t edge = feature({.01, -.005, .025}), side = feature({.01, -.005, .01});
  for (const double x : {.02, .03, .05, .08, .099}) {
    EXPECT_EQ(feature({x, -.005, .025}), edge);
    EXPECT_EQ(feature({x, -.005, .013}), side);
  }
  EXPECT_NE(edge, side);
  EXPECT_NE(feature({.05, .105, .025}), edge);
  EXPECT_NE(feature({-.005, -.005, .025}), edge);  // the corner at its end
}

TEST(GeometryFeatures, AFanOfManyTrianglesLeavesRoomForOtherContacts) {
  // 200 triangles meet under the centre, and a wall stands beside it.
  const std::vector<TriangleMesh> parts{cylinder_mesh({}, {0, 1, 0}, 0.1, 0.02, 200),
                                        rectangle_mesh({.011, -.1, -.1}, {0, .2, 0}, {0, 0, .2})};
  const MeshSurface both(parts);
  const auto found = touch(both, {0, .019, 0}, reach);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(found[0].distance, .009, 1e-15);
  EXPECT_NEAR(found[1].distance, .011, 1e-15);
  SurfaceContact one;
  std::vector<uint32_t> near;
  both.candidates({0, .019, 0}, reach, near);
  EXPECT_EQ(both.contacts({0, .019, 0}, reach, near, &one, 1), 1u);  // no room: the nearest
  EXPECT_NEAR(one.distance, .009, 1e-15);
}

TEST(GeometryMatch, ContactsKeepTheirHistoryByNormal) {
  std::vector<SurfaceContact> now(3);
  now[0].normal = {0, 1, 0}, now[1].normal = {1, 0, 0}, now[2].normal = {0, 0, 1};
  const std::vector<Vec3> before{normalized({1, 0.01, 0}), normalized({0.02, 1, 0})};
  int from[3];
  match_contacts(now, before, from);
  EXPECT_EQ(from[0], 1);
  EXPECT_EQ(from[1], 0);
  EXPECT_EQ(from[2], -1);
  // One previous contact serves one of now only, the nearer.
  now.resize(2);
  now[0].normal = normalized({1, 0.2, 0}), now[1].normal = normalized({1, 0.1, 0});
  match_contacts(now, std::vector<Vec3>{{1, 0, 0}}, from);
  EXPECT_EQ(from[0], -1);
  EXPECT_EQ(from[1], 0);
}

}  // namespace
}  // namespace subsoil::dem::test::geometry_bodies
