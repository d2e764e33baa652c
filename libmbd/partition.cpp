#include "libmbd/partition.hpp"

#include <algorithm>
#include <stdexcept>

#include "libmbd/assembly.hpp"

namespace subsoil::mbd {

namespace {
// |R| is at most about 2 right after full pivoting; a factor of ten on an angle still costs one digit only, and a
// switch costs one full-pivot LU, so switching is lazy.
constexpr double lazy_limit = 10;
constexpr double rank_share = 1e-9;
}  // namespace

Partition::Partition(System& system)
    : system_(system),
      row_scale_(mbd::row_scale(system)),
      column_scale_(coordinate_scale(system)),
      load_(system.coordinates()) {}

void Partition::choose(const MotionState& at) {
  system_.set_state(at.t, at.q, at.velocity);
  system_.constraints(c_);
  const auto n = system_.coordinates();
  std::vector<int> rows, u, v;
  if (system_.equations() > 0) {
    Eigen::FullPivLU<Eigen::MatrixXd> lu;
    lu.setThreshold(rank_share);
    lu.compute(scaled_jacobian(system_, c_));
    const auto rank = lu.rank();
    const Eigen::PermutationMatrix<Eigen::Dynamic> row_order = lu.permutationP().inverse();
    for (Eigen::Index i = 0; i < rank; ++i) {
      rows.push_back(row_order.indices()[i]);
      u.push_back(lu.permutationQ().indices()[i]);
    }
    if (choices_ > 0 && rank != this->rank())
      throw std::runtime_error("singular pose at t = " + std::to_string(at.t) + " s: the constraints lose " +
                               std::to_string(this->rank() - rank) +
                               " of their rank (a dead point); the motion is not determined from here");
  }
  std::sort(rows.begin(), rows.end());
  std::sort(u.begin(), u.end());
  for (int i = 0; i < n; ++i)
    if (!std::binary_search(u.begin(), u.end(), i)) v.push_back(i);
  rows_ = std::move(rows), u_ = std::move(u), v_ = std::move(v);
  ++choices_;

  const auto r = rank(), f = freedom();
  phi_u_.resize(r, r), r_.resize(r, f), m_hat_.resize(f, f);
  work_u_.resize(r), step_u_.resize(r), g_.resize(r), f_hat_.resize(f), v_rate_.resize(f);
  mass_u_.resize(r), mass_v_.resize(f);
  for (Eigen::Index i = 0; i < r; ++i) mass_u_[i] = system_.mass()[u_[static_cast<std::size_t>(i)]];
  for (Eigen::Index i = 0; i < f; ++i) mass_v_[i] = system_.mass()[v_[static_cast<std::size_t>(i)]];
  if (r > 0) lu_ = Eigen::PartialPivLU<Eigen::MatrixXd>(r);
  factor();
  limit_ = std::max(lazy_limit, 3 * sensitivity_);
}

bool Partition::choose_again_if_needed(const MotionState& at) {
  if (!asks_for_choice()) return false;
  const auto before = v_;
  choose(at);
  return v_ != before;
}

void Partition::factor() {
  const auto r = rank(), f = freedom();
  if (r == 0) return;
  for (Eigen::Index j = 0; j < r; ++j)
    for (Eigen::Index i = 0; i < r; ++i)
      phi_u_(i, j) = c_.jacobian(rows_[static_cast<std::size_t>(i)], u_[static_cast<std::size_t>(j)]);
  lu_.compute(phi_u_);
  sensitivity_ = 0;
  for (Eigen::Index j = 0; j < f; ++j) {
    const int column = v_[static_cast<std::size_t>(j)];
    for (Eigen::Index i = 0; i < r; ++i) work_u_[i] = -c_.jacobian(rows_[static_cast<std::size_t>(i)], column);
    r_.col(j) = lu_.solve(work_u_);
    for (Eigen::Index i = 0; i < r; ++i) {
      const double ratio = column_scale_[u_[static_cast<std::size_t>(i)]] / column_scale_[column];
      sensitivity_ = std::max(sensitivity_, std::abs(r_(i, j)) * ratio);
    }
  }
}

double Partition::residual() const {
  return c_.phi.size() ? row_scale_.cwiseProduct(c_.phi).cwiseAbs().maxCoeff() : 0.0;
}

void Partition::gather_residual() {
  for (std::size_t i = 0; i < rows_.size(); ++i) work_u_[static_cast<Eigen::Index>(i)] = c_.phi[rows_[i]];
}

void Partition::solve_positions(MotionState& m) {
  // Chord Newton with the factors of the evaluation before: along a step they are wrong by O(h), so each iteration
  // wins several digits and no new LU is needed; when it does not, the matrix is refreshed.
  const double scale = std::max(system_.length_scale(), m.q.cwiseAbs().maxCoeff());
  double before = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 50; ++iteration) {
    system_.set_position(m.t, m.q);
    system_.constraints(c_);
    if (rank() == 0) return;
    gather_residual();
    const double now = work_u_.cwiseAbs().maxCoeff();
    if (now <= 2e-15 * scale || (now <= 1e-13 * scale && now > 0.1 * before)) {
      if (rank() < system_.equations() && residual() > 1e-8 * scale) break;
      return;
    }
    if (!(now < 1e3 * scale)) break;
    if (now > 0.1 * before) factor(), gather_residual();
    before = now;
    step_u_ = lu_.solve(work_u_);
    for (std::size_t i = 0; i < u_.size(); ++i) m.q[u_[i]] -= step_u_[static_cast<Eigen::Index>(i)];
  }
  Eigen::Index worst = 0;
  row_scale_.cwiseProduct(c_.phi).cwiseAbs().maxCoeff(&worst);
  throw std::runtime_error("the joints cannot be kept closed at t = " + std::to_string(m.t) +
                           " s: " + system_.owner(static_cast<int>(worst)) + " is open by " +
                           std::to_string(std::abs(c_.phi[worst])) +
                           (system_.angular_row(static_cast<int>(worst)) ? " rad" : " m") +
                           "; the machine has reached the end of its travel, or the step is too long");
}

void Partition::evaluate(MotionState& m) {
  solve_positions(m);
  if (rank() > 0) {
    factor();
    for (std::size_t i = 0; i < rows_.size(); ++i) work_u_[static_cast<Eigen::Index>(i)] = -c_.phi_t[rows_[i]];
    step_u_ = lu_.solve(work_u_);
    for (std::size_t i = 0; i < u_.size(); ++i) {
      double rate = step_u_[static_cast<Eigen::Index>(i)];
      for (std::size_t j = 0; j < v_.size(); ++j)
        rate += r_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * m.velocity[v_[j]];
      m.velocity[u_[i]] = rate;
    }
  }
  accelerate(m);
}

void Partition::accelerate(MotionState& m) {
  const auto r = rank(), f = freedom();
  system_.set_velocity(m.velocity);
  system_.constraints(c_);  // gamma needs the velocities
  system_.loads(load_);
  if (r > 0) {
    for (std::size_t i = 0; i < rows_.size(); ++i) work_u_[static_cast<Eigen::Index>(i)] = c_.gamma[rows_[i]];
    g_ = lu_.solve(work_u_);
    for (Eigen::Index i = 0; i < r; ++i) work_u_[i] = load_[u_[static_cast<std::size_t>(i)]] - mass_u_[i] * g_[i];
  }
  if (f > 0) {
    for (Eigen::Index j = 0; j < f; ++j) f_hat_[j] = load_[v_[static_cast<std::size_t>(j)]];
    if (r > 0) f_hat_.noalias() += r_.transpose() * work_u_;
    m_hat_.setZero();
    if (r > 0) m_hat_.noalias() += r_.transpose() * mass_u_.asDiagonal() * r_;
    m_hat_.diagonal() += mass_v_;
    mass_factor_.compute(m_hat_);
    v_rate_ = mass_factor_.solve(f_hat_);
    for (Eigen::Index j = 0; j < f; ++j) m.acceleration[v_[static_cast<std::size_t>(j)]] = v_rate_[j];
  }
  m.lambda.setZero();
  if (r > 0) {
    step_u_ = g_;
    if (f > 0) step_u_.noalias() += r_ * v_rate_;
    for (Eigen::Index i = 0; i < r; ++i) {
      const int k = u_[static_cast<std::size_t>(i)];
      m.acceleration[k] = step_u_[i];
      work_u_[i] = load_[k] - mass_u_[i] * step_u_[i];
    }
    step_u_ = lu_.transpose().solve(work_u_);
    for (std::size_t i = 0; i < rows_.size(); ++i) m.lambda[rows_[i]] = step_u_[static_cast<Eigen::Index>(i)];
  }
  const auto forces = static_cast<Eigen::Index>(system_.model().forces.size());
  for (Eigen::Index i = 0; i < forces; ++i) {
    m.rates[i] = system_.powers()[static_cast<std::size_t>(i)].lost;
    m.rates[forces + i] = system_.powers()[static_cast<std::size_t>(i)].work;
  }
  // Constraint forces work at the rate -lambda^T Phi_q q' = lambda^T Phi_t: only drivers have a Phi_t.
  for (std::size_t d = 0; d < system_.model().drivers.size(); ++d) {
    const int row = system_.row_of_driver(d);
    m.rates[2 * forces + static_cast<Eigen::Index>(d)] = m.lambda[row] * c_.phi_t[row];
  }
}

Eigen::VectorXd Partition::reactions(const MotionState& m) const {
  if (rank() == system_.equations()) return m.lambda;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(rank_share);
  solver.compute(scaled_jacobian(system_, c_).transpose());
  const Eigen::VectorXd force = c_.jacobian.transpose() * m.lambda;
  return row_scale_.cwiseProduct(Eigen::VectorXd(solver.solve(column_scale_.cwiseInverse().cwiseProduct(force))));
}

}  // namespace subsoil::mbd
