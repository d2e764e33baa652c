#include "libmbd/base/dense.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace subsoil::mbd {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
using PivotedQR = Eigen::ColPivHouseholderQR<MatrixXd>;

PivotedQR pivoted(const MatrixXd& a, double threshold) {
  PivotedQR qr;
  qr.setThreshold(threshold);
  qr.compute(a);
  return qr;
}

LeastSquares solution(const PivotedQR& qr, const VectorXd& b) { return {qr.solve(b), qr.rank()}; }

}  // namespace

VectorXd least_norm_solution(const MatrixXd& a, const VectorXd& b, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
  solver.setThreshold(threshold);
  solver.compute(a);
  return solver.solve(b);
}

Eigen::Index rank_of(const MatrixXd& a, double threshold) { return pivoted(a, threshold).rank(); }

VectorXd pivots(const MatrixXd& a) { return PivotedQR(a).matrixR().diagonal().cwiseAbs(); }

LeastSquares least_squares(const MatrixXd& a, const VectorXd& b) { return solution(PivotedQR(a), b); }

LeastSquares least_squares(const MatrixXd& a, const VectorXd& b, double threshold) {
  return solution(pivoted(a, threshold), b);
}

MatrixXd outside_range(const MatrixXd& a, const MatrixXd& b) {
  const PivotedQR qr(a);
  MatrixXd turned = qr.householderQ().adjoint() * b;
  turned.topRows(qr.rank()).setZero();
  return qr.householderQ() * turned;
}

MatrixXd inverse_of_square(const MatrixXd& x) { return inverse(MatrixXd(x.transpose() * x)); }

VectorXd solve(const MatrixXd& a, const VectorXd& b) { return a.partialPivLu().solve(b); }

MatrixXd inverse(const MatrixXd& a) { return a.partialPivLu().inverse(); }

Eigen::MatrixXcd inverse(const Eigen::MatrixXcd& a) { return a.partialPivLu().inverse(); }

SingularValues singular_values(const MatrixXd& a) {
  const Eigen::JacobiSVD<MatrixXd> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixU(), svd.matrixV()};
}

Eigen::VectorXcd eigenvalues(const MatrixXd& a) { return Eigen::EigenSolver<MatrixXd>(a, false).eigenvalues(); }

Eigenvectors eigenvectors(const MatrixXd& a) {
  const Eigen::EigenSolver<MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

double spectral_radius(const MatrixXd& of) { return eigenvalues(of).cwiseAbs().maxCoeff(); }

}  // namespace subsoil::mbd
