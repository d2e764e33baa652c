#include "libdem/impact/hysteretic.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace subsoil::dem::impact {

void Hysteretic::check() const {
  if (!std::isnan(K1) && !std::isnan(S_y))
    throw std::invalid_argument("K1 and S_y say the same, K1 = 5 R S_y; keep one of them");
  if (std::isnan(K2) == std::isnan(restitution))
    throw std::invalid_argument("needs either the restitution or K2 = K1/restitution^2");
  if (K2 < K1) throw std::invalid_argument("K2 must not be below K1: unloading cannot give back more than loading");
}

double Hysteretic::loading(const Pair& pair) const {
  if (!std::isnan(K1)) return K1;
  const double yield = std::isnan(S_y) ? pair.yield : S_y;
  if (!(yield > 0) || !(pair.radius > 0))
    throw std::invalid_argument("needs K1, or a yield strength (S_y, or that of a body) and the radius of a body");
  return 5 * pair.radius * yield;
}

double Hysteretic::unloading(const Pair& pair) const {
  const double k1 = loading(pair), k2 = std::isnan(K2) ? k1 / (restitution * restitution) : K2;
  if (k2 < k1) throw std::invalid_argument("K2 is below K1 = 5 R S_y: unloading cannot give back more than loading");
  return k2;
}

double Hysteretic::restitution_at(const Pair& pair, double) const {
  return std::isnan(K2) ? restitution : std::sqrt(loading(pair) / unloading(pair));
}

Event Hysteretic::strike(const Pair& pair, double speed, int samples) const {
  const double k1 = loading(pair), k2 = unloading(pair), quarter = std::numbers::pi / 2;
  const double in = std::sqrt(k1 / pair.mass), out = std::sqrt(k2 / pair.mass);
  Event event;
  event.rebounds(pair.mass, speed, speed * in / out);
  event.largest = speed / in;
  event.peak_force = k1 * event.largest;
  event.time_in = event.peak_time = quarter / in;
  event.time_out = quarter / out;
  for (int k = 0; k <= samples; ++k) {
    const double phase = quarter * k / samples, x = event.largest * std::sin(phase);
    event.course.push_back({phase / in, x, k == samples ? 0 : speed * std::cos(phase), k1 * x});
  }
  // From the turn on F = F_max cos: the same force again, over a spring that is stiffer.
  for (int k = 1; k <= samples; ++k) {
    const double phase = quarter * k / samples, force = k == samples ? 0 : event.peak_force * std::cos(phase);
    event.course.push_back({event.time_in + phase / out, event.largest - (event.peak_force - force) / k2,
                            -event.rebound * std::sin(phase), force});
  }
  return event;
}

}  // namespace subsoil::dem::impact
