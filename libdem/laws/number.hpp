#pragma once
#include <cmath>

/// The number type of a contact law.
///
/// A law is a plain function over a number type T. T is `double` in tests and in the scalar path and a pack of 2, 4 or
/// 8 doubles in the sweep (kernel/pack.hpp). A law therefore branches with `select(condition, a, b)`, never with `if`,
/// and takes sqrt, rsqrt, min and max unqualified so that the overload of its number type is found.
namespace subsoil::dem {

inline double select(bool condition, double a, double b) { return condition ? a : b; }
inline double max(double a, double b) { return a > b ? a : b; }
inline double min(double a, double b) { return a < b ? a : b; }
inline double sqrt(double a) { return std::sqrt(a); }
inline double rsqrt(double a) { return 1 / std::sqrt(a); }  ///< 1/sqrt(a), a > 0
inline bool both(bool a, bool b) { return a && b; }

/// What a comparison of two T gives: bool for double, a lane mask for a pack.
template <class T>
using Mask = decltype(T(0.0) > T(0.0));

}  // namespace subsoil::dem
