#include <gtest/gtest.h>

#include "tests/tools/dem_beds.hpp"

/// What stops a run says when, which sphere and where; and small things that a user of Bed leans on.
namespace subsoil::dem::test::engine_faults {
namespace {

/// The fault that ends some steps; a sphere that no bed of these tests has where there is none.
BedFault fault_in(Bed& bed, int steps) {
  try {
    for (int n = 0; n < steps; ++n) bed.step(1e-5);
  } catch (const BedFault& fault) {
    return fault;
  }
  return BedFault({.kind = BedFault::Kind::speed, .time = -1, .sphere = 12345}, "no fault");
}
std::string fault_of(Bed& bed, int steps) { return fault_in(bed, steps).what(); }

std::vector<SphereSpec> row(int count) {
  std::vector<SphereSpec> out;
  for (int k = 0; k < count; ++k) out.push_back({{0.05 * k, 0.5, 0.25}, {}, {}, 0.01, 1800, 0});
  return out;
}

void expect_parts(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " is missing in: " << text;
}

TEST(Faults, TooFast) {
  Bed bed(table(grains()), quiet());
  auto specs = row(40);
  specs[7].velocity = {0, 60, 0};
  bed.add(specs);
  const BedFault fault = fault_in(bed, 10);
  expect_parts(fault.what(), {"t = 0 s", "sphere 7", "(0.35, 0.5006, 0.25)", "60 m/s", "limit 50"});
  EXPECT_EQ(fault.facts.kind, BedFault::Kind::speed);
  EXPECT_EQ(fault.facts.sphere, 7u);
  EXPECT_EQ(fault.facts.time, 0);
  EXPECT_NEAR(fault.facts.value, 60, 60 * 1e-15);  // a free sphere; one rounding of the square root
  EXPECT_EQ(fault.facts.limit, 50);
}

TEST(Faults, TooDeep) {
  Bed bed(table(grains()), quiet());
  auto specs = row(40);
  specs[9].position = {0.05 * 8 + 0.0149, 0.5, 0.25};
  bed.add(specs);
  const BedFault fault = fault_in(bed, 10);
  expect_parts(fault.what(), {"t = 0 s", "0.51 of a radius", "limit 0.5"});
  EXPECT_EQ(fault.facts.kind, BedFault::Kind::overlap);
  EXPECT_TRUE(fault.facts.sphere == 8 || fault.facts.sphere == 9) << fault.what();
  EXPECT_NEAR(fault.facts.value, 0.51, 1e-12);  // (2 r - distance)/r; rounding of positions of 0.4 m over r
  EXPECT_EQ(fault.facts.limit, 0.5);
}

TEST(Faults, TooDeepAtASurface) {
  Bed bed(table(grains()), quiet());
  bed.add(row(40));
  add_plane(bed, {0, 0.4951, 0}, {0, 1, 0});
  expect_parts(fault_of(bed, 1), {"overlaps by 0.51"});
}

/// A NaN anywhere in the order must be found in the very step, not only in the last sphere, and by any thread. Spheres
/// are checked when they enter, so it comes in by a surface whose velocity a caller got wrong.
TEST(Faults, NotANumber) {
  for (const int threads : {1, 2})
    for (const std::size_t where : {0u, 20u, 599u})
      for (const bool spins : {false, true}) {
        Bed bed(table(grains(1e4, 0.5, 0.5)), quiet({0, -9.81, 0}, threads));
        bed.add(row(600));
        Boundary roller;
        roller.shape = Cylinder({0, 0, 0}, {0, 0, 1}, 0.02, 0.02);
        roller.pose.position = {0.05 * static_cast<double>(where), 0.5 - 0.0295, 0.25};
        (spins ? roller.angular_velocity.z : roller.velocity.y) = NAN;
        bed.add(roller);
        expect_parts(fault_of(bed, 1), {"t = 0 s", ("sphere " + std::to_string(where) + " ").c_str(), "nan"});
      }
}

TEST(Faults, StateThatIsNoNumberIsRefusedOnEntry) {
  for (const int which : {0, 1, 2}) {
    Bed bed(table(grains()), quiet());
    auto specs = row(5);
    (which == 0   ? specs[3].position.y
     : which == 1 ? specs[3].velocity.x
                  : specs[3].angular_velocity.z) = which == 2 ? INFINITY : NAN;
    try {
      bed.add(specs);
      ADD_FAILURE() << "taken";
    } catch (const std::invalid_argument& refusal) {
      expect_parts(refusal.what(), {"sphere 3", "finite"});
    }
  }
}

TEST(Faults, BadSpheresAndMissingLaws) {
  Bed bed(table(grains()), quiet());
  auto specs = row(1);
  specs[0].radius = 0;
  EXPECT_THROW(bed.add(specs), std::invalid_argument);
  specs = row(1);
  specs[0].material = 1;
  EXPECT_THROW(bed.add(specs), std::invalid_argument);
  // More than an index can name, refused before one is read.
  EXPECT_THROW(bed.add(std::span(specs.data(), (std::size_t{1} << 29) + 1)), std::invalid_argument);
  LawTable two = table(grains());
  two.materials = 2, two.index = {0, -1, -1, 0};
  Bed mixed(two, quiet());
  specs = row(2);
  specs[1].material = 1;
  mixed.add(specs);
  EXPECT_THROW(mixed.step(1e-5), std::invalid_argument);
}

TEST(Boundaries, AnOpenedWallLetsGoAtOnceAndAClosedOneHolds) {
  Bed bed(table(grains(1e5, 1, 0)), quiet());
  const SphereSpec s{{0, 0.0095, 0}, {}, {}, 0.01, 1800, 0};
  bed.add(std::span(&s, 1));
  const int wall = add_plane(bed, {}, {0, 1, 0});
  EXPECT_NEAR(observe(bed, 1e-6).force[0].y, 50, 1e-2);
  bed.boundary(wall).active = false;
  EXPECT_EQ(observe(bed, 1e-6).force[0].y, 0);
  EXPECT_EQ(bed.boundary(wall).wrench.force.y, 0);
  bed.boundary(wall).active = true;
  EXPECT_NEAR(observe(bed, 1e-6).force[0].y, 50, 1e-1);
}

TEST(Boundaries, WrenchIsAboutTheOriginOfTheBoundary) {
  Bed bed(table(grains(1e5, 1, 0)), quiet());
  const SphereSpec s{{0.3, 0.0095, 0.2}, {}, {}, 0.01, 1800, 0};
  bed.add(std::span(&s, 1));
  Boundary floor;
  floor.shape = Plane({}, {0, 1, 0});
  floor.pose.position = {0.1, 0, 0};
  const int wall = bed.add(std::move(floor));
  bed.step(1e-6);
  const Wrench& w = bed.boundary(wall).wrench;
  EXPECT_NEAR(w.force.y, -50, 1e-9);
  EXPECT_NEAR(w.moment.z, 0.2 * -50, 1e-9);   // x F_y
  EXPECT_NEAR(w.moment.x, -0.2 * -50, 1e-9);  // -z F_y
}

TEST(Bed, SpheresBelowTheDropAreCountedOut) {
  BedOptions options = quiet({0, -9.81, 0});
  options.floor_drop = -0.5;
  Bed bed(table(grains()), options);
  bed.add(row(3));
  while (bed.time() < 0.6) bed.step(1e-3);
  EXPECT_EQ(bed.removed_count(), 3u);
  EXPECT_TRUE(bed.spheres().empty());
  bed.step(1e-3, {.energy = true, .snapshot = nullptr});
  // Free fall: what left carried all the energy there was.
  EXPECT_NEAR(bed.energy().total(), 3 * 1800 * 4.0 / 3 * pi * 1e-6 * 9.81 * 0.5, 1e-3);
}

TEST(Bed, FreeFallHasNoErrorInTheSnapshot) {
  Bed bed(table(grains()), quiet({0, -9.81, 0}));
  bed.add(row(1));
  Snapshot s;
  for (int n = 0; n <= 100; ++n) s = observe(bed, n % 2 == 0 ? 1e-3 : 5e-4);  // uneven steps
  const double t = 50 * 1.5e-3;
  EXPECT_NEAR(s.velocity[0].y, -9.81 * t, 1e-12);
  EXPECT_NEAR(s.force[0].y, -9.81 * 1800 * 4.0 / 3 * pi * 1e-6, 1e-12);
  // Leapfrog is exact for a constant force and even steps; each change of step costs a (dt1^2 - dt2^2)/8, alternating.
  EXPECT_NEAR(s.position[0].y, 0.5 - 0.5 * 9.81 * t * t, 9.81 * 1e-6);
}

}  // namespace
}  // namespace subsoil::dem::test::engine_faults
