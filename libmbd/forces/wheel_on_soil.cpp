#include "libmbd/forces/wheel_on_soil.hpp"

#include <boost/math/special_functions/beta.hpp>
#include <cmath>

namespace subsoil::mbd {

/// Traction; returns the power that it loses (W).
double WheelOnSoil::shear(const BodyState& b, double z, Loads& loads, ForceValues& values) const {
  if (!(values[0] > 0)) return 0;
  const double patch = std::sqrt(2 * radius * z), rim = std::abs(radius * b.omega), sliding = b.v.x + radius * b.omega;
  const double strength = width * patch * cohesion + values[0] * std::tan(internal_friction);
  const double x = patch * std::abs(sliding) / (std::hypot(rim, slow) * shear_displacement);  // j/K
  // Its series where both terms are nearly 1.
  const double share = x < 1e-4 ? x / 2 - x * x / 6 : 1 + std::expm1(-x) / x;
  const double traction = -std::copysign(strength * share, sliding);
  loads.add_wrench(body, traction, 0, radius * traction);
  const double forward = b.v.x - radius * b.omega >= 0 ? 1 : -1;
  values[4] = traction, values[5] = -forward * sliding / std::max({rim, std::abs(b.v.x), slow});
  return -traction * sliding;
}

ForcePower WheelOnSoil::press(const BodyState& b, double z, double z_p, Loads& loads, ForceValues& values) const {
  values = {0, 0, z, z_p};
  if (!(z > z_p)) return {};
  const double sinking = -b.v.y, forward = std::hypot(b.v.x, creep);
  const double u = -radius * sinking / (forward * std::sqrt(2 * radius * z));
  const double from = u * u, to = 1 - z_p / z;  // squares of parts of the arc's length
  if (u > 0 && from >= to) return {};
  const auto below = [&](double square) { return square < 1 ? boost::math::ibeta(0.5, n + 1, square) : 1; };
  const double bearing = load(z) * (below(to) - std::copysign(below(std::min(from, to)), u));
  const double pressed = std::pow(z * (1 - std::min(from, to)), n + 1) - (z_p > 0 ? std::pow(z_p, n + 1) : 0.0);
  const double resistance = width * modulus() * std::max(pressed, 0.0) / (n + 1), along = resistance * fading(b);
  loads.add_wrench(body, -along, bearing, 0);
  values = {bearing, resistance, z, z_p};
  return {0, bearing * sinking + along * b.v.x, 0};
}

}  // namespace subsoil::mbd
