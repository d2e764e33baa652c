#pragma once

#include <cstddef>
#include <vector>

namespace subsoil::mbd {

/// Cubic spline through (x_i, y_i), twice continuously differentiable everywhere.
///   natural   y'' = 0 at both ends, straight on beyond them
///   periodic  y(x + T) = y(x), T = x_n - x_1; the last y repeats the first
/// One point is a constant, two are a straight line. Source: de Boor, A Practical Guide to Splines, 1978, IV.
class CubicSpline {
 public:
  enum class Ends { natural, periodic };
  struct Value {
    double value = 0, first = 0, second = 0;
  };

  CubicSpline() = default;
  /// Throws std::invalid_argument when there is no point, x does not increase, or a periodic y does not return;
  /// `places` is what the message calls x.
  CubicSpline(std::vector<double> x, std::vector<double> y, Ends ends, const char* places = "places");

  Value at(double x) const;
  /// Integral and double integral of y from x_1 to x, for x between the first and the last point.
  double integral(double x) const;
  double double_integral(double x) const;

  double front() const { return x_.front(); }
  double back() const { return x_.back(); }
  const std::vector<double>& knots() const { return x_; }

 private:
  std::size_t interval(double x) const;
  Value inside(std::size_t i, double x) const;
  double integral_within(std::size_t i, double b) const;
  double double_integral_within(std::size_t i, double b) const;
  void solve();
  void sum();

  Ends ends_ = Ends::natural;
  std::vector<double> x_, y_;
  std::vector<double> bend_;              // y'' at the points
  std::vector<double> sum_, double_sum_;  // integral and double integral up to each point
};

}  // namespace subsoil::mbd
