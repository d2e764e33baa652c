// A box falls on a bed and is watched: an observer in the loop writes its height and the soil's force. At rest the soil
// bears its weight.
#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

#include "coupling/simulation.hpp"
#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/laws/linear.hpp"
#include "libmbd/joints/translational.hpp"

using namespace subsoil;

int main() {
  dem::Linear law;
  law.k_n = 2e4, law.restitution = 0.2, law.friction.mu = 0.5;
  dem::Bed bed({.materials = 1, .index = {0}, .laws = {law}}, {.gravity = {0, -9.81, 0}});
  std::vector<dem::SphereSpec> spheres;
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 8; ++k)
        spheres.push_back({.position = {0.01 + 0.02 * i, 0.01 + 0.02 * j, -0.07 + 0.02 * k},
                           .velocity = {},
                           .angular_velocity = {},
                           .radius = 0.01,
                           .density = 2000});
  bed.add(spheres);
  const auto wall = [&](dem::Vec3 point, dem::Vec3 normal) {
    dem::Boundary b;
    b.shape = dem::Plane(point, normal);
    bed.add(std::move(b));
  };
  wall({0, 0, 0}, {0, 1, 0}), wall({0, 0, 0}, {1, 0, 0}), wall({0.16, 0, 0}, {-1, 0, 0});
  wall({0, 0, -0.08}, {0, 0, 1}), wall({0, 0, 0.08}, {0, 0, -1});
  dem::Boundary face;
  face.shape = dem::MeshSurface(dem::box_mesh({0.1, 0.04, 0.1}));
  const int boundary = bed.add(std::move(face));

  mbd::Model model;
  model.gravity = {0, -9.81};
  const double mass = 0.5;
  const int box = model.add({.name = "box", .mass = mass, .inertia = 1e-3, .pose = {0.08, 0.1, 0}});
  mbd::Machine machine(model);
  machine.start_from_pose();
  coupling::Simulation simulation(&bed, &machine, {{box, boundary}}, {}, {.soil_step = 2e-5});

  std::vector<std::function<void(const coupling::Simulation&)>> observers;
  double mean = 0;
  int samples = 0;
  observers.push_back([&](const coupling::Simulation& s) {
    if (s.time() < 0.5) return;
    mean += s.soil_on_body(box).force.y, ++samples;
  });
  while (simulation.time() < 1) {
    simulation.step();
    for (const auto& observe : observers) observe(simulation);
  }
  mean /= samples;
  std::printf("the soil bears %.3f N of %.3f N, the box rests at y = %.1f mm\n", mean, mass * 9.81,
              1e3 * machine.body(box).r.y);
  return std::abs(mean / (mass * 9.81) - 1) < 0.01 ? 0 : 1;
}
