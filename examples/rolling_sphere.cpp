// A sphere set down sliding on a rough plane ends rolling at 5/7 of its speed, whatever the friction.
#include <cmath>
#include <cstdio>
#include <span>

#include "libdem/bed.hpp"
#include "libdem/laws/linear.hpp"

using namespace subsoil::dem;

int main() {
  Linear law;
  law.k_n = 1e6, law.restitution = 0.3, law.friction.mu = 0.4;
  Bed bed({.materials = 1, .index = {0}, .laws = {law}}, {.gravity = {0, -9.81, 0}, .threads = 1});
  const double radius = 0.05;
  const SphereSpec ball{
      .position = {0, radius, 0}, .velocity = {1, 0, 0}, .angular_velocity = {}, .radius = radius, .density = 2500};
  bed.add(std::span(&ball, 1));
  Boundary floor;
  floor.shape = Plane({0, 0, 0}, {0, 1, 0});
  bed.add(std::move(floor));

  for (int i = 0; i < 20000; ++i) bed.step(1e-5);  // it slides for 2 v / (7 mu g) = 73 ms
  const Sphere& s = bed.spheres()[0];
  std::printf("v = %.5f m/s (5/7 = %.5f), r omega = %.5f m/s\n", s.v.x, 5.0 / 7, -radius * s.w.z);
  return std::abs(s.v.x - 5.0 / 7) < 1e-3 && std::abs(s.v.x + radius * s.w.z) < 1e-3 ? 0 : 1;
}
