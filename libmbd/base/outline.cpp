#include "libmbd/base/outline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace subsoil::mbd {

namespace {

Vec2 vec(const std::array<double, 2>& p) { return {p[0], p[1]}; }

Vec2 direction_between(Vec2 a, Vec2 b) {
  const Vec2 d = b - a;
  return (1 / length(d)) * d;
}

double twice_area(const std::vector<Vec2>& p) {
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) sum += cross(p[i], p[(i + 1) % p.size()]);
  return sum;
}

/// Two sides that meet elsewhere than in a common corner: the number of the first, from 1, or 0.
std::size_t crossing_side(const std::vector<Vec2>& p) {
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      const Vec2 a = p[i], ab = p[i + 1] - a, c = p[j], cd = p[(j + 1) % n] - c;
      const double across = cross(ab, cd);
      if (across == 0) continue;
      const double s = cross(c - a, cd) / across, t = cross(c - a, ab) / across;
      if (s >= 0 && s <= 1 && t >= 0 && t <= 1) return i + 1;
    }
  return 0;
}

/// Corners, counter-clockwise, that are checked to be of a polygon.
std::vector<Vec2> checked_corners(const Outline::Points& points) {
  std::vector<Vec2> p;
  for (const auto& point : points)
    if (p.empty() || length(vec(point) - p.back()) > 0) p.push_back(vec(point));
  if (p.size() > 1 && !(length(p.front() - p.back()) > 0)) p.pop_back();  // the first again
  if (p.size() < 3) throw std::invalid_argument("a polygon needs at least three corners that differ");
  if (const std::size_t i = crossing_side(p); i > 0)
    throw std::invalid_argument("side " + std::to_string(i) +
                                " of the polygon meets another side; list its corners once around in order");
  double around = 0;
  for (std::size_t i = 0; i < p.size(); ++i) around += length(p[(i + 1) % p.size()] - p[i]);
  if (!(std::abs(twice_area(p)) > 1e-12 * around * around))
    throw std::invalid_argument("the polygon's corners lie on one line, so that it has no inside; move one of them");
  if (twice_area(p) < 0) std::reverse(p.begin(), p.end());
  return p;
}

/// The polygon whose sides lie r further in.
std::vector<Vec2> moved_in(const std::vector<Vec2>& p, double r) {
  const std::size_t n = p.size();
  std::vector<Vec2> core(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 u = direction_between(p[(i + n - 1) % n], p[i]), v = direction_between(p[i], p[(i + 1) % n]);
    // Moves in by r from both sides: d . k x u = d . k x v = r.
    core[i] = p[i] + (r / (1 + dot(u, v))) * (turned(u) + turned(v));
  }
  for (std::size_t i = 0; i < n && r > 0; ++i) {
    const std::size_t j = (i + 1) % n;
    if (!(dot(core[j] - core[i], p[j] - p[i]) > 0))
      throw std::invalid_argument("the corner radius leaves nothing of side " + std::to_string(i + 1) +
                                  " of the polygon; take a smaller one");
  }
  return core;
}

}  // namespace

Outline Outline::disk(std::array<double, 2> centre, double radius) {
  Outline o(Kind::disk);
  o.centre_ = vec(centre), o.radius_ = radius;
  o.corners_.push_back({o.centre_, radius, {}, {}});
  return o;
}

Outline Outline::polygon(const Points& points, double corner_radius) {
  const std::vector<Vec2> core = moved_in(checked_corners(points), corner_radius);
  const std::size_t n = core.size();
  Outline o(Kind::polygon);
  o.radius_ = corner_radius;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 u = direction_between(core[i], core[(i + 1) % n]);
    o.faces_.push_back({core[i], u, -1.0 * turned(u), length(core[(i + 1) % n] - core[i]), corner_radius});
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Face &before = o.faces_[(i + n - 1) % n], &after = o.faces_[i];
    o.convex_.push_back(cross(before.along, after.along) >= 0);
    if (o.convex_.back()) o.corners_.push_back({core[i], corner_radius, before.normal, after.normal});
    o.re_entrant_ = o.re_entrant_ || !o.convex_.back();
  }
  return o;
}

Outline Outline::curve(std::shared_ptr<const Curve> curve, std::array<double, 2> origin, std::array<double, 2> middle,
                       bool free_left, bool closed) {
  Outline o(Kind::curve);
  o.curve_ = std::move(curve), o.centre_ = vec(origin), o.middle_ = o.centre_ + vec(middle);
  o.free_left_ = free_left, o.closed_ = closed;
  return o;
}

Outline Outline::flat(std::array<double, 2> point, double angle) {
  Outline o(Kind::flat);
  const Vec2 along{std::cos(angle), std::sin(angle)};
  o.faces_.push_back({vec(point), along, turned(along), std::numeric_limits<double>::infinity(), 0});
  return o;
}

Outline::Near Outline::near(Vec2 w) const {
  if (kind_ == Kind::polygon) return near_polygon(w);
  if (kind_ == Kind::flat) return {dot(faces_[0].normal, w - faces_[0].from), faces_[0].normal};
  if (kind_ == Kind::disk) {
    const Vec2 d = w - centre_;
    const double l = length(d);
    if (!(l > 0))
      throw std::runtime_error(
          "outline contact: a point is in the centre of a disk, so has no direction; use a stiffer "
          "contact");
    return {l - radius_, (1 / l) * d};
  }
  const Curve::Nearest c = curve_->nearest(w - centre_);
  return free_left_ ? Near{c.distance, c.normal} : Near{-c.distance, -1.0 * c.normal};
}

Outline::OfPolygon Outline::nearest_of_polygon(Vec2 w) const {
  double least = std::numeric_limits<double>::infinity();
  OfPolygon nearest{0, false, 0};
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const Face& f = faces_[i];
    const Vec2 d = w - f.from;
    const double s = dot(f.along, d);
    if (s > f.length) continue;  // then the corner is that of the next side
    const double square = s < 0 ? dot(d, d) : dot(f.normal, d) * dot(f.normal, d);
    if (square < least) least = square, nearest = {i, s < 0, 0};
  }
  nearest.away = nearest.at_corner ? std::sqrt(least) : 0;
  return nearest;
}

Outline::Near Outline::near_polygon(Vec2 w) const {
  const OfPolygon nearest = nearest_of_polygon(w);
  const Face& f = faces_[nearest.side];
  const Vec2 d = w - f.from;
  if (!(nearest.away > 0)) return {dot(f.normal, d) - radius_, f.normal};
  // Nearest to a convex corner it is outside, to a concave one inside.
  const double sign = convex_[nearest.side] ? 1 : -1;
  return {sign * nearest.away - radius_, (sign / nearest.away) * d};
}

namespace {

/// Into its place by distance; the farthest falls out.
void put(Outline::Nears& out, Outline::Near near) {
  for (Outline::Near& place : out)
    if (near.distance < place.distance) std::swap(near, place);
}

}  // namespace

void Outline::all_near(Vec2 w, Nears& out) const {
  out.fill({nowhere, {}});
  if (!re_entrant_) {
    out[0] = near(w);
    return;
  }
  const OfPolygon nearest = nearest_of_polygon(w);
  const Face& f = faces_[nearest.side];
  const bool inside = nearest.away > 0 ? !convex_[nearest.side] : dot(f.normal, w - f.from) < 0;
  inside ? all_inside(w, nearest, out) : all_outside(w, out);
  if (out[0].distance >= nowhere) out[0] = near(w);  // far away
}

// Whether w lies beside the side, or beyond an end of it that is re-entrant.
bool Outline::faces_along(std::size_t side, Vec2 w) const {
  const double s = dot(faces_[side].along, w - faces_[side].from);
  return (s >= 0 || !convex_[side]) && (s <= faces_[side].length || !convex_[after(side)]);
}

void Outline::all_outside(Vec2 w, Nears& out) const {
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const Face& f = faces_[i];
    const Vec2 d = w - f.from;
    const double s = dot(f.along, d), height = dot(f.normal, d);
    const auto beside =
        [&](std::size_t side) {  // beyond a re-entrant end of f, on the free side of what joins it there
          return dot(faces_[side].normal, w - faces_[side].from) >= 0 && faces_along(side, w);
        };
    if (convex_[i] && s < 0 && dot(faces_[before(i)].along, d) >= 0) {
      const double away = length(d);
      if (away > 0) put(out, {away - radius_, (1 / away) * d});
    }
    if (height < 0 || !faces_along(i, w)) continue;
    if ((s < 0 && !beside(before(i))) || (s > f.length && !beside(after(i)))) continue;
    put(out, {height - radius_, f.normal});
  }
}

// The sides that join at re-entrant corners on either hand of the nearest.
void Outline::all_inside(Vec2 w, const OfPolygon& nearest, Nears& out) const {
  const auto take = [&](std::size_t i) {
    const double height = dot(faces_[i].normal, w - faces_[i].from);
    if (faces_along(i, w)) put(out, {height - radius_, faces_[i].normal});
  };
  const std::size_t n = faces_.size();
  take(nearest.side);
  std::size_t i = nearest.side, seen = 1;
  for (; !convex_[i] && seen < n; ++seen) take(i = before(i));
  for (i = after(nearest.side); !convex_[i] && seen < n; ++seen, i = after(i)) take(i);
}

double Outline::reach() const {
  double most = 0;
  if (kind_ == Kind::flat || (kind_ == Kind::curve && !closed_)) most = std::numeric_limits<double>::infinity();
  if (kind_ == Kind::curve && closed_) most = length(centre_) + curve_->reach();
  for (const Corner& c : corners_) most = std::max(most, length(c.centre) + c.radius);
  return most;
}

Vec2 Outline::farthest(Vec2 m) const { return centre_ + curve_->support(std::atan2(m.y, m.x)).point; }

double Outline::narrowest_hollow() const {
  if (kind_ != Kind::curve) return std::numeric_limits<double>::infinity();
  const Curve::Curvatures k = curve_->curvatures();
  const double bend = free_left_ ? k.largest : -k.least;
  return bend > 0 ? 1 / bend : std::numeric_limits<double>::infinity();
}

}  // namespace subsoil::mbd
