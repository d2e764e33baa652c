#include "libmbd/runge_kutta.hpp"

namespace subsoil::mbd {

namespace {

constexpr int stage_count = 6;
constexpr double nodes[stage_count] = {0, 1. / 5, 3. / 10, 4. / 5, 8. / 9, 1};
constexpr double stage_weights[stage_count][5] = {
    {},
    {1. / 5},
    {3. / 40, 9. / 40},
    {44. / 45, -56. / 15, 32. / 9},
    {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
    {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
};
constexpr double result_weights[stage_count] = {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84};
/// The result less that of order 4, the last at the result itself.
constexpr double error_weights[stage_count + 1] = {71. / 57600,      0,         -71. / 16695, 71. / 1920,
                                                   -17253. / 339200, 22. / 525, -1. / 40};

}  // namespace

void keep_rates(Eigen::MatrixXd& columns, Eigen::Index column, const MotionState& m) {
  const auto n = m.q.size();
  auto f = columns.col(column);
  f.head(n) = m.velocity, f.segment(n, n) = m.acceleration, f.tail(m.rates.size()) = m.rates;
}

RungeKutta::RungeKutta(const System& system, Partition& partition) : partition_(partition) {
  const auto& model = system.model();
  const auto rates = static_cast<Eigen::Index>(2 * model.forces.size() + model.drivers.size());
  stages_.setZero(2 * system.coordinates() + rates, stage_count + 1);
  weights_.setZero(stage_count + 1), sum_.setZero(stages_.rows());
}

void RungeKutta::step(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows) {
  const auto n = now.q.size();
  const bool nearest = partition_.near_singular();
  const auto sum = [&](const double* weights, int count) {
    for (int j = 0; j < count; ++j) weights_[j] = h * weights[j];
    sum_.noalias() = stages_.leftCols(count) * weights_.head(count);
  };
  const auto move_to = [&](const double* weights, int count, double node) {
    sum(weights, count);
    next.t = now.t + node * h;
    next.q = now.q + sum_.head(n);
    next.velocity = now.velocity + sum_.segment(n, n);
    nearest ? partition_.evaluate_nearest(next) : partition_.evaluate(next);
  };
  next = now;
  keep_rates(stages_, 0, now);
  for (int stage = 1; stage < stage_count; ++stage) {
    move_to(stage_weights[stage], stage, nodes[stage]);
    keep_rates(stages_, stage, next);
  }
  move_to(result_weights, stage_count, 1);
  flows += sum_.tail(now.rates.size());
  keep_rates(stages_, stage_count, next);
  sum(error_weights, stage_count + 1);
  error_ = sum_.head(2 * n).cwiseAbs().maxCoeff();
}

}  // namespace subsoil::mbd
