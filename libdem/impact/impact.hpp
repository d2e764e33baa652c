#pragma once
#include <functional>
#include <limits>
#include <vector>

/// Central impact of two bodies, or of a body and the fixed ground, in closed form: what every model answers.
///
/// x is the indentation (m; 0 at first touch, growing while the bodies come closer), v = dx/dt, F >= 0 pushes them
/// apart, and m dv/dt = -F with the effective mass m = m1 m2/(m1 + m2), the body's own mass against the ground.
/// Other forces are left out, as they are small beside F while an impact lasts.
namespace subsoil::dem::impact {

/// The two bodies as a model sees them. What a model does not need may stay NaN.
struct Pair {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  double mass = unknown;     ///< effective mass, kg
  double radius = unknown;   ///< effective radius R1 R2/(R1 + R2), m
  double E_eff = unknown;    ///< E* = 1/((1 - nu1^2)/E1 + (1 - nu2^2)/E2), Pa
  double density = unknown;  ///< of the striking body, kg/m^3
  double yield = unknown;    ///< yield strength of the softer body, Pa

  /// Hertz's coefficient 4/3 E* sqrt(R), N/m^1.5. Throws std::invalid_argument when E* or R is not known.
  double hertz() const;
};

struct Sample {
  double t, x, v, f;  ///< s, m, m/s, N
};

struct Event {
  double speed = 0;        ///< of approach, m/s
  double peak_force = 0;   ///< N
  double peak_time = 0;    ///< of the peak force after first touch, s
  double largest = 0;      ///< maximum indentation, m
  double time_in = 0;      ///< from first touch to the maximum indentation, s
  double time_out = 0;     ///< from there to separation, s; NaN when the bodies stick
  double rebound = 0;      ///< speed of separation, m/s
  double restitution = 0;  ///< rebound/speed
  double lost = 0;         ///< kinetic energy before less after, J
  double at_touch = 0;     ///< part of `lost` that goes in the first instant, J (ground element)
  double in_ground = 0;    ///< work that deforms the ground until the turn, J (ground element)
  bool sticks = false;
  std::vector<Sample> course;  ///< from first touch to separation

  double duration() const { return time_in + time_out; }
  /// Sets rebound and what follows from it.
  void rebounds(double mass, double speed_in, double speed_out);
};

/// One phase of an impact between its turn (v = 0) and its outer end, x(s) = turn + (end - turn) s^2 for s in [0, 1]:
/// near the turn v grows with s, so dt = dx/v stays smooth.
struct Phase {
  double turn = 0, end = 0;                     ///< m
  std::function<double(double)> speed;          ///< |v| at s, m/s
  std::function<double(double, double)> force;  ///< N at (x, |v|)

  double at(double s) const { return turn + (end - turn) * s * s; }
  double place_of(double x) const;  ///< s of an indentation
};

/// Time that a phase takes between two places, s: sums of Gauss to 1e-13 of the phase.
double time_between(const Phase& phase, double s_from, double s_to);

/// Fills times and course: `samples` intervals in each phase, inward first. Without `out` the bodies stick.
void follow(Event& event, const Phase& in, const Phase* out, int samples);

/// Hertzian unloading F = F* ((x - x_p)/(x* - x_p))^1.5 that gives back (m/2) rebound^2 = (2/5) F* (x* - x_p).
Phase hertzian_unloading(double largest, double force, double mass, double rebound);

inline constexpr int usual_samples = 200;  ///< of a phase

}  // namespace subsoil::dem::impact
