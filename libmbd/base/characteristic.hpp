#pragma once

#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "libmbd/base/function.hpp"

namespace subsoil::mbd {

/// f(x) = c1 x + c2 x^2 + c3 x^3 + c4 x^4 + c5 x^5: zero at zero, so a constant belongs in a preload.
struct PolynomialCharacteristic {
  PolynomialFunction law{};

  template <class V>
  void describe(V& v, const std::string& x_unit, const std::string& y_unit) {
    v.card("polynomial", "c1 x + c2 x^2 + c3 x^3 + c4 x^4 + c5 x^5");
    const auto unit = [&](int power) { return "(" + y_unit + ")/(" + x_unit + ")^" + std::to_string(power); };
    v.quantity("c1", law.c[1], unit(1).c_str(), "(-inf, inf)", "coefficient of x");
    v.quantity("c2", law.c[2], unit(2).c_str(), "(-inf, inf)", "coefficient of x^2");
    v.quantity("c3", law.c[3], unit(3).c_str(), "(-inf, inf)", "coefficient of x^3");
    v.quantity("c4", law.c[4], unit(4).c_str(), "(-inf, inf)", "coefficient of x^4");
    v.quantity("c5", law.c[5], unit(5).c_str(), "(-inf, inf)", "coefficient of x^5");
  }
  void check() const;
};

/// Piecewise cubic through (x, f), held constant outside: TableFunction over another argument.
struct TableCharacteristic {
  TableFunction law{};

  TableCharacteristic() = default;
  TableCharacteristic(std::vector<double> at, std::vector<double> value, Between between = Between::spline)
      : law(std::move(at), std::move(value), false, between) {}

  template <class V>
  void describe(V& v, const std::string& x_unit, const std::string& y_unit) {
    v.card("table", "a curve through given points, constant before the first and after the last");
    v.table("points", law.times, law.values, x_unit.c_str(), y_unit.c_str(), "x and value, x increasing");
    describe_between(v, law.between);
  }
  void check() const;
};

/// The kinds that a scenario can name; a new kind is its struct and one entry here.
using CharacteristicKinds = std::tuple<PolynomialCharacteristic, TableCharacteristic>;

/// A force or torque as a function of a relative measure x (shortening, rate of shortening, ...), with its exact
/// integral, which is the energy that a spring stores. Not set until given a kind.
class Characteristic {
 public:
  Characteristic() = default;
  /// Takes a kind, checks it; throws std::invalid_argument with rule and cure.
  template <class Kind>
  requires(!std::is_same_v<Kind, Characteristic>) Characteristic(Kind kind) {
    kind.check();
    if constexpr (requires { kind.law.prepare(); }) kind.law.prepare();
    kind_ = std::move(kind);
  }

  bool is_set() const { return !std::holds_alternative<std::monostate>(kind_); }
  /// The kind held, or null: for writers that print it.
  template <class Kind>
  const Kind* get_if() const {
    return std::get_if<Kind>(&kind_);
  }

  /// Zero while not set, so that a force adds its characteristic without asking.
  double value(double x) const;
  /// Integral from 0 to x.
  double integral(double x) const;
  /// Where pieces of it meet: the points of a table; none of a polynomial.
  std::span<const double> nodes() const;

 private:
  std::variant<std::monostate, PolynomialCharacteristic, TableCharacteristic> kind_;
};

}  // namespace subsoil::mbd
