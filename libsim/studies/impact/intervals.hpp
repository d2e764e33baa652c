#pragma once
#include <Eigen/Core>

#include "libsim/studies/impact/fit.hpp"

namespace subsoil::sim {

/// A fitted parameter's name and unit, and whether the fit moved its logarithm.
struct FitName {
  std::string name, unit;
  bool logarithm;
};

/// Fills parameters, their intervals, spread and counts of a fit from the solution, its Jacobian and its residuals:
/// covariance s^2 (J'J)^-1, s^2 = |r|^2/(points - parameters), half widths by Student's t.
void add_intervals(ImpactFit& fit, const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& at,
                   const Eigen::VectorXd& residuals, const std::vector<FitName>& names);

}  // namespace subsoil::sim
