#pragma once

#include <Eigen/Core>
#include <vector>

#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// A steady state: every body moves with the same velocity (towing; 0 is rest), nothing accelerates, and the states of
/// elements (pressures, currents, integrals of controllers) stay what they are.
struct Equilibrium {
  Eigen::VectorXd q, velocity, lambda;
  Eigen::VectorXd states{};  ///< of elements; empty: those that the system holds
  System::Grips grips{};     ///< what stiction holds there
  double residual = 0;       ///< maximum unbalanced force (N, moments over the machine's length)
  int iterations = 0;
};

/// Finds the steady towing equilibrium (at speed 0: the static one) near the guess q at time t:
///   F(q, q', x, lambda) - Phi_q^T lambda = 0,  Phi(q, t) = 0,  x'(q, q', x, lambda) = 0
/// for all coordinates q, multipliers lambda and states x of elements together, every body at (speed, 0). States begin
/// with their start values at the guess. What their rates leave free (oil that a closed valve locks in) follows the
/// motion from there: the equilibrium is the one that the machine reaches by moving slowly.
/// Contacts that can stick do so from where they touch on the way; joints, from the guess.
/// In a tow a body that nothing holds in its angle (a wheel on its axle) may rotate. Its angular velocity is unknown in
/// place of its angle, and follows from its balance of moments: it rolls where friction lets it. Wheels on soil turn
/// at -speed/R and take no part in the balance of moments. At speed 0 nothing rotates.
/// Newton's method on all unknowns, with pseudo-transient continuation: M/tau^2 stands beside the stiffness and
/// 1/tau beside the rates of states, and both fade as the residual falls. So a wheel that just touches the ground,
/// where the soil has no stiffness yet, falls in like a body and not where a singular matrix points.
/// At speed 0 a machine that this does not bring to balance falls (fall_to_rest), and Newton's method starts from
/// there. Throws std::runtime_error when there is none within reach, std::invalid_argument when a driver's velocity
/// contradicts the speed.
Equilibrium towing_equilibrium(System& system, double t, const Eigen::VectorXd& guess, double speed);

/// One oscillation about a steady state, or one real root of it.
struct Mode {
  double frequency = 0;  ///< imaginary part of the eigenvalue over 2 pi (Hz), >= 0
  double damping = 0;    ///< ratio: -real part over modulus; 0 for a zero eigenvalue
  double rate = 0;       ///< real part (1/s)
  /// Estimate of the error of the eigenvalue (1/s): a bound, all roundings of one sign. Of a coordinate that nothing
  /// holds: below which angular frequency it may be held nevertheless, hidden by rounding in the stiffest forces.
  double error = 0;
  /// Of it what comes from laws that change at the very state, as a contact that just touches (1/s).
  double error_of_laws = 0;
  /// Standard deviation from rounding, whose signs are independent of each other (1/s); below its bound in `error`.
  double rounding = 0;
  /// Of all coordinates, dependent ones too; the maximum entry (angles times the machine's length) is 1 m or rad and
  /// real. Empty for a coordinate that nothing holds.
  Eigen::VectorXcd shape;
  /// A force jumps at the very state, or is infinitely steep there, and this eigenvalue hangs on its slope: nothing is
  /// known of it but its shape.
  bool undetermined = false;
  bool is_zero() const { return frequency == 0 && rate == 0 && !undetermined; }
};

/// Small oscillations about a steady state: eigenvalues of the equations of motion in the independent coordinates,
/// linearised on the constraint manifold with the states of elements. Derivatives are those inside the branch of each
/// law that acts at the state (slope_at_zero): the end of a contact nearby does not count. Their errors, with those of
/// the eigenvalue problem, give Mode::error; an eigenvalue that its error covers is zero.
/// Oscillating pairs stand once; sorted by frequency.
std::vector<Mode> modes(System& system, double t, const Equilibrium& at);

/// What the eigenvalues tell about a steady state: unstable when one has a positive real part; else neutral when one is
/// zero (a free wheel: it stays wherever it is put); else stable, damped or not. An undetermined one beside none that
/// is unstable leaves it open.
enum class Stability { stable, neutral, unstable, undetermined };
struct StabilityReport {
  Stability kind = Stability::stable;
  int unstable = 0;  ///< eigenvalues with a positive real part, both of a pair counted
  int neutral = 0;   ///< coordinates with zero eigenvalues
  int undetermined = 0;
};
StabilityReport stability(const std::vector<Mode>& modes);

}  // namespace subsoil::mbd
