#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// Where a force is looked at, and in which direction of the coordinates.
struct MotionPoint {
  const Eigen::VectorXd &q, &velocity, &lambda;
};

/// Controllers and forces, as "controller 'brake'", that jump or are infinitely steep at a state, where it is passed
/// along `direction` by displacement or by velocity: their change over a step does not fall with the step.
std::vector<std::string> jumping(const System& system, double t, const MotionPoint& at,
                                 const Eigen::VectorXd& direction);

/// The cure of such a force.
inline constexpr const char* smooth_force =
    "write `tanh(x/w)` with a width w for `sign(x)`, or take `joint friction` or a contact with a `stick stiffness`";

}  // namespace subsoil::mbd
