#pragma once
#include <deque>

namespace subsoil::app {

/// Mean of a piecewise constant signal over the last `length` seconds, for steps of any duration. Keeps the integral at
/// each step's end; the mean is a difference of two of them, the older one interpolated.
class MovingMean {
 public:
  explicit MovingMean(double length) : length_(length) {}
  /// The value that held over the `duration` that ends at `time`.
  void add(double time, double duration, double value);
  /// True once a full length has been seen.
  bool full() const { return full_; }
  double length() const { return length_; }
  double mean() const;

 private:
  struct Knot {
    double time, integral;
  };
  double length_;
  std::deque<Knot> knots_;  ///< the first lies at or before the start of the interval
  bool full_ = false;
};

}  // namespace subsoil::app
