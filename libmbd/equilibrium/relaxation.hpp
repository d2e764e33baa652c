#pragma once

#include <Eigen/Core>

#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// Dynamic relaxation with kinetic damping (Cundall 1976; Barnes 1999): the machine moves under its forces from rest,
/// and each time its kinetic energy has passed a peak it is stopped and released again. Potential energy only falls, so
/// it comes near a stable equilibrium however far off it starts: a guess for Newton, good to 1e-3 of the first
/// acceleration. States of elements continue across the stops. Forces and drivers that depend on time are followed for
/// as long as each fall lasts. Ruts and other memories of the system are as before afterwards.
struct Rest {
  Eigen::VectorXd q, states;
  System::Grips grips{};  ///< what sticks there, by less than its limit
};
Rest fall_to_rest(System& system, double t, const Eigen::VectorXd& from);

}  // namespace subsoil::mbd
