#include "libdem/geometry/mesh_builders.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace subsoil::dem {
namespace {

void require_positive(double value, const char* what) {
  if (!(value > 0) || !std::isfinite(value))
    throw std::invalid_argument(std::string(what) + " = " + std::to_string(value) + " m: must be above 0");
}

struct RegularPolygon {
  Vec3 axis;
  std::vector<Vec3> directions;  // unit vectors to its corners, about the axis in the right-handed sense
};

RegularPolygon around(const Vec3& axis, double radius, double length, int segments) {
  require_positive(radius, "cylinder: radius");
  require_positive(length, "cylinder: length");
  require_positive(norm(axis), "cylinder: length of its axis vector");
  if (segments < 3) throw std::invalid_argument("cylinder: " + std::to_string(segments) + " segments; at least 3");
  RegularPolygon polygon{normalized(axis), {}};
  const Vec3& a = polygon.axis;
  const Vec3 aside = std::abs(a.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 e1 = normalized(cross(a, aside)), e2 = cross(a, e1);
  for (int i = 0; i < segments; ++i) {
    const double angle = 2 * std::numbers::pi * i / segments;
    polygon.directions.push_back(std::cos(angle) * e1 + std::sin(angle) * e2);
  }
  return polygon;
}

}  // namespace

TriangleMesh box_mesh(const Vec3& size, const Vec3& centre) {
  require_positive(size.x, "box: size along x");
  require_positive(size.y, "box: size along y");
  require_positive(size.z, "box: size along z");
  std::vector<Vec3> v;
  for (int i = 0; i < 8; ++i) {  // corner i: bit 0 for +x, bit 1 for +y, bit 2 for +z
    const auto half = [i](int bit) { return (i >> bit & 1) != 0 ? 0.5 : -0.5; };
    v.push_back(centre + Vec3{half(0) * size.x, half(1) * size.y, half(2) * size.z});
  }
  return {std::move(v),
          {{0, 4, 6},
           {0, 6, 2},
           {1, 3, 7},
           {1, 7, 5},
           {0, 1, 5},
           {0, 5, 4},
           {2, 6, 7},
           {2, 7, 3},
           {0, 2, 3},
           {0, 3, 1},
           {4, 5, 7},
           {4, 7, 6}}};
}

TriangleMesh rectangle_mesh(const Vec3& corner, const Vec3& u, const Vec3& v) {
  return {{corner, corner + u, corner + u + v, corner + v}, {{0, 1, 2}, {0, 2, 3}}};
}

TriangleMesh extruded_mesh(std::span<const Point2> outline, double width) {
  require_positive(width, "extrusion: width");
  const std::vector<Point2> points = simple_polygon(outline);
  const auto n = static_cast<uint32_t>(points.size());
  std::vector<Vec3> vertices;
  for (const double z : {-width / 2, width / 2})
    for (const Point2& p : points) vertices.push_back({p[0], p[1], z});
  std::vector<Triangle> triangles;
  for (const Triangle& t : triangulate_polygon(points)) {
    triangles.push_back({t[0], t[2], t[1]});
    triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  }
  for (uint32_t i = 0; i < n; ++i) {  // the mesh turns all of it outward, whichever way the outline runs
    const uint32_t j = (i + 1) % n;
    triangles.push_back({i, j, j + n});
    triangles.push_back({i, j + n, i + n});
  }
  return {std::move(vertices), std::move(triangles)};
}

TriangleMesh cylinder_mesh(const Vec3& centre, const Vec3& axis, double radius, double length, int segments) {
  const auto [a, directions] = around(axis, radius, length, segments);
  const auto n = static_cast<uint32_t>(segments);
  std::vector<Vec3> v{centre - (length / 2) * a, centre + (length / 2) * a};
  std::vector<Triangle> triangles;
  for (uint32_t i = 0; i < n; ++i) {
    const Vec3 out = radius * directions[i];
    v.push_back(v[0] + out);
    v.push_back(v[1] + out);
    const uint32_t low = 2 + 2 * i, next = 2 + 2 * ((i + 1) % n);
    triangles.insert(triangles.end(),
                     {{0, next, low}, {1, low + 1, next + 1}, {low, next, next + 1}, {low, next + 1, low + 1}});
  }
  return {std::move(v), std::move(triangles)};
}

TriangleMesh tube_mesh(const Vec3& centre, const Vec3& axis, double inner_radius, double radius, double length,
                       int segments) {
  const auto [a, directions] = around(axis, radius, length, segments);
  require_positive(inner_radius, "tube: inner radius");
  require_positive(radius - inner_radius, "tube: thickness of its wall");
  const auto n = static_cast<uint32_t>(segments);
  std::vector<Vec3> v;
  std::vector<Triangle> triangles;
  for (uint32_t i = 0; i < n; ++i) {
    // Corners of the wall's section, going round it: outer low, outer high, inner high, inner low.
    for (const auto& [r, along] : {std::pair{radius, -0.5}, {radius, 0.5}, {inner_radius, 0.5}, {inner_radius, -0.5}})
      v.push_back(centre + (along * length) * a + r * directions[i]);
    for (uint32_t k = 0; k < 4; ++k) {
      const uint32_t here = 4 * i + k, up = 4 * i + (k + 1) % 4, next = 4 * ((i + 1) % n) + k,
                     next_up = 4 * ((i + 1) % n) + (k + 1) % 4;
      triangles.insert(triangles.end(), {{here, next, next_up}, {here, next_up, up}});
    }
  }
  return {std::move(v), std::move(triangles)};
}

TriangleMesh icosphere_mesh(double radius, int subdivisions) {
  require_positive(radius, "icosphere: radius");
  const double g = std::numbers::phi;
  std::vector<Vec3> v{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<Triangle> triangles{{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int k = 0; k < subdivisions; ++k) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [entry, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(v.size()));
      if (is_new) v.push_back(normalized(v[a]) + normalized(v[b]));
      return entry->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : triangles) {
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  for (Vec3& p : v) p = radius * normalized(p);
  return {std::move(v), std::move(triangles)};
}

TriangleMesh welded_mesh(std::span<const std::array<Vec3, 3>> soup, double weld) {
  Bounds b;
  for (const auto& t : soup)
    for (const Vec3& p : t) b.include(p);
  if (!(weld > 0)) weld = 1e-6 * b.diagonal();
  if (!(weld > 0)) throw std::invalid_argument("mesh: all corners lie at one place");
  // Cells as wide as the tolerance: a vertex within it is in the same cell or a neighbour. First come, first kept.
  using Cell = std::array<int64_t, 3>;
  std::map<Cell, std::vector<uint32_t>> cells;
  std::vector<Vec3> vertices;
  const auto cell_of = [&](const Vec3& p) {
    const auto index = [weld](double x) { return static_cast<int64_t>(std::floor(x / weld)); };
    return Cell{index(p.x - b.low.x), index(p.y - b.low.y), index(p.z - b.low.z)};
  };
  const auto vertex = [&](const Vec3& p) -> uint32_t {
    const Cell home = cell_of(p);
    for (int k = 0; k < 27; ++k) {
      const auto cell = cells.find({home[0] + k % 3 - 1, home[1] + k / 3 % 3 - 1, home[2] + k / 9 - 1});
      if (cell == cells.end()) continue;
      for (const uint32_t v : cell->second)
        if (norm(vertices[v] - p) <= weld) return v;
    }
    vertices.push_back(p);
    cells[home].push_back(static_cast<uint32_t>(vertices.size() - 1));
    return static_cast<uint32_t>(vertices.size() - 1);
  };
  std::vector<Triangle> triangles;
  for (const auto& t : soup) triangles.push_back({vertex(t[0]), vertex(t[1]), vertex(t[2])});
  return {std::move(vertices), std::move(triangles)};
}

}  // namespace subsoil::dem
