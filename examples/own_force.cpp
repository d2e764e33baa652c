// A force of one's own: a body falls around a centre by F = -mu m r/|r|^3. After Kepler's period it is back at its
// start.
#include "libmbd/forces/own_force.hpp"

#include <cmath>
#include <cstdio>

#include "libmbd/machine.hpp"

namespace mine {
using namespace subsoil::mbd;

/// Attraction by a point of the world: F = -mu m r/|r|^3, stored = -mu m/|r|; mu m3/s2, m kg.
struct Attraction {
  static constexpr ForceMembers has{.check = true};
  static constexpr std::array<ForceColumn, 2> columns{{{"force", "N"}, {"distance", "m"}}};
  int body = -1;
  double mu = 0, mass = 0;

  void check() const {
    if (!(mu > 0 && mass > 0)) throw std::invalid_argument("mu and mass must be above 0");
  }
  ForcePower evaluate(const Scene& scene, Loads& loads, ForceValues& values) const {
    const Vec2 r = scene.bodies[static_cast<std::size_t>(body)].r;
    const double distance = length(r), force = mu * mass / (distance * distance);
    loads.add(body, {0, 0}, (-force / distance) * r);
    values = {force, distance};
    return {.stored = -mu * mass / distance};
  }
};
}  // namespace mine

int main() {
  using namespace subsoil::mbd;
  const double mu = 4, mass = 2, start = 1, speed = 2.4;
  Model model;
  model.gravity = {0, 0};
  const int moon =
      model.add({.name = "moon", .mass = mass, .inertia = 0.1, .pose = {start, 0, 0}, .velocity = {0, speed, 0}});
  model.add("attraction", OwnForce(mine::Attraction{.body = moon, .mu = mu, .mass = mass}));
  Machine machine(model, {.integrator = IntegratorKind::cvode, .cvode = {.rtol = 1e-10, .atol = 1e-12}});
  machine.start_from_pose();

  const double axis = 1 / (2 / start - speed * speed / mu);  // of the ellipse, by its energy
  const double period = 2 * M_PI * std::sqrt(axis * axis * axis / mu);
  machine.advance_to(0.5 * period);
  const double far = machine.force_value("attraction", "distance"), farthest = 2 * axis - start;
  machine.advance_to(period);
  const BodyState& end = machine.body(moon);
  std::printf("farthest %.6f m (exact %.6f), after a period at (%.6f, %.6f) m, energy balance %.1e J\n", far, farthest,
              end.r.x, end.r.y, machine.energy().balance());
  const bool there = std::hypot(end.r.x - start, end.r.y) < 1e-6 && std::abs(far - farthest) < 1e-6;
  return there && std::abs(machine.energy().balance()) < 1e-6 ? 0 : 1;
}
