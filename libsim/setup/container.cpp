#include "libsim/setup/container.hpp"

#include "libdem/particles/fixed.hpp"
#include "libsim/setup/moving_soil.hpp"

namespace subsoil::sim {

std::size_t spheres_beyond(const Faces& faces, const Scenario& scenario, const World& world, const Faces& except) {
  if (!scenario.soil || !scenario.soil->container) return 0;
  const Container& c = *scenario.soil->container;
  Vec3 corner = c.at + Vec3{0, world.container_shift, 0};
  double held = 0;  // its walls stand that far beyond a moving window
  if (world.moving) {
    corner.x += world.moving->window.plan().direction * world.moving->window.way();
    held = world.moving->window.held_length();
  }
  const dem::PeriodicCell& cell = world.bed->options().periodic;
  std::size_t count = 0;
  for (const dem::Sphere& p : world.bed->spheres()) {
    if (world.moving && dem::is_fixed(p)) continue;
    const Vec3 d = cell.wrapped(p.x) - corner;
    const auto outside = [&](const Faces& of) {
      return (of[0] && d.x < -held) || (of[1] && d.x > c.size.x + held) || (of[2] && d.y < 0) ||
             (of[3] && d.y > c.size.y) || (of[4] && d.z < 0) || (of[5] && d.z > c.size.z);
    };
    count += outside(faces) && !outside(except);
  }
  return count;
}

}  // namespace subsoil::sim
