#pragma once

#include <limits>
#include <stdexcept>

#include "libmbd/function.hpp"

namespace subsoil::mbd {

/// The motion f(t) that a driver imposes, given as a position or as a velocity:
///   position: f(t) = position(t)
///   velocity: f(t) = f(t_0) + integral of velocity from t_0 to t, exact; f(t_0) is what the start pose has.
/// A velocity is integrated in closed form and stays a position-level constraint, so it cannot drift.
struct Motion {
  Function position{}, velocity{};
  double start = std::numeric_limits<double>::quiet_NaN();  ///< f(t_0); set from the start pose
  double start_time = 0;

  void check() const {
    if (position.is_set() == velocity.is_set())
      throw std::invalid_argument(
          "needs exactly one of position and velocity as a function of time; give one, leave the other out");
  }
  void settle_start(double value_now, double t) {
    if (std::isnan(start)) start = value_now, start_time = t;
  }
  double value(double t) const {
    return position.is_set() ? position.value(t) : start + (velocity.integral(t) - velocity.integral(start_time));
  }
  double rate(double t) const { return position.is_set() ? position.first(t) : velocity.value(t); }
  double second(double t) const { return position.is_set() ? position.second(t) : velocity.first(t); }
};

}  // namespace subsoil::mbd
