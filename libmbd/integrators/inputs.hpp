#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "libmbd/base/function.hpp"
#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// The inputs of a machine: the functions of time in its forces, drivers and controllers. A variable-step method sees
/// them only at the ends of its steps, and its error test passes where both ends lie beside a pulse. They are known
/// ahead, so each is sampled here every `spacing` and at the corners of ramps and tables, once, and a step may only
/// be as long as the quartic through five points of it agrees with the samples inside: to 5e-4 of the bend in the
/// step, or 1e-8 of the maximum value nearby. A half-sine over a whole step is off by 1.8e-3. A parabola is not off,
/// but 0 at both ends of the step: what a formula of four values at the step's ends misses of the mean is no more than
/// a quarter of the bend. A smooth oscillation allows 0.7 rad of its phase and more, which the error test does not
/// exceed where it matters. A pulse between two samples stays unseen. Polynomials bound no step, which may be so long
/// that one turns in it more than once: between next_turn() and the next it rises or falls throughout.
class Inputs {
 public:
  static constexpr double spacing = 2.5e-4;  ///< s
  static constexpr double window = 0.5;      ///< s; no step is longer where there are inputs

  /// The times at which a step sees its inputs: where it begins or ends at a corner, at which a slope jumps, those a
  /// few ulp inside.
  struct Inside {
    double from = -std::numeric_limits<double>::infinity(), until = -from;
    double time(double t) const { return std::clamp(t, from, until); }
  };

  explicit Inputs(const Model& model);
  /// Whether any varies faster than a polynomial.
  bool any() const { return !functions_.empty(); }
  bool resolves_step(double t, double step) { return !any() || stop(t, step) >= t + step; }
  /// Whether a multistep method with these weights of the values at t + step, t, t - step ... takes the mean of each
  /// over the step, to a share of its maximum nearby.
  bool gives_means(double t, double step, std::span<const double> weights, double share);
  /// What such a method missed and what there was, of each function: sums of |mean taken - mean| and |mean| times the
  /// step.
  struct Missed {
    std::vector<double> missed, all;
    double share() const;  ///< the worst of the functions
  };
  void add_missed(double t, double step, std::span<const double> weights, Missed& to);
  /// Where a step from t that wants to be `planned` long has to end at the latest.
  double stop(double t, double planned);
  /// Whether t, in the windows around the last stop(), is a corner of a ramp or a table.
  bool is_corner(double t) const;
  /// Of a step from t whose end, if it gets so far, is `stop`; both as in stop().
  Inside inside(double t, double stop) const;
  /// The first corner of a ramp or a table in (t, until), `until` where there is none.
  double next_corner(double t, double until) const;
  /// The first time after t at which a polynomial may turn; infinity: none does.
  double next_turn(double t) const;

 private:
  void add(const Function& f);
  void sample_around(double t);
  void append_window(double index);
  void sample_changed(double t);
  void find_largest(std::size_t i);
  bool resolves(double t, double end) const;
  double mean(std::size_t i, double t, double end) const;
  double taken(std::size_t i, double t, double step, std::span<const double> weights) const;

  std::vector<const Function*> functions_;
  std::vector<double> turns_;  // of polynomials, rising
  double index_ = 0;           // of the first of the two windows that are sampled
  bool sampled_ = false;
  std::vector<double> times_, corners_;
  std::vector<std::vector<double>> values_;  // of each function at times_; NaN where it has none
  std::vector<double> largest_;              // of each function's |values|
};

}  // namespace subsoil::mbd
