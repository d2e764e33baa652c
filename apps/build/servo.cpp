#include "apps/build/servo.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace subsoil::app {

namespace {

using Polygon = std::vector<Vec3>;

/// What of a convex polygon lies at sign (x[d] - limit) <= 0.
Polygon cut(const Polygon& polygon, int d, double limit, double sign) {
  Polygon out;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    const double beyond_a = sign * (a[d] - limit), beyond_b = sign * (b[d] - limit);
    if (beyond_a <= 0) out.push_back(a);
    if ((beyond_a <= 0) != (beyond_b <= 0)) out.push_back(a + (b - a) * (beyond_a / (beyond_a - beyond_b)));
  }
  return out;
}

Polygon within(Polygon polygon, const dem::PeriodicCell& cell) {
  for (int d = 0; d < 3; ++d) {
    if (cell.length[d] == 0) continue;
    polygon = cut(cut(polygon, d, cell.low[d], -1), d, cell.low[d] + cell.length[d], 1);
  }
  return polygon;
}

double area_along(const Polygon& polygon, const Vec3& along) {
  Vec3 doubled;
  for (std::size_t k = 2; k < polygon.size(); ++k)
    doubled += dem::cross(polygon[k - 1] - polygon[0], polygon[k] - polygon[0]);
  return 0.5 * std::abs(dem::dot(along, doubled));
}

double area_of_triangles(const dem::Boundary& boundary, const Vec3& along, const dem::PeriodicCell& cell) {
  double area = 0;
  for (const dem::TriangleMesh& mesh : dem::drawing(boundary.shape, 1.0)) {
    const double sides = mesh.closed() ? 0.5 : 1;  // a solid is seen from behind, too
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
      Polygon corners;
      for (int k = 0; k < 3; ++k) corners.push_back(boundary.pose.to_world(mesh.corner(t, k)));
      area += sides * area_along(within(corners, cell), along);
    }
  }
  return area;
}

/// Common to two circles of a radius whose centres are `apart`.
double lens(double radius, double apart) {
  const double half = apart / (2 * radius);
  return half < 1 ? 2 * radius * radius * (std::acos(half) - half * std::sqrt(1 - half * half)) : 0;
}

/// Shadow of a round cylinder, less what is seen through its bore.
double shadow(const dem::Cylinder& c, const Vec3& along) {
  const double cosine = std::abs(dem::dot(c.axis(), along)), sine = dem::norm(dem::cross(c.axis(), along));
  double area = M_PI * c.radius() * c.radius() * cosine + 2 * c.radius() * c.length() * sine;
  if (c.inner_radius() > 0 && cosine > 0) area -= cosine * lens(c.inner_radius(), c.length() * sine / cosine);
  return area;
}

}  // namespace

double shown_area(const dem::Boundary& boundary, const Vec3& along, const dem::PeriodicCell& cell) {
  const double within_cell = area_of_triangles(boundary, along, cell);
  const auto* cylinder = std::get_if<dem::Cylinder>(&boundary.shape);
  if (cylinder == nullptr) return within_cell;
  // The triangles say what share of it is in the cell.
  const double whole = area_of_triangles(boundary, along, {});
  return within_cell / whole * shadow(*cylinder, boundary.pose.attitude.conjugate().rotate(along));
}

namespace {

double largest_load(const coupling::Servo& servo, double end) {
  constexpr int samples = 4000;  // of a run
  double most = 0;
  for (int k = 0; k <= samples; ++k) most = std::max(most, std::abs(servo.load(end * k / samples)));
  return most;
}

}  // namespace

coupling::Servo servo_of(const ServoSection& s, const dem::Boundary& boundary, const dem::PeriodicCell& cell,
                         double end, const std::string& place) {
  coupling::Servo out;
  out.along = dem::normalized(s.along);
  out.lag = s.lag.value_or(-1);
  out.limit = s.limit, out.integral_gain = s.integral, out.rate_gain = s.rate;
  if (s.load.is_set()) {
    out.load = [load = s.load](double t) { return load.value(t); };
  } else {
    if (std::holds_alternative<dem::Plane>(boundary.shape))
      throw ScenarioError(place + ".pressure: a plane has no end, so no area; give `load` in N, or a box");
    const double area = shown_area(boundary, out.along, cell);
    if (!(area > 0))
      throw ScenarioError(place +
                          ".pressure: the surface shows no area along `along` within the container's periodic "
                          "sides; give `load` in N, or place it there");
    out.load = [pressure = s.pressure, area](double t) { return area * pressure.value(t); };
  }
  if (s.gain) {
    out.gain = *s.gain;
    return out;
  }
  const double most = largest_load(out, end);
  if (!(most > 0))
    throw ScenarioError(place + ": the load is zero at all times, so that no gain follows from it; give `gain`");
  out.gain = s.limit / most;
  return out;
}

}  // namespace subsoil::app
