#include "libsim/setup/shown_area.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>
#include <vector>

#include "libdem/geometry/world_box.hpp"
#include "libdem/particles/cell_area.hpp"

namespace subsoil::sim {

namespace {

using Shadow = std::vector<std::pair<double, double>>;  ///< corners, m

Vec3 across(const Vec3& along) {
  const double x = std::abs(along.x), y = std::abs(along.y), z = std::abs(along.z);
  const Vec3 axis = x <= y && x <= z ? Vec3{1, 0, 0} : y <= z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  return dem::normalized(dem::cross(along, axis));
}

/// With images a period apart along u, so that between 0 and a period lies all that does anywhere.
void repeat(std::vector<Shadow>& shadows, double period) {
  std::vector<Shadow> all;
  for (const Shadow& s : shadows) {
    const auto [first, last] = std::minmax_element(s.begin(), s.end());
    for (double k = -std::floor(last->first / period); first->first + k * period < period; ++k) {
      all.push_back(s);
      for (auto& corner : all.back()) corner.first += k * period;
    }
  }
  shadows = std::move(all);
}

/// Of the directions that a surface spans the one whose period is the longest across `along`; -1: none.
int endless_direction(const dem::Bounds& box, const Vec3& along, const dem::PeriodicCell& cell) {
  const std::array<bool, 3> spans = dem::spanned(box, cell);
  int longest = -1;
  double length = 0;
  for (int d = 0; d < 3; ++d) {
    const double across_along = cell.length[d] * std::sqrt(std::max(0.0, 1 - along[d] * along[d]));
    if (spans[static_cast<std::size_t>(d)] && across_along > length) longest = d, length = across_along;
  }
  return longest;
}

/// The polygons' shadow on a plane across `along`, as corners (u, v). `period`: of a surface that extends beyond the
/// cell, along u, m; what lies beyond it is there once more a period on.
struct Shadows {
  std::vector<Shadow> of;
  double period = 0;
};

Shadows shadows(const dem::Boundary& boundary, const Vec3& along, const dem::PeriodicCell& cell) {
  const int endless = endless_direction(world_box(dem::bounds(boundary.shape), boundary.pose), along, cell);
  Vec3 u = across(along);
  Shadows out;
  if (endless >= 0) {
    Vec3 way;
    way[endless] = cell.length[endless];
    way = way - dem::dot(way, along) * along;
    out.period = dem::norm(way), u = way * (1 / out.period);
  }
  const Vec3 v = dem::cross(along, u);
  for (const dem::TriangleMesh& mesh : dem::drawing(boundary.shape, 1.0))
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
      std::vector<Vec3> corners;
      for (int k = 0; k < 3; ++k) corners.push_back(boundary.pose.to_world(mesh.corner(t, k)));
      Shadow shadow;
      for (const Vec3& x : dem::within(corners, cell)) shadow.emplace_back(dem::dot(x, u), dem::dot(x, v));
      if (shadow.size() > 2) out.of.push_back(std::move(shadow));
    }
  if (out.period > 0) repeat(out.of, out.period);
  return out;
}

/// Of a convex polygon over the line at u: the interval of v.
std::pair<double, double> interval_at(const Shadow& shadow, double u) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t k = 0; k < shadow.size(); ++k) {
    const auto& [u0, v0] = shadow[k];
    const auto& [u1, v1] = shadow[(k + 1) % shadow.size()];
    if ((u0 <= u) == (u1 <= u)) continue;
    const double at = v0 + (v1 - v0) * (u - u0) / (u1 - u0);
    low = std::min(low, at), high = std::max(high, at);
  }
  return {low, high};
}

double covered(std::vector<std::pair<double, double>>& intervals) {
  std::sort(intervals.begin(), intervals.end());
  double sum = 0, end = -std::numeric_limits<double>::infinity();
  for (const auto& [low, high] : intervals) {
    sum += std::max(0.0, high - std::max(low, end));
    end = std::max(end, high);
  }
  return sum;
}

/// Area of the union of convex polygons: the length covered along lines of constant u, integrated between the corners
/// and in strips of a two-thousandth of the width. That length is linear in u but where edges cross, so that only
/// strips with a crossing err, by the square of their width.
double area_of_union(Shadows of) {
  std::vector<Shadow>& shadows = of.of;
  std::vector<double> cuts;
  const auto least = [](const Shadow& s) { return std::min_element(s.begin(), s.end())->first; };
  for (const Shadow& s : shadows)
    for (const auto& corner : s) cuts.push_back(corner.first);
  if (cuts.empty()) return 0;
  if (of.period > 0) {
    std::erase_if(cuts, [&](double u) { return !(u > 0 && u < of.period); });
    cuts.push_back(0), cuts.push_back(of.period);
  }
  const auto [first, last] = std::minmax_element(cuts.begin(), cuts.end());
  constexpr int strips = 2000;
  const double begin = *first, width = *last - *first;
  for (int k = 1; k < strips; ++k) cuts.push_back(begin + width * k / strips);
  std::sort(cuts.begin(), cuts.end());
  std::sort(shadows.begin(), shadows.end(), [&](const Shadow& a, const Shadow& b) { return least(a) < least(b); });

  double area = 0;
  std::size_t next = 0;
  std::vector<const Shadow*> here;
  std::vector<std::pair<double, double>> intervals;
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    const double length = cuts[k + 1] - cuts[k], middle = 0.5 * (cuts[k] + cuts[k + 1]);
    if (!(length > 1e-14 * width)) continue;
    for (; next < shadows.size() && least(shadows[next]) < middle; ++next) here.push_back(&shadows[next]);
    intervals.clear();
    std::erase_if(here, [&](const Shadow* s) {
      const std::pair<double, double> interval = interval_at(*s, middle);
      if (interval.first <= interval.second) intervals.push_back(interval);
      return interval.first > interval.second;
    });
    area += length * covered(intervals);
  }
  return area;
}

/// Common to two circles of a radius whose centres are `apart`.
double lens(double radius, double apart) {
  const double half = apart / (2 * radius);
  return half < 1 ? 2 * radius * radius * (std::acos(half) - half * std::sqrt(1 - half * half)) : 0;
}

/// Shadow of a round cylinder, less what is seen through its bore.
double shadow_of(const dem::Cylinder& c, const Vec3& along) {
  const double cosine = std::abs(dem::dot(c.axis(), along)), sine = dem::norm(dem::cross(c.axis(), along));
  double area = M_PI * c.radius() * c.radius() * cosine + 2 * c.radius() * c.length() * sine;
  if (c.inner_radius() > 0 && cosine > 0) area -= cosine * lens(c.inner_radius(), c.length() * sine / cosine);
  return area;
}

}  // namespace

double shown_area(const dem::Boundary& boundary, const Vec3& along, const dem::PeriodicCell& cell) {
  const double within_cell = area_of_union(shadows(boundary, along, cell));
  const auto* cylinder = std::get_if<dem::Cylinder>(&boundary.shape);
  if (cylinder == nullptr) return within_cell;
  // The triangles say what share of it is in the cell.
  const double whole = area_of_union(shadows(boundary, along, {}));
  return within_cell / whole * shadow_of(*cylinder, boundary.pose.attitude.conjugate().rotate(along));
}

}  // namespace subsoil::sim
