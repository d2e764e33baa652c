#pragma once
#include <Eigen/Cholesky>
#include <functional>
#include <vector>

namespace subsoil::sim {

/// Kriging with a linear trend: a smooth function through scattered, noisy values.
///     y(u) = b0 + b u + f(u) + e,   cov f(u), f(u') = s^2 exp(-sum_k (u_k - u'_k)^2/(2 l_k^2)),   var e = noise
/// u in [0, 1]^p; noise the mean variance that the values carry with them. s and l_k maximise the likelihood (b by
/// generalised least squares), l_k in [0.2, 4]. Source: Rasmussen & Williams, Gaussian Processes for Machine Learning,
/// 2006, eqs. (2.25), (2.41), (5.8).
class Surrogate {
 public:
  /// A point per row of `points`; `noise` the variance of a value. Needs p + 2 points: throws std::invalid_argument.
  Surrogate(Eigen::MatrixXd points, Eigen::VectorXd values, double noise);

  double value(const Eigen::VectorXd& u) const;
  /// Standard deviation of what the function is at u, without the noise of a new value.
  double error(const Eigen::VectorXd& u) const;

 private:
  Eigen::VectorXd correlation(const Eigen::VectorXd& u) const;
  Eigen::VectorXd trend(const Eigen::VectorXd& u) const;
  /// Fits all but the hyperparameters; returns the negative log likelihood. `q`: ln s, ln l_1 ...
  double fit(const Eigen::VectorXd& q);

  Eigen::MatrixXd points_;
  Eigen::VectorXd values_;
  double noise_, scale_ = 1;
  Eigen::VectorXd q_, trend_, weights_;
  Eigen::MatrixXd basis_;
  Eigen::LLT<Eigen::MatrixXd> covariance_, trend_covariance_;
};

/// Minimum of f over [0, 1]^p: DIRECT-L (Gablonsky & Kelley 2001) over the whole box, then BOBYQA (Powell 2009)
/// from the best place.
Eigen::VectorXd minimise(int parameters, const std::function<double(const Eigen::VectorXd&)>& f);

}  // namespace subsoil::sim
