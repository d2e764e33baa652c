// A tine on a given path through a small bed: draft, and Newton's law for the whole bed.
#include <cstdio>
#include <vector>

#include "libdem/bed.hpp"
#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/laws/linear.hpp"

using namespace subsoil::dem;

int main() {
  Linear law;
  law.k_n = 2e4, law.restitution = 0.4, law.friction.mu = 0.5;
  Bed bed({.materials = 1, .index = {0}, .laws = {law}}, {.gravity = {0, -9.81, 0}});
  std::vector<SphereSpec> spheres;
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 6; ++j)
      for (int k = 0; k < 8; ++k)
        spheres.push_back({.position = {0.011 + 0.0205 * i + 0.001 * (j % 2), 0.011 + 0.0205 * j, 0.011 + 0.0205 * k},
                           .velocity = {},
                           .angular_velocity = {},
                           .radius = 0.01,
                           .density = 2000});
  bed.add(spheres);
  const auto wall = [&](Vec3 point, Vec3 normal) {
    Boundary b;
    b.shape = Plane(point, normal);
    bed.add(std::move(b));
  };
  wall({0, 0, 0}, {0, 1, 0}), wall({0, 0, 0}, {1, 0, 0}), wall({0.42, 0, 0}, {-1, 0, 0});
  wall({0, 0, 0}, {0, 0, 1}), wall({0, 0, 0.166}, {0, 0, -1});
  Boundary tine;
  tine.shape = MeshSurface(box_mesh({0.01, 0.1, 0.05}));
  tine.pose.position = {-0.02, 0.1, 0.083};
  const int index = bed.add(std::move(tine));

  const double dt = 2e-5, speed = 0.5;
  for (double t = 0; t < 0.3; t += dt) bed.step(dt);  // to rest; the tine stands outside
  double draft = 0, path = 0;
  while (path < 0.2) {
    Boundary& b = bed.boundary(index);  // its pose is that of t_n, its velocity that of t_n - dt/2
    b.velocity = {speed, 0, 0};
    bed.step(dt);
    b.pose.position.x += speed * dt;
    path += speed * dt;
    if (path > 0.1) draft -= bed.boundary(index).wrench.force.x * dt * speed / 0.1;
  }
  const double weight = 960 * 2000 * 4.19e-6 * 9.81;
  std::printf("mean draft %.1f N on the second half of the path; the bed weighs %.0f N\n", draft, weight);
  return draft > 0.02 * weight && draft < 2 * weight && bed.removed_count() == 0 ? 0 : 1;
}
