#pragma once
#include <cmath>

#include "libsim/document/grammar.hpp"

/// Numbers with exact derivatives with respect to one variable (dual numbers, forward mode).
///
///   c[0] = f, c[1] = f', c[2] = f'' (order 2)
///   f(x):  f' = f_x x',  f'' = f_xx x'^2 + f_x x''
///
/// Of min and max the derivatives are those of the argument that counts, half of each where both are equal. abs has the
/// slope sign(x); sign is a constant. A value that no variable moves (`moves` is false) has derivatives 0 whatever
/// function is taken of it: sqrt(max(0, t)) is at rest before t = 0, where the slope of the root is infinite.
/// The same operations on doubles make one evaluator serve both.
namespace subsoil::sim {

template <int order>
struct Jet {
  static_assert(order == 1 || order == 2);
  double c[order + 1];
  bool moves;  ///< whether a variable has an effect on it here
};

namespace jets {

inline double value(double x) { return x; }
template <int n>
inline double value(const Jet<n>& x) {
  return x.c[0];
}

inline void set(double& x, double value) { x = value; }
template <int n>
inline void set(Jet<n>& x, double value) {
  x = {};
  x.c[0] = value;
}

// ---- chain rule ----

/// Of a function with value f and slope f1 at x; f2() gives its second derivative.
template <int n, class Second>
inline Jet<n> chain(const Jet<n>& x, double f, double f1, Second f2) {
  Jet<n> r;
  r.c[0] = f, r.moves = x.moves;
  r.c[1] = x.moves ? f1 * x.c[1] : 0;
  if constexpr (n == 2) r.c[2] = x.moves ? f2() * x.c[1] * x.c[1] + f1 * x.c[2] : 0;
  return r;
}

// ---- operators ----

inline double negated(double x) { return -x; }
template <int n>
inline Jet<n> negated(const Jet<n>& x) {
  Jet<n> r;
  for (int k = 0; k <= n; ++k) r.c[k] = -x.c[k];
  r.moves = x.moves;
  return r;
}

inline double sum(double a, double b) { return a + b; }
template <int n>
inline Jet<n> sum(const Jet<n>& a, const Jet<n>& b) {
  Jet<n> r;
  for (int k = 0; k <= n; ++k) r.c[k] = a.c[k] + b.c[k];
  r.moves = a.moves || b.moves;
  return r;
}
template <int n>
inline Jet<n> sum(const Jet<n>& a, double b) {
  Jet<n> r = a;
  r.c[0] += b;
  return r;
}

inline double difference(double a, double b) { return a - b; }
template <int n>
inline Jet<n> difference(const Jet<n>& a, const Jet<n>& b) {
  Jet<n> r;
  for (int k = 0; k <= n; ++k) r.c[k] = a.c[k] - b.c[k];
  r.moves = a.moves || b.moves;
  return r;
}
template <int n>
inline Jet<n> difference(double a, const Jet<n>& b) {
  Jet<n> r = negated(b);
  r.c[0] = a - b.c[0];
  return r;
}

inline double product(double a, double b) { return a * b; }
template <int n>
inline Jet<n> product(const Jet<n>& a, const Jet<n>& b) {
  Jet<n> r;
  r.c[0] = a.c[0] * b.c[0];
  r.c[1] = a.c[1] * b.c[0] + a.c[0] * b.c[1];
  if constexpr (n == 2) r.c[2] = a.c[2] * b.c[0] + 2 * a.c[1] * b.c[1] + a.c[0] * b.c[2];
  r.moves = a.moves || b.moves;
  return r;
}
template <int n>
inline Jet<n> product(const Jet<n>& a, double b) {
  Jet<n> r;
  for (int k = 0; k <= n; ++k) r.c[k] = a.c[k] * b;
  r.moves = a.moves;
  return r;
}

inline double quotient(double a, double b) { return a / b; }
/// q b = a, differentiated.
template <int n>
inline Jet<n> quotient(const Jet<n>& a, const Jet<n>& b) {
  Jet<n> r;
  r.c[0] = a.c[0] / b.c[0];
  r.c[1] = (a.c[1] - r.c[0] * b.c[1]) / b.c[0];
  if constexpr (n == 2) r.c[2] = (a.c[2] - 2 * r.c[1] * b.c[1] - r.c[0] * b.c[2]) / b.c[0];
  r.moves = a.moves || b.moves;
  return r;
}
template <int n>
inline Jet<n> quotient(const Jet<n>& a, double b) {
  Jet<n> r;
  for (int k = 0; k <= n; ++k) r.c[k] = a.c[k] / b;
  r.moves = a.moves;
  return r;
}
template <int n>
inline Jet<n> quotient(double a, const Jet<n>& b) {
  const double q = a / b.c[0], slope = -q / b.c[0];
  return chain(b, q, slope, [&] { return -2 * slope / b.c[0]; });
}

inline double power(double x, double p) { return std::pow(x, p); }
template <int n>
inline Jet<n> power(const Jet<n>& x, double p) {
  const double v = x.c[0];
  if (p == 0) {  // 1 for every x
    Jet<n> r;
    set(r, std::pow(v, p));
    return r;
  }
  // A factor that is 0 stays 0 where its power of x is infinite: x^1 at x = 0.
  const auto times = [v](double factor, double exponent) { return factor == 0 ? 0 : factor * std::pow(v, exponent); };
  return chain(x, std::pow(v, p), times(p, p - 1), [&] { return times(p * (p - 1), p - 2); });
}
/// x^y = exp(y log x); an exponent that nothing moves makes it a power of x.
template <int n>
inline Jet<n> power(const Jet<n>& x, const Jet<n>& y) {
  if (!y.moves) return power(x, y.c[0]);
  Jet<n> r;
  set(r, std::pow(x.c[0], y.c[0]));
  if (!x.moves && x.c[0] == 0 && y.c[0] > 0) return r;  // 0^y is 0 for every y > 0
  const double v = x.c[0];
  const Jet<n> w = product(y, chain(x, std::log(v), 1 / v, [&] { return -1 / (v * v); }));
  r.c[1] = r.c[0] * w.c[1];
  if constexpr (n == 2) r.c[2] = r.c[0] * (w.c[2] + w.c[1] * w.c[1]);
  r.moves = true;
  return r;
}

// ---- functions ----

inline double call(Call f, double x) { return value_of(f, x); }
template <int n>
inline Jet<n> call(Call f, const Jet<n>& x) {
  const double v = x.c[0];
  switch (f) {
    case Call::sin: {
      const double s = std::sin(v);
      return chain(x, s, std::cos(v), [&] { return -s; });
    }
    case Call::cos: {
      const double c = std::cos(v);
      return chain(x, c, -std::sin(v), [&] { return -c; });
    }
    case Call::tan: {
      const double t = std::tan(v), slope = 1 + t * t;
      return chain(x, t, slope, [&] { return 2 * t * slope; });
    }
    case Call::asin: {
      const double square = (1 - v) * (1 + v), slope = 1 / std::sqrt(square);
      return chain(x, std::asin(v), slope, [&] { return v * slope / square; });
    }
    case Call::acos: {
      const double square = (1 - v) * (1 + v), slope = -1 / std::sqrt(square);
      return chain(x, std::acos(v), slope, [&] { return v * slope / square; });
    }
    case Call::atan: {
      const double slope = 1 / (1 + v * v);
      return chain(x, std::atan(v), slope, [&] { return -2 * v * slope * slope; });
    }
    case Call::sinh: {
      const double s = std::sinh(v);
      return chain(x, s, std::cosh(v), [&] { return s; });
    }
    case Call::cosh: {
      const double c = std::cosh(v);
      return chain(x, c, std::sinh(v), [&] { return c; });
    }
    case Call::tanh: {
      // 1/cosh^2 keeps its digits where 1 - tanh^2 loses them.
      const double t = std::tanh(v), c = std::cosh(v), slope = 1 / (c * c);
      return chain(x, t, slope, [&] { return -2 * t * slope; });
    }
    case Call::exp: {
      const double e = std::exp(v);
      return chain(x, e, e, [&] { return e; });
    }
    case Call::log:
      return chain(x, std::log(v), 1 / v, [&] { return -1 / (v * v); });
    case Call::sqrt: {
      const double root = std::sqrt(v), slope = 0.5 / root;
      return chain(x, root, slope, [&] { return -0.5 * slope / v; });
    }
    case Call::abs:
      return chain(x, std::abs(v), value_of(Call::sign, v), [] { return 0.0; });
    default: {  // sign
      Jet<n> r;
      set(r, value_of(f, v));
      return r;
    }
  }
}

inline double call(Call f, double x, double y) { return value_of(f, x, y); }
template <int n>
inline Jet<n> call(Call f, const Jet<n>& x, const Jet<n>& y) {
  if (f == Call::pow) return power(x, y);
  Jet<n> r;
  r.c[0] = value_of(f, x.c[0], y.c[0]);
  r.moves = x.moves || y.moves;
  if (f == Call::min || f == Call::max) {
    const bool of_x = (f == Call::min) == (x.c[0] < y.c[0]);
    if (x.c[0] != y.c[0] && !std::isnan(r.c[0])) return of_x ? x : y;
    for (int k = 1; k <= n; ++k) r.c[k] = r.c[0] == r.c[0] ? 0.5 * (x.c[k] + y.c[k]) : r.c[0];
    return r;
  }
  if (!r.moves) {
    set(r, r.c[0]);
    return r;
  }
  const double a = x.c[0], b = y.c[0], a1 = x.c[1], b1 = y.c[1];
  if (f == Call::atan2) {
    const double square = a * a + b * b;
    r.c[1] = (b * a1 - a * b1) / square;
    if constexpr (n == 2) r.c[2] = (b * x.c[2] - a * y.c[2] - 2 * r.c[1] * (a * a1 + b * b1)) / square;
    return r;
  }
  const double h = r.c[0];  // hypot
  r.c[1] = (a * a1 + b * b1) / h;
  if constexpr (n == 2) r.c[2] = (a1 * a1 + b1 * b1 + a * x.c[2] + b * y.c[2] - r.c[1] * r.c[1]) / h;
  return r;
}

}  // namespace jets
}  // namespace subsoil::sim
