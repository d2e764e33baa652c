#include "libmbd/base/curve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace subsoil::mbd {

namespace {
constexpr double full_turn = 2 * std::numbers::pi;
constexpr int samples_per_interval = 8;
// Of the curve: Newton steps that short are rounding, up to some 1e7 lengths of the curve from the origin.
constexpr double of_rounding = 1e-8;
}  // namespace

Curve Curve::polar(const std::vector<double>& angles, const std::vector<double>& radii, bool closed) {
  std::vector<double> u = angles, rho = radii;
  for (const double r : rho)
    if (!(r > 0))
      throw std::invalid_argument("the profile's radii must be above 0 m; take a centre inside the profile");
  if (u.size() < 3) throw std::invalid_argument("a profile needs at least three points");
  const double turn = u.back() - u.front();
  if (turn > full_turn * (1 + 1e-9))
    throw std::invalid_argument("the profile's angles span " + std::to_string(turn) +
                                " rad; one turn (360 deg) is the most that a radius over the angle can say");
  if (closed && turn < full_turn * (1 - 1e-9)) u.push_back(u.front() + full_turn), rho.push_back(rho.front());
  const auto ends = closed ? PiecewiseCubic::Ends::periodic : PiecewiseCubic::Ends::natural;
  if (closed) u.back() = u.front() + full_turn;
  return {PiecewiseCubic(std::move(u), std::move(rho), ends, "angles"), {}, true, closed};
}

Curve Curve::through(const std::vector<std::array<double, 2>>& points, bool closed) {
  if (points.size() < 3) throw std::invalid_argument("a path needs at least three points");
  std::vector<double> u{0}, x{points[0][0]}, y{points[0][1]};
  const auto add = [&](const std::array<double, 2>& p) {
    const double chord = std::hypot(p[0] - x.back(), p[1] - y.back());
    if (chord == 0)
      throw std::invalid_argument("point " + std::to_string(u.size() + 1) +
                                  " of the path lies on the one before; leave it out");
    u.push_back(u.back() + chord), x.push_back(p[0]), y.push_back(p[1]);
  };
  for (std::size_t i = 1; i < points.size(); ++i) add(points[i]);
  if (closed && points.back() != points.front()) add(points.front());
  const auto ends = closed ? PiecewiseCubic::Ends::periodic : PiecewiseCubic::Ends::natural;
  return {PiecewiseCubic(u, std::move(x), ends), PiecewiseCubic(u, std::move(y), ends), false, closed};
}

Curve::Curve(PiecewiseCubic first, PiecewiseCubic second, bool polar, bool closed)
    : x_(std::move(first)), y_(std::move(second)), polar_(polar), closed_(closed) {
  const auto& u = x_.knots();
  for (std::size_t i = 0; i + 1 < u.size(); ++i)
    for (int k = 0; k < samples_per_interval; ++k) {
      const double share = k / static_cast<double>(samples_per_interval);
      const double place = u[i] + share * (u[i + 1] - u[i]);
      samples_.push_back({place, at(place).point});
    }
  if (!closed_) samples_.push_back({u.back(), at(u.back()).point});
}

Curve::At Curve::at(double u) const {
  const PiecewiseCubic::Value x = x_.at(u);
  if (!polar_) {
    const PiecewiseCubic::Value y = y_.at(u);
    return {{x.value, y.value}, {x.first, y.first}, {x.second, y.second}};
  }
  const Vec2 e{std::cos(u), std::sin(u)}, k = turned(e);
  return {x.value * e, x.first * e + x.value * k, (x.second - x.value) * e + 2 * x.first * k};
}

double Curve::curvature(const At& c) const {
  const double speed = length(c.first);
  return cross(c.first, c.second) / (speed * speed * speed);
}

/// The root of an increasing function between the neighbours of a sample by Newton's method, halving where a step
/// leaves them. slope(u) gives {value, derivative}. An open curve has no neighbour beyond its end: straight on the root
/// may be anywhere, with a radius linear in the angle it is sought as far again as the profile goes.
template <class Slope>
double Curve::root_near(std::size_t sample, Slope slope) const {
  const std::size_t last = samples_.size() - 1;
  const double span = x_.back() - x_.front(), beyond = polar_ ? span : 1e9 * span;
  double low = sample > 0 ? samples_[sample - 1].u : closed_ ? samples_[last].u - span : x_.front() - beyond;
  double high = sample < last ? samples_[sample + 1].u : closed_ ? samples_[0].u + span : x_.back() + beyond;
  double u = samples_[sample].u, step_before = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 150; ++iteration) {
    const auto [value, rate] = slope(u);
    (value > 0 ? high : low) = u;
    double next = u - value / rate;
    const bool newton = rate > 0 && next >= low && next <= high;
    if (!newton) next = 0.5 * (low + high);
    const double step = std::abs(next - u), size = std::max(span, std::abs(u));
    u = next;
    // What is left after a Newton step is its square; a bisection step ends at rounding. Far from the origin rounding
    // of the points is above that: there Newton steps, each the square of the one before, no longer become shorter.
    const bool at_rounding = newton && step <= of_rounding * size && step > 0.5 * step_before;
    step_before = newton ? step : std::numeric_limits<double>::infinity();
    if (step <= 1e-13 * size || at_rounding) {
      if (!closed_ && (u <= x_.front() - 0.999 * beyond || u >= x_.back() + 0.999 * beyond)) break;
      return u;
    }
  }
  throw std::runtime_error("a cam or path joint has lost its curve: its point is far beyond the curve's end");
}

Curve::Nearest Curve::nearest(Vec2 w) const {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const Vec2 d = samples_[i].point - w;
    const double now = dot(d, d);
    if (now < least) least = now, best = i;
  }
  const double u = root_near(best, [&](double at_u) {
    const At c = at(at_u);
    const Vec2 d = c.point - w;
    return std::pair(dot(d, c.first), dot(c.first, c.first) + dot(d, c.second));
  });
  const At c = at(u);
  Nearest found;
  found.point = c.point;
  found.tangent = (1 / length(c.first)) * c.first;
  found.normal = turned(found.tangent);
  found.distance = dot(found.normal, w - c.point);
  found.curvature = curvature(c);
  return found;
}

Curve::Support Curve::support(double beta) const {
  const Vec2 m{std::cos(beta), std::sin(beta)};
  std::size_t best = 0;
  for (std::size_t i = 1; i < samples_.size(); ++i)
    if (dot(samples_[i].point, m) > dot(samples_[best].point, m)) best = i;
  const double u = root_near(best, [&](double at_u) {
    const At c = at(at_u);
    return std::pair(-dot(c.first, m), -dot(c.second, m));
  });
  const At c = at(u);
  const double across = dot(c.first, turned(m));
  return {dot(c.point, m), dot(c.point, turned(m)), -across * across / dot(c.second, m) - dot(c.point, m), c.point};
}

double Curve::reach() const {
  double most = 0;
  for (const Sample& s : samples_) most = std::max(most, length(s.point));
  return most;
}

Curve::Curvatures Curve::curvatures() const {
  Curvatures found{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(), 0, 0};
  for (const Sample& s : samples_) {
    const double now = curvature(at(s.u));
    if (now < found.least) found.least = now, found.least_at = s.u;
    if (now > found.largest) found.largest = now, found.largest_at = s.u;
  }
  return found;
}

bool Curve::crosses_itself(Vec2& where) const {
  const std::size_t n = samples_.size(), stretches = closed_ ? n : n - 1;
  const auto begin = [&](std::size_t i) { return samples_[i].point; };
  const auto end = [&](std::size_t i) { return samples_[(i + 1) % n].point; };
  for (std::size_t i = 0; i < stretches; ++i)
    for (std::size_t j = i + 2; j < stretches; ++j) {
      if (closed_ && i == 0 && j == stretches - 1) continue;  // neighbours across the end point
      const Vec2 p = begin(i), r = end(i) - p, q = begin(j), s = end(j) - q;
      const double parallel = cross(r, s);
      if (parallel == 0) continue;
      const double along_r = cross(q - p, s) / parallel, along_s = cross(q - p, r) / parallel;
      if (along_r < 0 || along_r > 1 || along_s < 0 || along_s > 1) continue;
      where = p + along_r * r;
      return true;
    }
  return false;
}

}  // namespace subsoil::mbd
