#pragma once
#include <functional>

#include "libdem/geometry/boundary.hpp"

namespace subsoil::coupling {

/// Moves a boundary along a line so that the force of the spheres on it meets a load: the servo-controlled walls of
/// triaxial and shear tests. With d the direction in which the load pushes, F = -F_spheres . d the resistance at t_n,
/// e = F_load(t_n) - F the error and v_max the speed limit, the surface moves from t_n to t_{n+1} by
///   u = clamp(K_p e + K_i int e dt + K_d de/dt, -v_max, v_max),   v += (u - v)(1 - exp(-dt/T)),   s += v dt
/// K_p alone is a plate of mass T/K_p that the load pushes through a dashpot 1/K_p; in free flight it comes to
/// min(K_p F_load, v_max). With the stiffness k and damping c of all its contacts together it is stable while
/// K_p c dt < 2 T and K_p k dt^2 < 4 T, without the lag T while K_p c < 1 and K_p k dt < 2: damping alone makes a
/// massless plate jump to and fro. The integral waits while the limit holds u (anti-windup). Work and energy are those
/// of any moved surface (Boundary::work). After the numerical servo-mechanism of Cundall & Strack, Geotechnique 29
/// (1979); velocity-controlled with a limit as in LIGGGHTS's mesh/surface/stress/servo.
struct Servo {
  dem::Vec3 along{0, -1, 0};                ///< d, unit, world axes
  std::function<double(double time)> load;  ///< N
  double gain = 0, integral_gain = 0;       ///< m/(s N), m/(s^2 N)
  bool gain_given = true;                   ///< else a state that is restored keeps its own
  double rate_gain = 0;                     ///< m/N
  double limit = 0;                         ///< v_max, m/s
  double lag = 0;                           ///< T, s; 0: none
};

/// How far one has come.
struct ServoState {
  double travel = 0;    ///< m along d since the start
  double velocity = 0;  ///< m/s of the step that ends at t_n
  double integral = 0;  ///< N s
  double error = 0;     ///< N, at the last step
  double force = 0;     ///< N, F at the last step
  double load = 0;      ///< N, F_load at the last step
  bool began = false;   ///< there is a last step
  double gain = 0;      ///< K_p, of the servo as it began
  template <class A>
  void archive(A& a) {
    a("travel", travel)("velocity", velocity)("integral", integral)("error", error);
    a("force", force)("load", load)("began", began)("gain", gain);
  }

  void advance(const Servo& servo, const dem::Vec3& force_of_spheres, double time, double dt);
};

}  // namespace subsoil::coupling
