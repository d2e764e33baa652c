#include <algorithm>
#include <cmath>
#include <limits>

#include "libmbd/assembly/partition.hpp"
#include "libmbd/assembly/partition_limits.hpp"

/// Positions and velocities on the constraints.
namespace subsoil::mbd {

namespace {
// Above it accelerations come from M^: S need not be asked how near a singular pose is (Adaptive stays beside one up to
// 0.15), and M^ has the square of R, so that rounding grows beside flat poses (two four-bar windows,
// IFToMM A02: 2e-8 J of kinetic energy with 0.2, 3e-11 J with 0.6). The rig stays above it.
constexpr double sure_pivot = 0.6;
// Factors of a pose this far away (lengths of the machine) still serve; they leave at most ten times the distance of a
// right side, and those of M^ no less than rounding does: where that is below the goal there is nothing to look at
// again.
constexpr double near_enough = 1e-7, left_by_distance = 10, left_by_rounding = 1e-12;
// Of a residual, over the size of its terms.
constexpr double rounding = 2e-16;
constexpr double rest_speed = 1e-8;  // lengths of the machine in a second
}  // namespace

void Partition::evaluate(MotionState& m) {
  nearest_ = false;
  put_on_constraints(m);
}

void Partition::evaluate_predicted(MotionState& m) {
  nearest_ = false;
  if (rank() == 0 || !may_reduce()) return evaluate(m);
  system_.set_state(m.t, m.q, m.velocity);
  system_.constraints(c_);
  double open = 0;
  for (const UsedRow& r : used_rows_)
    if (!(std::abs(c_.phi[r.row]) <= open)) open = std::abs(c_.phi[r.row]);
  if (!(open <= near_enough * system_.length_scale())) return evaluate(m);
  factor();
  if (!may_reduce()) return evaluate(m);
  velocity_turn_ = 0, of_this_pose_ = true;
  reduce(m);
  solve_motion(m);
}

void Partition::evaluate_nearest(MotionState& m) {
  nearest_ = true;
  factored_at_[0] = std::numeric_limits<double>::quiet_NaN();
  put_on_constraints(m);
}

void Partition::put_on_constraints(MotionState& m) {
  const bool serve = solve_positions(m);
  if (rank() > 0) {
    solve_velocities(m);
    of_this_pose_ = !serve;
    if (!nearest_) prepare_motion(m, serve);
  }
  system_.set_velocity(m.velocity);
  system_.constraints_of_velocity(c_);
  solve_motion(m);
}

// Factors for accelerations and multipliers, but where those of before serve. Phi_u has its own of the guess; R wants
// them of the pose itself, which cost less than a pass of refinement.
void Partition::prepare_motion(const MotionState& m, bool serve) {
  if (!serve && may_reduce()) {
    factor();
    return reduce(m);
  }
  if (serve && reduced_) return;
  weigh();
  if (!serve) factor_schur(m);
}

bool Partition::may_reduce() const { return freedom() > 0 && freedom() <= few_freedoms && least_pivot_ >= sure_pivot; }

// The corrector moves the pose by the local error of a step. Factors that are this near solve as well as fresh ones
// with one pass of refinement more, and cost a third of an evaluation less.
bool Partition::factors_serve(const MotionState& m) {
  double moved = 0;
  for (Eigen::Index i = 0; i < m.q.size(); ++i) {
    const double by = std::abs(m.q[i] - factored_at_[i]) * column_scale_[i];
    if (!(by <= moved)) moved = by;  // NaN counts as far
  }
  const double distance = moved / system_.length_scale();
  const bool serve = distance <= near_enough && !near_singular();
  trust_ = serve && reduced_ ? std::max(left_by_distance * distance, left_by_rounding) : left_by_distance * near_enough;
  return serve;
}

// Returns whether the factors of before serve the new pose.
bool Partition::solve_positions(MotionState& m) {
  // Newton with the matrix of the guess, which a predictor leaves nearly on Phi = 0: the first iteration then is the
  // last, and the same factors serve the velocities.
  double far = 0;
  for (Eigen::Index i = 0; i < m.q.size(); ++i)
    far = std::max(far,
                   std::abs(m.q[i]) * (i % 3 == 2 ? std::min(1.0, system_.body_size(static_cast<int>(i / 3 + 1))) : 1));
  const double scale = std::max(system_.length_scale(), far);
  // The second is the rounding of Phi itself. Beside a singular pose what is left returns over the distance from it.
  const double goal = nearest_ ? rounding * scale : 1e-14 * system_.length_scale() + 2e-15 * far;
  double before = 0, first = 0;
  bool serve = factors_serve(m);
  if (!serve) factored_at_[0] = std::numeric_limits<double>::quiet_NaN();
  for (int iteration = 0; iteration < 50; ++iteration) {
    system_.set_position(m.t, m.q);
    system_.constraints_of_position(c_);
    if (rank() == 0) return true;
    if (nearest_) weigh();
    if (iteration == 0 && !serve) factor_again(m);
    double now = 0;
    for (std::size_t k = 0; k < work_.size(); ++k) {
      const auto row = used_rows_[k].row;
      work_[k] = c_.phi[row];
      // An angle counts as its arc, and in a machine of more than a metre as it is.
      now = std::max(now, std::abs(work_[k]) * std::min(1.0, row_scale_[static_cast<Eigen::Index>(row)]));
    }
    if (now <= goal || (now <= 1e-13 * scale && iteration > 0 && now > 0.1 * before)) {
      if (!choice_.redundant.empty() && residual() > 1e-8 * scale) break;
      // What is left of a guess that met the goal follows the guess, from step to step. Where M^ is nearly singular
      // accelerations magnify it above what rounding makes of them. Near-singular Phi_u magnifies the rounding.
      if (now > rounding * scale && least_pivot_ >= sure_pivot) correct(m.q);
      return serve;
    }
    if (iteration == 0) first = now;
    if (!(now < 1e3 * scale)) break;
    if (iteration > 0 && now > 0.01 * before) factor_again(m), serve = false;
    before = now;
    correct(m.q);
  }
  if (first < 1e-8 * scale && least_pivot_ < singular_pose.pivot) refuse_singular(m);  // closed, and yet no way on
  refuse_open(m);
}

// Of what corrects, which beside a singular pose is S.
void Partition::factor_again(const MotionState& m) {
  factor();
  if (nearest_) factor_schur(m);
}

// Takes the residual in work_ out of positions or velocities: out of the dependent ones, or with least change of all.
void Partition::correct(Eigen::VectorXd& x) {
  if (nearest_) {
    schur_.solve(work_);
    subtract_reactions(work_, x);
    return;
  }
  for (std::size_t k = 0; k < work_.size(); ++k) chosen_work_[used_rows_[k].chosen] = work_[k];
  phi_u_.solve(chosen_work_);
  for (std::size_t k = 0; k < work_.size(); ++k) x[choice_.dependent[k]] -= chosen_work_[k];
}

// work_ = Phi_q x + sign * other; returns the largest of it.
template <int sign>
double Partition::apply_jacobian(const Eigen::VectorXd& x, const std::vector<double>& other) {
  const auto* const jacobian = c_.jacobian.data();
  double most = 0;
  for (std::size_t k = 0; k < work_.size(); ++k) {
    const UsedRow& r = used_rows_[k];
    double sum = sign * other[r.row];
    for (Index b = r.first; b < r.last; ++b) {
      const double* const p = x.data() + column_[b];
      const auto& j = jacobian[b];
      sum += j[0] * p[0] + j[1] * p[1] + j[2] * p[2];
    }
    work_[k] = sum;
    most = std::max(most, std::abs(sum));
  }
  return most;
}

template double Partition::apply_jacobian<-1>(const Eigen::VectorXd&, const std::vector<double>&);

void Partition::solve_velocities(MotionState& m) {
  // As a correction of the guess: the digits that the guess has are not lost to the condition of Phi_u.
  if (!m.velocity.allFinite())
    for (const int i : choice_.dependent) m.velocity[i] = 0;
  const double fastest = m.velocity.cwiseProduct(column_scale_).cwiseAbs().maxCoeff();
  const double goal = (nearest_ ? rounding : 2e-15) * fastest;  // of the sum of a row
  double before = std::numeric_limits<double>::infinity();
  Eigen::VectorXd& guess = free_;
  guess = m.velocity;
  for (int iteration = 0; iteration < 10; ++iteration) {
    const double now = apply_jacobian<1>(m.velocity, c_.phi_t);
    if (now <= goal || !(now < 0.1 * before)) break;
    before = now;
    correct(m.velocity);
    if (trust_ * now <= goal && !near_singular()) break;
  }
  velocity_turn_ = 0;
  for (Eigen::Index i = 0; i < guess.size(); ++i)
    if (!(m.velocity[i] * guess[i] > 0.5 * guess[i] * guess[i]))
      velocity_turn_ = std::max(velocity_turn_, std::abs(m.velocity[i] - guess[i]) * column_scale_[i]);
  // A machine at rest has velocities of rounding, which turn as they like.
  if (velocity_turn_ > 0) velocity_turn_ /= std::max({fastest, velocity_turn_, rest_speed * system_.length_scale()});
}

}  // namespace subsoil::mbd
