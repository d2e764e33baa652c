#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/assembly/partition.hpp"
#include "libmbd/assembly/partition_limits.hpp"
#include "libmbd/assembly/shared_reactions.hpp"
#include "libmbd/base/dense.hpp"

/// Accelerations, multipliers and rates at a state that is on the constraints.
namespace subsoil::mbd {

extern template double Partition::apply_jacobian<-1>(const Eigen::VectorXd&, const std::vector<double>&);

namespace {
// Friction returns about mu times a ratio of moment arms of a change of the reaction: passes settle by that share each.
// Newton's method needs a pass per equation and step, two steps as a rule, and finds the share itself.
constexpr int most_friction_steps = 20, most_patient_passes = 600;
// Of the largest multiplier, for slopes by differences: T is piecewise linear in slides and smooth in pins.
constexpr double friction_difference = 1e-6;

template <std::size_t count>
using Count = std::integral_constant<std::size_t, count>;
template <std::size_t count>
using Few = Eigen::Vector<double, static_cast<int>(count)>;
template <std::size_t count>
using Square = Eigen::Matrix<double, static_cast<int>(count), static_cast<int>(count)>;
template <std::size_t count>
using ConstRow = Eigen::Map<const Few<count>>;

/// action(Count<freedom>), 1 to few_freedoms: vectors of a known length cost a third.
template <std::size_t count = 1, class Action>
void with_freedom(Eigen::Index freedom, Action action) {
  if (freedom == static_cast<Eigen::Index>(count)) return action(Count<count>{});
  if constexpr (count < few_freedoms) with_freedom<count + 1>(freedom, action);
}
}  // namespace

void Partition::accelerate_as_it_is(MotionState& m) {
  system_.set_state(m.t, m.q, m.velocity);
  system_.constraints(c_);
  if (rank() > 0) {
    factor();
    weigh();
    factor_schur(m);
  }
  velocity_turn_ = 0;
  solve_motion(m);
}

// The constraints are those of the evaluation before; one may have looked elsewhere since.
void Partition::accelerate(MotionState& m) {
  system_.set_state(m.t, m.q, m.velocity);
  if (!reduced_ || !system_.friction_rows().empty()) return solve_motion(m);
  system_.set_element_states(m.states);
  balance_ = load_;
  take_loads();
  balance_ = load_ - balance_;
  correct_reduced(m, false);
  take_rates(m);
}

void Partition::accelerate_by_wrenches(MotionState& m) {
  if (!reduced_ || !system_.friction_rows().empty() || system_.state_count() > 0) return accelerate(m);
  if (wrenches_ == system_.external_wrenches()) return accelerate(m);  // another force has jumped
  for (std::size_t i = 1; i < wrenches_.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const double now = system_.external_wrench(static_cast<int>(i))[k];
      balance_[static_cast<Eigen::Index>(3 * (i - 1) + k)] = now - wrenches_[i][k];
    }
  load_ += balance_;
  wrenches_ = system_.external_wrenches();
  correct_reduced(m, false);
  take_driver_rates(m);
}

void Partition::take_loads() {
  system_.loads(load_);
  wrenches_ = system_.external_wrenches();
}

void Partition::solve_motion(MotionState& m) {
  system_.set_element_states(m.states);
  if (!m.lambda.allFinite()) m.lambda.setZero();  // what a failed evaluation left is no guess
  if (system_.friction_rows().empty()) {
    take_loads();
    solve_accelerations(m);
  } else {
    solve_with_friction(m);
  }
  take_rates(m);
}

void Partition::take_rates(MotionState& m) {
  const auto forces = static_cast<Eigen::Index>(system_.model().forces.size());
  for (Eigen::Index i = 0; i < forces; ++i) {
    m.rates[i] = system_.powers()[static_cast<std::size_t>(i)].lost;
    m.rates[forces + i] = system_.powers()[static_cast<std::size_t>(i)].work;
  }
  take_driver_rates(m);
  if (system_.state_count() == 0) return;
  const SharedReactions reactions(system_, rows_.size(), m.lambda, controllers_read_reactions(system_));
  const std::vector<double>& rates = system_.take_state_rates(m.acceleration, reactions.lambda());
  std::copy(rates.begin(), rates.end(), m.rates.data() + system_.flow_count());
}

// Constraint forces work at the rate -lambda^T Phi_q q' = lambda^T Phi_t: only drivers have a Phi_t.
void Partition::take_driver_rates(MotionState& m) {
  const auto first = static_cast<Eigen::Index>(2 * system_.model().forces.size());
  for (std::size_t d = 0; d < system_.model().drivers.size(); ++d) {
    const int row = system_.row_of_driver(d);
    m.rates[first + static_cast<Eigen::Index>(d)] = m.lambda[row] * c_.phi_t[static_cast<std::size_t>(row)];
  }
}

// acceleration -= M^-1 Phi_q^T lambda.
void Partition::subtract_reactions(const std::vector<double>& lambda, Eigen::VectorXd& acceleration) const {
  for (std::size_t k = 0; k < lambda.size(); ++k) {
    const double l = lambda[k];
    for (Index b = used_rows_[k].first; b < used_rows_[k].last; ++b) {
      double* const a = acceleration.data() + column_[b];
      const auto& w = weighted_[b];
      a[0] -= w[0] * l, a[1] -= w[1] * l, a[2] -= w[2] * l;
    }
  }
}

// R and the factors of M^, from those of Phi_u at the same pose.
void Partition::reduce(const MotionState& m) {
  std::fill(r_.begin(), r_.end(), 0.0);
  for (const Entry& e : free_entries_) r_[e.place] = -c_.jacobian[e.block][e.component];
  with_freedom(freedom(), [&]<std::size_t f>(Count<f>) {
    phi_u_.solve_rows<f>(r_);
    Square<f> a = Square<f>::Zero();
    for (std::size_t k = 0; k < dependent_mass_.size(); ++k) {
      const Few<f> row = ConstRow<f>(r_.data() + k * f);
      a += (dependent_mass_[k] * row) * row.transpose();
    }
    for (std::size_t i = 0; i < f; ++i) {
      const auto d = static_cast<Eigen::Index>(i);
      a(d, d) += system_.mass()[choice_.independent[i]];
    }
    for (Eigen::Index j = 0; j < a.rows(); ++j)  // L L^T, with 1/L on the diagonal
      for (Eigen::Index i = j; i < a.rows(); ++i) {
        double sum = a(i, j);
        for (Eigen::Index k = 0; k < j; ++k) sum -= a(i, k) * a(j, k);
        a(i, j) = i == j ? 1 / std::sqrt(sum) : sum * a(j, j);
      }
    Eigen::Map<Square<f>>(m_hat_.data()) = a;
  });
  reduced_ = true;
  factored_at_ = m.q;
}

// balance_ = F - M q'' - Phi_q^T lambda; returns the largest acceleration that it makes of free bodies.
double Partition::balance(const MotionState& m) {
  balance_ = load_ - system_.mass().cwiseProduct(m.acceleration);
  for (const UsedRow& r : used_rows_) {
    const double lambda = m.lambda[r.row];
    for (Index b = r.first; b < r.last; ++b) {
      double* const rest = balance_.data() + column_[b];
      const auto& j = c_.jacobian[b];
      rest[0] -= j[0] * lambda, rest[1] -= j[1] * lambda, rest[2] -= j[2] * lambda;
    }
  }
  return balance_.cwiseProduct(inverse_mass_).cwiseAbs().maxCoeff();
}

// Takes balance_, and work_ = Phi_q q'' - gamma unless it is nothing, out of accelerations and multipliers.
void Partition::correct_reduced(MotionState& m, bool open) {
  const std::size_t r = dependent_mass_.size();
  double* const c = chosen_work_.data();
  for (std::size_t k = 0; k < r; ++k) c[used_rows_[k].chosen] = open ? -work_[k] : 0;
  if (open) phi_u_.solve(chosen_work_);
  with_freedom(freedom(), [&]<std::size_t f>(Count<f>) {
    const auto row = [&](std::size_t k) { return ConstRow<f>(r_.data() + k * f); };
    const Eigen::Map<const Square<f>> l(m_hat_.data());
    Few<f> y;
    for (std::size_t j = 0; j < f; ++j) y[static_cast<Eigen::Index>(j)] = balance_[choice_.independent[j]];
    for (std::size_t k = 0; k < r; ++k) y += row(k) * (balance_[choice_.dependent[k]] - dependent_mass_[k] * c[k]);
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      for (Eigen::Index k = 0; k < i; ++k) y[i] -= l(i, k) * y[k];
      y[i] *= l(i, i);
    }
    for (Eigen::Index i = y.size(); i-- > 0;) {
      for (Eigen::Index k = i + 1; k < y.size(); ++k) y[i] -= l(k, i) * y[k];
      y[i] *= l(i, i);
    }
    for (std::size_t j = 0; j < f; ++j) m.acceleration[choice_.independent[j]] += y[static_cast<Eigen::Index>(j)];
    for (std::size_t k = 0; k < r; ++k) {
      const double change = c[k] + row(k).dot(y);
      m.acceleration[choice_.dependent[k]] += change;
      c[k] = balance_[choice_.dependent[k]] - dependent_mass_[k] * change;
    }
  });
  phi_u_.solve_transposed(chosen_work_);
  for (std::size_t k = 0; k < r; ++k) m.lambda[choice_.rows[k]] += c[k];
}

void Partition::solve_reduced(MotionState& m) {
  if (of_this_pose_) {
    m.acceleration.setZero(), m.lambda.setZero();
    for (std::size_t k = 0; k < work_.size(); ++k) work_[k] = -c_.gamma[used_rows_[k].row];
    balance_ = load_;
    return correct_reduced(m, true);
  }
  // Factors of a pose near by serve for what is left of a guess.
  if (!m.acceleration.allFinite()) m.acceleration.setZero();
  for (const int row : choice_.redundant) m.lambda[row] = 0;
  double largest = load_.cwiseProduct(inverse_mass_).cwiseAbs().maxCoeff();
  for (const double g : c_.gamma) largest = std::max(largest, std::abs(g));
  const double goal = 1e-14 * largest;  // rounding of a sum of some ten terms
  double before = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < 6; ++pass) {
    const double now = std::max(balance(m), apply_jacobian<-1>(m.acceleration, c_.gamma));
    if (now <= goal || !(now < 0.1 * before)) return;
    before = now;
    correct_reduced(m, true);
    if (trust_ * now <= goal) return;
  }
}

void Partition::solve_accelerations(MotionState& m) {
  if (reduced_) return solve_reduced(m);
  free_ = load_.cwiseProduct(inverse_mass_);
  m.acceleration = free_;
  if (rank() == 0) return;
  // From the lambda given on: it is near after a predictor, and then factors of a pose near by serve as well. Further
  // passes are iterative refinement: S has the square of the condition of Phi_q, and where that is large the
  // accelerations still satisfy their constraints to rounding.
  for (const int row : choice_.redundant) m.lambda[row] = 0;
  for (std::size_t k = 0; k < work_.size(); ++k) work_[k] = m.lambda[used_rows_[k].row];
  subtract_reactions(work_, m.acceleration);
  double largest = free_.cwiseAbs().maxCoeff();
  for (const double g : c_.gamma) largest = std::max(largest, std::abs(g));
  const double goal = 1e-15 * largest;
  double before = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < 6; ++pass) {
    const double now = apply_jacobian<-1>(m.acceleration, c_.gamma);
    if (now <= goal || !(now < 0.1 * before)) return;
    before = now;
    schur_.solve(work_);
    for (std::size_t k = 0; k < work_.size(); ++k) m.lambda[used_rows_[k].row] += work_[k];
    subtract_reactions(work_, m.acceleration);
    if (trust_ * now <= goal) return;
  }
}

// One pass lambda -> T(lambda): the multipliers that belong to friction by those given. Returns the largest change.
double Partition::friction_pass(MotionState& m) {
  system_.set_multipliers(m.lambda);
  take_loads();
  lambda_before_ = m.lambda;
  solve_accelerations(m);
  return (m.lambda - lambda_before_).cwiseAbs().maxCoeff();
}

// Gives up once more than `affordable` passes are ahead at the share that the last two show.
bool Partition::iterate_friction(MotionState& m, double affordable) {
  constexpr double settled = 1e-13;
  double before = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < most_patient_passes; ++pass) {
    const double change = friction_pass(m), size = m.lambda.cwiseAbs().maxCoeff();
    if (change <= settled * size || (change <= 1e-11 * size && change > 0.5 * before)) return true;
    if (!(size < 1e100)) return false;
    if (pass >= 3 && std::isfinite(affordable) &&
        !(std::log(settled * size / change) > affordable * std::log(change / before)))
      return false;
    before = change;
  }
  return false;
}

void Partition::solve_with_friction(MotionState& m) {
  if (iterate_friction(m, 4 + 4.0 * static_cast<double>(system_.friction_rows().size()))) return;
  const LockedFriction found = solve_strong_friction(m);
  if (found.settled) return;
  // Between the branches of |N| and of the two ends of a guide Newton's method may turn in a circle.
  if (found.returned < 1 && iterate_friction(m, std::numeric_limits<double>::infinity())) return;
  char share[32];
  std::snprintf(share, sizeof share, "%.3g", found.returned);
  throw std::runtime_error("no unique acceleration at t = " + std::to_string(m.t) + " s: " + system_.owner(found.row) +
                           " locks itself; its friction returns " + share +
                           " times a change of the reaction that makes it, and must return less than 1. A smaller mu, "
                           "a longer guide or a load along the friction frees it");
}

// Newton's method for T(y) = y, y the multipliers that friction reads. Of two solutions it may find either, so the
// spectral radius of T' there decides: from 1 on the accelerations are not unique, or there are none (Painleve).
Partition::LockedFriction Partition::solve_strong_friction(MotionState& m) {
  std::vector<Eigen::Index> rows;
  for (const int row : system_.friction_rows()) rows.push_back(row), rows.push_back(row + 1);
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  const auto n = static_cast<Eigen::Index>(rows.size());
  const auto next = [&](const Eigen::VectorXd& y) {
    m.lambda(rows) = y;
    friction_pass(m);
    return Eigen::VectorXd(m.lambda(rows));
  };
  LockedFriction found{.row = static_cast<int>(rows.front())};
  Eigen::VectorXd y = m.lambda(rows);
  Eigen::MatrixXd slope(n, n);
  double before = std::numeric_limits<double>::infinity();
  for (int step = 0; step < most_friction_steps; ++step) {
    const Eigen::VectorXd t = next(y);
    const double size = m.lambda.cwiseAbs().maxCoeff(), change = (t - y).cwiseAbs().maxCoeff();
    if (!(size < 1e100)) break;
    if (change <= 1e-13 * size || (change <= 1e-11 * size && change > 0.5 * before)) {
      found.settled = found.returned < 1;
      break;
    }
    before = change;
    const Eigen::VectorXd solution = m.lambda;
    for (Eigen::Index k = 0; k < n; ++k) {
      Eigen::VectorXd beside = y;
      beside[k] += friction_difference * size;
      slope.col(k) = (next(beside) - t) / (friction_difference * size);
    }
    m.lambda = solution;
    const auto [values, vectors] = eigenvectors(slope);
    Eigen::Index fastest = 0, largest = 0;
    found.returned = values.cwiseAbs().maxCoeff(&fastest);
    vectors.col(fastest).cwiseAbs().maxCoeff(&largest);
    found.row = static_cast<int>(rows[static_cast<std::size_t>(largest)]);
    y += solve(Eigen::MatrixXd::Identity(n, n) - slope, t - y);
  }
  return found;
}

Eigen::VectorXd Partition::reactions(const MotionState& m) const {
  if (choice_.redundant.empty()) return m.lambda;
  Constraints dense;
  dense.sparse = c_;
  write_out(system_, dense);
  return least_norm_reactions(system_, dense, m.lambda);
}

}  // namespace subsoil::mbd
