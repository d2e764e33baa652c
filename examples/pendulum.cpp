// A rod swings about a pin: its period at 60 degrees is that of the complete elliptic integral, its energy stays.
#include <cmath>
#include <cstdio>

#include "libmbd/joints/revolute.hpp"
#include "libmbd/machine.hpp"

using namespace subsoil::mbd;

int main() {
  const double length = 1, mass = 2, g = 9.81, start = M_PI / 3;
  Model model;
  model.gravity = {0, -g};
  const double angle = start - M_PI / 2;  // of the rod from the world's x
  const int rod = model.add({.name = "rod",
                             .mass = mass,
                             .inertia = mass * length * length / 12,
                             .pose = {length / 2 * std::cos(angle), length / 2 * std::sin(angle), angle}});
  model.add("pin", Revolute{.body_a = 0, .body_b = rod, .p_a = {0, 0}, .p_b = {-length / 2, 0}});
  Machine machine(model);
  machine.start_from_pose();

  double period = 0, before = 0;
  while (period == 0) {
    before = machine.body(rod).omega;
    machine.advance(1e-4);
    const double omega = machine.body(rod).omega;
    if (before > 0 && omega <= 0) period = machine.time();  // back at the start: omega falls through 0 from above
  }
  const double exact = 4 * std::sqrt(2 * length / (3 * g)) * std::comp_ellint_1(std::sin(start / 2));
  std::printf("period %.4f s (exact %.4f), energy balance %.1e J\n", period, exact, machine.energy().balance());
  return std::abs(period - exact) < 2e-4 && std::abs(machine.energy().balance()) < 1e-4 ? 0 : 1;
}
