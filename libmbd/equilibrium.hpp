#pragma once

#include <Eigen/Dense>
#include <vector>

#include "libmbd/system.hpp"

namespace subsoil::mbd {

/// A steady state: every body moves with the same velocity (towing; 0 is rest) and nothing accelerates.
struct Equilibrium {
  Eigen::VectorXd q, velocity, lambda;
  double residual = 0;  ///< largest unbalanced force (N, moments over the machine's length)
  int iterations = 0;
};

/// Finds the steady towing equilibrium near the guess q at time t:
///   F(q, q', t) - Phi_q^T lambda = 0 for all coordinates,  Phi(q, t) = 0
/// with every body at (speed, 0) and no spin, except wheels on soil, which are held at the spin -speed/R and take no
/// part in the balance of moments (they are neutral: no moment acts on them and their angle stays as guessed).
/// Newton on all coordinates and multipliers together, made globally safe by pseudo-transient continuation: M/tau^2
/// stands beside the stiffness and fades as the residual falls, so a wheel that just touches the ground, where the
/// soil has no stiffness yet, falls in like a body and not where a singular matrix points.
/// Throws std::runtime_error when there is none within reach, std::invalid_argument when a driver's velocity
/// contradicts the speed.
Equilibrium towing_equilibrium(System& system, double t, const Eigen::VectorXd& guess, double speed);

/// One oscillation about a steady state.
struct Mode {
  double frequency = 0;  ///< imaginary part of the eigenvalue over 2 pi (Hz), >= 0
  double damping = 0;    ///< ratio: -real part over modulus; 0 for a zero eigenvalue
  double rate = 0;       ///< real part (1/s)
};

/// Small oscillations about a steady state: eigenvalues of the equations of motion in the independent coordinates,
/// linearised by central differences on the constraint manifold. Oscillating pairs stand once; sorted by frequency.
std::vector<Mode> modes(System& system, double t, const Equilibrium& at);

}  // namespace subsoil::mbd
