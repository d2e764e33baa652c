#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/geometry/mesh_surface.hpp"

/// What the geometry tests share: a query as the engine makes it, random numbers, meshes.
namespace subsoil::dem::test {

inline std::vector<SurfaceContact> touch(const MeshSurface& surface, const Vec3& c, double reach) {
  std::vector<uint32_t> candidates;
  surface.candidates(c, reach, candidates);
  std::vector<SurfaceContact> found(MeshSurface::max_minima);
  found.resize(surface.contacts(c, reach, candidates, found.data(), found.size()));
  return found;
}

class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * uniform_(engine_); }
  size_t below(size_t n) { return static_cast<size_t>(uniform_(engine_) * static_cast<double>(n)); }
  Vec3 in_box(const Vec3& low, const Vec3& high) {
    return {between(low.x, high.x), between(low.y, high.y), between(low.z, high.z)};
  }
  Vec3 direction() {
    for (;;) {
      const Vec3 v = in_box({-1, -1, -1}, {1, 1, 1});
      if (norm(v) > 0.1 && norm(v) < 1) return normalized(v);
    }
  }
  Quaternion attitude() { return Quaternion::from_rotation_vector(between(0, 3) * direction()); }

 private:
  std::mt19937 engine_;
  std::uniform_real_distribution<double> uniform_{0, 1};
};

/// Unit square of the x-z plane, normal +y, cut into triangles by dropping points into triangles: without swapping of
/// sides this leaves many slivers. Every third point lies `edge_gap` of a triangle's height off one of its sides.
inline TriangleMesh random_floor(int points, double edge_gap, uint32_t seed) {
  Random random(seed);
  std::vector<Vec3> v{{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}};
  std::vector<Triangle> triangles{{0, 1, 2}, {0, 2, 3}};
  for (int k = 0; k < points;) {
    const size_t t = random.below(triangles.size());
    const auto [a, b, c] = triangles[t];
    double wa = random.between(0.2, 0.8), wb = random.between(0.2, 0.8), wc = k % 3 == 0 ? edge_gap : 0.5;
    const double sum = wa + wb + wc;
    wa /= sum, wb /= sum, wc /= sum;
    const Vec3 point = wa * v[a] + wb * v[b] + wc * v[c];
    const auto height = [&](uint32_t i, uint32_t j) {  // relative to the longest side
      const double d = std::max({norm(v[i] - v[j]), norm(v[i] - point), norm(v[j] - point)});
      return norm(area_vector(v[i], v[j], point)) / (d * d);
    };
    if (std::min({height(a, b), height(b, c), height(c, a)}) < 1e-6) continue;  // slivers, but no degenerate ones
    ++k;
    const auto p = static_cast<uint32_t>(v.size());
    v.push_back(point);
    triangles[t] = {a, b, p};
    triangles.push_back({b, c, p});
    triangles.push_back({c, a, p});
  }
  return {v, triangles};
}

/// The shovel's side profile of the 1S-300 rig, counter-clockwise from the tip, axes of its centre of mass (m).
inline const std::vector<Point2>& shovel_outline() {
  static const std::vector<Point2> points{{.244, -.495},  {.113, -.434},  {.074, -.365}, {.046, -.255},
                                          {.034, -.115},  {.034, .505},   {-.066, .505}, {-.066, -.135},
                                          {-.054, -.285}, {-.021, -.395}, {.034, -.457}, {.094, -.479}};
  return points;
}

/// The rig's shovel: share below y = -0.365 m 50 mm wide, shank above it 30 mm, one on the other.
inline std::array<TriangleMesh, 2> shovel_surfaces() {
  const std::vector<Point2>& p = shovel_outline();
  const double cut = -.365, t = (cut - p[8][1]) / (p[9][1] - p[8][1]);
  const Point2 rear{p[8][0] + t * (p[9][0] - p[8][0]), cut};
  const std::vector<Point2> share{p[0], p[1], p[2], rear, p[9], p[10], p[11]};
  const std::vector<Point2> shank{p[2], p[3], p[4], p[5], p[6], p[7], p[8], rear};
  return {extruded_mesh(share, 0.050), extruded_mesh(shank, 0.030)};
}

}  // namespace subsoil::dem::test
