#include "libdem/impact/jackson_green.hpp"

#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>

namespace subsoil::dem::impact {
namespace {

constexpr double elastic_until = 1.9;  ///< x/x_c

struct Onset {
  double x, f;
};
Onset onset_of(const Pair& pair, double S_y, double C) {
  const double ratio = std::numbers::pi * C * S_y / (2 * pair.E_eff), x = ratio * ratio * pair.radius;
  return {x, pair.hertz() * std::pow(x, 1.5)};
}

}  // namespace

double yield_coefficient(double poisson) { return 1.295 * std::exp(0.736 * poisson); }

double JacksonGreen::strength(const Pair& pair) const {
  const double yield = std::isnan(S_y) ? pair.yield : S_y;
  if (!(yield > 0)) throw std::invalid_argument("needs a yield strength: give S_y, or yield strength of a body");
  return yield;
}

double JacksonGreen::critical_speed(const Pair& pair) const {
  const Onset o = onset_of(pair, strength(pair), yield_coefficient(poisson));
  return std::sqrt(0.8 * o.f * o.x / pair.mass);
}

double JacksonGreen::force(const Pair& pair, double x) const {
  if (!(x > 0)) return 0;
  const double C = yield_coefficient(poisson), e_y = strength(pair) / pair.E_eff;
  const Onset o = onset_of(pair, strength(pair), C);
  const double w = x / o.x;
  if (w < elastic_until) return o.f * w * std::sqrt(w);
  const double B = 0.14 * std::exp(23 * e_y);
  const double wide = std::numbers::pi * C * e_y / 2 * std::sqrt(w) * std::pow(w / elastic_until, B / 2);
  const double hardness = 2.84 * -std::expm1(-0.82 * std::pow(wide, -0.7));
  return o.f * (std::exp(-0.25 * std::pow(w, 5.0 / 12)) * w * std::sqrt(w) -
                4 * hardness / C * std::expm1(-std::pow(w, 5.0 / 9) / 25) * w);
}

double JacksonGreen::restitution_at(const Pair& pair, double speed) const {
  const double r = speed / critical_speed(pair), e_y = strength(pair) / pair.E_eff;
  if (r <= 1) return 1;
  const double e = r <= 60 ? 1 - 0.1 * std::log(r) * std::pow((r - 1) / 59, 0.156)
                           : 1 - 0.1 * std::log(60) - 0.11 * std::log(r / 60) * std::pow(r - 60, 2.36 * e_y);
  if (!(e > 0))
    throw std::invalid_argument(
        "the speed is beyond the range of the Jackson-Green fit: its restitution is not above 0");
  return e;
}

Event JacksonGreen::strike(const Pair& pair, double speed, int samples) const {
  using boost::math::quadrature::gauss;
  const Onset o = onset_of(pair, strength(pair), yield_coefficient(poisson));
  const double mass = pair.mass, energy = 0.5 * mass * speed * speed, edge = elastic_until * o.x;
  // The law has a small step at 1.9 x_c: integrals stop there.
  const auto work = [&](double from, double to) {
    const auto part = [&](double a, double b) {
      return b > a ? gauss<double, 20>::integrate([&](double x) { return force(pair, x); }, a, b) : 0.0;
    };
    return part(from, std::fmin(to, edge)) + part(std::fmax(from, edge), to);
  };
  double high = o.x;
  while (work(0, high) < energy) high *= 2;
  std::uintmax_t turns = 100;
  const auto [a, b] = boost::math::tools::toms748_solve([&](double x) { return work(0, x) - energy; }, 0.0, high,
                                                        boost::math::tools::eps_tolerance<double>(50), turns);
  const double largest = 0.5 * (a + b);
  const JacksonGreen law = *this;
  const Phase in{largest, 0, [&](double s) { return std::sqrt(2 / mass * work(largest * (1 - s * s), largest)); },
                 [law, pair](double x, double) { return law.force(pair, x); }};
  Event event;
  event.rebounds(mass, speed, restitution_at(pair, speed) * speed);
  event.largest = largest;
  event.peak_force = force(pair, largest);
  const Phase out = hertzian_unloading(largest, event.peak_force, mass, event.rebound);
  follow(event, in, &out, samples);
  event.peak_time = event.time_in;
  return event;
}

}  // namespace subsoil::dem::impact
