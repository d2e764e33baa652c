#include "coupling/servo.hpp"

#include <algorithm>
#include <cmath>

namespace subsoil::coupling {

void ServoState::advance(const Servo& servo, const dem::Vec3& force_of_spheres, double time, double dt) {
  force = -dem::dot(force_of_spheres, servo.along);
  load = servo.load(time);
  if (!began) gain = servo.gain;
  const double now = load - force, rate = began ? (now - error) / dt : 0;
  const double wished = gain * now + servo.integral_gain * (integral + now * dt) + servo.rate_gain * rate;
  const double share = servo.lag > 0 ? -std::expm1(-dt / servo.lag) : 1;
  velocity += share * (std::clamp(wished, -servo.limit, servo.limit) - velocity);
  // At the limit the integral may only leave it.
  if (std::abs(wished) <= servo.limit || now * wished < 0) integral += now * dt;
  travel += velocity * dt;
  error = now, began = true;
}

}  // namespace subsoil::coupling
