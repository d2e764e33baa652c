#include "libdem/impact/jkr.hpp"

#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace subsoil::dem::impact {
namespace {

constexpr double pi = std::numbers::pi;

/// The branch of contact in units of a_0, in which x = 0: with y = (a/a_0)^(1/2),
///   x = (a_0^2/R) (y^4 - y),   F = 2 pi w R (4/3 y^6 - 2 y^3),   U = 2 pi w a_0^2 (8/15 y^10 - 4/3 y^7 + y^4/2).
struct Branch {
  double length, force, energy;
  explicit Branch(const Pair& pair, double w) {
    static_cast<void>(pair.hertz());  // refuses a pair without elasticity or shape
    const double a0 = std::cbrt(2 * pi * w * pair.radius * pair.radius / pair.E_eff);
    length = a0 * a0 / pair.radius, force = 2 * pi * w * pair.radius, energy = 2 * pi * w * a0 * a0;
  }
  static constexpr double y_touch = 1;
  static inline const double y_rupture = std::cbrt(0.25);  // a_f = a_0/4^(2/3)
  double x(double y) const { return length * y * (y * y * y - 1); }
  double f(double y) const { return force * y * y * y * (4.0 / 3.0 * y * y * y - 2); }
  double u(double y) const {
    const double y3 = y * y * y;
    return energy * y3 * y * (8.0 / 15.0 * y3 * y3 - 4.0 / 3.0 * y3 + 0.5);
  }
  /// y at an indentation: the outer root of y^4 - y = x/length, by Newton from above, where the curve is convex.
  double at(double wanted) const {
    const double q = wanted / length;
    double y = std::fmax(1.0, q > 0 ? std::pow(q, 0.25) + 1 : 1.0);
    for (int k = 0; k < 60; ++k) {
      const double slope = 4 * y * y * y - 1;
      if (!(slope > 1e-9)) break;
      const double step = (y * (y * y * y - 1) - q) / slope;
      y = std::fmax(y - step, y_rupture);
      if (std::abs(step) < 1e-16 * y) break;
    }
    return y;
  }
};

}  // namespace

double Jkr::pull_off(const Pair& pair) const { return 1.5 * pi * w * pair.radius; }
double Jkr::rupture(const Pair& pair) const { return Branch(pair, w).x(Branch::y_rupture); }
double Jkr::force(const Pair& pair, double x) const {
  const Branch branch(pair, w);
  return branch.f(branch.at(x));
}

double Jkr::sticking_speed(const Pair& pair) const {
  const Branch b(pair, w);
  return std::sqrt(2 / pair.mass * (b.u(Branch::y_rupture) - b.u(Branch::y_touch)));
}

double Jkr::restitution_at(const Pair& pair, double speed) const {
  const double share = sticking_speed(pair) / speed;
  return share >= 1 ? 0 : std::sqrt((1 - share) * (1 + share));
}

Event Jkr::strike(const Pair& pair, double speed, int samples) const {
  const Branch b(pair, w);
  const double mass = pair.mass, start = b.u(Branch::y_touch), energy = 0.5 * mass * speed * speed;
  double high = 2;
  while (b.u(high) - start < energy) high *= 2;
  std::uintmax_t turns = 200;
  const auto [low_y, high_y] =
      boost::math::tools::toms748_solve([&](double y) { return b.u(y) - start - energy; }, Branch::y_touch, high,
                                        boost::math::tools::eps_tolerance<double>(52), turns);
  const double y_turn = 0.5 * (low_y + high_y), largest = b.x(y_turn);
  const auto speed_at = [=](double x) { return std::sqrt(std::fmax(0.0, 2 / mass * (b.u(y_turn) - b.u(b.at(x))))); };
  const auto force_at = [=](double x, double) { return b.f(b.at(x)); };
  const double end = b.x(Branch::y_rupture);
  const Phase in{largest, 0, [=](double s) { return speed_at(largest * (1 - s * s)); }, force_at};
  const Phase out{largest, end, [=](double s) { return speed_at(largest + (end - largest) * s * s); }, force_at};
  Event event;
  event.rebounds(mass, speed, restitution_at(pair, speed) * speed);
  event.largest = largest;
  event.peak_force = b.f(y_turn);
  follow(event, in, event.rebound > 0 ? &out : nullptr, samples);
  event.peak_time = event.time_in;
  return event;
}

}  // namespace subsoil::dem::impact
