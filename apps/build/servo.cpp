#include "apps/build/servo.hpp"

#include <algorithm>
#include <cmath>

namespace subsoil::app {

double shown_area(const dem::Shape& shape, const Vec3& along) {
  double area = 0;
  for (const dem::TriangleMesh& mesh : dem::drawing(shape, 1.0)) {
    const double sides = mesh.closed() ? 0.5 : 1;  // a solid is seen from behind, too
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t)
      area += 0.5 * sides *
              std::abs(dem::dot(along, dem::area_vector(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2))));
  }
  return area;
}

namespace {

double largest_load(const coupling::Servo& servo, double end) {
  constexpr int samples = 4000;  // of a run
  double most = 0;
  for (int k = 0; k <= samples; ++k) most = std::max(most, std::abs(servo.load(end * k / samples)));
  return most;
}

}  // namespace

coupling::Servo servo_of(const ServoSection& s, const dem::Boundary& boundary, double end, const std::string& place) {
  coupling::Servo out;
  out.along = dem::normalized(s.along);
  out.lag = s.lag.value_or(-1);
  out.limit = s.limit, out.integral_gain = s.integral, out.rate_gain = s.rate;
  if (s.load.is_set()) {
    out.load = [load = s.load](double t) { return load.value(t); };
  } else {
    if (std::holds_alternative<dem::Plane>(boundary.shape))
      throw ScenarioError(place + ".pressure: a plane has no end, so no area; give `load` in N, or a box");
    const Vec3 own = boundary.pose.attitude.conjugate().rotate(out.along);
    out.load = [pressure = s.pressure, area = shown_area(boundary.shape, own)](double t) {
      return area * pressure.value(t);
    };
  }
  if (s.gain) {
    out.gain = *s.gain;
    return out;
  }
  const double most = largest_load(out, end);
  if (!(most > 0))
    throw ScenarioError(place + ": the load is zero at all times, so that no gain follows from it; give `gain`");
  out.gain = s.limit / most;
  return out;
}

}  // namespace subsoil::app
