#include "libdem/geometry/sphere_union.hpp"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

namespace subsoil::dem {
namespace {

constexpr double pi = std::numbers::pi;

/// 1, x, y, z, xx, yy, zz, xy, yz, zx, integrated.
using Moments = std::array<double, 10>;

void add_scaled(Moments& to, const Moments& m, double by) {
  for (std::size_t k = 0; k < m.size(); ++k) to[k] += by * m[k];
}

/// use(abscissa in [-1, 1], weight) for each point of Gauss's rule.
template <unsigned Points, class Use>
void each_gauss_point(const Use& use) {
  using Rule = boost::math::quadrature::gauss<double, Points>;
  const auto& x = Rule::abscissa();
  const auto& w = Rule::weights();
  for (std::size_t k = 0; k < x.size(); ++k) {
    use(x[k], w[k]);
    if (x[k] != 0) use(-x[k], w[k]);
  }
}

struct Disc {
  double x, y, r;
};

/// Moments of a slice: x and y alone.
struct SliceMoments {
  double area = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
};

/// Adds what the arc from `from` to `to`, rad, counterclockwise, gives by Green's theorem: the area is half the
/// integral of x dy - y dx, and likewise.
void add_arc(const Disc& d, double from, double to, SliceMoments& out) {
  const int parts = std::max(1, static_cast<int>(std::ceil((to - from) / (0.5 * pi))));
  const double half = 0.5 * (to - from) / parts;
  for (int p = 0; p < parts; ++p)
    each_gauss_point<12>([&](double at, double weight) {
      const double angle = from + half * (2 * p + 1 + at), c = std::cos(angle), s = std::sin(angle);
      const double x = d.x + d.r * c, y = d.y + d.r * s, dy = half * weight * d.r * c, dx = -half * weight * d.r * s;
      out.area += 0.5 * (x * dy - y * dx);
      out.x += 0.5 * x * x * dy, out.y -= 0.5 * y * y * dx;
      out.xx += x * x * x * dy / 3, out.yy -= y * y * y * dx / 3;
      out.xy += 0.5 * x * x * y * dy;
    });
}

/// Arcs of disc `own` that no other disc covers.
void add_free_arcs(const std::vector<Disc>& discs, std::size_t own, SliceMoments& out) {
  const Disc& d = discs[own];
  std::vector<std::pair<double, double>> covered;
  for (std::size_t k = 0; k < discs.size(); ++k) {
    if (k == own) continue;
    const Disc& o = discs[k];
    const double dx = o.x - d.x, dy = o.y - d.y, apart = std::hypot(dx, dy);
    if (apart >= d.r + o.r) continue;
    if (apart <= o.r - d.r && (apart > 0 || o.r > d.r || k < own)) return;  // of two equal ones the first stays
    if (apart <= d.r - o.r) continue;
    const double cosine = (apart * apart + d.r * d.r - o.r * o.r) / (2 * apart * d.r);
    const double half = std::acos(std::clamp(cosine, -1.0, 1.0));
    double from = std::atan2(dy, dx) - half;
    if (from < 0) from += 2 * pi;
    const double to = from + 2 * half;
    covered.emplace_back(from, std::min(to, 2 * pi));
    if (to > 2 * pi) covered.emplace_back(0, to - 2 * pi);
  }
  std::sort(covered.begin(), covered.end());
  double at = 0;
  for (const auto& [from, to] : covered) {
    if (from > at) add_arc(d, at, from, out);
    at = std::max(at, to);
  }
  if (at < 2 * pi) add_arc(d, at, 2 * pi, out);
}

Moments slice(std::span<const Ball> balls, double z) {
  std::vector<Disc> discs;
  for (const Ball& b : balls) {
    const double away = z - b.centre.z, square = b.radius * b.radius - away * away;
    if (square > 0) discs.push_back({b.centre.x, b.centre.y, std::sqrt(square)});
  }
  SliceMoments m;
  for (std::size_t k = 0; k < discs.size(); ++k) add_free_arcs(discs, k, m);
  return {m.area, m.x, m.y, z * m.area, m.xx, m.yy, z * z * m.area, m.xy, z * m.y, z * m.x};
}

template <unsigned Points>
Moments over_piece(std::span<const Ball> balls, double from, double to) {
  Moments out{};
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  each_gauss_point<Points>([&](double at, double weight) {
    const double angle = 0.5 * pi * at;
    add_scaled(out, slice(balls, middle + half * std::sin(angle)), 0.5 * pi * weight * half * std::cos(angle));
  });
  return out;
}

/// Circle in which the surfaces of two balls meet.
struct Circle {
  Vec3 centre, normal;
  double radius;  ///< negative where they do not
};
Circle meeting(const Ball& a, const Ball& b) {
  const Vec3 apart = b.centre - a.centre;
  const double d = norm(apart);
  if (d == 0) return {a.centre, {}, -1};
  const double along = (d * d + a.radius * a.radius - b.radius * b.radius) / (2 * d);
  const double square = a.radius * a.radius - along * along;
  return {a.centre + (along / d) * apart, (1 / d) * apart, square > 0 ? std::sqrt(square) : -1};
}

/// Places where the integral over z may be broken.
class BreakHeights {
 public:
  /// @param length of the union, m
  BreakHeights(std::span<const Ball> balls, double length) : balls_(balls), close_(1e-12 * length) {}

  /// A point within a ball is no point of the union's surface, and its height breaks nothing. Within `close_` of the
  /// surface it may be one: a break that is missing or off by so much costs close_^(3/2), the kinks being that smooth.
  void add(const Vec3& x) {
    for (const Ball& b : balls_)
      if (norm(x - b.centre) < b.radius - close_) return;
    heights_.push_back(x.z);
  }

  /// Of a circle that is level.
  void add_level(double z) { heights_.push_back(z); }

  /// Ascending. Of those that differ by rounding one is left: symmetric unions have hundreds of them.
  std::vector<double> take() {
    std::sort(heights_.begin(), heights_.end());
    std::vector<double> out;
    for (const double z : heights_)
      if (out.empty() || z > out.back() + close_) out.push_back(z);
    return out;
  }

 private:
  std::span<const Ball> balls_;
  double close_;
  std::vector<double> heights_;
};

/// The two points at which the circle meets a third ball's surface.
void add_triple_points(const Circle& c, const Ball& b, BreakHeights& heights) {
  Vec3 u = cross(c.normal, std::abs(c.normal.x) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0});
  u = normalized(u);
  const Vec3 v = cross(c.normal, u), to = b.centre - c.centre;
  // |to - rho (u cos a + v sin a)|^2 = R^2
  const double p = dot(to, u), q = dot(to, v), reach = std::hypot(p, q);
  const double needed = (dot(to, to) + c.radius * c.radius - b.radius * b.radius) / (2 * c.radius);
  if (!(reach > std::abs(needed))) return;
  const double middle = std::atan2(q, p), half = std::acos(needed / reach);
  for (const double angle : {middle - half, middle + half})
    heights.add(c.centre + c.radius * (std::cos(angle) * u + std::sin(angle) * v));
}

/// Where the integral over z is broken, ascending.
std::vector<double> break_heights(std::span<const Ball> balls, double length) {
  BreakHeights z(balls, length);
  for (const Ball& b : balls)
    for (const double sign : {-1.0, 1.0}) z.add(b.centre + Vec3{0, 0, sign * b.radius});
  for (std::size_t i = 0; i < balls.size(); ++i)
    for (std::size_t j = i + 1; j < balls.size(); ++j) {
      const Circle c = meeting(balls[i], balls[j]);
      if (c.radius < 0) continue;
      const Vec3 up = Vec3{0, 0, 1} - c.normal.z * c.normal;  // in the plane of the circle
      const double slope = norm(up);
      if (slope < 1e-12) {
        z.add_level(c.centre.z);
      } else {
        z.add(c.centre - (c.radius / slope) * up), z.add(c.centre + (c.radius / slope) * up);
      }
      for (std::size_t k = j + 1; k < balls.size(); ++k) add_triple_points(c, balls[k], z);
    }
  return z.take();
}

/// Adaptive integral over the slices.
class SliceIntegral {
 public:
  SliceIntegral(std::span<const Ball> balls, double length) : balls_(balls) {
    const double area = length * length, volume = area * length;
    for (std::size_t k = 0; k < scale_.size(); ++k) scale_[k] = volume * (k == 0 ? 1 : k < 4 ? length : area);
  }
  void add(double from, double to, int depth) {
    const Moments rough = over_piece<20>(balls_, from, to), fine = over_piece<40>(balls_, from, to);
    double off = 0;
    for (std::size_t k = 0; k < fine.size(); ++k) off = std::max(off, std::abs(fine[k] - rough[k]) / scale_[k]);
    constexpr double enough = 1e-13;
    constexpr int deepest = 12;
    if (off > enough && depth < deepest) {
      const double middle = 0.5 * (from + to);
      add(from, middle, depth + 1), add(middle, to, depth + 1);
      return;
    }
    add_scaled(sum, fine, 1);
    error += off;
  }
  Moments sum{};
  double error = 0;

 private:
  std::span<const Ball> balls_;
  Moments scale_{};
};

SquareMatrix<3> second_to_inertia(double xx, double yy, double zz, double xy, double yz, double zx) {
  return {{{yy + zz, -xy, -zx}, {-xy, xx + zz, -yz}, {-zx, -yz, xx + yy}}};
}

/// Of balls that share nothing.
SolidMoments sum_of_balls(std::span<const Ball> balls) {
  SolidMoments out;
  const auto volume = [](const Ball& b) { return 4.0 / 3.0 * pi * b.radius * b.radius * b.radius; };
  for (const Ball& b : balls) out.volume += volume(b), out.centre += volume(b) * b.centre;
  out.centre *= 1 / out.volume;
  if (balls.size() == 1) out.centre = balls[0].centre;
  for (const Ball& b : balls) {
    const Vec3 d = b.centre - out.centre;
    const double v = volume(b);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        out.inertia[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] +=
            (i == j ? 0.4 * v * b.radius * b.radius + v * dot(d, d) : 0) - v * d[i] * d[j];
  }
  return out;
}

}  // namespace

bool is_exposed(std::span<const Ball> balls, const Vec3& x, std::size_t except) {
  for (std::size_t k = 0; k < balls.size(); ++k)
    if (k != except && norm(x - balls[k].centre) < balls[k].radius) return false;
  return true;
}

SolidMoments moments_of_union(std::span<const Ball> balls) {
  if (balls.empty()) throw std::invalid_argument("a union of spheres needs one");
  bool overlap = false;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    if (!(balls[i].radius > 0)) throw std::invalid_argument("radii of spheres must be positive");
    for (std::size_t j = 0; j < i; ++j)
      overlap = overlap || norm(balls[i].centre - balls[j].centre) < balls[i].radius + balls[j].radius;
  }
  const SolidMoments apart = sum_of_balls(balls);
  if (!overlap) return apart;
  // About a point within, so that no two large numbers are subtracted.
  std::vector<Ball> near(balls.begin(), balls.end());
  double length = 0;
  for (Ball& b : near) b.centre -= apart.centre, length = std::max(length, norm(b.centre) + b.radius);
  SliceIntegral integral(near, length);
  const std::vector<double> z = break_heights(near, length);
  for (std::size_t k = 0; k + 1 < z.size(); ++k) integral.add(z[k], z[k + 1], 0);
  const Moments& m = integral.sum;
  SolidMoments out;
  out.volume = m[0];
  const Vec3 c = (1 / m[0]) * Vec3{m[1], m[2], m[3]};
  out.centre = apart.centre + c;
  const double v = m[0];
  out.inertia = second_to_inertia(m[4] - v * c.x * c.x, m[5] - v * c.y * c.y, m[6] - v * c.z * c.z,
                                  m[7] - v * c.x * c.y, m[8] - v * c.y * c.z, m[9] - v * c.z * c.x);
  double least = out.inertia[0][0];
  for (std::size_t k = 1; k < 3; ++k) least = std::min(least, out.inertia[k][k]);
  // Errors are relative to the box; what they are of the solid itself is no more than this.
  const double of_volume = length * length * length / v, of_inertia = of_volume * v * length * length / least;
  out.error = integral.error * std::max(of_volume, 4 * of_inertia) + 1e-14;
  return out;
}

}  // namespace subsoil::dem
