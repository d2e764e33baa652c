#include "libsim/setup/servo.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "libsim/setup/shown_area.hpp"

namespace subsoil::sim {

namespace {

double largest_load(const coupling::Servo& servo, double end) {
  constexpr int samples = 4000;  // of a run
  double most = 0;
  for (int k = 0; k <= samples; ++k) most = std::max(most, std::abs(servo.load(end * k / samples)));
  return most;
}

}  // namespace

coupling::Servo servo_of(const ServoSection& s, const dem::Boundary& boundary, const dem::PeriodicCell& cell,
                         double end, const std::string& place) {
  coupling::Servo out;
  out.along = dem::normalized(s.along);
  out.lag = s.lag.value_or(-1);
  out.limit = s.limit, out.integral_gain = s.integral, out.rate_gain = s.rate;
  if (s.load.is_set()) {
    out.load = [load = s.load](double t) { return load.value(t); };
  } else {
    if (std::holds_alternative<dem::Plane>(boundary.shape))
      throw ScenarioError(place + ".pressure: a plane has no end, so no area; give `load` in N, or a box");
    const double area = shown_area(boundary, out.along, cell);
    if (!(area > 0))
      throw ScenarioError(place +
                          ".pressure: the surface shows no area along `along` within the container's periodic "
                          "sides; give `load` in N, or place it there");
    out.load = [pressure = s.pressure, area](double t) { return area * pressure.value(t); };
  }
  if (s.gain) {
    out.gain = *s.gain;
    return out;
  }
  const double most = largest_load(out, end);
  if (!(most > 0))
    throw ScenarioError(place + ": the load is zero at all times, so that no gain follows from it; give `gain`");
  out.gain = s.limit / most, out.gain_given = false;
  return out;
}

}  // namespace subsoil::sim
