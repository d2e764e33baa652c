#include "libmbd/assembly/least_norm.hpp"

#include "libmbd/base/dense.hpp"

namespace subsoil::mbd {

Eigen::VectorXd least_norm_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(threshold);
  solver.compute(a);
  return solver.solve(b);
}

}  // namespace subsoil::mbd
