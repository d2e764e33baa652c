#include <gtest/gtest.h>

#include "tests/tools/dem_reference.hpp"
#include "tests/tools/every_law.hpp"

/// The bed against the all-pairs engine of tools/dem_reference.hpp: same pairs, forces and motion, whatever the skin
/// and into how many cache blocks it is cut.
namespace subsoil::dem::test::search {
namespace {

std::vector<Plane> walls() { return {Plane({0, 2e-3, 0}, {0.1, 1, 0}), Plane({0.15, 0, 0}, {-1, 0, 0.2})}; }

/// Fast spheres of radius 4 to 4 x `ratio` mm thrown about in a box; heavy ones, so that 10 us are stable for every
/// law.
std::vector<SphereSpec> swarm(int count, double ratio, double speed, std::uint32_t seed) {
  Dice dice(seed);
  std::vector<SphereSpec> out;
  const double box = 0.0115 * std::cbrt(count) * std::sqrt(ratio);
  while (static_cast<int>(out.size()) < count) {
    SphereSpec s;
    s.radius = 4e-3 * std::pow(ratio, dice.between(0, 1));
    s.position = dice.in_box({0, 0, 0}, {box, box / 2, box});
    s.velocity = dice.ball(speed), s.angular_velocity = dice.ball(100);
    s.density = 5e4;
    bool free = true;
    for (const Plane& p : walls()) free = free && dot(s.position - p.point(), p.normal()) > s.radius - 2e-4;
    for (const SphereSpec& o : out) free = free && norm(o.position - s.position) > o.radius + s.radius - 2e-4;
    if (free) out.push_back(s);
  }
  return out;
}

struct Difference {
  double force = 0, position = 0;
  long rebuilds = 0;
  std::size_t contacts = 0;  ///< summed over steps
};

Difference compare(const Law& law, double skin, double ratio, double speed, int steps, std::uint32_t seed,
                   double dt = 1e-5) {
  const auto specs = swarm(150, ratio, speed, seed);
  BedOptions options = quiet({0, -9.81, 0}, 1);
  options.skin = skin;
  options.cache_blocks = static_cast<int>(ratio);
  options.overlap_limit = 10;  // a law's behaviour at depth is not the question here
  options.speed_limit = 1e3;
  Bed bed(table(law), options);
  ReferenceBed reference(table(law), {0, -9.81, 0});
  bed.add(specs);
  reference.add(specs);
  for (const Plane& p : walls()) add_plane(bed, p.point(), p.normal());
  reference.planes = walls();
  bed.let_bonds_form();
  Difference d;
  double largest = 1e-3;
  for (int n = 0; n < steps; ++n) {
    const Snapshot s = observe(bed, dt);
    reference.step(dt);
    EXPECT_EQ(bed.touching_pairs(), reference.pairs) << "step " << n;
    EXPECT_EQ(bed.bonds().intact(), reference.bonds) << "step " << n;
    d.contacts += reference.pairs;
    for (std::size_t i = 0; i < specs.size(); ++i) {
      largest = std::max(largest, norm(reference.force[i]));
      d.force = std::max(d.force, norm(s.force[i] - reference.force[i]) / largest);
      d.position = std::max(d.position, norm(sphere(bed, static_cast<std::uint32_t>(i)).x - reference.spheres[i].x));
    }
    if (testing::Test::HasFailure()) break;
  }
  d.rebuilds = bed.rebuilds();
  return d;
}

TEST(Search, MissesNoContactOfFastSpheresOfManySizes) {
  for (const auto& [name, law] : every_law())
    for (const double ratio : {1.0, 3.0, 10.0}) {
      const Difference d = compare(law, 0, ratio, 3, 150, 5);
      EXPECT_GT(d.contacts, 500u) << name;
      // Both sum the same doubles in another order; collisions amplify 1e-16 by about a decade each, and so does a slip
      // near zero whose direction alone decides on the force.
      const bool by_direction = law->friction().tangential == Tangential::constant_direction;
      EXPECT_LT(d.force, by_direction ? 1e-6 : 1e-8) << name << ratio;
      EXPECT_LT(d.position, 1e-12) << name << ratio;
    }
}

/// Three spheres ten times as large as 300 others: they find their neighbours across many cells.
TEST(Search, MissesNoContactOfAFewLargeSpheres) {
  Dice dice(31);
  std::vector<SphereSpec> specs;
  for (const double x : {0.0, 0.05, 0.095})
    specs.push_back({.position = {x, 0.06, 0.05},
                     .velocity = {dice.between(-1, 1), -2, 0},
                     .angular_velocity = {},
                     .radius = 0.03,
                     .density = 5e4});
  while (specs.size() < 303) {
    SphereSpec s{.position = dice.in_box({-0.04, 0.02, 0}, {0.14, 0.12, 0.1}),
                 .velocity = dice.ball(2),
                 .angular_velocity = {},
                 .radius = 3e-3,
                 .density = 5e4};
    bool free = true;
    for (std::size_t k = 0; k < specs.size(); ++k)
      free = free && (k < 3) == (specs[k].radius > 0.01) &&
             norm(s.position - specs[k].position) > s.radius + specs[k].radius - 2e-4;
    if (free) specs.push_back(s);
  }
  specs[1].position.y += 0.01;  // the three overlap by a little, in a row
  BedOptions options = quiet({0, -9.81, 0}, 2);
  options.overlap_limit = 10, options.speed_limit = 1e3, options.cache_blocks = 2;
  Bed bed(table(grains(1e6)), options);
  ReferenceBed reference(table(grains(1e6)), {0, -9.81, 0});
  bed.add(specs), reference.add(specs);
  std::size_t contacts = 0;
  for (int n = 0; n < 200; ++n) {
    bed.step(1e-5), reference.step(1e-5);
    ASSERT_EQ(bed.touching_pairs(), reference.pairs) << n;
    contacts += reference.pairs;
  }
  EXPECT_GT(contacts, 1000u);
  for (std::uint32_t i = 0; i < specs.size(); ++i)
    EXPECT_LT(norm(sphere(bed, i).x - reference.spheres[i].x), 1e-12) << i;  // as above: rounding of other sums
}

TEST(Search, TheSkinChangesOnlyWhenListsAreBuilt) {
  const Difference tiny = compare(soil(), 1e-6, 3, 4, 150, 9), wide = compare(soil(), 5e-3, 3, 4, 150, 9);
  EXPECT_GE(tiny.rebuilds, 149);
  EXPECT_LT(wide.rebuilds, 12);
  for (const Difference& d : {tiny, wide}) {
    EXPECT_LT(d.force, 1e-8);
    EXPECT_LT(d.position, 1e-12);
  }
}

/// A swarm that flies as one through another at rest and against a wall, up to the length that lists last when they
/// measure how far spheres have come apart. The longest path alone would have them built twice as often.
TEST(Search, MissesNoContactOfASwarmThatDrifts) {
  for (const std::uint32_t seed : {7u, 8u, 9u}) {
    Dice dice(seed);
    auto specs = swarm(150, 1.3, 0.05, seed);
    for (SphereSpec& s : specs)
      if (s.position.x < 0.03) s.velocity += Vec3{3, 0, 0} + dice.ball(0.1);
    BedOptions options = quiet({}, 2);
    options.overlap_limit = 10, options.speed_limit = 1e3, options.cache_blocks = static_cast<int>(seed) - 6;
    Bed bed(table(grains(1e6)), options);
    ReferenceBed reference(table(grains(1e6)), {});
    bed.add(specs), reference.add(specs);
    for (const Plane& p : walls()) add_plane(bed, p.point(), p.normal());
    reference.planes = walls();
    double path = 0;
    std::size_t contacts = 0;
    constexpr int steps = 1500;
    constexpr double dt = 1e-5;
    for (int n = 0; n < steps; ++n) {
      bed.step(dt), reference.step(dt);
      ASSERT_EQ(bed.touching_pairs(), reference.pairs) << "seed " << seed << ", step " << n;
      contacts += reference.pairs, path += bed.max_speed() * dt;
    }
    EXPECT_GT(contacts, 1000u);
    const double skin = 0.4 * 4.5e-3;  // of the mean radius, to 2 %
    EXPECT_LT(static_cast<double>(bed.rebuilds()), 0.75 * path / (0.5 * skin))
        << "lists lasted no longer than paths say";
    for (std::uint32_t i = 0; i < specs.size(); ++i)
      EXPECT_LT(norm(sphere(bed, i).x - reference.spheres[i].x), 1e-9) << i;
  }
}

/// Friction histories must survive every rebuild and re-sort: a block of spheres pushed over a floor, lists built every
/// step against seldom. A lost spring would change the friction force by its whole size.
TEST(Search, HistoriesSurviveRebuildsAndSorting) {
  const auto run = [](double skin) {
    BedOptions options = quiet({3, -9.81, 1}, 1);
    options.skin = skin, options.cache_blocks = skin > 1e-3 ? 1 : 2;
    Bed bed(table(grains(1e4, 0.3, 0.6, 0.1)), options);
    Dice dice(3);
    bed.add(loose_lattice({0, 0, 0}, 5, 4, 5, 0.0199, 0.01, 0, 0.02, dice));
    add_plane(bed, {0, 0, 0}, {0, 1, 0});
    for (int n = 0; n < 2000; ++n) bed.step(1e-4);
    return std::pair(std::move(bed), 0);
  };
  const auto often = run(1e-9), seldom = run(8e-3);
  EXPECT_GT(often.first.rebuilds(), 1990);
  EXPECT_LT(seldom.first.rebuilds(), 200);
  double apart = 0, path = 0;
  for (std::uint32_t id = 0; id < 100; ++id) {
    apart = std::max(apart, norm(sphere(often.first, id).x - sphere(seldom.first, id).x));
    path = std::max(path, sphere(often.first, id).x.x);
  }
  EXPECT_GT(path, 0.03) << "the block must move";
  // 0.2 s of a sliding, barely colliding block: rounding of 1e-17 m grows by some decades, a lost spring is 1e-4 m.
  EXPECT_LT(apart, 1e-8);
}

TEST(Search, TesterFindsADroppedHistory) {
  // The comparison above must fail when histories are lost: here they are, by restoring without pairs.
  Bed bed(table(grains(1e4, 0.3, 0.6)), quiet({3, -9.81, 0}));
  Dice dice(3);
  bed.add(loose_lattice({0, 0, 0}, 3, 3, 3, 0.0199, 0.01, 0, 0.02, dice));
  add_plane(bed, {0, 0, 0}, {0, 1, 0});
  Bed lossy(table(grains(1e4, 0.3, 0.6)), quiet({3, -9.81, 0}));
  add_plane(lossy, {0, 0, 0}, {0, 1, 0});
  for (int n = 0; n < 500; ++n) bed.step(1e-4);
  Bed::State state = bed.save();
  state.pairs.clear(), state.surfaces.clear();
  lossy.restore(state);
  for (int n = 0; n < 100; ++n) bed.step(1e-4), lossy.step(1e-4);
  double apart = 0;
  for (std::uint32_t id = 0; id < 27; ++id) apart = std::max(apart, norm(sphere(bed, id).x - sphere(lossy, id).x));
  EXPECT_GT(apart, 1e-6);
}

}  // namespace
}  // namespace subsoil::dem::test::search
