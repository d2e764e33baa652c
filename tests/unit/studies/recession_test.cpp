#include "libsim/studies/wear/recession.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "libdem/geometry/mesh_builders.hpp"
#include "tests/tools/grid_box.hpp"
#include "tests/tools/message_of.hpp"

/// Surfaces that lose a volume, beside closed forms of what is left.
namespace subsoil::sim::recession {
namespace {

using dem::TriangleMesh;
using dem::Vec3;
using subsoil::test::grid_box;
using subsoil::test::message_of;

double area_of(const TriangleMesh& mesh, std::size_t t) {
  return norm(cross(mesh.corner(t, 1) - mesh.corner(t, 0), mesh.corner(t, 2) - mesh.corner(t, 0))) / 2;
}

Vec3 middle(const TriangleMesh& mesh, std::size_t t) {
  return (1.0 / 3) * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2));
}

/// depth(normal, middle) times area, of each triangle.
template <class Depth>
std::vector<double> worn(const TriangleMesh& mesh, Depth depth) {
  std::vector<double> out;
  for (std::size_t t = 0; t < mesh.triangles().size(); ++t)
    out.push_back(area_of(mesh, t) * depth(mesh.normal(t), middle(mesh, t)));
  return out;
}

double sum(const std::vector<double>& values) {
  double all = 0;
  for (const double v : values) all += v;
  return all;
}

/// Volume in long double, about the mesh's own corner: an oracle that shares nothing with recede().
long double volume(const TriangleMesh& mesh) {
  struct Wide {
    long double x, y, z;
  };
  const Vec3 origin = mesh.vertices()[0];
  const auto wide = [&](const Vec3& p) {
    return Wide{(long double)p.x - origin.x, (long double)p.y - origin.y, (long double)p.z - origin.z};
  };
  long double six = 0;
  for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
    const Wide a = wide(mesh.corner(t, 0)), b = wide(mesh.corner(t, 1)), c = wide(mesh.corner(t, 2));
    six += a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x);
  }
  return six / 6;
}

/// Of a loss against the difference of both volumes. What rounding of coordinates, 1e-16 of the size, makes of it is
/// 1e-16 size/depth: below 1e-13 where a thousandth of the size is worn.
double closure(const TriangleMesh& before, const TriangleMesh& after, double lost) {
  return static_cast<double>((volume(before) - volume(after)) / lost - 1);
}

void expect_same_sense(const TriangleMesh& before, const TriangleMesh& after) {
  ASSERT_EQ(before.triangles(), after.triangles());
  EXPECT_TRUE(after.closed());
  for (std::size_t t = 0; t < before.triangles().size(); ++t) EXPECT_GT(dot(before.normal(t), after.normal(t)), 0) << t;
}

double top_only(const Vec3& normal, double depth) { return normal.y > 0.9 ? depth : 0; }

TEST(Recession, AFaceStaysAPlaneAndTheOthersKeepTheirs) {
  for (const TriangleMesh& box : {dem::box_mesh({0.3, 0.1, 0.2}), grid_box({0.3, 0.1, 0.2}, 4)}) {
    constexpr double depth = 4e-3;
    const std::vector<double> lost = worn(box, [&](const Vec3& n, const Vec3&) { return top_only(n, depth); });
    const Recession r = recede(box, lost);
    expect_same_sense(box, r.mesh);
    for (std::size_t v = 0; v < box.vertices().size(); ++v) {
      const Vec3 &from = box.vertices()[v], &to = r.mesh.vertices()[v];
      EXPECT_NEAR(to.x, from.x, 1e-16);
      EXPECT_NEAR(to.z, from.z, 1e-16);
      EXPECT_NEAR(to.y, from.y > 0.049 ? 0.05 - depth : from.y, 1e-16);
    }
    EXPECT_NEAR(sum(lost), 0.3 * 0.2 * depth, 1e-18);
    EXPECT_NEAR(closure(box, r.mesh, sum(lost)), 0, 1e-12);
    const Recessed by = recessed(box, r.mesh);
    EXPECT_NEAR(by.deepest, depth, 1e-16);
    EXPECT_NEAR(by.farthest, depth, 1e-16);
    EXPECT_NEAR(by.area, 0.3 * 0.2, 1e-15);
  }
}

/// All faces of a cube of side a by d each: 6 a^2 d = a^3 - (a - 2 x)^3 is lost, so that each recedes by x.
TEST(Recession, ACubeWornAllRoundStaysACube) {
  constexpr double a = 0.2, d = 3e-3;
  const double x = (a - std::cbrt(a * a * a - 6 * a * a * d)) / 2;
  for (const TriangleMesh& cube : {dem::box_mesh({a, a, a}), grid_box({a, a, a}, 3)}) {
    const std::vector<double> lost = worn(cube, [&](const Vec3&, const Vec3&) { return d; });
    const Recession r = recede(cube, lost);
    expect_same_sense(cube, r.mesh);
    EXPECT_NEAR(closure(cube, r.mesh, sum(lost)), 0, 1e-12);
    EXPECT_NEAR(recessed(cube, r.mesh).deepest, x, 1e-15);
    EXPECT_NEAR(r.factor, x / d, 1e-11);
    EXPECT_GT(x, 1.01 * d) << "what the factor has to make up";
    for (std::size_t v = 0; v < cube.vertices().size(); ++v)
      for (int i = 0; i < 3; ++i)
        if (std::abs(std::abs(cube.vertices()[v][i]) - a / 2) < 1e-12) {
          EXPECT_NEAR(std::abs(r.mesh.vertices()[v][i]), a / 2 - x, 1e-15);
        }
  }
}

/// A sphere by d all round. On triangles of half angle psi a vertex of five and one of six triangles see means of their
/// normals that differ by psi^2: so much of d is what is not round, and no more after a tenth of the radius.
TEST(Recession, ASphereStaysRound) {
  constexpr double radius = 0.1;
  for (const double d : {1e-4, 1e-2}) {
    const TriangleMesh sphere = dem::icosphere_mesh(radius, 4);
    const std::vector<double> lost = worn(sphere, [&](const Vec3&, const Vec3&) { return d; });
    const Recession r = recede(sphere, lost);
    expect_same_sense(sphere, r.mesh);
    EXPECT_NEAR(closure(sphere, r.mesh, sum(lost)), 0, d > 1e-3 ? 1e-12 : 1e-11);
    double least = 1, greatest = 0;
    for (const Vec3& p : r.mesh.vertices()) least = std::min(least, norm(p)), greatest = std::max(greatest, norm(p));
    const double share = std::cbrt(1 - sum(lost) / sphere.volume());
    constexpr double psi = 0.05;  // rad: an edge of the mesh is 0.07
    EXPECT_NEAR(least, radius * share, psi * psi * d) << d;
    EXPECT_NEAR(greatest, radius * share, psi * psi * d) << d;
  }
}

/// A wedge of half angle alpha and length l, both flanks by d: the flanks recede by x and the edge by x/sin(alpha)
/// towards the back, which stays where it is. What is left is a similar triangle.
TEST(Recession, TheEdgeOfAWedgeRecedesByDepthOverSine) {
  constexpr double length = 0.1, width = 0.06, d = 1e-3;
  for (const double degrees : {10.0, 25.0, 40.0}) {
    const double alpha = degrees * std::numbers::pi / 180, back = length * std::tan(alpha);
    const std::vector<dem::Point2> outline{{0, 0}, {length, -back}, {length, back}};
    const TriangleMesh wedge = dem::extruded_mesh(outline, width);
    const std::vector<double> lost =
        worn(wedge, [&](const Vec3& n, const Vec3&) { return std::abs(n.z) < 0.5 && n.x < 0 ? d : 0; });
    const Recession r = recede(wedge, lost);
    expect_same_sense(wedge, r.mesh);
    EXPECT_NEAR(closure(wedge, r.mesh, sum(lost)), 0, 1e-12);
    // length back - (length - e) (length - e) tan(alpha), times width, is the loss: e is how far the edge recedes.
    const double e = length - std::sqrt((length * back - sum(lost) / width) / std::tan(alpha));
    const Recessed by = recessed(wedge, r.mesh);
    EXPECT_NEAR(by.farthest, e, 1e-13);
    EXPECT_NEAR(by.deepest, e * std::sin(alpha), 1e-13);
    for (std::size_t v = 0; v < wedge.vertices().size(); ++v) {
      const Vec3 &from = wedge.vertices()[v], &to = r.mesh.vertices()[v];
      const bool edge = from.x == 0;
      EXPECT_NEAR(to.x, edge ? e : length, 1e-13);
      EXPECT_NEAR(to.y, edge ? 0 : std::copysign(back - e * std::tan(alpha), from.y), 1e-13);
      EXPECT_NEAR(to.z, from.z, 1e-15);
    }
  }
}

/// The land b of a blunt edge alone by d: it recedes by x and widens to b + 2 x tan(alpha), b x + x^2 tan(alpha) = b d.
TEST(Recession, AnEdgeBlunts) {
  constexpr double length = 0.1, width = 0.06, b = 4e-3, d = 2e-3, slope = 0.4;
  const std::vector<dem::Point2> outline{
      {0, b / 2}, {0, -b / 2}, {length, -b / 2 - slope * length}, {length, b / 2 + slope * length}};
  const TriangleMesh tool = dem::extruded_mesh(outline, width);
  const std::vector<double> lost = worn(tool, [&](const Vec3& n, const Vec3&) { return n.x < -0.99 ? d : 0; });
  const Recession r = recede(tool, lost);
  expect_same_sense(tool, r.mesh);
  EXPECT_NEAR(closure(tool, r.mesh, sum(lost)), 0, 1e-12);
  const double x = (std::sqrt(b * b + 4 * slope * b * d) - b) / (2 * slope);
  for (std::size_t v = 0; v < tool.vertices().size(); ++v) {
    const Vec3 &from = tool.vertices()[v], &to = r.mesh.vertices()[v];
    if (from.x != 0) {
      EXPECT_EQ(to, from);
      continue;
    }
    EXPECT_NEAR(to.x, x, 1e-14);
    EXPECT_NEAR(to.y, std::copysign(b / 2 + slope * x, from.y), 1e-14);
  }
}

/// The same through rows of triangles of 10 mm behind the land: 25 mm of them are used up, the others make room. All
/// vertices of the flanks stay in their planes.
TEST(Recession, AnEdgeRecedesThroughItsTriangles) {
  constexpr double length = 0.1, width = 0.06, b = 8e-3, slope = 0.2, x = 25e-3;
  const TriangleMesh box = grid_box({length, 1, width}, 10);
  const auto half = [&](double at) { return b / 2 + slope * at; };
  std::vector<Vec3> vertices = box.vertices();
  for (Vec3& p : vertices) p.x += length / 2, p.y *= 2 * half(p.x);
  const TriangleMesh tool(vertices, box.triangles());
  const double lost_all = width * x * (half(0) + half(x)), d = lost_all / (b * width);
  const std::vector<double> lost = worn(tool, [&](const Vec3& n, const Vec3&) { return n.x < -0.99 ? d : 0; });
  const Recession r = recede(tool, lost);
  expect_same_sense(tool, r.mesh);
  EXPECT_NEAR(closure(tool, r.mesh, lost_all), 0, 1e-12);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const Vec3 &from = vertices[v], &to = r.mesh.vertices()[v];
    if (from.x < 1e-12) {
      EXPECT_NEAR(to.x, x, 1e-13);
    }
    if (std::abs(std::abs(from.y) - half(from.x)) < 1e-12) {
      EXPECT_NEAR(std::abs(to.y), half(to.x), 1e-13);
    }
    if (std::abs(std::abs(from.z) - width / 2) < 1e-12) {
      EXPECT_NEAR(to.z, from.z, 1e-15);
    }
  }
}

/// Uneven wear on an uneven mesh: the sum is met whatever its distribution.
TEST(Recession, TheVolumeClosesForAnyDistribution) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1);
  for (int round = 0; round < 3; ++round)
    for (const TriangleMesh& mesh : {dem::icosphere_mesh(0.1, 3), grid_box({0.2, 0.1, 0.3}, 5),
                                     dem::cylinder_mesh({1, 2, 3}, {1, 2, 2}, 0.1, 0.2)}) {
      const std::vector<double> lost = worn(mesh, [&](const Vec3&, const Vec3&) { return 2e-3 * share(random); });
      for (const double spread : {0.0, 0.02}) {
        const Recession r = recede(mesh, lost, spread);
        expect_same_sense(mesh, r.mesh);
        EXPECT_NEAR(r.removed, sum(lost), 1e-15 * sum(lost));
        EXPECT_NEAR(closure(mesh, r.mesh, sum(lost)), 0, 1e-12);
      }
    }
}

/// A small loss: the factor that meets the sum is 1 to first order in depth over edge length. What is left halves with
/// the depth.
TEST(Recession, TheFactorIsOneToFirstOrder) {
  const TriangleMesh mesh = dem::icosphere_mesh(0.1, 3);
  const auto excess = [&](double d) {
    return recede(mesh, worn(mesh, [&](const Vec3&, const Vec3& p) { return d * (1 + 5 * p.x + 30 * p.y * p.y); }))
               .factor -
           1;
  };
  const double one = excess(1e-4), half = excess(5e-5);
  EXPECT_GT(one, 5e-4) << "of the order of depth over radius";
  EXPECT_LT(one, 2e-3);
  EXPECT_NEAR(one / half, 2, 0.01);
}

TEST(Recession, AMirroredMeshGivesTheMirrorImage) {
  const std::vector<dem::Point2> outline{{0, 0}, {0.1, -0.03}, {0.12, 0.04}, {0.05, 0.06}};
  const TriangleMesh mesh = dem::extruded_mesh(outline, 0.08);
  const auto mirrored = [](const Vec3& p) { return Vec3{-p.x, p.y, p.z}; };
  std::vector<Vec3> vertices;
  for (const Vec3& p : mesh.vertices()) vertices.push_back(mirrored(p));
  std::vector<dem::Triangle> triangles;
  for (const dem::Triangle& t : mesh.triangles()) triangles.push_back({t[0], t[2], t[1]});
  const TriangleMesh image(vertices, triangles);
  const std::vector<double> lost =
      worn(mesh, [](const Vec3& n, const Vec3& p) { return 2e-3 * (n.x < 0) * (1 + p.y); });
  const Recession a = recede(mesh, lost, 0.01), b = recede(image, lost, 0.01);
  for (std::size_t v = 0; v < vertices.size(); ++v)
    EXPECT_LT(norm(mirrored(a.mesh.vertices()[v]) - b.mesh.vertices()[v]), 1e-15) << v;
}

/// Worn at one place of a fine grid, the depth spreads by the variance that was asked for, along both axes of the face.
TEST(Recession, DepthsSpreadByTheLengthAndKeepTheirVolume) {
  const TriangleMesh box = grid_box({1, 0.5, 1}, 40);
  const auto moments = [&](double spread) {
    const std::vector<double> lost =
        worn(box, [&](const Vec3& n, const Vec3& p) { return n.y > 0.9 && std::hypot(p.x, p.z) < 0.05 ? 1e-4 : 0; });
    const Recession r = recede(box, lost, spread);
    EXPECT_NEAR(closure(box, r.mesh, sum(lost)), 0, 1e-9) << "1e-16 of the size over a mean depth of 1e-6";
    Vec3 out;
    double all = 0;
    for (std::size_t v = 0; v < box.vertices().size(); ++v) {
      const Vec3& p = box.vertices()[v];
      const double depth = p.y - r.mesh.vertices()[v].y;
      all += depth, out += depth * Vec3{p.x * p.x, 0, p.z * p.z};
      if (p.y < 0.2) {
        EXPECT_EQ(r.mesh.vertices()[v], p) << "no wear goes over the edge";
      }
    }
    return (1 / all) * out;
  };
  // 1e-3 of it lies beyond the rim of the face, 4.5 deviations away: it is held back.
  const Vec3 before = moments(0), after = moments(0.1);
  EXPECT_NEAR(after.x - before.x, 0.01, 1e-4);
  EXPECT_NEAR(after.z - before.z, 0.01, 1e-4);
  // An even depth has nothing to spread.
  const std::vector<double> even = worn(box, [&](const Vec3& n, const Vec3&) { return top_only(n, 1e-3); });
  const Recession r = recede(box, even, 0.1);
  for (std::size_t v = 0; v < box.vertices().size(); ++v)
    EXPECT_NEAR(r.mesh.vertices()[v].y, box.vertices()[v].y > 0.249 ? 0.249 : box.vertices()[v].y, 1e-14);
}

/// A bump that recedes through many steps: its triangles shrink and none turns over.
TEST(Recession, DeepWearTakesSteps) {
  const TriangleMesh sphere = dem::icosphere_mesh(0.1, 3);
  const std::vector<double> lost =
      worn(sphere, [](const Vec3& n, const Vec3&) { return 0.03 * std::max(n.y, 0.0) * std::max(n.y, 0.0); });
  const Recession r = recede(sphere, lost, 0);
  expect_same_sense(sphere, r.mesh);
  EXPECT_GT(r.steps, 3);
  EXPECT_NEAR(closure(sphere, r.mesh, sum(lost)), 0, 1e-12);
}

TEST(Recession, WithoutWearNothingMoves) {
  const TriangleMesh box = dem::box_mesh({1, 1, 1});
  EXPECT_EQ(recede(box, std::vector<double>(12, 0.0), 0.1).mesh.vertices(), box.vertices());
}

/// A plate of 10 mm whose faces are worn by 6 and 3 mm, in the middle of which no triangle spans both: what is told to
/// be the limit recedes, with the volume closed, and what is above it by two hundredths does not.
TEST(Recession, TheLimitThatARefusalStatesIsOne) {
  const TriangleMesh box = dem::box_mesh({0.1, 0.01, 0.1}), plate = grid_box({0.1, 0.01, 0.1}, 10);
  const std::vector<double> faces =
      worn(box, [](const Vec3& n, const Vec3&) { return std::abs(n.y) > 0.9 ? 4.95e-3 : 0; });
  const std::vector<double> pit =
      worn(plate, [](const Vec3& n, const Vec3& p) { return n.y > 0.9 && std::hypot(p.x, p.z) < 0.02 ? 0.02 : 0; });
  for (const auto& [mesh, lost] : {std::pair{box, faces}, std::pair{plate, pit}}) {
    double share = 0, depth = 0;
    try {
      recede(mesh, lost);
      ADD_FAILURE() << "accepted";
    } catch (const RecessionLimit& limit) {
      share = limit.share, depth = limit.depth;
    }
    ASSERT_GT(share, 0.1);
    const auto part = [&](double of) {
      std::vector<double> out = lost;
      for (double& v : out) v *= of;
      return out;
    };
    const Recession r = recede(mesh, part(share));
    expect_same_sense(mesh, r.mesh);
    EXPECT_NEAR(closure(mesh, r.mesh, share * sum(lost)), 0, 1e-12);
    EXPECT_NEAR(recessed(mesh, r.mesh).deepest, depth, 1e-12);
    EXPECT_THROW(recede(mesh, part(1.02 * share)), RecessionLimit);
  }
}

/// A body with a valley along x on top and one along z below, both with flanks of 45 degrees: 8 mm apart where they
/// pass over each other, far apart at their ends.
TriangleMesh crossed_valleys() {
  constexpr double a = 0.05, h = 4e-3;
  const std::vector<Vec3> vertices{{-a, h, 0},       {a, h, 0},       {0, -h, -a},    {0, -h, a},
                                   {-a, h + a, -a},  {a, h + a, -a},  {a, h + a, a},  {-a, h + a, a},
                                   {-a, -h - a, -a}, {a, -h - a, -a}, {a, -h - a, a}, {-a, -h - a, a}};
  const struct {
    Vec3 outward;
    std::vector<std::uint32_t> around;
  } faces[] = {{{0, 1, 0}, {4, 5, 1, 0}},     {{0, 1, 0}, {0, 1, 6, 7}},      {{0, -1, 0}, {8, 2, 3, 11}},
               {{0, -1, 0}, {2, 9, 10, 3}},   {{-1, 0, 0}, {0, 4, 8, 11, 7}}, {{1, 0, 0}, {1, 5, 9, 10, 6}},
               {{0, 0, -1}, {2, 8, 4, 5, 9}}, {{0, 0, 1}, {3, 11, 7, 6, 10}}};
  std::vector<dem::Triangle> triangles;
  for (const auto& face : faces)
    for (std::size_t k = 1; k + 1 < face.around.size(); ++k) {
      dem::Triangle t{face.around[0], face.around[k], face.around[k + 1]};
      if (dot(dem::area_vector(vertices[t[0]], vertices[t[1]], vertices[t[2]]), face.outward) < 0)
        std::swap(t[1], t[2]);
      triangles.push_back(t);
    }
  return TriangleMesh(vertices, triangles);
}

/// The upper valley sinks by sqrt(2) of the depth of its flanks: its edge passes the one below, and no vertex comes
/// out.
TEST(Recession, RefusesASurfaceThatPassesThroughItself) {
  const TriangleMesh body = crossed_valleys();
  ASSERT_TRUE(body.closed());
  ASSERT_GT(body.volume(), 0);
  const auto flanks = [&](double depth) {
    return worn(body, [&](const Vec3& n, const Vec3&) { return n.y > 0.5 ? depth : 0; });
  };
  const Recession r = recede(body, flanks(5e-3));
  EXPECT_NEAR(closure(body, r.mesh, sum(flanks(5e-3))), 0, 1e-12);
  EXPECT_NEAR(body.vertices()[0].y - r.mesh.vertices()[0].y, std::numbers::sqrt2 * 5e-3 * r.factor, 1e-9);
  const std::string refused = message_of<RecessionLimit>([&] { recede(body, flanks(7e-3)); });
  EXPECT_NE(refused.find("the worn surface passes through itself at ("), std::string::npos) << refused;
  EXPECT_NE(refused.find("mm at its deepest: wear it for less"), std::string::npos) << refused;
}

TEST(Recession, RefusesWhatCannotRecede) {
  const auto refusal = [](const TriangleMesh& mesh, const std::vector<double>& lost) {
    return message_of<std::invalid_argument>([&] { recede(mesh, lost); });
  };
  const auto holds = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos ? std::string() : text;
  };
  const TriangleMesh open = dem::rectangle_mesh({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), box = dem::box_mesh({0.1, 0.01, 0.1});
  EXPECT_EQ(holds(refusal(open, {1e-3, 1e-3}), "open surface has no volume to lose; close it"), "");
  EXPECT_EQ(holds(refusal(box, std::vector<double>(11, 0.0)), "11 worn volumes for 12 triangles"), "");
  std::vector<double> gain(12, 0.0);
  gain[4] = -1e-9;
  EXPECT_EQ(holds(refusal(box, gain), "triangle 5 has lost -1e-09 m^3: must be 0 or above"), "");
  // A plate of 10 mm, both faces by 6 mm, and all of it.
  const auto faces = [&](double depth) {
    return worn(box, [&](const Vec3& n, const Vec3&) { return std::abs(n.y) > 0.9 ? depth : 0; });
  };
  EXPECT_EQ(refusal(box, faces(4e-3)), "accepted");
  EXPECT_EQ(holds(refusal(box, faces(4.9e-3)), "9.95 mm high, at ("), "");
  EXPECT_EQ(holds(refusal(box, faces(6e-3)), "nothing is left; wear it for less"), "");
  // A pit through its middle, where no triangle spans both faces.
  const TriangleMesh plate = grid_box({0.1, 0.01, 0.1}, 10);
  const std::vector<double> pit =
      worn(plate, [](const Vec3& n, const Vec3& p) { return n.y > 0.9 && std::hypot(p.x, p.z) < 0.02 ? 0.02 : 0; });
  EXPECT_EQ(holds(refusal(plate, pit), "comes through the opposite side at ("), "");
  EXPECT_EQ(holds(refusal(plate, pit), "spread the wear over a length, or mesh the surface with larger triangles"), "");
}

}  // namespace
}  // namespace subsoil::sim::recession
