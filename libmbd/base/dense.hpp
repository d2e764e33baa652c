#pragma once
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

/// Decompositions of dense matrices that several sources use, compiled once, in dense.cpp: each takes 5 to 10 s.
extern template class Eigen::EigenSolver<Eigen::MatrixXd>;
extern template class Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;
extern template class Eigen::PartialPivLU<Eigen::MatrixXd>;

namespace subsoil::mbd {

/// max |lambda|: how much repeated multiplication by a square matrix grows a vector.
double spectral_radius(const Eigen::MatrixXd& of);

}  // namespace subsoil::mbd
