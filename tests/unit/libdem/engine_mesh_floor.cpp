#include <gtest/gtest.h>

#include "libdem/geometry/mesh_builders.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_law.hpp"

/// A sphere on triangles against the analytic shape, dynamically: same path, spin and friction history.
namespace subsoil::dem::test::engine_mesh_floor {
namespace {

/// Floor y = 0 over [-1, 1]^2 in n x n cells with irregular nodes, so that sides run everywhere.
MeshSurface ragged_floor(int n) {
  Dice dice(41);
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double h = 2.0 / n, inner = i > 0 && j > 0 && i < n && j < n ? 0.35 * h : 0;
      vertices.push_back({-1 + i * h + dice.between(-inner, inner), 0, -1 + j * h + dice.between(-inner, inner)});
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  return MeshSurface(TriangleMesh(vertices, triangles));
}

Bed on(const Shape& shape, const Law& law, const Vec3& gravity, const SphereSpec& s) {
  Bed bed(table(law), quiet(gravity));
  bed.add(std::span(&s, 1));
  Boundary b;
  b.shape = shape;
  bed.add(std::move(b));
  return bed;
}

/// Largest difference of paths and surface speeds over the run, relative to the radius and 1 m/s.
double apart(Bed& a, Bed& b, int steps, double dt) {
  double worst = 0;
  for (int n = 0; n < steps; ++n) {
    a.step(dt), b.step(dt);
    const Sphere &p = a.spheres()[0], &q = b.spheres()[0];
    worst = std::max({worst, norm(p.x - q.x) / p.r, norm(p.v - q.v), p.r * norm(p.w - q.w)});
  }
  return worst;
}

TEST(MeshFloor, RollingSphereFeelsAPlane) {
  for (auto [name, law] : every_law()) {
    // Once the sphere rolls, the direction of a slip that rounding alone makes would decide on the whole friction.
    Friction friction = law->friction();
    if (friction.tangential == Tangential::constant_direction) continue;
    friction.mu_r = 1e-3;  // so that cohesive ones roll some triangles far
    law = law->with_friction(friction);
    const double rest = law->rest_overlap();
    const SphereSpec s{{-0.5, 0.01 - rest - 2e-5, -0.31}, {1.5, 0, 0.9}, {30, 5, -60}, 0.01, 1800, 0};
    Bed flat = on(Plane({}, {0, 1, 0}), law, {0, -9.81, 0}, s);
    Bed mesh = on(ragged_floor(80), law, {0, -9.81, 0}, s);
    // 15,000 steps over some 20 triangles; the distance to a triangle rounds at 1e-16 of coordinates up to 1 m, which
    // is 1e-14 of the radius; slips carry it on, and every bounce on a law that bounces for long.
    EXPECT_LT(apart(flat, mesh, 15000, 2e-5), 1e-9) << name;
    EXPECT_GT(norm(mesh.spheres()[0].x - s.position), 0.05) << name;
  }
}

TEST(MeshFloor, AttractionAcrossAGapIsThePlanes) {
  for (const Vec3 v : {Vec3{0.8, -0.02, 0.3}, Vec3{1.0, 0.0, 0.0}}) {
    const SphereSpec s{{-0.5, 0.0113, -0.31}, v, {}, 0.01, 1800, 0};
    Bed flat = on(Plane({}, {0, 1, 0}), soil(), {}, s);
    Bed mesh = on(ragged_floor(80), soil(), {}, s);
    EXPECT_LT(apart(flat, mesh, 10000, 2e-5), 1e-10);
    EXPECT_LT(mesh.spheres()[0].x.y, 0.0090) << "it must have been pulled in";
  }
}

/// Centres on a grid around the edge of a box: the force is that of the distance to the quarter space, in closed form.
TEST(MeshEdge, ForceFieldOfABoxEdge) {
  Wet law = soil();
  const MeshSurface box(box_mesh({1, 1, 1}, {-0.5, -0.5, 0}));  // edge along z at x = y = 0
  const double r = 0.01;
  for (int i = -4; i <= 12; ++i)
    for (int k = 1; k <= 12; ++k) {
      const Vec3 c{i * 1.01e-3, k * 0.97e-3 + 2e-4, 0.013};
      const double distance = std::hypot(std::max(0.0, c.x), c.y);
      if (distance < 5.1e-3) continue;
      Bed bed = on(box, law, {}, {c, {}, {}, r, 1800, 0});
      const Vec3 f = observe(bed, 1e-6).force[0];
      const double overlap = r - distance;
      const double want = overlap > 2e-3    ? 1e4 * (overlap - 2e-3)
                          : overlap >= 0    ? -7e3 * (2e-3 - overlap)
                          : overlap > -2e-3 ? -7e3 * (2e-3 + overlap)
                                            : 0;
      const Vec3 n = (1 / distance) * Vec3{std::max(0.0, c.x), c.y, 0};
      EXPECT_LT(norm(f - want * n), 1e-9) << c.x << " " << c.y;
    }
}

/// A cohesive sphere rolls off the top and pivots round the edge: one contact all the way, face, edge, face.
TEST(MeshEdge, OneContactWhileRoundingTheEdge) {
  Wet law = soil();
  law.friction.mu_r = 0;
  const MeshSurface box(box_mesh({1, 1, 1}, {-0.5, -0.5, 0}));
  const SphereSpec s{{-0.002, 0.008, 0.1}, {0.35, 0, 0}, {0, 0, -0.35 / 0.008}, 0.01, 1800, 0};
  Bed bed = on(box, law, {}, s);
  int most = 0;
  double turned = 0;
  for (int n = 0; n < 8000; ++n) {
    const Snapshot now = observe(bed, 1e-5);
    most = std::max(most, now.contacts[0]);
    turned = std::max(turned, std::atan2(now.position[0].x, now.position[0].y));
  }
  EXPECT_EQ(most, 1);
  EXPECT_GT(turned, 0.3) << "it must go round";
}

}  // namespace
}  // namespace subsoil::dem::test::engine_mesh_floor
