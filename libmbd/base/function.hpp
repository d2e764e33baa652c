#pragma once

#include <functional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "libmbd/base/spline.hpp"

namespace subsoil::mbd {

/// f(t) = value
struct ConstantFunction {
  double value_ = 0;

  template <class V>
  void describe(V& v, const std::string& unit) {
    v.card("constant", "the same value at all times");
    v.quantity("value", value_, unit.c_str(), "(-inf, inf)", "the value");
  }
  void check() const {}
  double value(double t) const;
  double first(double t) const;
  double second(double t) const;
  double integral(double t) const;
  double double_integral(double t) const;
};

/// f(t) = c0 + c1 t + c2 t^2 + c3 t^3 + c4 t^4 + c5 t^5
struct PolynomialFunction {
  double c[6] = {0, 0, 0, 0, 0, 0};

  template <class V>
  void describe(V& v, const std::string& unit) {
    v.card("polynomial", "c0 + c1 t + c2 t^2 + c3 t^3 + c4 t^4 + c5 t^5");
    v.quantity("c0", c[0], unit.c_str(), "(-inf, inf)", "value at t = 0");
    v.quantity("c1", c[1], ("(" + unit + ")/s").c_str(), "(-inf, inf)", "coefficient of t");
    v.quantity("c2", c[2], ("(" + unit + ")/s^2").c_str(), "(-inf, inf)", "coefficient of t^2");
    v.quantity("c3", c[3], ("(" + unit + ")/s^3").c_str(), "(-inf, inf)", "coefficient of t^3");
    v.quantity("c4", c[4], ("(" + unit + ")/s^4").c_str(), "(-inf, inf)", "coefficient of t^4");
    v.quantity("c5", c[5], ("(" + unit + ")/s^5").c_str(), "(-inf, inf)", "coefficient of t^5");
  }
  void check() const {}
  double value(double t) const;
  double first(double t) const;
  double second(double t) const;
  double integral(double t) const;
  double double_integral(double t) const;
};

/// f(t) = mean + amplitude sin(2 pi frequency t + phase)
struct HarmonicFunction {
  double mean = 0, amplitude = 0, frequency = 1, phase = 0;

  template <class V>
  void describe(V& v, const std::string& unit) {
    v.card("harmonic", "mean + amplitude sin(2 pi frequency t + phase)");
    v.quantity("mean", mean, unit.c_str(), "(-inf, inf)", "value about which it swings");
    v.quantity("amplitude", amplitude, unit.c_str(), "(-inf, inf)", "half the swing");
    v.quantity("frequency", frequency, "Hz", "(0, inf)", "cycles per second");
    v.quantity("phase", phase, "rad", "(-inf, inf)", "phase at t = 0");
  }
  void check() const;
  double value(double t) const;
  double first(double t) const;
  double second(double t) const;
  double integral(double t) const;
  double double_integral(double t) const;
};

/// from -> to between two times by 10 x^3 - 15 x^4 + 6 x^5, x = (t - begin)/(end - begin); constant outside.
/// Twice continuously differentiable: no acceleration jump when it drives a joint.
struct RampFunction {
  double from = 0, to = 0, begin = 0, end = 1;

  template <class V>
  void describe(V& v, const std::string& unit) {
    v.card("ramp", "a smooth step from one value to another, constant before and after");
    v.quantity("from", from, unit.c_str(), "(-inf, inf)", "value until the ramp begins");
    v.quantity("to", to, unit.c_str(), "(-inf, inf)", "value after the ramp");
    v.quantity("begin", begin, "s", "(-inf, inf)", "time at which the ramp begins");
    v.quantity("end", end, "s", "(-inf, inf)", "time at which the ramp ends, after its begin");
  }
  void check() const;
  double value(double t) const;
  double first(double t) const;
  double second(double t) const;
  double integral(double t) const;
  double double_integral(double t) const;

 private:
  double once(double t) const;
  double twice(double t) const;
};

/// How a table goes from point to point: see PiecewiseCubic.
using Between = PiecewiseCubic::Between;
template <class V>
void describe_between(V& v, Between& between) {
  v.choice("between", between,
           {{"spline", Between::spline}, {"monotone", Between::monotone}, {"linear", Between::linear}},
           "spline: a natural cubic spline, the smoothest, which may overshoot the points; monotone: a cubic that "
           "rises and falls only where they do, its slope without jumps; linear: straight lines");
}

/// Piecewise cubic through (time, value): held constant (with its first or last value) outside, or repeating itself
/// with the period from its first to its last point.
struct TableFunction {
  std::vector<double> times, values;
  bool periodic = false;
  Between between = Between::spline;

  TableFunction() = default;
  TableFunction(std::vector<double> at, std::vector<double> value, bool repeats = false, Between rule = Between::spline)
      : times(std::move(at)), values(std::move(value)), periodic(repeats), between(rule) {}

  template <class V>
  void describe(V& v, const std::string& unit) {
    v.card("table", "a curve through given points, constant before the first and after the last");
    v.table("points", times, values, "s", unit.c_str(), "time and value, times increasing");
    v.flag("periodic", periodic, "yes: the points repeat themselves without end; the last value is the first again");
    describe_between(v, between);
  }
  void check() const;
  void prepare();
  double value(double t) const;
  double first(double t) const;
  double second(double t) const;
  double integral(double t) const;
  double double_integral(double t) const;

 private:
  PiecewiseCubic::Value at(double t) const;
  PiecewiseCubic spline() const;
  struct Sums {
    double once, twice;
  };
  Sums sums(double t) const;  // integral and double integral from the first point
  PiecewiseCubic spline_;
};

/// A formula in t that whoever reads formulas has turned into callables; this library only calls them.
///   f(t) = value_(t), with its exact first and second derivative and its integral and double integral from t = 0
/// Each must be a function of t alone. What they throw ends the run.
struct ExpressionFunction {
  /// Its word holds the formula itself: {expression: "0.1*sin(20*t)", unit: m}.
  static constexpr bool word_is_key = true;
  std::string text, unit;  // as the scenario has them
  std::function<double(double)> value_, first_, second_, integral_, double_integral_;

  template <class V>
  void describe(V& v, const std::string& wanted_unit) {
    v.card("expression", "a formula in t, the time in s");
    v.expression("expression", *this, wanted_unit,
                 "formula in t (s) with + - * / ^, pi, e, sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt "
                 "abs sign min max pow; angles in it are in rad");
  }
  void check() const;
  double value(double t) const;
  double first(double t) const;
  double second(double t) const;
  double integral(double t) const;
  double double_integral(double t) const;
};

class Function;
/// Sum of functions.
struct SumFunction {
  std::vector<Function> terms;
  void check() const;
  double value(double t) const;
  double first(double t) const;
  double second(double t) const;
  double integral(double t) const;
  double double_integral(double t) const;
};

/// The kinds that a scenario can name; a new kind is its struct and one entry here.
using FunctionKinds =
    std::tuple<ConstantFunction, PolynomialFunction, HarmonicFunction, RampFunction, TableFunction, ExpressionFunction>;

/// A function of time with its derivatives and its integral and double integral from t = 0. Not set until given a kind.
class Function {
 public:
  Function() = default;
  Function(double constant) : kind_(ConstantFunction{constant}) {}
  /// Takes a kind, checks it; throws std::invalid_argument with rule and cure.
  template <class Kind>
  requires(!std::is_arithmetic_v<Kind> && !std::is_same_v<Kind, Function>) Function(Kind kind) {
    if constexpr (requires { kind.prepare(); }) kind.prepare();
    kind.check();
    kind_ = std::move(kind);
  }

  bool is_set() const { return !std::holds_alternative<std::monostate>(kind_); }
  /// The kind held, or null: for writers that print it.
  template <class Kind>
  const Kind* get_if() const {
    return std::get_if<Kind>(&kind_);
  }

  /// Throws std::invalid_argument for a constant beyond -1 or 1: such a value is a mistake. A function of time beyond
  /// the bounds saturates in its user, as a controller's output does.
  void check_share(const char* key) const;

  double value(double t) const;
  double first(double t) const;
  double second(double t) const;
  /// Integral of f from 0 to t, and the integral of that from 0 to t.
  double integral(double t) const;
  double double_integral(double t) const;
  /// Whether f' jumps: of a table with straight lines, and of sums with one.
  bool has_corners() const;

 private:
  std::variant<std::monostate, ConstantFunction, PolynomialFunction, HarmonicFunction, RampFunction, TableFunction,
               ExpressionFunction, SumFunction>
      kind_;
};

}  // namespace subsoil::mbd
