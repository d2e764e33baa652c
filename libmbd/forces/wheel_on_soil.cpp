#include "libmbd/forces/wheel_on_soil.hpp"

#include <boost/math/special_functions/beta.hpp>
#include <cmath>

namespace subsoil::mbd {

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
