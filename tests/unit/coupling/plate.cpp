#include <gtest/gtest.h>

#include "coupling/simulation.hpp"
#include "libdem/geometry/mesh_builders.hpp"
#include "tests/tools/dem_beds.hpp"

namespace subsoil::coupling::test::plate {
namespace {

/// A free plate of known weight sinks into a bed and comes to rest: the contacts carry its weight, their moment about
/// its centre of mass is zero, and the bin carries both. Means over 20 ms, in which what little still swings averages
/// out; the bounds are a thousandth of the weight, and of the weight at a quarter of the plate's width.
TEST(Plate, RestsOnTheBedWithItsWeightAndWithoutMoment) {
  const double size = 0.07, mass = 2, step = 5e-5, g = 9.81;
  dem::Bed bed(dem::test::table(dem::test::grains(5e4, 0.1, 0.4, 0.1)), dem::test::quiet({0, -g, 0}));
  dem::test::Dice dice(5);
  bed.add(dem::test::loose_lattice({0.001, 0, 0.001}, 5, 3, 5, 0.0202, 0.01, 0.1, 0, dice));
  dem::test::add_bin(bed, 0.103, 0.103);
  const int walls = bed.boundary_count();
  dem::Boundary b;
  b.shape = dem::MeshSurface(dem::box_mesh({size, 0.01, size}, {0, 0, 0.0515}));
  const int plate = bed.add(std::move(b));
  mbd::Model model;
  const int body =
      model.add({.name = "plate", .mass = mass, .inertia = mass * size * size / 12, .pose = {0.0515, 0.067, 0}});
  mbd::Machine machine(model);
  machine.start_from_pose();
  Simulation simulation(&bed, &machine, {{body, plate}}, {}, {.soil_step = step, .soil_steps = 2});
  dem::Wrench on_plate, on_bin;
  const long steps = 40000, last = 400;
  for (long n = 0; n < steps; ++n) {
    simulation.step();
    if (n < steps - last) continue;
    on_plate += simulation.soil_on_body(body) * (1.0 / last);
    for (int w = 0; w < walls; ++w) on_bin += bed.boundary(w).wrench * (1.0 / last);
  }
  double soil = 0;
  for (const dem::Sphere& s : bed.spheres()) soil += s.m;
  EXPECT_GE(bed.boundary(plate).contacts, 3);
  EXPECT_LT(machine.body(body).r.y, 0.0665) << "it must have sunk";
  EXPECT_LT(mbd::length(machine.body(body).v), 1e-4);
  EXPECT_NEAR(on_plate.force.y, mass * g, 1e-3 * mass * g);
  EXPECT_NEAR(on_plate.force.x, 0, 1e-3 * mass * g);
  EXPECT_NEAR(on_plate.moment.z, 0, 1e-3 * mass * g * size / 4);
  EXPECT_NEAR(on_bin.force.y, -(mass + soil) * g, 1e-3 * mass * g);
  EXPECT_NEAR(on_bin.force.x, 0, 1e-3 * mass * g);
  // What tilts the plate out of the machine's plane is the guide's to take: reported, not zero.
  EXPECT_GT(std::abs(on_plate.moment.x), 1e-3);
}

}  // namespace
}  // namespace subsoil::coupling::test::plate
