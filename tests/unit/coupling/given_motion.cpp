#include <gtest/gtest.h>

#include "coupling/simulation.hpp"
#include "tests/tools/dem_beds.hpp"

/// Boundaries on given paths: velocity and pose belong together, and what they do to spheres is counted as work.
namespace subsoil::coupling::test::given_motion {
namespace {

TEST(GivenMotion, VelocityIsTheDisplacementOverTheStep) {
  dem::Bed bed(dem::test::table(dem::test::grains()), dem::test::quiet());
  const int plate = dem::test::add_plane(bed, {}, {0, 1, 0});
  const auto path = [](double t) {
    return dem::Pose{{0.2 * std::sin(30 * t), -0.1 * t, 0.05 * t},
                     dem::Quaternion::from_rotation_vector({0, 4 * t, 0})};
  };
  const double step = 1e-4;
  Simulation simulation(&bed, nullptr, {}, {{plate, path}}, {.soil_step = step});
  for (int n = 0; n < 50; ++n) {
    simulation.step();
    const dem::Boundary& b = bed.boundary(plate);
    const double t = n * step;
    EXPECT_LT(norm(b.pose.position - path(t).position), 1e-15);
    // The first step has no step before; leapfrog takes its velocity as that of the start.
    const double middle = n == 0 ? 0 : t - step / 2;
    // Mid-step differences of a sine err by (30 step)^2/24 of 6 m/s.
    EXPECT_NEAR(b.velocity.x, 6 * std::cos(30 * middle), 5e-6) << n;
    EXPECT_NEAR(b.velocity.y, -0.1, 1e-12) << n;
    EXPECT_NEAR(b.velocity.z, 0.05, 1e-12) << n;
    EXPECT_NEAR(b.angular_velocity.y, 4, 1e-6) << n;
  }
}

TEST(BodySurface, MovesWithTheBodyFromTheFirstStepOn) {
  dem::Bed bed(dem::test::table(dem::test::grains()), dem::test::quiet());
  const int face = dem::test::add_plane(bed, {0, -1, 0}, {0, -1, 0});
  mbd::Model model;
  model.gravity = {0, 0};
  const int body = model.add({.name = "b", .mass = 1, .inertia = 1, .pose = {0, 5, 0.3}, .velocity = {0.5, -1, 2}});
  mbd::Machine machine(model);
  machine.start_from_pose();
  Simulation simulation(&bed, &machine, {{body, face}}, {}, {.soil_step = 1e-4});
  for (int n = 0; n < 10; ++n) {
    simulation.step();
    const dem::Boundary& b = bed.boundary(face);
    EXPECT_NEAR(b.velocity.x, 0.5, 1e-9) << n;
    EXPECT_NEAR(b.velocity.y, -1, 1e-9) << n;
    EXPECT_NEAR(b.angular_velocity.z, 2, 1e-6) << n;
    EXPECT_NEAR(b.pose.position.y, 5 - n * 1e-4, 1e-12) << n;
  }
}

/// A sphere at rest on a turning drum, large enough to be flat for it: Coulomb friction brings it to rolling at
/// t = 2 U/(7 mu g) with 2/7 of the surface speed U (MFiX DEM04 seen from the belt). The drum's work is
/// mu m g U t = (2/7) m U^2; one half is the sphere's motion, the other half slid away.
TEST(GivenMotion, TurningDrumDragsASphereAndItsWorkIsAccumulated) {
  const double radius = 0.01, drum = 0.5, speed = 0.1, mu = 0.4, step = 2e-6;
  dem::Bed bed(dem::test::table(dem::test::grains(1e5, 0.5, mu, 0)), dem::test::quiet({0, -9.81, 0}));
  const double mass = 2500 * 4.0 / 3.0 * M_PI * std::pow(radius, 3);
  const dem::SphereSpec ball{{0, drum + radius - mass * 9.81 / 1e5, 0}, {}, {}, radius, 2500, 0};
  bed.add(std::span(&ball, 1));
  dem::Boundary b;
  b.shape = dem::Cylinder({}, {0, 0, 1}, drum, 0.2);
  const int boundary = bed.add(std::move(b));
  // Turning clockwise: the top moves along +x.
  Simulation simulation(&bed, nullptr, {},
                        {{boundary,
                          [&](double t) {
                            return dem::Pose{{}, dem::Quaternion::from_rotation_vector({0, 0, -speed / drum * t})};
                          }}},
                        {.soil_step = step});
  const double rolling = 2 * speed / (7 * mu * 9.81);
  double torque = 0, start = 0;
  const long steps = std::lround(2 * rolling / step);
  for (long n = 0; n <= steps; ++n) {
    simulation.step({.energy = n == 0 || n == steps, .snapshot = nullptr});
    if (n == 0) start = bed.energy().total();
    if (n == steps / 4) torque = bed.boundary(boundary).wrench.moment.z;
  }
  const dem::Sphere& s = bed.spheres()[0];
  // The tangential spring's stretch, mu m g/k_t, and the drum's curve change these by parts in a thousand.
  EXPECT_NEAR(s.v.x, 2 * speed / 7, 0.01 * speed);
  EXPECT_NEAR(s.w.z, 5 * speed / (7 * radius), 0.01 * speed / radius);
  EXPECT_NEAR(torque, mu * mass * 9.81 * drum, 0.01 * mu * mass * 9.81 * drum);
  const dem::BedEnergy& e = bed.energy();
  const double work = 2.0 / 7.0 * mass * speed * speed;
  EXPECT_NEAR(e.boundary_work, work, 0.01 * work);
  EXPECT_NEAR(e.kinetic + e.rotational, work / 2, 0.01 * work);
  EXPECT_NEAR(e.lost.sliding + e.lost.damping, work / 2, 0.01 * work);
  EXPECT_NEAR(e.total() - start, e.boundary_work, 1e-3 * work);
  EXPECT_EQ(simulation.interface_work().on_soil, 0) << "a given motion is no machine's";
}

/// The first evaluation of forces has the velocity that the motion has at the start, also of one that begins there:
/// half of it, the mean with the rest before, would be an error of first order.
TEST(GivenMotion, BeginsWithItsVelocity) {
  const double dt = 1e-4, U = 0.7, a = 30, w = 5;
  dem::Bed bed(dem::test::table(dem::test::grains()), dem::test::quiet());
  const int plate = dem::test::add_plane(bed, {}, {0, 1, 0});
  const auto path = [=](double t) {
    const double since = std::max(0.0, t);
    return dem::Pose{{U * since + 0.5 * a * since * since, 0, 0},
                     dem::Quaternion::from_rotation_vector({0, 0, w * since})};
  };
  Simulation simulation(&bed, nullptr, {}, {{plate, path}}, {.soil_step = dt});
  simulation.step();
  // A parabola is exact; the sine of half the angle of a step, 2.5e-4, leaves its cube.
  EXPECT_NEAR(bed.boundary(plate).velocity.x, U, 1e-12);
  EXPECT_NEAR(bed.boundary(plate).angular_velocity.z, w, 1e-6 * w);
}

/// Force of the first evaluation on a plane that swings from the start on, against k delta + c v of the law at t = 0.
double first_force_error(double dt) {
  const double k = 1e5, e = 0.6, radius = 0.01, overlap = 1e-4, amplitude = 1e-3, w = 300, phase = 1;
  dem::Bed bed(dem::test::table(dem::test::grains(k, e, 0, 0)), dem::test::quiet());
  const dem::SphereSpec ball{{0, radius - overlap, 0}, {}, {}, radius, 2500, 0};
  bed.add(std::span(&ball, 1));
  const int plate = dem::test::add_plane(bed, {}, {0, 1, 0});
  const auto path = [=](double t) {
    return dem::Pose{{0, amplitude * (std::sin(w * std::max(0.0, t) + phase) - std::sin(phase)), 0}, {}};
  };
  Simulation simulation(&bed, nullptr, {}, {{plate, path}}, {.soil_step = dt});
  simulation.step();
  const double mass = 2500 * dem::sphere_volume(radius), speed = amplitude * w * std::cos(phase);
  const double share = -std::log(e) / std::hypot(M_PI, std::log(e)), c = 2 * share * std::sqrt(k * mass);
  return std::abs(bed.boundary(plate).wrench.force.y + k * overlap + c * speed);
}

// Second order in the step, where half of the velocity would leave c v/2 = 0.9 N whatever the step.
TEST(GivenMotion, TheFirstForceIsOfSecondOrder) {
  const double coarse = first_force_error(4e-5), fine = first_force_error(2e-5), finest = first_force_error(1e-5);
  EXPECT_LT(coarse, 1e-3);
  EXPECT_NEAR(coarse / fine, 4, 0.1);
  EXPECT_NEAR(fine / finest, 4, 0.05);
}

}  // namespace
}  // namespace subsoil::coupling::test::given_motion
