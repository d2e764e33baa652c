#pragma once

#include "libmbd/partition.hpp"

namespace subsoil::mbd {

/// y = (q, q', energy flows) at the rate f = (q', q'', powers): f into a column of a matrix, as multistep methods keep
/// it.
void keep_rates(Eigen::MatrixXd& columns, Eigen::Index column, const MotionState& m);

/// A step of Dormand & Prince 1980, order 5, six stages, with the error of the embedded order 4. Each stage is put on
/// the constraints by the partition; beside a singular pose with least change of all coordinates.
class RungeKutta {
 public:
  RungeKutta(const System& system, Partition& partition);

  /// From `now`, which the partition evaluated last, over h to `next`; adds to `flows` what flows meanwhile.
  void step(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows);
  /// Of the last step: the largest error of q and q' that it has left, estimated.
  double error() const { return error_; }

 private:
  Partition& partition_;
  Eigen::MatrixXd stages_;
  Eigen::VectorXd weights_, sum_;
  double error_ = 0;
};

}  // namespace subsoil::mbd
