#include "libmbd/base/dense.hpp"

template class Eigen::EigenSolver<Eigen::MatrixXd>;
template class Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;
template class Eigen::PartialPivLU<Eigen::MatrixXd>;

namespace subsoil::mbd {

double spectral_radius(const Eigen::MatrixXd& of) {
  return Eigen::EigenSolver<Eigen::MatrixXd>(of, false).eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace subsoil::mbd
