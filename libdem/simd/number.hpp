#pragma once
#include <cmath>

/// The number type of a contact law.
///
/// A law is a plain function over a number type T. T is `double` in tests and in the scalar path and a SIMD vector of
/// 2, 4 or 8 doubles in the sweep (simd/vec_d.hpp, in mixed precision floats: vec_f.hpp). A law therefore branches with
/// `select(condition, a, b)`, never with `if`, and takes sqrt, rsqrt, min and max unqualified so that the overload of
/// its number type is found.
namespace subsoil::dem {

inline double select(bool condition, double a, double b) { return condition ? a : b; }
inline double max(double a, double b) { return a > b ? a : b; }
inline double min(double a, double b) { return a < b ? a : b; }
inline double sqrt(double a) { return std::sqrt(a); }
inline double pow(double a, double n) { return std::pow(a, n); }
inline double rsqrt(double a) { return 1 / std::sqrt(a); }                ///< 1/sqrt(a), a > 0
inline double over_root(double k, double a) { return k / std::sqrt(a); }  ///< k/sqrt(a), a > 0
inline double log(double a) { return std::log(a); }
inline bool both(bool a, bool b) { return a && b; }
inline bool any(bool a) { return a; }  ///< in any lane: skips what no contact of a SIMD vector needs

/// What a comparison of two T gives: bool for double, a lane mask for a SIMD vector.
template <class T>
using Mask = decltype(T(0.0) > T(0.0));

/// A number far below all that a law computes with and far above the smallest of T: where 0 would be divided by.
template <class T>
inline T tiny() {
  return T(1e-30);
}

/// How the square of a force or torque is formed so that it stays a number of T: times `unit` before it is squared, and
/// at least `least`. What grains of a micrometre bear, 1e-20 N m, has a square that is no float and lies far below
/// tiny().
template <class T>
struct SquareRange {
  static constexpr double unit = 1, least = 1e-290;
};

/// x^n for x >= 0, n >= 0. Whole and half exponents up to 4 are products and one square root; any other takes the
/// library's pow lane by lane, exact to an ulp: an exponential of n ln x in vector form would lose the digits of
/// n ln x ~ 30, or need arithmetic of double length.
template <class T>
T power(const T& x, double n) {
  const double whole = std::floor(n);
  const bool half = n - whole == 0.5;
  if (n > 4.5 || (!half && n != whole)) return pow(x, n);
  T out = half ? sqrt(x) : T(1.0);
  for (int k = static_cast<int>(whole); k > 0; --k) out = out * x;
  return out;
}

}  // namespace subsoil::dem
