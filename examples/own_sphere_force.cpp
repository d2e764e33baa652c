// A force of one's own on every sphere: grains settle in water. Buoyancy and Stokes' drag act beside gravity and
// contacts; a grain falls as v(t) = v_t (1 - exp(-t/tau)), and the energy closes with the work of the force.
#include <cmath>
#include <cstdio>
#include <span>

#include "libdem/bed.hpp"
#include "libdem/laws/linear.hpp"

namespace mine {
using namespace subsoil::dem;

/// F = -6 pi eta r v - rho V g, M = -8 pi eta r^3 w (Stokes); eta viscosity, Pa s; rho density of the fluid, kg/m3.
struct Fluid {
  double eta = 0, rho = 0;
  Vec3 g{};
  Wrench operator()(const SphereAt& s) const {
    const double r = s.radius;
    return {(-6 * M_PI * eta * r) * s.velocity - (rho * sphere_volume(r)) * g,
            (-8 * M_PI * eta * r * r * r) * s.angular_velocity};
  }
};
}  // namespace mine

int main() {
  using namespace subsoil::dem;
  const Vec3 g{0, -9.81, 0};
  const double radius = 1e-4, density = 2650, mass = density * sphere_volume(radius);
  const mine::Fluid water{.eta = 1e-3, .rho = 1000, .g = g};
  const double tau = mass / (6 * M_PI * water.eta * radius), fall = (1 - water.rho / density) * 9.81 * tau;

  Linear law;
  law.k_n = 10, law.restitution = 0.5, law.friction.mu = 0.4;
  Bed bed({.materials = 1, .index = {0}, .laws = {law}}, {.gravity = g, .threads = 1});
  bed.add_force("water", water);
  const SphereSpec grain{
      .position = {0, 0.003, 0}, .velocity = {}, .angular_velocity = {}, .radius = radius, .density = density};
  bed.add(std::span(&grain, 1));
  Boundary floor;
  floor.shape = Plane({0, 0, 0}, {0, 1, 0});
  bed.add(std::move(floor));

  const double dt = 2e-6, until = 2 * tau;
  while (bed.time() < until) bed.step(dt);
  const double speed = -bed.spheres()[0].v.y, exact = fall * (1 - std::exp(-(bed.time() - 0.5 * dt) / tau));
  std::printf("speed after 2 tau: %.6f mm/s (exact %.6f)\n", 1e3 * speed, 1e3 * exact);

  while (bed.time() < 1) bed.step(dt);  // to the bottom, and to rest there
  bed.step(dt, {.energy = true});
  const BedEnergy& e = bed.energy();
  const double height = grain.position.y - bed.spheres()[0].x.y, weight = mass * 9.81 * height;
  std::printf("of the weight's work %.3e J the water took %.4f, contacts %.1e; gap %.1e\n", weight,
              -e.force_work / weight, e.lost.total() / weight, (e.total() - e.work() - mass * 9.81 * 0.003) / weight);
  const bool closes = std::abs(e.total() - e.work() - mass * 9.81 * 0.003) < 1e-3 * weight;
  return std::abs(speed / exact - 1) < 1e-5 && closes && -e.force_work > 0.9 * weight ? 0 : 1;
}
