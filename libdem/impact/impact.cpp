#include "libdem/impact/impact.hpp"

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <stdexcept>

namespace subsoil::dem::impact {

double Pair::hertz() const {
  if (!(E_eff > 0 && radius > 0))
    throw std::invalid_argument(
        "needs the bodies' elasticity and shape: give young and poisson of both bodies and the radius of one at least");
  return 4.0 / 3.0 * E_eff * std::sqrt(radius);
}

void Event::rebounds(double mass, double speed_in, double speed_out) {
  speed = speed_in, rebound = speed_out, restitution = speed_out / speed_in;
  lost = 0.5 * mass * (speed_in - speed_out) * (speed_in + speed_out);
}

double Phase::place_of(double x) const { return std::sqrt(std::fmax(0.0, (x - turn) / (end - turn))); }

double time_between(const Phase& phase, double s_from, double s_to) {
  if (!(s_to > s_from)) return 0;
  const double stroke = 2 * std::abs(phase.end - phase.turn);
  const auto slowness = [&](double s) { return stroke * s / phase.speed(s); };
  // Panels of a 64th at most hold 1e-13 even beside the end s = 1, where a force x^n leaves (1 - s)^(n+1).
  const int panels = static_cast<int>(std::ceil(64 * (s_to - s_from)));
  double sum = 0;
  for (int k = 0; k < panels; ++k) {
    const double low = s_from + (s_to - s_from) * k / panels, high = s_from + (s_to - s_from) * (k + 1) / panels;
    sum += boost::math::quadrature::gauss<double, 15>::integrate(slowness, low, high);
  }
  return sum;
}

void follow(Event& event, const Phase& in, const Phase* out, int samples) {
  const auto put = [&](double t, const Phase& phase, double s, double sign) {
    const double x = phase.at(s), v = s > 0 ? phase.speed(s) : 0.0;
    event.course.push_back({t, x, sign * v, phase.force(x, sign * v)});
  };
  event.course.clear();
  double t = 0;
  put(t, in, 1, 1);
  for (int k = samples; k > 0; --k) {
    t += time_between(in, double(k - 1) / samples, double(k) / samples);
    put(t, in, double(k - 1) / samples, 1);
  }
  event.time_in = t;
  event.sticks = out == nullptr;
  event.time_out = Pair::unknown;
  if (out == nullptr) return;
  for (int k = 0; k < samples; ++k) {
    t += time_between(*out, double(k) / samples, double(k + 1) / samples);
    put(t, *out, double(k + 1) / samples, -1);
  }
  event.time_out = t - event.time_in;
}

Phase hertzian_unloading(double largest, double force, double mass, double rebound) {
  const double stroke = 1.25 * mass * rebound * rebound / force;
  // (x - x_p)/(x* - x_p) = 1 - s^2, without the cancellation near the turn.
  return {largest, largest - stroke,
          [=](double s) { return rebound * std::sqrt(-std::expm1(2.5 * std::log1p(-s * s))); },
          [=](double x, double) { return force * std::pow(std::fmax(0.0, 1 - (largest - x) / stroke), 1.5); }};
}

}  // namespace subsoil::dem::impact
