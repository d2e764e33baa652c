// The rule itself, on meshes without closed form: contacts are the visible local minima of the distance. The oracle
// knows no edges and no neighbours: it samples the surface densely and walks downhill from sample to sample.
#include <algorithm>
#include <map>
#include <numbers>

#include "tests/unit/libdem/geometry_support.hpp"

namespace subsoil::dem::test::geometry_minima {
namespace {

/// Solid angle of a closed surface seen from p, over 4 pi: 1 inside, 0 outside.
double winding(const TriangleMesh& mesh, const Vec3& p) {
  double sum = 0;
  for (size_t t = 0; t < mesh.triangles().size(); ++t) {
    const Vec3 a = mesh.corner(t, 0) - p, b = mesh.corner(t, 1) - p, c = mesh.corner(t, 2) - p;
    const double la = norm(a), lb = norm(b), lc = norm(c);
    sum += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

/// Samples of the boundary of a union of closed meshes, `spacing` apart at most.
class Samples {
 public:
  Samples(std::span<const TriangleMesh> meshes, double spacing) : meshes_(meshes) {
    for (const TriangleMesh& mesh : meshes) {
      for (size_t t = 0; t < mesh.triangles().size(); ++t) add_triangle(mesh, t, spacing);
    }
  }
  const std::vector<Vec3>& points() const { return points_; }
  /// Is the place strictly inside one of the solids?
  bool inside(const Vec3& p) const {
    return std::any_of(meshes_.begin(), meshes_.end(), [&](const TriangleMesh& m) { return winding(m, p) > 0.9; });
  }
  /// Does the stretch from c to the place p of the surface run outside?
  bool visible(const Vec3& c, const Vec3& p) const {
    for (int k = 1; k < 25; ++k) {
      if (inside(c + (0.98 * k / 25) * (p - c))) return false;
    }
    return true;
  }

 private:
  void add_triangle(const TriangleMesh& mesh, size_t t, double spacing) {
    const Vec3 &a = mesh.corner(t, 0), &b = mesh.corner(t, 1), &c = mesh.corner(t, 2);
    const double longest = std::max({norm(b - a), norm(c - b), norm(a - c)});
    const int n = static_cast<int>(std::ceil(longest / spacing));
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        const Vec3 p = a + (static_cast<double>(i) / n) * (b - a) + (static_cast<double>(j) / n) * (c - a);
        if (!inside(p + 1e-6 * mesh.normal(t))) points_.push_back(p);  // inner faces of a union are no boundary
      }
  }

  std::span<const TriangleMesh> meshes_;
  std::vector<Vec3> points_;
};

/// Visible local minima among the samples within `reach` of c: samples with no nearer sample within `ball`.
std::vector<Vec3> sampled_minima(const Samples& samples, const Vec3& c, double reach, double ball) {
  using Cell = std::array<int, 3>;  // cubes of side `ball`, so that a ball lies in 27 of them
  const auto cell_of = [&](const Vec3& p) {
    const auto index = [&](double x) { return static_cast<int>(std::floor(x / ball)); };
    return Cell{index(p.x), index(p.y), index(p.z)};
  };
  std::map<Cell, std::vector<Vec3>> cells;
  for (const Vec3& p : samples.points()) {
    if (norm(p - c) < reach) cells[cell_of(p)].push_back(p);
  }
  const auto is_lowest = [&](const Cell& home, const Vec3& p) {
    for (int k = 0; k < 27; ++k) {
      const auto cell = cells.find({home[0] + k % 3 - 1, home[1] + k / 3 % 3 - 1, home[2] + k / 9 - 1});
      if (cell == cells.end()) continue;
      for (const Vec3& q : cell->second) {
        if (norm(q - c) < norm(p - c) && norm(q - p) <= ball) return false;
      }
    }
    return true;
  };
  std::vector<Vec3> minima;
  for (const auto& [cell, points] : cells) {
    for (const Vec3& p : points) {
      if (is_lowest(cell, p) && samples.visible(c, p)) minima.push_back(p);
    }
  }
  return minima;
}

double distance_to(const Vec3& p, const std::vector<SurfaceContact>& contacts) {
  double least = 1;
  for (const SurfaceContact& contact : contacts) least = std::min(least, norm(contact.point - p));
  return least;
}

/// A contact is what it claims: seen from c, nearer than every place of the surface in a small ball around it.
void expect_minimum(const Samples& samples, std::span<const TriangleMesh> meshes, const SurfaceContact& contact,
                    const Vec3& c, Random& random) {
  EXPECT_NEAR(norm(c - contact.point), contact.distance, 1e-14);
  EXPECT_LE(norm(contact.point + contact.distance * contact.normal - c), 1e-14);
  EXPECT_TRUE(samples.visible(c, contact.point)) << "through the body";
  const double ball = 1e-6;
  for (const TriangleMesh& mesh : meshes)
    for (size_t t = 0; t < mesh.triangles().size(); ++t) {
      const Facet facet = Facet::from(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2));
      if (nearest_point(facet, contact.point).distance_squared > ball * ball) continue;
      for (int k = 0; k < 20; ++k) {
        const Vec3 place = nearest_point(facet, contact.point + ball * random.direction()).point;
        EXPECT_GE(norm(place - c), contact.distance - 1e-14) << "falls further";
      }
    }
}

/// Both ways at `wanted` random centres. Every contact is checked as above. Every sampled minimum must have its
/// contact: with samples h apart and balls of b, a sample that is lowest in its ball has a slope below about h/b = 1/4,
/// so the true minimum is within d h/b = 3 mm, and a millimetre is left for the samples' own places. A minimum whose
/// hollow is narrower than a ball has no sampled counterpart, so the converse is left to the first check.
void compare(std::span<const TriangleMesh> meshes, uint32_t seed, int wanted) {
  const double reach = 0.012, spacing = 0.0005, ball = 0.002, near = 0.004;
  const Samples samples(meshes, spacing);
  const MeshSurface surface(meshes);
  Random random(seed);
  const Bounds b = surface.bounds();
  const Vec3 margin{.011, .011, .011};
  int several = 0;
  for (int judged = 0; judged < wanted;) {
    const Vec3 c = random.in_box(b.low - margin, b.high + margin);
    const auto found = touch(surface, c, reach);
    if (found.empty() || found[0].distance < 0.002 || samples.inside(c)) continue;
    ++judged;
    several += found.size() > 1;
    for (const SurfaceContact& contact : found) expect_minimum(samples, meshes, contact, c, random);
    for (const Vec3& p : sampled_minima(samples, c, reach, ball)) {
      if (norm(p - c) > reach - 5e-4) continue;
      EXPECT_LE(distance_to(p, found), near) << "missed at " << c.x << ", " << c.y << ", " << c.z;
    }
  }
  EXPECT_GT(several, wanted / 50);  // the case is about bodies with more than one contact
}

TEST(GeometryMinima, BumpySphere) {
  TriangleMesh mesh = icosphere_mesh(0.02, 2);
  Random random(31);
  std::vector<Vec3> v = mesh.vertices();
  for (Vec3& p : v) p *= random.between(0.6, 1.3);
  const TriangleMesh bumpy(v, mesh.triangles());
  compare(std::span(&bumpy, 1), 1, 70);
}

TEST(GeometryMinima, StarPrism) {
  Random random(32);
  std::vector<Point2> star;
  for (int k = 0; k < 15; ++k) {
    const double angle = 2 * std::numbers::pi * k / 15,
                 r = k % 2 == 0 ? random.between(.02, .03) : random.between(.01, .02);
    star.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  const TriangleMesh prism = extruded_mesh(star, 0.02);
  compare(std::span(&prism, 1), 2, 70);
}

TEST(GeometryMinima, TwoCrossedBars) {
  // Two closed surfaces that run through each other: what lies inside the other is no surface.
  const std::vector<TriangleMesh> bars{box_mesh({.06, .02, .02}), box_mesh({.02, .06, .03}, {.007, .003, .004})};
  compare(bars, 3, 70);
}

TEST(GeometryMinima, ShareAndShankAroundTheirJoint) {
  // The rig's shovel cut to the part around the joint of its two extrusions.
  const std::vector<Point2> share{{.094, -.400}, {.074, -.365}, {-.030, -.365}, {-.021, -.395}},
      shank{{.074, -.365}, {.064, -.325}, {-.042, -.325}, {-.030, -.365}};
  const std::vector<TriangleMesh> parts{extruded_mesh(share, 0.050), extruded_mesh(shank, 0.030)};
  compare(parts, 4, 70);
}

TEST(GeometryMinima, CandidatesEqualBruteForceAndOthersDoNotMatter) {
  const auto parts = shovel_surfaces();
  std::vector<TriangleMesh> meshes(parts.begin(), parts.end());
  meshes.push_back(icosphere_mesh(0.05, 3).placed({{0.1, -.45, 0.02}, {}}));
  const MeshSurface surface(meshes);
  std::vector<uint32_t> all(surface.triangle_count()), tree;
  for (uint32_t t = 0; t < all.size(); ++t) all[t] = t;
  std::vector<Facet> facets;
  for (const TriangleMesh& m : meshes)
    for (size_t t = 0; t < m.triangles().size(); ++t)
      facets.push_back(Facet::from(m.corner(t, 0), m.corner(t, 1), m.corner(t, 2)));
  Random random(41);
  for (int k = 0; k < 2000; ++k) {
    const Vec3 c = random.in_box(surface.bounds().low, surface.bounds().high);
    const double reach = random.between(0.001, 0.05);
    tree.assign(1, 12345u);  // what is there stays
    surface.candidates(c, reach, tree);
    std::vector<uint32_t> expected{12345u};
    for (const uint32_t t : all)
      if (std::sqrt(nearest_point(facets[t], c).distance_squared) <= reach) expected.push_back(t);
    ASSERT_EQ(tree, expected);
    SurfaceContact few[8], many[8];
    const size_t n = surface.contacts(c, reach, std::span(tree).subspan(1), few, 8);
    ASSERT_EQ(n, surface.contacts(c, reach, all, many, 8));
    for (size_t i = 0; i < n; ++i) {
      EXPECT_EQ(few[i].point, many[i].point);
      EXPECT_EQ(few[i].normal, many[i].normal);
      EXPECT_EQ(few[i].feature, many[i].feature);
    }
  }
}

TEST(GeometryMinima, NearestPointOfATriangleAgainstAProjectedDescent) {
  Random random(51);
  for (int k = 0; k < 300; ++k) {
    const Vec3 a = random.in_box({0, 0, 0}, {1, 1, 1}), b = random.in_box({0, 0, 0}, {1, 1, 1}),
               d = random.in_box({0, 0, 0}, {1, 1, 1}), c = random.in_box({-1, -1, -1}, {2, 2, 2});
    const Facet facet = Facet::from(a, b, d);
    double least = INFINITY;  // on a grid of 200 points a side
    for (int i = 0; i <= 200; ++i)
      for (int j = 0; i + j <= 200; ++j)
        least = std::min(least, norm(a + (i / 200.) * (b - a) + (j / 200.) * (d - a) - c));
    const Nearest nearest = nearest_point(facet, c);
    EXPECT_NEAR(norm(nearest.point - c), std::sqrt(nearest.distance_squared), 1e-14);
    EXPECT_LE(std::sqrt(nearest.distance_squared), least + 1e-14);
    EXPECT_GE(std::sqrt(nearest.distance_squared), least - 0.01);  // a cell of the grid is at most sqrt(3)/200 wide
  }
}

}  // namespace
}  // namespace subsoil::dem::test::geometry_minima
