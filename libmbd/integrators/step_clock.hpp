#pragma once

#include <cmath>

namespace subsoil::mbd {

/// Ends of equal steps without gathered rounding: origin + count * h for as long as h stays what it is. Steps that
/// differ by rounding gather: origin and h are set again before that is seen.
class StepClock {
 public:
  void restart() { step_ = 0; }
  /// @param asked the end where it is given as a time; NaN: it is not
  double end_of_step(double now, double h, double asked) {
    const double end = end_of_step(now, h), rounding = 1e-9 * h + 4e-16 * std::abs(end);
    return std::abs(end - asked) <= rounding ? asked : end;
  }
  double end_of_step(double now, double h) {
    const double end = origin_ + static_cast<double>(count_ + 1) * step_;
    const bool goes_on = std::abs(h - step_) <= 1e-9 * step_ && std::abs(end - (now + h)) <= 1e-10 * h;
    if (!goes_on) step_ = h, origin_ = now, count_ = 0;
    return origin_ + static_cast<double>(++count_) * step_;
  }
  bool operator==(const StepClock&) const = default;
  template <class A>
  void archive(A& a) {
    a("clock step", step_)("clock origin", origin_)("clock steps", count_);
  }

 private:
  double step_ = 0, origin_ = 0;
  long count_ = 0;
};

}  // namespace subsoil::mbd
