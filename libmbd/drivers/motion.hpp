#pragma once

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "libmbd/base/function.hpp"

namespace subsoil::mbd {

/// The motion f(t) that a driver imposes, given as a position, a velocity or an acceleration:
///   position      f(t) = position(t)
///   velocity      f(t) = f(t_0) + integral of velocity from t_0 to t
///   acceleration  f(t) = f(t_0) + f'(t_0) (t - t_0) + double integral of acceleration from t_0 to t
/// f(t_0) and f'(t_0) are what the start pose has. The integrals are those of the function, in closed form where it has
/// one, so that every motion stays a position-level constraint and cannot drift.
struct Motion {
  Function position{}, velocity{}, acceleration{};
  double start = std::numeric_limits<double>::quiet_NaN();  ///< f(t_0); set from the start pose
  double start_rate = 0;                                    ///< f'(t_0); the same
  double start_time = 0;
  /// Between both times (s) f continues as it was at the first: f, f' and f'' there. A run ends where a table has its
  /// last point, and its last step may end behind it.
  double extended_from = std::numeric_limits<double>::infinity(), extended_until = extended_from;

  /// `what` moves, in `unit`: "the angle", "rad".
  template <class V>
  void describe(V& v, const std::string& unit, const std::string& what) {
    v.optional_function("position", position, unit.c_str(), (what + " as a function of time").c_str());
    v.optional_function("velocity", velocity, (unit + "/s").c_str(),
                        "its rate, from the start pose on; instead of position");
    v.optional_function("acceleration", acceleration, (unit + "/s^2").c_str(),
                        "its second rate, from the pose and the velocity of the start on; instead of position");
  }

  void check() const {
    if (position.is_set() + velocity.is_set() + acceleration.is_set() != 1)
      throw std::invalid_argument(
          "needs exactly one of position, velocity and acceleration as a function of time; give one, leave the others "
          "out");
    if (position.has_corners())
      throw std::invalid_argument(
          "position is a table with straight lines: its velocity jumps, which takes a force without bound; use "
          "`between: monotone` or `spline`, or give the velocity");
  }
  void initialise_from_pose(double value_now, double rate_now, double t) {
    if (std::isnan(start)) start = value_now, start_rate = rate_now, start_time = t;
  }
  double value(double t) const {
    if (!is_extended(t)) return given_value(t);
    const double since = t - extended_from;
    return given_value(extended_from) + since * (given_rate(extended_from) + 0.5 * since * given_second(extended_from));
  }
  double rate(double t) const {
    if (!is_extended(t)) return given_rate(t);
    return given_rate(extended_from) + (t - extended_from) * given_second(extended_from);
  }
  double second(double t) const { return given_second(is_extended(t) ? extended_from : t); }

 private:
  bool is_extended(double t) const { return t > extended_from && t <= extended_until; }
  double given_value(double t) const {
    if (position.is_set()) return position.value(t);
    if (velocity.is_set()) return start + (velocity.integral(t) - velocity.integral(start_time));
    const double since = t - start_time;
    return start + since * (start_rate - acceleration.integral(start_time)) +
           (acceleration.double_integral(t) - acceleration.double_integral(start_time));
  }
  double given_rate(double t) const {
    if (position.is_set()) return position.first(t);
    if (velocity.is_set()) return velocity.value(t);
    return start_rate + (acceleration.integral(t) - acceleration.integral(start_time));
  }
  double given_second(double t) const {
    return position.is_set() ? position.second(t) : velocity.is_set() ? velocity.first(t) : acceleration.value(t);
  }
};

}  // namespace subsoil::mbd
