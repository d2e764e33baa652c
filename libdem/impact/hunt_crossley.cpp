#include "libdem/impact/hunt_crossley.hpp"

#include <boost/math/special_functions/lambert_w.hpp>
#include <boost/math/special_functions/log1p.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace subsoil::dem::impact {
namespace {

/// u - ln(1 + u), accurate relative to itself down to u -> 0.
double bend(double u) { return -boost::math::log1pmx(u); }

/// Beyond this exp(-1 - g) leaves the range of numbers, and ln(1 + u) is all that u differs from g by.
constexpr double far_out = 600;
/// Below this the argument of W is so near its branch point -1/e that half of the digits are lost there.
constexpr double near_branch = 0.02;

/// Steps of Newton that `start` needs from its 1e-4 or better to rounding.
template <class Value, class Slope>
double polished(double start, Value value, Slope slope) {
  for (int k = 0; k < 3; ++k) start -= value(start) / slope(start);
  return start;
}

/// b v > 0 on the way in: bend(u) = g.
double rate_in(double g) {
  if (!(g > 0)) return 0;
  const double r = std::sqrt(2 * g);
  const double start = g < near_branch ? r * (1 + r / 3 * (1 + r / 12))
                       : g < far_out   ? -1 - boost::math::lambert_wm1(-std::exp(-1 - g))
                                       : g + std::log1p(g);
  return polished(
      start, [g](double u) { return bend(u) - g; }, [](double u) { return u / (1 + u); });
}

/// -b v in (0, 1) on the way out: bend(-p) = g.
double rate_out(double g) {
  if (!(g > 0)) return 0;
  if (g > 0.5) return 1 + boost::math::lambert_w0(-std::exp(-1 - g));
  const double r = std::sqrt(2 * g);
  const double start =
      g < near_branch ? r * (1 - r / 3 * (1 - r / 12)) : 1 + boost::math::lambert_w0(-std::exp(-1 - g));
  return polished(
      start, [g](double p) { return bend(-p) - g; }, [](double p) { return p / (1 - p); });
}

/// w = b v at the peak of the force: a w - ln(1 + w) = g0.
double rate_at_peak(double g0, double n) {
  const double a = (2 * n + 1) / (n + 1);
  const double start =
      g0 < far_out ? -1 - boost::math::lambert_wm1(-a * std::exp(-(g0 + a))) / a : (g0 + std::log1p(g0 / a)) / a;
  return polished(
      std::fmax(start, 0.0), [=](double w) { return (a - 1) * w + bend(w) - g0; },
      [a](double w) { return a - 1 / (1 + w); });
}

}  // namespace

double hunt_crossley_restitution(double nu) { return nu > 0 ? rate_out(bend(nu)) / nu : 1; }

double hunt_crossley_nu(double restitution) {
  if (!(restitution < 1)) return 0;
  // 1 - 2 nu/3 < k < 1/(1 + 2 nu/3) brackets it.
  const double low = 1.5 * (1 - restitution), high = low / restitution;
  std::uintmax_t turns = 100;
  const auto [a, b] = boost::math::tools::toms748_solve(
      [&](double nu) { return hunt_crossley_restitution(nu) - restitution; }, low * (1 - 1e-9), high * (1 + 1e-9),
      boost::math::tools::eps_tolerance<double>(52), turns);
  return 0.5 * (a + b);
}

HuntCrossleyModel HuntCrossleyModel::completed() const {
  const bool map = !std::isnan(restitution) || !std::isnan(at_speed);
  if (map && !std::isnan(b))
    throw std::invalid_argument("has b and a restitution: they say the same twice; keep one of them");
  if (!map && std::isnan(b)) throw std::invalid_argument("needs b, or restitution and at speed; for no damping b: 0");
  if (map && (std::isnan(restitution) || std::isnan(at_speed)))
    throw std::invalid_argument("restitution and at speed belong together: it falls as the speed grows");
  if (std::isnan(c) && n != 1.5)
    throw std::invalid_argument("needs c: Hertz's stiffness from the bodies holds for n = 1.5 only");
  HuntCrossleyModel out = *this;
  if (map) out.b = hunt_crossley_nu(restitution) / at_speed;
  out.restitution = out.at_speed = left_out;
  return out;
}

double HuntCrossleyModel::restitution_at(const Pair&, double speed) const {
  return hunt_crossley_restitution(completed().b * speed);
}

Event HuntCrossleyModel::strike(const Pair& pair, double speed, int samples) const {
  const HuntCrossleyModel law = completed();
  const double n1 = n + 1, stiff = stiffness(pair), damp = law.b, nu = damp * speed;
  // Below this b^2 leaves the range of numbers, and 1 - k is 1e-100.
  const bool elastic = nu < 1e-100;
  const double g0 = elastic ? 0 : bend(nu), energy = elastic ? 0.5 * speed * speed : g0 / (damp * damp);
  const double largest = std::pow(n1 * pair.mass * energy / stiff, 1 / n1);
  // 1 - (x/x_max)^(n+1) at s.
  const auto share = [=](double s) { return -std::expm1(n1 * std::log1p(-s * s)); };
  const auto speed_in = [=](double s) { return elastic ? speed * std::sqrt(share(s)) : rate_in(g0 * share(s)) / damp; };
  const auto speed_out = [=](double s) {
    return elastic ? speed * std::sqrt(share(s)) : rate_out(g0 * share(s)) / damp;
  };
  const double shape = n;
  const auto force = [=](double x, double v) { return stiff * std::pow(std::fmax(x, 0.0), shape) * (1 + damp * v); };
  const Phase in{largest, 0, speed_in, force}, out{largest, 0, speed_out, force};

  Event event;
  event.rebounds(pair.mass, speed, elastic ? speed : hunt_crossley_restitution(nu) * speed);
  event.largest = largest;
  follow(event, in, &out, samples);
  const double w = elastic ? 0 : rate_at_peak(g0, n);
  const double x_peak = elastic ? largest : std::pow(n * pair.mass * w / (damp * damp * stiff), 1 / n1);
  event.peak_force = stiff * std::pow(x_peak, n) * (1 + w);
  event.peak_time = time_between(in, in.place_of(x_peak), 1);
  return event;
}

}  // namespace subsoil::dem::impact
