#pragma once
#include <Eigen/Core>
#include <vector>

namespace subsoil::coupling {

/// Solves z = g(z) where only values of g are known, by the quasi-Newton method with least squares of partitioned
/// coupling (Degroote, Bathe & Vierendeels, Computers & Structures 87, 2009; Anderson acceleration). With residuals
/// r_k = g(z_k) - z_k and the differences R = [r_k - r_{k-1}, ...], G = [g_k - g_{k-1}, ...]:
///   c = argmin |r_k + R c|,   z_{k+1} = g_k + G c;   the first step is z_1 = g_0
/// With one unknown it is the secant method. A linear g of N unknowns is solved by at most N + 2 values, also where
/// plain repetition z = g(z) diverges.
class QuasiNewton {
 public:
  explicit QuasiNewton(Eigen::VectorXd start) : at_(std::move(start)) {}
  /// Where g is to be evaluated next.
  const Eigen::VectorXd& at() const { return at_; }
  /// @param value g(at())
  void take(const Eigen::VectorXd& value);

 private:
  Eigen::VectorXd at_, value_, residual_;                ///< the last two of the evaluation before
  std::vector<Eigen::VectorXd> of_residual_, of_value_;  ///< differences, the newest first
};

}  // namespace subsoil::coupling
