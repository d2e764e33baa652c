#pragma once

#include <array>

#include "libmbd/integrators/between.hpp"

namespace subsoil::mbd {

/// A step of Gauss's collocation of four stages, order 8, for q'' = f(t, q, q'), every stage put on the constraints
/// with the minimum change of all coordinates. Stages lie at 0.069, 0.330, 0.670 and 0.931 of the step: neither at its
/// ends nor at its middle, so a singular configuration at any of these three is not evaluated. Source: Hairer, Lubich,
/// Wanner, Geometric Numerical Integration, II.1.3.
class GaussCollocation {
 public:
  static constexpr int stages = 4;

  GaussCollocation(const System& system, Partition& partition);

  /// From `now` over h to `next`; adds to `flows` what flows meanwhile. Returns false where the fixed-point iteration
  /// does not converge; throws what evaluations of the stages throw. A singular end is taken as the polynomial has it.
  bool step(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows);
  /// Of the last step, of q', angles times the machine's length: from how far the acceleration of the end lies off the
  /// cubic through the stages.
  double error() const { return error_; }
  /// Whether the end was singular.
  bool landed() const { return landed_; }
  /// How fast the distance from the singular configuration falls at the end (1/s), and that distance.
  double approach() const { return approach_; }
  double distance() const { return distance_; }
  /// Dense output of the last step.
  Polynomial polynomial() const;

 private:
  Partition& partition_;
  Eigen::VectorXd scale_;
  Eigen::MatrixXd accelerations_, rates_;  // columns: begin, stages, end
  Eigen::MatrixXd stage_velocity_;
  std::array<MotionState, stages> trial_;
  Eigen::VectorXd q_, velocity_, flows_;  // as the step began
  double t_ = 0, h_ = 0, error_ = 0, approach_ = 0, distance_ = 0;
  bool landed_ = false;
};

}  // namespace subsoil::mbd
