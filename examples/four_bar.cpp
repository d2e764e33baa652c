// A crank-rocker without friction: the joints stay closed and the energy stays, for ten turns of the crank.
#include <cmath>
#include <cstdio>

#include "libmbd/joints/revolute.hpp"
#include "libmbd/machine.hpp"

using namespace subsoil::mbd;

int main() {
  Model model;
  model.gravity = {0, 0};
  const auto rod = [&](const char* name, double x0, double y0, double x1, double y1, double spin) {
    const double length = std::hypot(x1 - x0, y1 - y0), angle = std::atan2(y1 - y0, x1 - x0);
    return model.add({.name = name,
                      .mass = length,
                      .inertia = length * length * length / 12,
                      .pose = {(x0 + x1) / 2, (y0 + y1) / 2, angle},
                      .velocity = {-spin * (y0 + y1) / 2, spin * (x0 + x1) / 2, spin}});
  };
  // Ground pins at (0, 0) and (4, 0); crank 1 m upright, rocker 3 m, coupler between them.
  const double x = 4 - 1.0, y = std::sqrt(9 - 1.0);
  const int crank = rod("crank", 0, 0, 0, 1, 5), coupler = rod("coupler", 0, 1, x, y, 0),
            rocker = rod("rocker", 4, 0, x, y, 0);
  const double l2 = std::hypot(x, y - 1);
  model.add("O", Revolute{.body_a = 0, .body_b = crank, .p_a = {0, 0}, .p_b = {-0.5, 0}});
  model.add("A", Revolute{.body_a = crank, .body_b = coupler, .p_a = {0.5, 0}, .p_b = {-l2 / 2, 0}});
  model.add("B", Revolute{.body_a = coupler, .body_b = rocker, .p_a = {l2 / 2, 0}, .p_b = {1.5, 0}});
  model.add("C", Revolute{.body_a = 0, .body_b = rocker, .p_a = {4, 0}, .p_b = {-1.5, 0}});
  Machine machine(model);
  machine.start_from_pose();

  const double energy = machine.energy().kinetic;
  double gap = 0;
  for (int i = 0; i < 12000; ++i) {
    machine.advance(1e-3);
    const BodyState &a = machine.body(coupler), &b = machine.body(rocker);
    const Vec2 from = a.point_in_world({l2 / 2, 0}), to = b.point_in_world({1.5, 0});
    gap = std::max(gap, std::hypot(from.x - to.x, from.y - to.y));
  }
  std::printf("crank turned %.2f times, joint open by %.1e m, energy %.6f of %.6f J\n",
              machine.body(crank).angle / (2 * M_PI), gap, machine.energy().kinetic, energy);
  return gap < 1e-6 && std::abs(machine.energy().kinetic / energy - 1) < 1e-4 ? 0 : 1;
}
