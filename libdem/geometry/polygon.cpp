#include "libdem/geometry/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace subsoil::dem {
namespace {

Point2 minus(const Point2& a, const Point2& b) { return {a[0] - b[0], a[1] - b[1]}; }
double cross2(const Point2& a, const Point2& b) { return a[0] * b[1] - a[1] * b[0]; }
double dot2(const Point2& a, const Point2& b) { return a[0] * b[0] + a[1] * b[1]; }
double turn(const Point2& a, const Point2& b, const Point2& c) { return cross2(minus(b, a), minus(c, a)); }

double distance_to_segment(const Point2& p, const Point2& a, const Point2& b) {
  const Point2 ab = minus(b, a), ap = minus(p, a);
  const double t = std::clamp(dot2(ap, ab) / dot2(ab, ab), 0.0, 1.0);
  return std::hypot(ap[0] - t * ab[0], ap[1] - t * ab[1]);
}

bool cross_or_touch(const Point2& a, const Point2& b, const Point2& c, const Point2& d, double tolerance) {
  if ((turn(a, b, c) > 0) != (turn(a, b, d) > 0) && (turn(c, d, a) > 0) != (turn(c, d, b) > 0)) return true;
  return std::min({distance_to_segment(a, c, d), distance_to_segment(b, c, d), distance_to_segment(c, a, b),
                   distance_to_segment(d, a, b)}) <= tolerance;
}

std::string name(size_t i, const Point2& p) {
  const auto number = [](double x) {
    std::string s = std::to_string(x);
    s.erase(s.find_last_not_of('0') + 1);
    if (s.back() == '.') s.pop_back();
    return s;
  };
  return std::to_string(i + 1) + " (" + number(p[0]) + ", " + number(p[1]) + ")";
}

/// The ring of points not yet clipped, with each point's worth as an ear.
class EarClipper {
 public:
  explicit EarClipper(std::span<const Point2> outline) : points_(outline), flat_(flatness(outline)) {
    const auto n = static_cast<uint32_t>(outline.size());
    const bool reversed = polygon_area(outline) < 0;
    for (uint32_t i = 0; i < n; ++i) ring_.push_back(reversed ? n - 1 - i : i);
    for (size_t k = 0; k < ring_.size(); ++k) worth_.push_back(worth(k));
  }

  std::vector<Triangle> run() {
    std::vector<Triangle> triangles;
    while (ring_.size() > 3) {
      auto best = std::max_element(worth_.begin(), worth_.end());
      if (*best <= 0) {
        // A point clipped since may have stood in the way of an ear that is not its neighbour.
        for (size_t k = 0; k < ring_.size(); ++k) worth_[k] = worth(k);
        best = std::max_element(worth_.begin(), worth_.end());
      }
      if (*best <= 0) throw std::invalid_argument("outline: no triangulation found; its sides nearly touch");
      const auto k = static_cast<size_t>(best - worth_.begin());
      triangles.push_back({at(k - 1), ring_[k], at(k + 1)});
      ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(k));
      worth_.erase(best);
      const size_t n = ring_.size(), before = (k + n - 1) % n, after = k % n;
      worth_[before] = worth(before);
      worth_[after] = worth(after);
    }
    triangles.push_back({ring_[0], ring_[1], ring_[2]});
    return triangles;
  }

 private:
  static double flatness(std::span<const Point2> outline) {
    Bounds b;
    for (const Point2& p : outline) b.include(Vec3{p[0], p[1], 0});
    return 1e-12 * dot(b.high - b.low, b.high - b.low);
  }
  uint32_t at(size_t k) const { return ring_[(k + ring_.size()) % ring_.size()]; }

  /// Height over longest side of the ear at ring position k, 0 when it is none. Points on the rim of an ear spoil it
  /// too: cut there, they would end between vertices, and the rest could be left without area.
  double worth(size_t k) const {
    const uint32_t ia = at(k + ring_.size() - 1), ib = ring_[k], ic = at(k + 1);
    const Point2 &a = points_[ia], &b = points_[ib], &c = points_[ic];
    const double twice_area = turn(a, b, c);
    if (twice_area <= flat_) return 0;
    for (const uint32_t i : ring_) {
      if (i == ia || i == ib || i == ic) continue;
      const Point2& p = points_[i];
      if (turn(a, b, p) >= -flat_ && turn(b, c, p) >= -flat_ && turn(c, a, p) >= -flat_) return 0;
    }
    const Point2 ab = minus(b, a), bc = minus(c, b), ca = minus(a, c);
    return twice_area / std::max({dot2(ab, ab), dot2(bc, bc), dot2(ca, ca)});
  }

  std::span<const Point2> points_;
  double flat_;  // m^2: twice the area that counts as none
  std::vector<uint32_t> ring_;
  std::vector<double> worth_;
};

}  // namespace

double polygon_area(std::span<const Point2> outline) {
  double twice = 0;
  for (size_t i = 1; i + 1 < outline.size(); ++i) twice += turn(outline[0], outline[i], outline[i + 1]);
  return twice / 2;
}

std::vector<Point2> simple_polygon(std::span<const Point2> outline) {
  std::vector<Point2> points(outline.begin(), outline.end());
  if (points.size() > 1 && points.front() == points.back()) points.pop_back();
  if (points.size() < 3)
    throw std::invalid_argument("outline: " + std::to_string(points.size()) + " points; a polygon needs at least 3");
  Bounds b;
  for (size_t i = 0; i < points.size(); ++i) {
    if (!std::isfinite(points[i][0] + points[i][1]))
      throw std::invalid_argument("outline: point " + std::to_string(i + 1) + " is not finite");
    b.include(Vec3{points[i][0], points[i][1], 0});
  }
  const double tolerance = 1e-9 * b.diagonal();
  const size_t n = points.size();
  const auto next = [n](size_t i) { return (i + 1) % n; };
  for (size_t i = 0; i < n; ++i) {
    const Point2 &p = points[i], &q = points[next(i)];
    if (std::hypot(q[0] - p[0], q[1] - p[1]) <= tolerance)
      throw std::invalid_argument("outline: points " + name(i, p) + " and " + name(next(i), q) +
                                  " lie at the same place; remove one");
  }
  for (size_t i = 0; i < n; ++i) {
    const size_t k = next(next(i));
    if (distance_to_segment(points[k], points[i], points[next(i)]) <= tolerance ||
        distance_to_segment(points[i], points[next(i)], points[k]) <= tolerance)
      throw std::invalid_argument("outline: it turns back on itself at point " + name(next(i), points[next(i)]) +
                                  "; remove the spike");
    for (size_t j = i + 2; j < n; ++j) {
      if (next(j) == i || !cross_or_touch(points[i], points[next(i)], points[j], points[next(j)], tolerance)) continue;
      throw std::invalid_argument("outline: the side from point " + name(i, points[i]) + " to " +
                                  name(next(i), points[next(i)]) + " meets the side from point " + name(j, points[j]) +
                                  " to " + name(next(j), points[next(j)]) +
                                  "; list the points in order around the outline");
    }
  }
  return points;
}

std::vector<Triangle> triangulate_polygon(std::span<const Point2> outline) {
  const std::vector<Point2> points = simple_polygon(outline);
  return EarClipper(points).run();
}

}  // namespace subsoil::dem
