#include "libsim/studies/impact/intervals.hpp"

#include <cmath>
#include <limits>

#include "libmbd/base/dense.hpp"
#include "libsim/base/replicates.hpp"

namespace subsoil::sim {

void add_intervals(ImpactFit& fit, const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& at,
                   const Eigen::VectorXd& residuals, const std::vector<FitName>& names) {
  fit.points = residuals.size();
  fit.freedoms = static_cast<int>(residuals.size() - at.size());
  fit.spread = fit.freedoms > 0 ? residuals.norm() / std::sqrt(fit.freedoms) : 0;
  fit.worst = residuals.cwiseAbs().maxCoeff();
  const Eigen::MatrixXd covariance = mbd::inverse_of_square(jacobian);
  const double quantile =
      fit.freedoms > 0 ? student_t(fit.freedoms, fit.confidence) : std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double half = quantile * fit.spread * std::sqrt(covariance(i, i));
    const auto back = [&](double value) { return names[k].logarithm ? std::exp(value) : value; };
    fit.parameters.push_back({names[k].name, names[k].unit, back(at[i]), back(at[i] - half), back(at[i] + half)});
  }
}

}  // namespace subsoil::sim
