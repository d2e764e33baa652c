#include "libmbd/forces/wheel_on_soil.hpp"

#include <boost/math/special_functions/beta.hpp>
#include <cmath>

namespace subsoil::mbd {

ForcePower WheelOnSoil::press(const BodyState& b, double z, double z_p, Loads& loads, ForceValues& values) const {
  values = {0, 0, z, z_p};
  const double sinking = -b.v.y, forward = std::hypot(b.v.x, creep);
  const double u = std::min(1.0, std::max(-1.0, -radius * sinking / (forward * std::sqrt(2 * radius * z))));
  if (!(z > z_p) || u == 1) return {};
  const double bearing = load(z) * (1 - std::copysign(boost::math::ibeta(0.5, n + 1, u * u), u));
  const double pressed = std::pow(z * (1 - u * u), n + 1) - (z_p > 0 ? std::pow(z_p, n + 1) : 0.0);
  const double resistance = width * modulus() * std::max(pressed, 0.0) / (n + 1), along = resistance * fading(b);
  loads.add_wrench(body, -along, bearing, 0);
  values = {bearing, resistance, z, z_p};
  return {0, bearing * sinking + along * b.v.x, 0};
}

}  // namespace subsoil::mbd
