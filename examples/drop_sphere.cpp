// A sphere falls on a plane and bounces: the coefficient of restitution comes out as it went in.
#include <cmath>
#include <cstdio>
#include <span>

#include "libdem/bed.hpp"
#include "libdem/laws/linear.hpp"

using namespace subsoil::dem;

int main() {
  Linear law;
  law.k_n = 1e5;          // N/m
  law.restitution = 0.6;  // speed after over speed before
  Bed bed({.materials = 1, .index = {0}, .laws = {law}}, {.gravity = {0, 0, 0}, .threads = 1});
  const SphereSpec ball{
      .position = {0, 0.0101, 0}, .velocity = {0, -1, 0}, .angular_velocity = {}, .radius = 0.01, .density = 2500};
  bed.add(std::span(&ball, 1));
  Boundary floor;
  floor.shape = Plane({0, 0, 0}, {0, 1, 0});
  bed.add(std::move(floor));

  for (int i = 0; i < 2000; ++i) bed.step(1e-6);
  const double out = bed.spheres()[0].v.y;
  std::printf("restitution: %.5f in, %.5f out\n", 0.6, out);
  return std::abs(out - 0.6) < 1e-3 ? 0 : 1;  // second order in the step: 400 steps in contact
}
