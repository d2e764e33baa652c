// Spheres that keep their velocity: what they do to others, what acts on them, and what never moves them.

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/step/stability.hpp"
#include "tests/tools/dem_beds.hpp"

namespace subsoil::dem::fixed_spheres_test {
namespace {

using namespace test;

SphereSpec at(const Vec3& position, const Vec3& velocity = {}, double radius = 0.01) {
  return {.position = position,
          .velocity = velocity,
          .angular_velocity = {},
          .radius = radius,
          .density = 2500,
          .material = 0};
}

void add(Bed& bed, const std::vector<SphereSpec>& spheres) { bed.add(spheres); }

class FixedIn : public testing::TestWithParam<Precision> {};
INSTANTIATE_TEST_SUITE_P(Both, FixedIn, testing::Values(Precision::doubles, Precision::mixed));

// m_eff is the mass of the free one: a linear contact then has the restitution that it was given, as at a wall, and
// lasts as long. With m/2 in place of m the damping would belong to another e.
TEST_P(FixedIn, AnImpactHasTheRestitutionOfTheLaw) {
  const double e = 0.6, k = 1e5, v = 0.5;
  BedOptions options = quiet();
  options.precision = GetParam();
  Bed bed(table(Law(grains(k, e, 0, 0))), options);
  add(bed, {fixed(at({0, 0, 0})), at({0.0201, 0, 0}, {-v, 0, 0})});
  const double m = 2500 * sphere_volume(0.01), loss = -std::log(e), damped = loss / std::sqrt(loss * loss + pi * pi);
  const double contact = pi / std::sqrt(k / m * (1 - damped * damped)), dt = contact / 2000;
  double impulse = 0;
  int steps = 0;
  for (int i = 0; i < 4000; ++i) {
    bed.step(dt);
    ASSERT_EQ(bed.fixed_spheres().size(), 1U);
    const double force = bed.fixed_spheres()[0].force.x;
    impulse += force * dt, steps += force != 0;
  }
  const double tolerance = GetParam() == Precision::doubles ? 2e-3 : 4e-3;  // of first order in dt/contact
  EXPECT_NEAR(sphere(bed, 1).v.x, e * v, tolerance * v);
  EXPECT_NEAR(steps, 2000, 8);
  EXPECT_NEAR(impulse, -m * (sphere(bed, 1).v.x + v), 1e-6 * m * v) << "what it takes is what the other is given";
  EXPECT_EQ(sphere(bed, 0).x, (Vec3{})) << "to the last bit";
  EXPECT_EQ(sphere(bed, 0).v, (Vec3{}));
}

/// A cross of fixed spheres that turns and sinks through a heap of free ones under gravity, on a plane.
std::vector<SphereSpec> stirred() {
  std::vector<SphereSpec> out;
  for (int i = 0; i < 6; ++i) {
    SphereSpec s = fixed(at({0.012 * i, 0.07, 0.03}, {0.1, -0.2, 0}));
    s.angular_velocity = {0, 3, 1};
    out.push_back(s);
  }
  for (int x = 0; x < 6; ++x)
    for (int y = 0; y < 3; ++y)
      for (int z = 0; z < 4; ++z)
        out.push_back(at({0.0195 * x + 1e-3 * y, 0.0099 + 0.0195 * y, 0.0195 * z}, {}, 0.0095 + 1e-4 * (x + z)));
  return out;
}

Bed stirring(int threads, Precision precision = Precision::doubles) {
  BedOptions options = quiet({0, -9.81, 0}, threads);
  options.precision = precision;
  Bed bed(table(Law(grains(2e4, 0.5, 0.4, 0.05))), options);
  add_plane(bed, {}, {0, 1, 0});
  add(bed, stirred());
  return bed;
}

constexpr double step_of_stirring = 1e-5;

TEST_P(FixedIn, TheEnergyOfABedThatTheyStirCloses) {
  Bed bed = stirring(1, GetParam());
  const double start = (observe(bed, step_of_stirring), bed.energy().total() - bed.energy().boundary_work);
  for (int i = 0; i < 8000; ++i) bed.step(step_of_stirring);
  observe(bed, step_of_stirring);
  const BedEnergy& now = bed.energy();
  EXPECT_GT(now.boundary_work, 1e-3) << "they have done something";
  EXPECT_LT(now.kinetic, 1) << "none of it their own";
  const double tolerance = GetParam() == Precision::doubles ? 2e-3 : 5e-3;
  EXPECT_NEAR(now.total() - now.boundary_work - start, 0, tolerance * now.boundary_work);
}

TEST(FixedSpheres, MoveExactlyAsTheyAreAsked) {
  Bed bed = stirring(1);
  for (int i = 0; i < 4000; ++i) bed.step(step_of_stirring);
  const double t = 4000 * step_of_stirring;
  for (std::uint32_t id = 0; id < 6; ++id) {
    const Sphere& s = sphere(bed, id);
    EXPECT_NEAR(s.x.x, 0.012 * id + 0.1 * t, 1e-13);
    EXPECT_NEAR(s.x.y, 0.07 - 0.2 * t, 1e-13);
    EXPECT_EQ(s.x.z, 0.03);
    EXPECT_EQ(s.v, (Vec3{0.1, -0.2, 0}));
    EXPECT_EQ(s.w, (Vec3{0, 3, 1}));
    EXPECT_NEAR(density(s), 2500, 1e-9);
  }
}

TEST(FixedSpheres, SameBitsOnAnyNumberOfThreadsAndThroughARestart) {
  Bed one = stirring(1), four = stirring(4), again = stirring(1);
  for (int i = 0; i < 3000; ++i) one.step(step_of_stirring), four.step(step_of_stirring);
  EXPECT_EQ(hash(one), hash(four));
  again.restore(one.save());
  for (int i = 0; i < 2000; ++i) one.step(step_of_stirring), four.step(step_of_stirring), again.step(step_of_stirring);
  observe(one, step_of_stirring), observe(four, step_of_stirring), observe(again, step_of_stirring);
  EXPECT_EQ(hash(one), hash(four));
  EXPECT_EQ(hash(one), hash(again));
  EXPECT_EQ(one.energy().boundary_work, four.energy().boundary_work);
  EXPECT_EQ(one.energy().boundary_work, again.energy().boundary_work);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(one.fixed_spheres()[k].force, again.fixed_spheres()[k].force);
}

// However light: a fixed sphere is known by its kind and not by its mass (dimensionless units have densities of 1).
TEST(FixedSpheres, OfAnyDensityStayAndKeepTheirMass) {
  for (const double density : {1e-6, 1.9, 2500.0, 1e6}) {
    const double k = 1e5, e = 0.6, v = 1e-3;
    Bed bed(table(Law(grains(k, e, 0, 0))), quiet({0, 0, -1}));
    SphereSpec light = fixed(at({})), other = at({0.0201, 0, 0}, {-v, 0, 0});
    light.density = other.density = density;
    bed.add(std::vector<SphereSpec>{light, other});
    const double m = density * sphere_volume(0.01), step = 0.01 * std::sqrt(m / k);
    Bed again(table(Law(grains(k, e, 0, 0))), quiet({0, 0, -1}));
    for (int i = 0; i < 1000; ++i) bed.step(step);
    again.restore(bed.save());
    for (int i = 0; i < 1000; ++i) bed.step(step), again.step(step);
    EXPECT_EQ(sphere(bed, 0).x, (Vec3{})) << density;
    EXPECT_EQ(sphere(bed, 0).m, m) << density;
    EXPECT_EQ(hash(bed), hash(again)) << density;
    EXPECT_EQ(sphere(again, 0).m, m) << density;
    EXPECT_TRUE(is_fixed(sphere(again, 0))) << density;
  }
}

/// A surface that presses on a fixed sphere at a steady speed and slides along it: by the linear law k delta + c v with
/// the mass of the sphere's own matter in c, friction at its limit mu F, and every joule accounted for.
void press_fixed_sphere(const Shape& shape, const Vec3& start) {
  constexpr double k = 1e5, e = 0.5, mu = 0.3, r = 0.01, into = 0.02, along = 0.05, dt = 1e-6;
  Bed bed(table(Law(grains(k, e, mu, 0))), quiet({0, -9.81, 0}));
  add(bed, {fixed(at({}, {}, r)), at({-0.5, 0, 0}, {}, 0.5 * r)});
  Boundary b;
  b.shape = shape, b.pose.position = start, b.velocity = {-into, 0, along};
  const int tool = bed.add(std::move(b));
  double begin = 0;
  for (int n = 0; n < 20000; ++n) {
    if (n == 0) {
      observe(bed, dt);
      begin = bed.energy().total();
    } else {
      bed.step(dt);
    }
    Boundary& moved = bed.boundary(tool);
    moved.pose.position += dt * moved.velocity;
  }
  observe(bed, dt);
  const double m = 2500 * sphere_volume(r), loss = -std::log(e), beta = loss / std::hypot(loss, pi);
  const double depth = into * 20000 * dt - 1e-4;  // it begins a tenth of a millimetre away
  const double force = k * depth + 2 * beta * std::sqrt(m * k) * into;
  ASSERT_EQ(bed.fixed_spheres().size(), 1U);
  const FixedSphere& f = bed.fixed_spheres()[0];
  EXPECT_NEAR(f.force.x, -force, 1e-9 * force);
  EXPECT_NEAR(f.force.z, mu * force, 1e-9 * force) << "it slides: the spring has long been at its limit";
  EXPECT_EQ(bed.boundary(tool).wrench.force, -f.force);
  EXPECT_EQ(f.position, (Vec3{}));
  // Work of the tool: k/2 depth^2 is stored, the rest is lost.
  const BedEnergy& now = bed.energy();
  EXPECT_GT(now.boundary_work, 0.5 * k * depth * depth);
  // The dashpot and the spring of friction begin within a step: half a step of their force.
  EXPECT_NEAR(now.total() - begin - now.boundary_work, 0, 1e-5 * now.boundary_work);
}

TEST(FixedSpheres, MeetSurfacesThatMove) {
  // The face lies at x = 0.0101 at the start, the nearest place of each shape to the sphere.
  press_fixed_sphere(Plane({}, {-1, 0, 0}), {0.0101, 0, 0});
  press_fixed_sphere(MeshSurface(box_mesh({0.02, 0.1, 0.1})), {0.0201, 0, 0});
  press_fixed_sphere(Cylinder({}, {0, 0, 1}, 0.05, 0.2), {0.0601, 0, 0});
}

TEST(FixedSpheres, MeetSurfacesWithTheSameBitsOnAnyNumberOfThreads) {
  const auto pressed = [](int threads) {
    Bed bed = stirring(threads);
    Boundary b;
    b.shape = MeshSurface(box_mesh({0.02, 0.3, 0.3})), b.velocity = {0.1, 0, 0};
    b.pose.position = {-0.02, 0.1, 0.05};
    const int tool = bed.add(std::move(b));
    for (int n = 0; n < 3000; ++n) {
      bed.step(step_of_stirring);
      bed.boundary(tool).pose.position.x += 0.1 * step_of_stirring;
    }
    return std::pair(hash(bed), bed.boundary(tool).wrench.force);
  };
  const auto one = pressed(1);
  EXPECT_LT(one.second.x, 0);
  EXPECT_EQ(pressed(3), one);
}

// A rough floor of spheres laid into each other and into a plane is nobody's load.
TEST(FixedSpheres, DoNotMeetEachOtherNorSurfacesThatSaySo) {
  Bed bed(table(Law(grains())), quiet({0, -9.81, 0}));
  const int floor = add_plane(bed, {}, {0, 1, 0});
  bed.boundary(floor).meets_fixed = false;
  add(bed, {fixed(at({0, 0, 0})), fixed(at({0.012, 0.001, 0})), at({0.3, 0.0099, 0})});
  for (int i = 0; i < 5; ++i) bed.step(1e-5);
  const Snapshot s = observe(bed, 1e-5);
  EXPECT_EQ(s.contacts[0], 0);
  EXPECT_EQ(s.force[0], (Vec3{})) << "nor gravity";
  EXPECT_EQ(bed.fixed_spheres()[1].force, (Vec3{}));
  EXPECT_EQ(bed.boundary(floor).contacts, 1) << "the free one";
  EXPECT_LT(bed.max_overlap(), 0.02);
}

}  // namespace
}  // namespace subsoil::dem::fixed_spheres_test
