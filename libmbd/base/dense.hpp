#pragma once
#include <Eigen/Core>

/// Decompositions of dense matrices, compiled once, in dense.cpp: each takes seconds to compile. No hot loop calls
/// them.
namespace subsoil::mbd {

/// The x of minimum norm among those that make |a x - b| minimum, by a complete orthogonal decomposition a P = Q T Z
/// (Golub & Van Loan, Matrix Computations, 4th ed., section 5.5.6). Pivots below `threshold` times the maximum count as
/// zero. a is m x n, b has m components, x n.
Eigen::VectorXd least_norm_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold);

/// Number of pivots of a that exceed `threshold` times the maximum, by QR with column pivoting (Golub & Van Loan,
/// section 5.4.2).
Eigen::Index rank_of(const Eigen::MatrixXd& a, double threshold);
/// |Diagonal of R| of this decomposition, in falling order.
Eigen::VectorXd pivots(const Eigen::MatrixXd& a);

/// The x that makes |a x - b| minimum, by the same decomposition; components of pivots up to `threshold` times the
/// maximum are zero. Without a threshold, epsilon times the smaller size of a.
struct LeastSquares {
  Eigen::VectorXd x;
  Eigen::Index rank = 0;
};
LeastSquares least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
LeastSquares least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold);

/// b - a a^+ b: the part of each column of b that is orthogonal to the columns of a, by the same decomposition.
Eigen::MatrixXd outside_range(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// (x^T x)^-1: the covariance of parameters fitted by least squares over the variance of the residuals; x m x n of rank
/// n.
Eigen::MatrixXd inverse_of_square(const Eigen::MatrixXd& x);

/// a^-1 b and a^-1 of a regular square matrix, by LU with row pivoting.
Eigen::VectorXd solve(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);
Eigen::MatrixXcd inverse(const Eigen::MatrixXcd& a);

/// a = left diag(values) right^T, values in falling order; left m x m, right n x n, orthogonal (two-sided Jacobi).
struct SingularValues {
  Eigen::VectorXd values;
  Eigen::MatrixXd left, right;
};
SingularValues singular_values(const Eigen::MatrixXd& a);

/// Eigenvalues of a square matrix; with its right eigenvectors as columns of norm 1.
struct Eigenvectors {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& a);
Eigenvectors eigenvectors(const Eigen::MatrixXd& a);

/// max |lambda|: how much repeated multiplication by a square matrix grows a vector.
double spectral_radius(const Eigen::MatrixXd& of);

}  // namespace subsoil::mbd
