#pragma once

#include <cstddef>
#include <vector>

namespace subsoil::mbd {

/// Piecewise cubic through (x_i, y_i). Between the points
///   spline    twice continuously differentiable everywhere
///   monotone  once: monotone where the points are, so that it overshoots none; slopes are weighted harmonic means of
///             those on both sides, 0 at a peak
///   linear    straight lines, continuous
/// and at the ends
///   natural   straight on beyond them; of a spline y'' = 0 there
///   periodic  y(x + T) = y(x), T = x_n - x_1; the last y repeats the first
/// One point is a constant, two are a straight line. Sources: de Boor, A Practical Guide to Splines, 1978, IV;
/// monotone: Fritsch & Butland 1984, SIAM J. Sci. Stat. Comput. 5, 300, with the ends of Moler 2004, Numerical
/// Computing with MATLAB, section 3.6.
class PiecewiseCubic {
 public:
  enum class Ends { natural, periodic };
  enum class Between { spline, monotone, linear };
  struct Value {
    double value = 0, first = 0, second = 0;
  };

  PiecewiseCubic() = default;
  /// Throws std::invalid_argument when there is no point, x does not increase, or a periodic y does not return;
  /// `places` is what the message calls x.
  PiecewiseCubic(std::vector<double> x, std::vector<double> y, Ends ends, const char* places = "places",
                 Between between = Between::spline);

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
  void take_monotone_slopes();
  void sum();

  /// y'' at both ends of an interval, which with y there makes the cubic.
  struct Bend {
    double left = 0, right = 0;
  };
  Ends ends_ = Ends::natural;
  std::vector<double> x_, y_;
  std::vector<Bend> bend_;                // of the intervals
  std::vector<double> sum_, double_sum_;  // integral and double integral up to each point
};

}  // namespace subsoil::mbd
