#pragma once

#include "libmbd/assembly/partition.hpp"

namespace subsoil::mbd {

/// y = (q, q', energy flows) at the rate f = (q', q'', powers): f into a column of a matrix, as multistep methods keep
/// it.
void keep_rates(Eigen::MatrixXd& columns, Eigen::Index column, const MotionState& m);

/// A step of Dormand & Prince 1980, order 5, six stages, with the error of the embedded order 4. Each stage is put on
/// the constraints by the partition; beside a singular pose with minimum change of all coordinates.
class RungeKutta {
 public:
  RungeKutta(const System& system, Partition& partition);

  /// From `now`, which the partition evaluated last, over h to `next`; adds to `flows` what flows meanwhile.
  void step(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows);
  /// The same by Heun's method of order 3, whose stages stay short of the end, for an end on a singular pose: there q
  /// and q' are taken as they come, q'' and powers are carried on, reactions are those of the last stage.
  void step_onto_singular(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows);
  /// Of the last step(): the errors of all q, then of all q', then of the flows, the elements' states at their end,
  /// that it has left, estimated.
  const Eigen::VectorXd& errors() const { return sum_; }

 private:
  void sum(const double* weights, int count, double h);
  void move_to(const MotionState& now, double dt, MotionState& next) const;

  Partition& partition_;
  Eigen::MatrixXd stages_;
  Eigen::VectorXd weights_, sum_;
};

}  // namespace subsoil::mbd
