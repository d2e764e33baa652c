#include "coupling/quasi_newton.hpp"

#include <utility>

#include "libmbd/base/dense.hpp"

namespace subsoil::coupling {

void QuasiNewton::take(const Eigen::VectorXd& value) {
  Eigen::VectorXd residual = value - at_;
  if (residual_.size() > 0) {
    of_residual_.insert(of_residual_.begin(), residual - residual_);
    of_value_.insert(of_value_.begin(), value - value_);
    // More differences than unknowns say nothing new; the oldest are of the farthest points.
    if (of_residual_.size() > static_cast<std::size_t>(value.size())) of_residual_.pop_back(), of_value_.pop_back();
  }
  at_ = value;
  const auto columns = static_cast<Eigen::Index>(of_residual_.size());
  if (columns > 0) {
    Eigen::MatrixXd r(value.size(), columns), g(value.size(), columns);
    for (Eigen::Index k = 0; k < columns; ++k) {
      r.col(k) = of_residual_[static_cast<std::size_t>(k)];
      g.col(k) = of_value_[static_cast<std::size_t>(k)];
    }
    // Of dependent columns the pivoting leaves out what rounding made of them.
    at_ -= g * mbd::least_squares(r, residual, 1e-8).x;
  }
  value_ = value, residual_ = std::move(residual);
}

}  // namespace subsoil::coupling
