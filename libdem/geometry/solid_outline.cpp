#include "libdem/geometry/solid_outline.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "libdem/geometry/world_box.hpp"

namespace subsoil::dem {
namespace {

using Corners = std::array<Vec3, 3>;

bool apart(const Bounds& a, const Bounds& b) {
  for (int d = 0; d < 3; ++d)
    if (a.high[d] < b.low[d] || b.high[d] < a.low[d]) return true;
  return false;
}

Bounds box_of(const Corners& t) {
  Bounds box;
  for (const Vec3& p : t) box.include(p);
  return box;
}

/// Whether the open stretch from a to b goes through the inside of the triangle (Moeller and Trumbore 1997, J. Graphics
/// Tools 2, 21).
bool cuts(const Vec3& a, const Vec3& b, const Corners& t) {
  constexpr double margin = 1e-9;  // of both: what only touches does not cut
  const Vec3 way = b - a, u = t[1] - t[0], v = t[2] - t[0], h = cross(way, v);
  const double det = dot(u, h);
  if (std::abs(det) <= margin * norm(way) * norm(cross(u, v))) return false;
  const Vec3 s = a - t[0], q = cross(s, u);
  const double p = dot(s, h) / det, r = dot(way, q) / det, along = dot(v, q) / det;
  return p > margin && r > margin && p + r < 1 - margin && along > margin && along < 1 - margin;
}

bool any_edge_cuts(std::span<const Corners> edges_of, std::span<const Corners> triangles) {
  for (const Corners& e : edges_of) {
    const Bounds box = box_of(e);
    for (const Corners& t : triangles) {
      if (apart(box, box_of(t))) continue;
      for (std::size_t k = 0; k < 3; ++k)
        if (cuts(e[k], e[(k + 1) % 3], t)) return true;
    }
  }
  return false;
}

}  // namespace

SolidOutline::SolidOutline(const Boundary& b) : boundary_(&b) {
  if (std::holds_alternative<Plane>(b.shape)) return;
  for (const TriangleMesh& mesh : drawing(b.shape, 1.0))
    for (std::size_t k = 0; k < mesh.triangles().size(); ++k)
      triangles_.push_back({mesh.corner(k, 0), mesh.corner(k, 1), mesh.corner(k, 2)});
}

SolidOutline::Triangles SolidOutline::within(const Bounds& box) const {
  Triangles out;
  for (const Corners& t : triangles_) {
    Corners now;
    for (std::size_t k = 0; k < 3; ++k) now[k] = boundary_->pose.to_world(t[k]);
    if (!apart(box_of(now), box)) out.push_back(now);
  }
  return out;
}

bool SolidOutline::holds(const Vec3& point) const {
  const Shape& shape = boundary_->shape;
  const Vec3 c = boundary_->pose.to_local(point);
  const Bounds box = bounds(shape);
  if (box.distance_squared(c) > 0) return false;
  const double size = std::isfinite(box.diagonal()) ? box.diagonal() : Bounds::infinity;
  std::vector<std::uint32_t> near;
  candidates(shape, c, size, near);
  SurfaceContact nearest;
  return !near.empty() && contacts(shape, c, size, near, &nearest, 1) > 0 && nearest.distance < -1e-9 * size;
}

bool SolidOutline::meets(const SolidOutline& other) const {
  const Boundary &a = *boundary_, &b = *other.boundary_;
  if (!a.active || !b.active) return false;
  const auto plane_holds = [](const Boundary& of, const SolidOutline& body) {
    const auto& plane = std::get<Plane>(of.shape);
    const Vec3 point = of.pose.to_world(plane.point()), n = of.pose.attitude.rotate(plane.normal());
    const double margin = 1e-9 * bounds(body.boundary_->shape).diagonal();
    return std::any_of(body.triangles_.begin(), body.triangles_.end(), [&](const Corners& t) {
      return std::any_of(t.begin(), t.end(),
                         [&](const Vec3& p) { return dot(body.boundary_->pose.to_world(p) - point, n) < -margin; });
    });
  };
  const bool flat = triangles_.empty(), other_flat = other.triangles_.empty();
  if (flat && other_flat) return false;
  if (flat) return plane_holds(a, other);
  if (other_flat) return plane_holds(b, *this);
  const Bounds mine = world_box(bounds(a.shape), a.pose), its = world_box(bounds(b.shape), b.pose);
  if (apart(mine, its)) return false;
  const Triangles own = within(its), their = other.within(mine);
  if (any_edge_cuts(own, their) || any_edge_cuts(their, own)) return true;
  return other.holds(a.pose.to_world(triangles_.front()[0])) || holds(b.pose.to_world(other.triangles_.front()[0]));
}

}  // namespace subsoil::dem
