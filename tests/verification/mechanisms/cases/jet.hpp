#pragma once

// Numbers that carry their first and second derivative along one parameter, and plane points made of them: positions of
// a mechanism written once in closed form give velocities and accelerations without a second formula to get wrong.

#include <array>
#include <cmath>

namespace subsoil::test {

/// Value, first and second derivative.
struct Jet {
  double v = 0, d = 0, dd = 0;
  Jet() = default;
  Jet(double value) : v(value) {}
  Jet(double value, double first, double second) : v(value), d(first), dd(second) {}
};

/// f(x) by the chain rule from f, f', f'' at x.v.
inline Jet chain(const Jet& x, double f, double f1, double f2) { return {f, f1 * x.d, f2 * x.d * x.d + f1 * x.dd}; }

inline Jet operator+(const Jet& a, const Jet& b) { return {a.v + b.v, a.d + b.d, a.dd + b.dd}; }
inline Jet operator-(const Jet& a, const Jet& b) { return {a.v - b.v, a.d - b.d, a.dd - b.dd}; }
inline Jet operator-(const Jet& a) { return {-a.v, -a.d, -a.dd}; }
inline Jet operator*(const Jet& a, const Jet& b) {
  return {a.v * b.v, a.d * b.v + a.v * b.d, a.dd * b.v + 2 * a.d * b.d + a.v * b.dd};
}
inline Jet operator/(const Jet& a, const Jet& b) {
  return a * chain(b, 1 / b.v, -1 / (b.v * b.v), 2 / (b.v * b.v * b.v));
}
inline Jet sin(const Jet& x) { return chain(x, std::sin(x.v), std::cos(x.v), -std::sin(x.v)); }
inline Jet cos(const Jet& x) { return chain(x, std::cos(x.v), -std::sin(x.v), -std::cos(x.v)); }
inline Jet sqrt(const Jet& x) {
  const double root = std::sqrt(x.v);
  return chain(x, root, 0.5 / root, -0.25 / (root * x.v));
}
/// Angle of the vector (x, y); its derivatives do not know in which turn it is.
inline Jet atan2(const Jet& y, const Jet& x) {
  const double r2 = x.v * x.v + y.v * y.v, turn = x.v * y.d - y.v * x.d, grow = x.v * x.d + y.v * y.d;
  return {std::atan2(y.v, x.v), turn / r2, (x.v * y.dd - y.v * x.dd) / r2 - 2 * grow * turn / (r2 * r2)};
}

struct Point {
  Jet x, y;
};
inline Point operator+(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y}; }
inline Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y}; }
inline Point operator*(const Jet& k, const Point& a) { return {k * a.x, k * a.y}; }
inline Point polar(const Jet& radius, const Jet& angle) { return {radius * cos(angle), radius * sin(angle)}; }
inline Jet direction(const Point& from, const Point& to) { return atan2(to.y - from.y, to.x - from.x); }

/// The point at distance r_a from a and r_b from b, on the left (side 1) or right (side -1) of the way from a to b: how
/// two links close a loop.
inline Point meet(const Point& a, double r_a, const Point& b, double r_b, int side) {
  const Point way = b - a;
  const Jet d2 = way.x * way.x + way.y * way.y;
  const Jet along = (d2 + r_a * r_a - r_b * r_b) / (2 * d2);
  const Jet aside = side * sqrt(r_a * r_a / d2 - along * along);
  return a + along * way + aside * Point{-way.y, way.x};
}

/// Centre of gravity and angle of a body.
using Pose = std::array<Jet, 3>;

/// A bar between two points, its centre of gravity in the middle.
inline Pose bar(const Point& from, const Point& to) {
  const Point middle = 0.5 * (from + to);
  return {middle.x, middle.y, direction(from, to)};
}
/// A body with the given point of it at `at` and the centre of gravity at (x, y) from there in axes turned by `angle`.
inline Pose body_at(const Point& at, const Jet& angle, double x = 0, double y = 0) {
  return {at.x + x * cos(angle) - y * sin(angle), at.y + x * sin(angle) + y * cos(angle), angle};
}

}  // namespace subsoil::test
