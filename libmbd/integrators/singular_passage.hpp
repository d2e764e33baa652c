#pragma once

#include "libmbd/integrators/gauss.hpp"

namespace subsoil::mbd {

/// Steps beside and over a singular configuration, in place of those of a multistep method.
///
/// At an angle d from one, rounding eps leaves eps/d of position, eps/d^2 of velocity and eps/d^3 of acceleration in
/// the coordinates that the constraints hardly hold. A Newton matrix loses its rank, and an error control sees the
/// rounding. The motion itself is smooth there. So one step of Gauss's collocation leads from one side to the other;
/// its stages lie at 0.34 and 0.86 of the distance of its ends, where rounding is small. The distance d falls and rises
/// linearly in time: its rate tells where the configuration is.
///
///   mode   to     when
///   away   near   the motion reaches the configuration within 0.15 rad of travel; a step of the method would end
///                 near_singular() or behind the configuration, and does not count; or the method fails within 0.5 rad
///   near   over   the step that the measured approach asks for ends as far behind the configuration as it begins
///   before near   near   that step errs by more than the tolerance: the next one ends half as far from the
///   configuration over   away   not near_singular(): the method restarts without its past over   near   otherwise near
///   away   0.15 rad and no other configuration ahead
class SingularPassage {
 public:
  enum class Mode { away, near, over };
  static constexpr double far_enough = 0.15;  ///< rad

  SingularPassage(const System& system, Partition& partition);

  Mode mode() const { return mode_; }
  bool away() const { return mode_ == Mode::away; }
  void leave() { mode_ = Mode::away; }
  /// Whether a step over the configuration may begin here: the distance of the last evaluation, and how fast it has
  /// fallen (rad/s).
  bool in_sight(double approach) const;
  void enter() {
    if (away()) mode_ = Mode::near, begun_ = false;
  }
  /// One step from `now`, which the partition evaluated last, to `latest` at most. `tolerance`: of q and q' of size 1.
  void step(const MotionState& now, double latest, double tolerance, MotionState& next, Eigen::VectorXd& flows);
  /// The same again over h, to an event in it.
  void repeat(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows);
  /// The step last made stands.
  void accept();
  /// Whether it has ended on the configuration itself, where nothing can be evaluated.
  bool landed() const { return gauss_.landed(); }
  Polynomial polynomial() const { return gauss_.polynomial(); }
  /// Maximum rate of the machine at the state evaluated last, lengths as shares of its own (rad/s).
  double rate() const;
  double rate_of(const MotionState& m) const;

 private:
  void measure_approach(const MotionState& now);
  bool attempt(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows);

  const System& system_;
  Partition& partition_;
  GaussCollocation gauss_;
  Eigen::VectorXd scale_;
  double length_;
  Mode mode_ = Mode::away;
  bool begun_ = false;
  double step_ = 0, distance_ = 0, approach_ = 0;  // s; rad; rad/s, 0: not known
};

}  // namespace subsoil::mbd
