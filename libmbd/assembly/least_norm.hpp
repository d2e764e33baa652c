#pragma once
#include <Eigen/Core>

namespace subsoil::mbd {

/// The x of minimum norm among those that make |a x - b| minimum, by a complete orthogonal decomposition a P = Q T Z
/// (Golub & Van Loan, Matrix Computations, 4th ed., section 5.5.6). Pivots below `threshold` times the maximum count as
/// zero. a is m x n, b has m components, x n. Compiled once, since the decomposition is slow to compile.
Eigen::VectorXd least_norm_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold);

}  // namespace subsoil::mbd
