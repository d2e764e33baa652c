#include "libsim/studies/calibrate/surrogate.hpp"

#include <cmath>
#include <nlopt.hpp>
#include <stdexcept>

namespace subsoil::sim {
namespace {

using Objective = std::function<double(const Eigen::VectorXd&)>;

double call(const std::vector<double>& x, std::vector<double>&, void* data) {
  const auto& f = *static_cast<const Objective*>(data);
  return f(Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size())));
}

/// One search; stops by itself when rounding ends it, with the best place so far.
void search(nlopt::algorithm method, const Objective& f, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
            int calls, Eigen::VectorXd& x) {
  const auto n = static_cast<std::size_t>(x.size());
  nlopt::opt search(method, static_cast<unsigned>(n));
  search.set_min_objective(call, const_cast<Objective*>(&f));
  search.set_lower_bounds(std::vector<double>(low.data(), low.data() + n));
  search.set_upper_bounds(std::vector<double>(high.data(), high.data() + n));
  search.set_maxeval(calls);
  search.set_xtol_abs(1e-7);
  std::vector<double> at(x.data(), x.data() + n);
  double least = 0;
  try {
    search.optimize(at, least);
  } catch (const nlopt::roundoff_limited&) {
  }
  x = Eigen::Map<Eigen::VectorXd>(at.data(), static_cast<Eigen::Index>(n));
}

}  // namespace

Eigen::VectorXd minimise(int parameters, const Objective& f) {
  const Eigen::VectorXd low = Eigen::VectorXd::Zero(parameters), high = Eigen::VectorXd::Ones(parameters);
  Eigen::VectorXd x = 0.5 * (low + high);
  search(nlopt::GN_DIRECT_L, f, low, high, 1500 * parameters, x);
  x = x.cwiseMax(low).cwiseMin(high);  // DIRECT may leave the box by a rounding, which BOBYQA refuses to start from
  const double before = f(x);
  Eigen::VectorXd nearer = x;
  search(nlopt::LN_BOBYQA, f, low, high, 300 * parameters, nearer);
  return f(nearer) < before ? nearer : x;
}

Surrogate::Surrogate(Eigen::MatrixXd points, Eigen::VectorXd values, double noise)
    : points_(std::move(points)), values_(std::move(values)), noise_(noise) {
  const Eigen::Index n = points_.rows(), p = points_.cols();
  if (n < p + 2) throw std::invalid_argument("a surrogate needs two points more than there are parameters");
  basis_ = Eigen::MatrixXd::Ones(n, p + 1);
  basis_.rightCols(p) = points_;
  // Hyperparameters are searched for with values of spread one.
  const double spread = std::sqrt((values_.array() - values_.mean()).square().mean());
  scale_ = spread > 0 ? spread : 1;
  values_ /= scale_;
  noise_ = std::max(noise_ / (scale_ * scale_), 1e-8);
  Eigen::VectorXd low = Eigen::VectorXd::Constant(p + 1, std::log(0.2)),
                  high = Eigen::VectorXd::Constant(p + 1, std::log(4.0));
  low[0] = std::log(1e-2), high[0] = std::log(10.0);
  Eigen::VectorXd q = 0.5 * (low + high);
  const Objective badness = [this](const Eigen::VectorXd& at) { return fit(at); };
  search(nlopt::LN_SBPLX, badness, low, high, 300 * static_cast<int>(p + 1), q);
  fit(q);
}

double Surrogate::fit(const Eigen::VectorXd& q) {
  q_ = q;
  const Eigen::Index n = points_.rows();
  Eigen::MatrixXd k(n, n);
  for (Eigen::Index i = 0; i < n; ++i) k.col(i) = correlation(points_.row(i).transpose());
  k.diagonal().array() += noise_ + 1e-10;
  covariance_.compute(k);
  const Eigen::MatrixXd solved = covariance_.solve(basis_);
  trend_covariance_.compute(basis_.transpose() * solved);
  trend_ = trend_covariance_.solve(solved.transpose() * values_);
  const Eigen::VectorXd off = values_ - basis_ * trend_;
  weights_ = covariance_.solve(off);
  return 0.5 * off.dot(weights_) + covariance_.matrixLLT().diagonal().array().log().sum();
}

Eigen::VectorXd Surrogate::correlation(const Eigen::VectorXd& u) const {
  const Eigen::Index p = points_.cols();
  const Eigen::ArrayXd inverse = (-q_.tail(p)).array().exp();
  const Eigen::ArrayXXd off = (points_.rowwise() - u.transpose()).array().rowwise() * inverse.transpose();
  return (std::exp(2 * q_[0]) * (-0.5 * off.square().rowwise().sum()).exp()).matrix();
}

Eigen::VectorXd Surrogate::trend(const Eigen::VectorXd& u) const {
  Eigen::VectorXd f(u.size() + 1);
  f << 1, u;
  return f;
}

double Surrogate::value(const Eigen::VectorXd& u) const {
  return scale_ * (trend(u).dot(trend_) + correlation(u).dot(weights_));
}

double Surrogate::error(const Eigen::VectorXd& u) const {
  const Eigen::VectorXd k = correlation(u), solved = covariance_.solve(k);
  const Eigen::VectorXd r = trend(u) - basis_.transpose() * solved;
  const double variance = std::exp(2 * q_[0]) - k.dot(solved) + r.dot(trend_covariance_.solve(r));
  return scale_ * std::sqrt(std::max(variance, 0.0));
}

}  // namespace subsoil::sim
