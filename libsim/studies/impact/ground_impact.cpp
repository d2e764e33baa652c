#include "libsim/studies/impact/ground_impact.hpp"

#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <cstdint>

namespace subsoil::sim {

dem::impact::Event GroundImpact::strike(const dem::impact::Pair& pair, double speed, int samples) const {
  const double m = pair.mass, both = m * (1 + share), v0 = speed / (1 + share), weight = m * gravity;
  const double energy = 0.5 * both * v0 * v0;
  const auto force = [&](double z) { return mbd::plastic_force(stiffness, z, speed, m); };
  // Panels that shrink towards the surface, where F ~ z^(alpha + 1) bends: z = to (u)^2.
  const auto work = [&](double from, double to) {
    double sum = 0;
    constexpr int panels = 8;
    const double low = std::sqrt(from), high = std::sqrt(to);
    for (int k = 0; k < panels; ++k)
      sum += boost::math::quadrature::gauss<double, 15>::integrate([&](double u) { return 2 * u * force(u * u); },
                                                                   low + (high - low) * k / panels,
                                                                   low + (high - low) * (k + 1) / panels);
    return sum;
  };
  double high = 1e-6;
  while (work(0, high) - weight * high < energy) high *= 2;
  std::uintmax_t turns = 100;
  const auto [a, b] =
      boost::math::tools::toms748_solve([&](double z) { return z > 0 ? work(0, z) - weight * z - energy : -energy; },
                                        0.0, high, boost::math::tools::eps_tolerance<double>(50), turns);
  const double deepest = 0.5 * (a + b);
  const double on_body = m / both, follower_weight = share * weight;
  const dem::impact::Phase in{deepest, 0,
                              [&](double s) {
                                const double z = deepest * (1 - s * s);
                                return std::sqrt(2 / both * (work(z, deepest) - weight * (deepest - z)));
                              },
                              [&](double z, double) { return on_body * (force(z) + follower_weight); }};
  dem::impact::Event event;
  event.rebounds(m, speed, 0);
  event.largest = deepest;
  event.at_touch = 0.5 * m * speed * (speed - v0);
  event.in_ground = work(0, deepest);
  follow(event, in, nullptr, samples);
  event.peak_force = in.force(deepest, 0), event.peak_time = event.time_in;
  return event;
}

}  // namespace subsoil::sim
