#pragma once

#include <Eigen/Core>

/// Limits that more than one source of Partition works with.
namespace subsoil::mbd {

// At an angle e from a singular pose a pivot of Phi_u falls as e and one of S, over its diagonal, as e^2. Either alone
// may be small for another reason: Phi_u by a choice that has had its time, S by bodies of very different mass. Nearer
// than 1e-6 rad rounding takes more than the third digit of the velocities.
struct Nearness {
  double pivot, share;
};
inline constexpr Nearness near_pose{0.05, 1e-2}, singular_pose{1e-5, 1e-12};
// Freedoms up to which M^ is formed: a handful. A pendulum of six bars, which has nothing but freedoms, gains nothing.
inline constexpr Eigen::Index few_freedoms = 6;

}  // namespace subsoil::mbd
