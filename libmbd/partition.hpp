#pragma once

#include <Eigen/Dense>
#include <vector>

#include "libmbd/system.hpp"

namespace subsoil::mbd {

/// A state with everything that follows from it.
struct MotionState {
  double t = 0;
  Eigen::VectorXd q, velocity, acceleration;
  Eigen::VectorXd lambda;  ///< one per equation; 0 for equations that the partition left out as redundant
  Eigen::VectorXd rates;   ///< powers: lost of each force, work of each force, work of each driver (W)
};

/// Generalised coordinate partitioning (Wehage & Haug 1982; model.md section 1): q -> (u dependent, v independent),
/// det Phi_u != 0, M diagonal because q holds centres of gravity.
///   R  = -Phi_u^-1 Phi_v,  g = Phi_u^-1 gamma
///   M^ = M_vv + R^T M_uu R                   v'' = M^^-1 F^
///   F^ = F_v + R^T (F_u - M_uu g)            u'' = R v'' + g
///   Phi_u^T lambda = F_u - M_uu u''          (the u rows of M q'' + Phi_q^T lambda = F)
///   u from Phi(u, v, t) = 0 by Newton;  u' = R v' - Phi_u^-1 Phi_t
/// The choice is made by full-pivot LU of the scaled Phi_q, rows too: redundant equations drop out of the kernel.
/// sensitivity() = max |R| (scaled) says how fast dependent coordinates run against independent ones; it grows without
/// bound exactly as Phi_u becomes singular, and costs nothing, so it is what asks for a new choice.
class Partition {
 public:
  explicit Partition(System& system);

  /// Chooses u and v at an assembled state. Throws std::runtime_error at a singular pose.
  void choose(const MotionState& at);
  /// New choice when the last evaluation asks for it; true when the choice changed hands.
  bool choose_again_if_needed(const MotionState& at);
  bool asks_for_choice() const { return sensitivity_ > limit_; }
  long choices() const { return choices_; }
  double sensitivity() const { return sensitivity_; }

  const std::vector<int>& independent() const { return v_; }
  const std::vector<int>& dependent() const { return u_; }
  const std::vector<int>& used_rows() const { return rows_; }
  Eigen::Index freedom() const { return static_cast<Eigen::Index>(v_.size()); }
  Eigen::Index rank() const { return static_cast<Eigen::Index>(u_.size()); }

  /// From t, q (v part exact, u part a guess) and v' to everything: u, u', q'', lambda, rates.
  void evaluate(MotionState& m);
  /// Only q'', lambda, rates anew at the state last evaluated: after a change of the external wrench.
  void accelerate(MotionState& m);
  /// All multipliers; for redundant constraints the solution of least norm.
  Eigen::VectorXd reactions(const MotionState& m) const;
  const Constraints& constraints() const { return c_; }
  /// Largest |Phi| of all rows at the state last evaluated (angles times length).
  double residual() const;

 private:
  void solve_positions(MotionState& m);
  void factor();
  void gather_residual();

  System& system_;
  Constraints c_;
  Eigen::VectorXd row_scale_, column_scale_;
  std::vector<int> rows_, u_, v_;
  long choices_ = 0;
  double sensitivity_ = 0, limit_ = 0;

  Eigen::MatrixXd phi_u_, r_, m_hat_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  Eigen::LLT<Eigen::MatrixXd> mass_factor_;
  Eigen::VectorXd load_, work_u_, step_u_, g_, f_hat_, v_rate_;
  Eigen::VectorXd mass_u_, mass_v_;
};

}  // namespace subsoil::mbd
