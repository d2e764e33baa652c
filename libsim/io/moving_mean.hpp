#pragma once
#include <deque>

#include "libdem/base/archive.hpp"

namespace subsoil::sim {

/// Mean of a piecewise constant signal over the last `length` seconds, for steps of any duration. Keeps the integral at
/// each step's end; the mean is a difference of two of them, the older one interpolated. Of steps shorter than a
/// 16,384th of the length only some ends are kept, so that memory has a bound: the older end is then interpolated over
/// that share of the length.
class MovingMean {
 public:
  explicit MovingMean(double length) : length_(length) {}
  /// The value that held over the `duration` that ends at `time`.
  void add(double time, double duration, double value);
  /// What came before does not count: there was no value since.
  void restart() { knots_.clear(), full_ = false; }
  /// True once a full length has been seen.
  bool full() const { return full_; }
  double length() const { return length_; }
  double mean() const;
  void archive(Archive& a) { a("knots", knots_)("full", full_); }

 private:
  struct Knot {
    double time, integral;
    void archive(Archive& a) { a("time", time)("integral", integral); }
  };
  double length_;
  std::deque<Knot> knots_;  ///< the first lies at or before the start of the interval
  bool full_ = false;
};

}  // namespace subsoil::sim
