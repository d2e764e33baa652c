#include "libdem/impact/thornton.hpp"

#include <cmath>
#include <numbers>

#include "libdem/impact/hertz.hpp"

namespace subsoil::dem::impact {
namespace {

struct Yield {
  double x, f;  ///< indentation and force at which yield begins
};
Yield yield_of(const Pair& pair, double p_y) {
  const double ratio = std::numbers::pi * p_y / (2 * pair.E_eff), x = ratio * ratio * pair.radius;
  return {x, pair.hertz() * std::pow(x, 1.5)};
}

}  // namespace

double Thornton::yield_speed(const Pair& pair) const {
  const Yield y = yield_of(pair, p_y);
  return std::sqrt(0.8 * y.f * y.x / pair.mass);
}

double Thornton::restitution_at(const Pair& pair, double speed) const {
  const double u = yield_speed(pair) / speed;
  if (u >= 1) return 1;
  return std::sqrt(1.2 * std::numbers::sqrt3 * (1 - u * u / 6)) *
         std::pow(u / (u + 2 * std::sqrt(1.2 - 0.2 * u * u)), 0.25);
}

Event Thornton::strike(const Pair& pair, double speed, int samples) const {
  const double u = yield_speed(pair) / speed;
  if (u >= 1) return Hertz{}.strike(pair, speed, samples);
  const Yield y = yield_of(pair, p_y);
  const double stiff = pair.hertz(), slope = 1.5 * y.f / y.x, mass = pair.mass;
  // Energy balance of the loading: F*/F_y = sqrt(6/5 (V/V_y)^2 - 1/5).
  const double force = y.f * std::sqrt(1.2 / (u * u) - 0.2), largest = y.x + (force - y.f) / slope;
  const auto push = [=](double x, double) {
    return x < y.x ? stiff * std::pow(std::fmax(x, 0.0), 1.5) : y.f + slope * (x - y.x);
  };
  const Phase in{largest, 0,
                 [=](double s) {
                   const double left = largest * s * s, x = largest - left;
                   if (x >= y.x) return std::sqrt(left * (push(x, 0) + force) / mass);
                   return std::sqrt(speed * speed - 0.8 * push(x, 0) * x / mass);
                 },
                 push};
  Event event;
  event.rebounds(mass, speed, restitution_at(pair, speed) * speed);
  event.largest = largest;
  event.peak_force = force;
  const Phase out = hertzian_unloading(largest, force, mass, event.rebound);
  follow(event, in, &out, samples);
  event.peak_time = event.time_in;
  return event;
}

}  // namespace subsoil::dem::impact
