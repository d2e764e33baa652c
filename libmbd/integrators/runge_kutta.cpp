#include "libmbd/integrators/runge_kutta.hpp"

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
  stages_.setZero(2 * system.coordinates() + system.rate_count(), stage_count + 1);
  weights_.setZero(stage_count + 1), sum_.setZero(stages_.rows());
}

void RungeKutta::sum(const double* weights, int count, double h) {
  for (int j = 0; j < count; ++j) weights_[j] = h * weights[j];
  sum_.noalias() = stages_.leftCols(count) * weights_.head(count);
}

void RungeKutta::move_to(const MotionState& now, double dt, MotionState& next) const {
  const auto n = now.q.size();
  next.t = now.t + dt;
  next.q = now.q + sum_.head(n);
  next.velocity = now.velocity + sum_.segment(n, n);
  next.states = now.states + sum_.tail(now.states.size());
}

void RungeKutta::step(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows) {
  const bool nearest = partition_.near_singular();
  const auto evaluate_at = [&](const double* weights, int count, double node) {
    sum(weights, count, h);
    move_to(now, node * h, next);
    nearest ? partition_.evaluate_nearest(next) : partition_.evaluate(next);
  };
  next = now;
  keep_rates(stages_, 0, now);
  for (int stage = 1; stage < stage_count; ++stage) {
    evaluate_at(stage_weights[stage], stage, nodes[stage]);
    keep_rates(stages_, stage, next);
  }
  evaluate_at(result_weights, stage_count, 1);
  flows += sum_.tail(now.rates.size());
  keep_rates(stages_, stage_count, next);
  sum(error_weights, stage_count + 1, h);
}

void RungeKutta::step_onto_singular(const MotionState& now, double h, MotionState& next, Eigen::VectorXd& flows) {
  const auto n = now.q.size();
  constexpr double third[] = {1. / 3}, two_thirds[] = {0, 2. / 3}, result[] = {1. / 4, 0, 3. / 4};
  constexpr double line_to_end[] = {-0.5, 0, 1.5};  // through the rates at 0 and 2/3
  next = now;
  keep_rates(stages_, 0, now);
  for (int stage = 1; stage < 3; ++stage) {
    sum(stage == 1 ? third : two_thirds, stage, h);
    move_to(now, stage * h / 3, next);
    partition_.evaluate_nearest(next);
    keep_rates(stages_, stage, next);
  }
  sum(line_to_end, 3, 1);
  next.acceleration = sum_.segment(n, n);
  next.rates = sum_.tail(now.rates.size());
  sum(result, 3, h);
  move_to(now, h, next);
  flows += sum_.tail(now.rates.size());
}

}  // namespace subsoil::mbd
