#include <gtest/gtest.h>

#include "coupling/simulation.hpp"
#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/step/accuracy.hpp"
#include "tests/tools/dem_beds.hpp"

/// A free body and a free sphere that collide: what must be kept by both together, and what a planar body cannot take.
namespace subsoil::coupling::test::collision {
namespace {

struct Totals {
  double px = 0, py = 0, pz = 0, spin = 0, energy = 0;
};

struct Collision {
  double restitution = 1, mu = 0.3;
  dem::Shape shape = dem::MeshSurface(dem::box_mesh({0.2, 0.02, 0.06}));
  Totals start{}, end{};
  dem::Wrench impulse{};  ///< of the sphere on the body as reported, N s, N m s
  double error = 0;       ///< of the interface, J
  double balance = 0;     ///< of the machine's balance, J
  int touched = 0;        ///< steps in contact

  void run(double step) {
    const double radius = 0.01;
    dem::Bed bed(dem::test::table(dem::test::grains(2e4, restitution, mu, 0)), dem::test::quiet());
    const dem::SphereSpec ball{{0.03, 0.0215, 0.007}, {0.3, -0.8, 0}, {0, 0, 20}, radius, 12000, 0};
    bed.add(std::span(&ball, 1));
    dem::Boundary face;
    face.shape = shape;
    const int boundary = bed.add(std::move(face));
    mbd::Model model;
    model.gravity = {0, 0};
    const int body =
        model.add({.name = "box", .mass = 0.1, .inertia = 2e-4, .pose = {0, 0, 0.02}, .velocity = {-0.1, 0.4, 1.5}});
    mbd::Machine machine(model);
    machine.start_from_pose();
    Simulation simulation(&bed, &machine, {{body, boundary}}, {}, {.soil_step = step});
    const auto totals = [&] {
      const dem::Sphere& s = bed.spheres()[0];
      const mbd::BodyState& b = machine.body(body);
      const dem::Vec3 l = cross(s.x, s.m * s.v) + s.w * inertia(s);
      const double m = model.bodies[0].mass, j = model.bodies[0].inertia;
      return Totals{s.m * s.v.x + m * b.v.x, s.m * s.v.y + m * b.v.y, s.m * s.v.z,
                    l.z + m * mbd::cross(b.r, b.v) + j * b.omega,
                    0.5 * s.m * dot(s.v, s.v) + 0.5 * inertia(s) * dot(s.w, s.w) + 0.5 * m * mbd::dot(b.v, b.v) +
                        0.5 * j * b.omega * b.omega};
    };
    start = totals();
    for (double t = 0; t < 0.015; t += step) {
      simulation.step();
      touched += bed.boundary(boundary).contacts;
      impulse += simulation.soil_on_body(body) * step;
    }
    EXPECT_EQ(bed.boundary(boundary).contacts, 0) << "they must have parted";
    end = totals();
    error = simulation.interface_work().error();
    balance = machine.energy().balance();
  }
};

TEST(Collision, KeepsLinearMomentumToRounding) {
  for (const double restitution : {1.0, 0.5}) {
    Collision c{.restitution = restitution};
    c.run(2e-6);
    ASSERT_GT(c.touched, 100);
    EXPECT_GT(std::abs(c.impulse.force.y), 0.02);
    // 1e3 steps of 1e-17 kg m/s each.
    EXPECT_NEAR(c.end.px, c.start.px, 1e-14);
    EXPECT_NEAR(c.end.py, c.start.py, 1e-14);
  }
}

TEST(Collision, KeepsAngularMomentumInFirstOrder) {
  // The wrench stands about the centre of mass of t_n while the body moves on over the step: V x F h^2/2 per step.
  double before = 0;
  for (const double step : {8e-6, 4e-6, 2e-6}) {
    Collision c;
    c.run(step);
    const double gap = std::abs(c.end.spin - c.start.spin);
    EXPECT_LT(gap, 100 * step * std::abs(c.start.spin));
    if (before > 0) {
      EXPECT_NEAR(std::log2(before / gap), 1, 0.15);
    }
    before = gap;
  }
}

TEST(Collision, ElasticOneKeepsEnergyUpToTheInterfaceError) {
  Collision c{.mu = 0};
  c.run(2e-6);
  EXPECT_NEAR(c.end.energy, c.start.energy, 1e-3 * c.start.energy);
  // What was made or lost is what the two balances say that it is. The contact opens and closes within a step: a spring
  // of overlap v h each, (k/2) (v h)^2 = 1e-7 J at most.
  EXPECT_NEAR(c.end.energy - c.start.energy, c.error, 2e-7);
  EXPECT_NEAR(c.balance, 0, 1e-12);
}

/// The step of soil and machine that the impact in numbers takes is that of the simulation, and what it makes of an
/// elastic impact is the closed form: each step's roots have the product 1 + k dt^2/(2 M), over pi/(w dt) steps.
TEST(Collision, AnImpactOnABodyInNumbersIsThatOfTheSimulation) {
  const double radius = 0.01, k = 2e4, m = 12000 * 4.0 / 3 * dem::test::pi * 1e-6;
  for (const int soil_steps : {1, 3})
    for (const double mass : {0.3 * m, m, 10 * m}) {
      const double reduced = m * mass / (m + mass), w = std::sqrt(k / reduced), step = 0.03 / w;
      const dem::Law law = dem::test::grains(k, 1, 0, 0);
      dem::Bed bed(dem::test::table(law), dem::test::quiet());
      const dem::SphereSpec ball{{-0.02 - 0.4 * step, 0, 0}, {1, 0, 0}, {}, radius, 12000, 0};
      bed.add(std::span(&ball, 1));
      dem::Boundary face;
      face.shape = dem::MeshSurface(dem::box_mesh({0.02, 0.02, 0.06}));
      const int boundary = bed.add(std::move(face));
      mbd::Model model;
      model.gravity = {0, 0};
      const int body = model.add({.name = "box", .mass = mass, .inertia = 1});
      mbd::Machine machine(model);
      machine.start_from_pose();
      Simulation simulation(&bed, &machine, {{body, boundary}}, {}, {.soil_step = step, .soil_steps = soil_steps});
      for (int n = 0; n < 240; ++n) simulation.step();
      ASSERT_EQ(bed.boundary(boundary).contacts, 0);
      const double e = machine.body(body).v.x - bed.spheres()[0].v.x;
      const double there = dem::impact_on_body_in_steps(law, m, radius, mass, soil_steps, 1, step, 0.4, 1).restitution;
      // The machine's integrator places it by another h^3 F'/12, and the last step of a contact pulls or not.
      EXPECT_NEAR(e, there, 0.1 * (there - 1) + 1e-3) << mass / m << " of the sphere's mass, " << soil_steps;
      if (soil_steps == 1) {
        EXPECT_NEAR(there - 1, std::expm1(dem::test::pi / 4 * w * step * reduced / mass), 1e-3) << mass / m;
      }
    }
}

TEST(OutOfPlane, ForcesAreReportedAndDoNoWork) {
  // A face that leans out of the plane pushes the sphere along z; the guide must hold the body against it.
  Collision c{.mu = 0, .shape = dem::Plane({0, 0.01, 0}, {0, 1, 0.4})};
  c.run(2e-6);
  EXPECT_GT(std::abs(c.impulse.force.z), 1e-3);
  EXPECT_GT(std::abs(c.impulse.moment.x) + std::abs(c.impulse.moment.y), 1e-5);
  // The sphere's momentum along z is what the wrench's z part says, in the world's axes; the body has none.
  EXPECT_NEAR(c.end.pz, -c.impulse.force.z, 1e-14);
  // Both bodies' energy is kept although a force of some newtons acts along z: it did no work.
  EXPECT_NEAR(c.end.energy - c.start.energy, c.error, 2e-7);
  EXPECT_NEAR(c.end.energy, c.start.energy, 1e-3 * c.start.energy);
}

}  // namespace
}  // namespace subsoil::coupling::test::collision
