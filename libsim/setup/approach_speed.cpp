#include "libsim/setup/approach_speed.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libmbd/elements.hpp"

namespace subsoil::sim {
namespace {

constexpr int kSamples = 4000;  ///< of a run

/// Farthest that a point of a surface in its own axes lies from `from`, m; 0 of a plane, which has no farthest point.
double reach_from(const dem::Bounds& box, const Vec3& from) {
  const double far = box.farthest(from);
  return std::isfinite(far) ? far : 0;
}

/// Moves of a boundary add up: at most the sum of what each gives its farthest point.
double fastest(const BoundarySection& b, const dem::Boundary& made, double end) {
  double most = 0;
  for (int k = 0; k <= kSamples; ++k) {
    const double t = end * k / kSamples;
    double speed = b.servo ? b.servo->limit : 0;
    for (const Move& m : b.moves) {
      if (t < m.from || t > m.until) continue;
      const Vec3 about = m.about ? *m.about : made.pose.position;
      const double reach = dem::norm(m.spin) > 0 ? reach_from(dem::bounds(made.shape), made.pose.to_local(about)) : 0;
      speed += std::abs(m.profile.value(t)) * (dem::norm(m.velocity) + dem::norm(m.spin) * reach);
    }
    most = std::max(most, speed);
  }
  return most;
}

/// The machine's surfaces as it starts, and what its drivers ask for at any time.
double fastest(const MachineSection& machine, const World& world, double end) {
  double most = machine.start.speed, reach = 0;
  for (const SurfaceRecord& r : world.surfaces) {
    if (r.owner != SurfaceRecord::Owner::machine) continue;
    const double far = reach_from(dem::bounds(world.bed->boundary(r.boundary).shape), {});
    const mbd::BodyState& body = world.machine->body(r.body);
    most = std::max(most, std::hypot(body.v.x, body.v.y) + std::abs(body.omega) * far);
    reach = std::max(reach, far);
  }
  for (const NamedDriver& d : machine.drivers)
    visit(
        [&](const auto& driver) {
          const double lever = driver.angular() ? reach : 1;
          for (int k = 0; k <= kSamples; ++k)
            most = std::max(most, lever * std::abs(driver.motion.rate(end * k / kSamples)));
        },
        d.element);
  return most;
}

/// The longest free fall in a box with these edges, m.
double fall_through(const Vec3& room, const Vec3& gravity) {
  double longest = std::numeric_limits<double>::infinity();
  for (int d = 0; d < 3; ++d)
    if (gravity[d] != 0)
      longest = std::min(longest, std::max(0.0, room[d]) * (dem::norm(gravity) / std::abs(gravity[d])));
  return std::isfinite(longest) ? longest : 0;
}

/// Of its spheres where they have fallen from the inlet's upper side to the container's floor, wherever gravity leads.
double speed_below(const InletSection& inlet, const Soil& soil, const Vec3& gravity) {
  Vec3 room{};
  for (int d = 0; d < 3 && soil.container; ++d) {
    const Container& c = *soil.container;
    const double at = inlet.box ? inlet.box->at[d] : inlet.disk->at[d], size = inlet.box ? inlet.box->size[d] : 0;
    room[d] = gravity[d] > 0 ? c.at[d] + c.size[d] - at : at + size - c.at[d];
  }
  return std::sqrt(dem::dot(inlet.velocity, inlet.velocity) + 2 * dem::norm(gravity) * fall_through(room, gravity));
}

}  // namespace

double expected_speed(const Scenario& s, const World& world) {
  const double end = s.time.end > 0 ? s.time.end : 0;  // a laboratory's sample has none
  double sphere = 0, surface = 0, fall = 0;
  for (const dem::Sphere& one : world.bed->spheres()) sphere = std::max(sphere, dem::norm(one.v));
  for (const SurfaceRecord& r : world.surfaces) {
    if (r.owner != SurfaceRecord::Owner::given) continue;
    for (const BoundarySection& b : s.boundaries)
      if (b.name == r.name) surface = std::max(surface, fastest(b, world.bed->boundary(r.boundary), end));
  }
  if (s.machine && world.machine) surface = std::max(surface, fastest(*s.machine, world, end));
  if (s.soil)
    for (const InletSection& inlet : s.soil->inlets) sphere = std::max(sphere, speed_below(inlet, *s.soil, s.gravity));
  if (s.soil && s.soil->container)
    fall = std::sqrt(2 * dem::norm(s.gravity) * fall_through(s.soil->container->size, s.gravity));
  return std::max({0.1, 2 * sphere, sphere + surface, fall});
}

}  // namespace subsoil::sim
