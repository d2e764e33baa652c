#include "libdem/geometry/triangle_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "libdem/geometry/mesh_edges.hpp"

namespace subsoil::dem {
namespace {

/// Triangles that meet across an edge, and whether they run along it in the same direction (one of them is turned).
struct Neighbour {
  uint32_t triangle;
  bool turned;
};

}  // namespace

Vec3 area_vector(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, bc = c - b, ca = a - c;
  const double ab2 = dot(ab, ab), bc2 = dot(bc, bc), ca2 = dot(ca, ca);
  if (ab2 >= bc2 && ab2 >= ca2) return cross(bc, ca);
  if (bc2 >= ca2) return cross(ca, ab);
  return cross(ab, bc);
}

TriangleMesh::TriangleMesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles)
    : vertices_(std::move(vertices)), triangles_(std::move(triangles)) {
  refuse_bad_triangles();
  orient();
}

void TriangleMesh::refuse_bad_triangles() const {
  if (triangles_.empty()) throw std::invalid_argument("mesh: no triangles; a surface needs at least one");
  for (size_t v = 0; v < vertices_.size(); ++v) {
    if (!std::isfinite(dot(vertices_[v], vertices_[v])))
      throw std::invalid_argument("mesh: vertex " + std::to_string(v + 1) + " is not finite");
  }
  size_t flat = 0, first = 0;
  for (size_t t = 0; t < triangles_.size(); ++t) {
    for (const uint32_t v : triangles_[t]) {
      if (v >= vertices_.size())
        throw std::invalid_argument("mesh: triangle " + std::to_string(t + 1) + " names vertex " +
                                    std::to_string(v + 1) + " of " + std::to_string(vertices_.size()));
    }
    const Vec3 &a = corner(t, 0), &b = corner(t, 1), &c = corner(t, 2);
    const double longest = std::max({norm(b - a), norm(c - b), norm(a - c)});
    if (norm(area_vector(a, b, c)) > flatness * longest * longest) continue;
    if (flat++ == 0) first = t;
  }
  if (flat > 0)
    throw std::invalid_argument("mesh: " + std::to_string(flat) + " of " + std::to_string(triangles_.size()) +
                                " triangles have no area (the first is triangle " + std::to_string(first + 1) +
                                "); remove them or mesh the surface again");
}

void TriangleMesh::orient() {
  const MeshEdges all(triangles_);
  std::vector<std::vector<Neighbour>> neighbours(triangles_.size());
  bool pairs = true, balanced = true;  // each edge between two triangles; each edge run through equally both ways
  for (const MeshEdge& edge : all.edges) {
    int sense = 0;
    for (size_t k = edge.begin; k < edge.end; ++k) sense += all.uses[k].forward ? 1 : -1;
    balanced = balanced && sense == 0;
    pairs = pairs && edge.end - edge.begin == 2;
    if (edge.end - edge.begin != 2) continue;
    const EdgeUse &a = all.uses[edge.begin], &b = all.uses[edge.begin + 1];
    neighbours[a.triangle].push_back({b.triangle, a.forward == b.forward});
    neighbours[b.triangle].push_back({a.triangle, a.forward == b.forward});
  }
  closed_ = pairs || balanced;
  if (!closed_) return;

  // Component by component: make the sense consistent. Where more than two triangles share an edge the
  // given sense is kept (it is balanced) and the walk stays on the edges between two.
  enum : char { unseen, kept, flipped };
  std::vector<char> state(triangles_.size(), unseen);
  std::vector<std::vector<uint32_t>> components;
  for (uint32_t seed = 0; seed < triangles_.size(); ++seed) {
    if (state[seed] != unseen) continue;
    std::vector<uint32_t>& component = components.emplace_back(1, seed);
    state[seed] = kept;
    for (size_t k = 0; k < component.size(); ++k) {
      const uint32_t t = component[k];
      for (const Neighbour& n : neighbours[t]) {
        const char wanted = (state[t] == flipped) != n.turned ? flipped : kept;
        if (state[n.triangle] == unseen) {
          state[n.triangle] = wanted;
          component.push_back(n.triangle);
        } else if (state[n.triangle] != wanted) {
          closed_ = false;  // one-sided, such as a Klein bottle: no inside
          return;
        }
      }
    }
    for (const uint32_t t : component)
      if (state[t] == flipped) std::swap(triangles_[t][1], triangles_[t][2]);
  }
  if (pairs) return turn_outward(components);
  if (signed_volume(every_triangle()) < 0)
    for (Triangle& t : triangles_) std::swap(t[1], t[2]);
}

// What lies within another component is turned when that is, so that it keeps its sense against it.
void TriangleMesh::turn_outward(std::span<const std::vector<uint32_t>> components) {
  std::vector<double> volume;
  for (const auto& component : components) volume.push_back(signed_volume(component));
  const auto inward = [](double v) { return v < 0; };
  const bool of_one_sense =
      std::all_of(volume.begin(), volume.end(), inward) || std::none_of(volume.begin(), volume.end(), inward);
  std::vector<size_t> order(components.size());  // the largest first: a component after those around it
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return std::abs(volume[a]) > std::abs(volume[b]); });
  std::vector<char> turned(components.size());
  for (size_t k = 0; k < order.size(); ++k) {
    const size_t c = order[k];
    turned[c] = inward(volume[c]);
    for (size_t j = of_one_sense ? 0 : k; j-- > 0;) {  // the smallest around it
      if (!encloses(components[order[j]], components[c])) continue;
      turned[c] = turned[order[j]];
      break;
    }
  }
  for (size_t c = 0; c < components.size(); ++c)
    if (turned[c] != 0)
      for (const uint32_t t : components[c]) std::swap(triangles_[t][1], triangles_[t][2]);
}

// Not what merely overlaps: its box lies within, and so do the middles of eight of its triangles.
bool TriangleMesh::encloses(std::span<const uint32_t> component, std::span<const uint32_t> other) const {
  const Bounds around = bounds(component), within = bounds(other);
  if (around.distance_squared(within.low) > 0 || around.distance_squared(within.high) > 0) return false;
  for (size_t k = 0; k < other.size(); k += (other.size() + 7) / 8) {
    const Vec3 middle = (1.0 / 3) * (corner(other[k], 0) + corner(other[k], 1) + corner(other[k], 2));
    if (std::abs(solid_angle(component, middle)) < 2 * std::numbers::pi) return false;
  }
  return true;
}

// 4 pi from within and 0 from without, negative where normals point inward; van Oosterom & Strackee, IEEE Trans.
// Biomed. Eng. 30 (1983) 125.
double TriangleMesh::solid_angle(std::span<const uint32_t> component, const Vec3& from) const {
  double half = 0;
  for (const uint32_t t : component) {
    const Vec3 a = corner(t, 0) - from, b = corner(t, 1) - from, c = corner(t, 2) - from;
    const double la = norm(a), lb = norm(b), lc = norm(c);
    half += std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(a, c) * lb + dot(b, c) * la);
  }
  return 2 * half;
}

Bounds TriangleMesh::bounds(std::span<const uint32_t> triangles) const {
  Bounds box;
  for (const uint32_t t : triangles)
    for (int i = 0; i < 3; ++i) box.include(corner(t, i));
  return box;
}

std::vector<uint32_t> TriangleMesh::every_triangle() const {
  std::vector<uint32_t> all(triangles_.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

double TriangleMesh::signed_volume(std::span<const uint32_t> triangles) const {
  const Vec3 origin = corner(triangles[0], 0);  // near the mesh, so that the cones do not cancel
  double six_volumes = 0;
  for (const uint32_t t : triangles)
    six_volumes += dot(corner(t, 0) - origin, cross(corner(t, 1) - origin, corner(t, 2) - origin));
  return six_volumes / 6;
}

double TriangleMesh::volume() const {
  if (!closed_) throw std::invalid_argument("mesh: an open surface has no volume; close it first");
  return signed_volume(every_triangle());
}

double TriangleMesh::area() const {
  double sum = 0;
  for (size_t t = 0; t < triangles_.size(); ++t) sum += norm(area_vector(corner(t, 0), corner(t, 1), corner(t, 2))) / 2;
  return sum;
}

Bounds TriangleMesh::bounds() const {
  Bounds b;
  for (const Triangle& t : triangles_)
    for (const uint32_t v : t) b.include(vertices_[v]);
  return b;
}

Vec3 TriangleMesh::normal(size_t triangle) const {
  return normalized(area_vector(corner(triangle, 0), corner(triangle, 1), corner(triangle, 2)));
}

TriangleMesh TriangleMesh::placed(const Pose& pose, double scale) const {
  if (!(scale > 0) || !std::isfinite(scale))
    throw std::invalid_argument("mesh: scale " + std::to_string(scale) + " must be above 0");
  TriangleMesh mesh = *this;
  for (Vec3& v : mesh.vertices_) v = pose.to_world(scale * v);
  return mesh;
}

}  // namespace subsoil::dem
