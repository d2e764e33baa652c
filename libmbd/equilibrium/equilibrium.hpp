#pragma once

#include <Eigen/Dense>
#include <vector>

#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// A steady state: every body moves with the same velocity (towing; 0 is rest) and nothing accelerates.
struct Equilibrium {
  Eigen::VectorXd q, velocity, lambda;
  double residual = 0;  ///< largest unbalanced force (N, moments over the machine's length)
  int iterations = 0;
};

/// Finds the steady towing equilibrium (at speed 0: the static one) near the guess q at time t:
///   F(q, q', t) - Phi_q^T lambda = 0 for all coordinates,  Phi(q, t) = 0
/// with every body at (speed, 0) and no angular velocity, except wheels on soil, which are held at -speed/R and take no
/// part in the balance of moments (they are neutral: no moment acts on them and their angle stays as guessed).
/// Newton on all coordinates and multipliers together, made globally safe by pseudo-transient continuation: M/tau^2
/// stands beside the stiffness and fades as the residual falls, so a wheel that just touches the ground, where the
/// soil has no stiffness yet, falls in like a body and not where a singular matrix points.
/// At speed 0 a machine that this does not bring to balance is let fall (fall_to_rest) and tried again from there.
/// Throws std::runtime_error when there is none within reach, std::invalid_argument when a driver's velocity
/// contradicts the speed.
Equilibrium towing_equilibrium(System& system, double t, const Eigen::VectorXd& guess, double speed);

/// One oscillation about a steady state, or one real root of it.
struct Mode {
  double frequency = 0;  ///< imaginary part of the eigenvalue over 2 pi (Hz), >= 0
  double damping = 0;    ///< ratio: -real part over modulus; 0 for a zero eigenvalue
  double rate = 0;       ///< real part (1/s)
  /// Of all coordinates, dependent ones too; the largest entry (angles times the machine's length) is 1 m or rad and
  /// real. Empty for a coordinate that nothing holds.
  Eigen::VectorXcd shape;
  bool is_zero() const { return frequency == 0 && rate == 0; }
};

/// Small oscillations about a steady state: eigenvalues of the equations of motion in the independent coordinates,
/// linearised by central differences on the constraint manifold (order 4 in displacements, 2 in velocities).
/// Oscillating pairs stand once; sorted by frequency.
std::vector<Mode> modes(System& system, double t, const Equilibrium& at);

/// What the eigenvalues say of a steady state: unstable when one has a positive real part; else neutral when one is
/// zero (a free wheel: it stays wherever it is put); else stable, damped or not.
enum class Stability { stable, neutral, unstable };
struct StabilityReport {
  Stability kind = Stability::stable;
  int unstable = 0;  ///< eigenvalues with a positive real part, both of a pair counted
  int neutral = 0;   ///< coordinates with zero eigenvalues
};
StabilityReport stability(const std::vector<Mode>& modes);

}  // namespace subsoil::mbd
