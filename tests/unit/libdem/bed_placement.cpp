// Lattices as printed, their densities and surfaces; loose placement; sizes. Oracle: hand counts and closed moments.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libdem/packing/measure.hpp"
#include "tests/unit/libdem/bed_support.hpp"

namespace subsoil::dem::test::bed_placement {
namespace {

const Bounds bin{{-1, -0.4, -0.7}, {1, 0, 0.7}};  // 2 x 0.4 x 1.4 m
constexpr double bin_volume = 2 * 0.4 * 1.4;
const double sphere_mass = density * 4.0 / 3.0 * std::numbers::pi * 1e-6;  // r = 10 mm: 7.54 g

LatticePlan plan(double pitch) {
  LatticePlan p;
  p.region = bin;
  p.radius = EqualRadius{0.010};
  p.pitch = pitch;
  p.floor_overlap = 0.002;
  return p;
}

TEST(BedLattice, HoldsAsManyAsPrinted) {
  const LatticeCount n = lattice_count(plan(0.0202));
  EXPECT_EQ(n.x, 99u);
  EXPECT_EQ(n.y, 19u);
  EXPECT_EQ(n.z, 69u);
  EXPECT_EQ(lattice(plan(0.0202), soil_material).size(), 129789u);
  EXPECT_EQ(lattice(plan(0.0205), soil_material).size(), 125324u);
}

TEST(BedLattice, RestPitchHoldsAsManyAsInTheReference) {
  const LatticeCount n = lattice_count(plan(0.018));
  EXPECT_EQ(n.x, 111u);  // 1.98 m is 110 pitches but for rounding
  EXPECT_EQ(n.y, 22u);
  EXPECT_EQ(n.z, 77u);
  EXPECT_EQ(rest_lattice(plan(0), 0.002, soil_material).size(), 188034u);
}

TEST(BedLattice, CountDoesNotDependOnWhereTheBinStands) {
  for (const double shift : {0.0, 0.1, -1.7, 123.4}) {
    LatticePlan p = plan(0.018);
    p.region.low += Vec3{shift, shift, shift}, p.region.high += Vec3{shift, shift, shift};
    EXPECT_EQ(lattice_count(p).total(), 188034u) << shift;
  }
}

// Over the bin 874 and 1266, in the lattice m/pitch^3 = 915 and 1293 kg/m3; the window's error for n >= 17 pitches is
// below 3 x 2/(pi 17^3) = 4e-4.
TEST(BedLattice, DensitiesOfTheReference) {
  const auto printed = as_spheres(lattice(plan(0.0202), soil_material));
  const BedReport of_printed = report(printed, bin);
  EXPECT_NEAR(of_printed.mass / bin_volume, 874, 0.5);
  EXPECT_NEAR(of_printed.bulk_density, sphere_mass / std::pow(0.0202, 3), 4e-4 * 915);
  EXPECT_EQ(of_printed.coordination, 0);
  const BedReport of_rest = report(as_spheres(rest_lattice(plan(0), 0.002, soil_material)), bin);
  EXPECT_NEAR(of_rest.mass / bin_volume, 1266, 0.5);
  EXPECT_NEAR(of_rest.bulk_density, 1293, 0.5 + 4e-4 * 1293);
  // Inside six neighbours; each of the three directions loses two of them at its two end rows.
  EXPECT_NEAR(of_rest.coordination, 6 - 2.0 / 111 - 2.0 / 22 - 2.0 / 77, 1e-12);
}

// A shaft in the middle, where the window weighs most: the measure tells beds apart.
TEST(BedLattice, DensityMeasureSeesAHollow) {
  auto spheres = as_spheres(rest_lattice(plan(0), 0.002, soil_material));
  const double full = bulk_density(spheres, bin);
  std::erase_if(spheres, [](const Sphere& s) { return std::abs(s.x.x) < 0.2 && std::abs(s.x.z) < 0.2; });
  EXPECT_LT(bulk_density(spheres, bin), 0.9 * full);
}

// Spheres that just touch, in boxes of whole diameters: pi/6 of their own density however few lie side by side, with
// walls and with periodic sides.
TEST(BedLattice, DensityOfThinBeds) {
  constexpr double r = 0.01;
  for (const bool periodic : {false, true})
    for (const int nx : {1, 2, 3, 5, 9})
      for (const int ny : {1, 2, 4, 8})
        for (const int nz : {1, 3, 7}) {
          std::vector<Sphere> spheres;
          for (int i = 0; i < nx * ny * nz; ++i) {
            Sphere& s = spheres.emplace_back();
            s.x = r * Vec3{2.0 * (i % nx) + 1, 2.0 * (i / nx % ny) + 1, 2.0 * (i / nx / ny) + 1};
            s.r = r, s.m = sphere_mass;
          }
          const Bounds box{{}, 2 * r * Vec3{1.0 * nx, 1.0 * ny + 1, 1.0 * nz}};
          PeriodicCell cell;
          if (periodic) cell.length = {box.high.x, 0, box.high.z};
          EXPECT_NEAR(bulk_density(spheres, box, cell), density * std::numbers::pi / 6, 1e-6) << nx << ny << nz;
          // Fixed ones weigh what their matter does.
          for (Sphere& s : spheres)
            if (s.x.y < 2 * r) s.kind = SphereKind::fixed;
          const BedReport fixed = report(spheres, box, cell);
          EXPECT_NEAR(fixed.bulk_density, density * std::numbers::pi / 6, 1e-6) << nx << ny << nz;
          EXPECT_NEAR(fixed.mass, nx * ny * nz * sphere_mass, 1e-12);
        }
}

// Layers half as full at floor and surface are no part of the middle, however shallow the bed: a bed of five diameters
// was taken as a whole. The window of six and more shows a lattice of n pitches within 2/(pi n (n^2 - 1)).
TEST(BedLattice, DensityDoesNotDependOnTheDepth) {
  constexpr double r = 0.01;
  PeriodicCell cell;
  cell.length = {16 * r, 0, 16 * r};
  for (const int ny : {5, 6, 7, 12}) {
    std::vector<Sphere> spheres;
    for (int i = 0; i < 64 * ny; ++i) {
      const int x = i % 8, z = i / 8 % 8, layer = i / 64;
      if ((layer == 0 || layer == ny - 1) && (x + z) % 2 == 1) continue;
      Sphere& s = spheres.emplace_back();
      s.x = r * Vec3{2.0 * x + 1, 2.0 * layer + 1, 2.0 * z + 1};
      s.r = r, s.m = sphere_mass;
    }
    const double n = ny - 2, of_window = ny < 6 ? 1e-9 : 2 / (std::numbers::pi * n * (n * n - 1));
    EXPECT_NEAR(bulk_density(spheres, {{}, {16 * r, 2 * r * ny, 16 * r}}, cell) / (density * std::numbers::pi / 6), 1,
                of_window)
        << ny;
  }
}

TEST(BedLattice, StandsCentredAndLetIntoTheFloor) {
  Bounds box;
  for (const SphereSpec& s : lattice(plan(0.0202), soil_material)) box.include(s.position);
  EXPECT_NEAR(box.low.x + box.high.x, 0, 1e-12);
  EXPECT_NEAR(box.low.z + box.high.z, 0, 1e-12);
  EXPECT_NEAR(box.low.y, bin.low.y + 0.008, 1e-12);
}

TEST(BedLattice, DepthTakesLayersUpToIt) {
  LatticePlan p = plan(0.018);
  p.depth = 0.2;  // (200 - 20)/18 = 10 pitches
  EXPECT_EQ(lattice_count(p).y, 11u);
  p.depth = 0.199;
  EXPECT_EQ(lattice_count(p).y, 10u);
  p.depth = 9;  // more than the region: the region
  EXPECT_EQ(lattice_count(p).y, 22u);
}

TEST(BedLattice, SurfaceHeightIsTheTopOfTheLastLayer) {
  const auto spheres = as_spheres(rest_lattice(plan(0), 0.002, soil_material));
  const double top = bin.low.y + 0.008 + 21 * 0.018 + 0.010;
  const SurfaceHeight all = surface_height(spheres, bin);
  EXPECT_NEAR(all.mean, top, 1e-12);
  EXPECT_NEAR(all.spread, 0, 1e-12);
  // Half of the bed one layer lower: the mean of a range sees only its part.
  auto step = spheres;
  std::erase_if(step, [&](const Sphere& s) { return s.x.x > 0 && s.x.y > top - 0.012; });
  EXPECT_NEAR(surface_height(step, bin, -1, 0).mean, top, 1e-12);
  EXPECT_NEAR(surface_height(step, bin, 0.05, 1).mean, top - 0.018, 1e-12);
  EXPECT_NEAR(surface_height(step, bin).spread, 0.009, 1e-4);
}

/// The region is four columns wide by the mean radius, whose last bits depend on the order of the sum.
TEST(SurfaceHeight, DoesNotDependOnTheOrderOfTheSpheres) {
  const Bounds region{{0, 0, 0}, {0.04, 0.1, 0.04}};
  for (int seed = 1; seed <= 20; ++seed) {
    Dice dice(seed);
    std::vector<Sphere> spheres;
    for (int k = 0; k < 300; ++k)
      for (const double sign : {-1.0, 1.0}) {
        Sphere s{};
        s.x = dice.in_box(region.low, region.high), s.m = 1;
        s.r = 2.5e-3 + sign * 5e-4 * (k % 7) / 7.0;
        spheres.push_back(s);
      }
    const double mean = surface_height(spheres, region).mean;
    std::sort(spheres.begin(), spheres.end(), [](const Sphere& a, const Sphere& b) { return a.r < b.r; });
    EXPECT_NEAR(surface_height(spheres, region).mean, mean, 1e-12) << seed;
  }
}

TEST(BedLattice, JitterShiftsWithinItsBallAndKeepsToTheSeed) {
  LatticePlan p = plan(0.0202);
  p.depth = 0.05;
  const auto still = lattice(p, soil_material);
  p.jitter = 0.05;
  const auto moved = lattice(p, soil_material), again = lattice(p, soil_material);
  p.seed = 2;
  const auto other = lattice(p, soil_material);
  double largest = 0;
  for (std::size_t i = 0; i < still.size(); ++i) {
    largest = std::max(largest, norm(moved[i].position - still[i].position));
    EXPECT_EQ(moved[i].position, again[i].position);
  }
  EXPECT_LE(largest, 0.05 * 0.010 * (1 + 1e-12));
  EXPECT_GT(largest, 0.99 * 0.05 * 0.010);  // of 13,662 points in a ball 3 % lie in its last hundredth
  EXPECT_NE(other[0].position, moved[0].position);
}

TEST(BedLattice, RefusesWhatCannotStand) {
  LatticePlan p = plan(0.018);
  p.region = {{0, 0, 0}, {1, 0.015, 1}};
  EXPECT_THROW(lattice(p, soil_material), std::invalid_argument);
  p = plan(0);
  EXPECT_THROW(lattice(p, soil_material), std::invalid_argument);
  p = plan(0.018);
  p.depth = 0.01;
  EXPECT_THROW(lattice(p, soil_material), std::invalid_argument);
  p = plan(0.018);
  p.radius = UniformRadius{0.008, 0.010};
  EXPECT_THROW(rest_lattice(p, 0.002, soil_material), std::invalid_argument);
}

TEST(BedLoose, SpheresKeepClearOfEachOtherAndOfTheWalls) {
  const Bounds box{{0, 0, 0}, {0.15, 0.1, 0.11}};
  LoosePlacer placer(box, UniformRadius{0.006, 0.012}, ShareOf::number, 3, soil_material);
  const auto spheres = placer.place(400, 0.02);
  ASSERT_EQ(spheres.size(), 400u);
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const SphereSpec& a = spheres[i];
    EXPECT_GE(a.position.x - a.radius, box.low.x - 1e-12);
    EXPECT_LE(a.position.x + a.radius, box.high.x + 1e-12);
    EXPECT_GE(a.position.z - a.radius, box.low.z - 1e-12);
    EXPECT_LE(a.position.z + a.radius, box.high.z + 1e-12);
    EXPECT_GE(a.position.y - a.radius, 0.02 - 1e-12);
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GE(norm(a.position - spheres[j].position), (a.radius + spheres[j].radius) * (1 - 1e-12));
  }
  double volume = 0;
  const auto filled = placer.place_volume(1e-3, 0);
  for (const SphereSpec& s : filled) volume += sphere_volume(s.radius);
  EXPECT_GE(volume, 1e-3);
  EXPECT_LT(volume - sphere_volume(filled.back().radius), 1e-3);
}

// ---- sizes ---------------------------------------------------------------------------------------------------------

struct Moments {
  double mean = 0, deviation = 0, least = 1, largest = 0;
};
constexpr int draws = 200000;

Moments moments(const RadiusDistribution& sizes, ShareOf shares = ShareOf::number) {
  const RadiusSampler sampler(sizes, shares);
  RandomNumbers random(11);
  Moments m;
  double square = 0;
  for (int k = 0; k < draws; ++k) {
    const double r = sampler.draw(random);
    m.mean += r / draws, square += r * r / draws;
    m.least = std::min(m.least, r), m.largest = std::max(m.largest, r);
  }
  m.deviation = std::sqrt(square - m.mean * m.mean);
  return m;
}

/// Four standard errors of a mean over the draws: deviation/sqrt(draws).
double error_of_mean(double deviation) { return 4 * deviation / std::sqrt(draws); }

TEST(BedSizes, Uniform) {
  const Moments m = moments(UniformRadius{0.004, 0.010});
  const double deviation = 0.006 / std::sqrt(12);
  EXPECT_NEAR(m.mean, 0.007, error_of_mean(deviation));
  EXPECT_NEAR(m.deviation, deviation, error_of_mean(deviation));
  EXPECT_GE(m.least, 0.004);
  EXPECT_LE(m.largest, 0.010);
}

// Cut one deviation below and two above the mean: mean + s (phi(a) - phi(b))/Z, variance s^2 [1 + (a phi(a) - b
// phi(b))/Z -
// ((phi(a) - phi(b))/Z)^2], a = -1, b = 2.
TEST(BedSizes, NormalCutOff) {
  const double s = 0.001, mean = 0.008;
  const Moments m = moments(NormalRadius{mean, s, mean - s, mean + 2 * s});
  const auto phi = [](double x) { return std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi); };
  const auto below = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
  const double z = below(2) - below(-1), shift = (phi(-1) - phi(2)) / z;
  const double variance = s * s * (1 + (-1 * phi(-1) - 2 * phi(2)) / z - shift * shift);
  EXPECT_NEAR(m.mean, mean + s * shift, error_of_mean(s));
  EXPECT_NEAR(m.deviation, std::sqrt(variance), error_of_mean(s));
  EXPECT_GE(m.least, mean - s);
  EXPECT_LE(m.largest, mean + 2 * s);
}

// Equal mass of 5 and 10 mm: eight small ones for each large one.
TEST(BedSizes, TableByNumberAndByMass) {
  const TableRadius table{{0.005, 0.010}, {3, 1}};
  EXPECT_NEAR(moments(table).mean, 0.75 * 0.005 + 0.25 * 0.010, error_of_mean(0.0025));
  const TableRadius halves{{0.005, 0.010}, {1, 1}};
  EXPECT_NEAR(moments(halves, ShareOf::mass).mean, (8 * 0.005 + 0.010) / 9, error_of_mean(0.0025));
}

// Even in mass between a and b: number density ~ r^-3, so the mean radius is (1/a - 1/b)/((1/a^2 - 1/b^2)/2).
TEST(BedSizes, UniformByMass) {
  const double a = 0.004, b = 0.010;
  const double mean = 2 * (1 / a - 1 / b) / (1 / (a * a) - 1 / (b * b));
  EXPECT_NEAR(moments(UniformRadius{a, b}, ShareOf::mass).mean, mean, error_of_mean(0.003));
  EXPECT_GT(std::abs(moments(UniformRadius{a, b}).mean - mean), error_of_mean(0.003));  // by number it is another
}

// Uniform by number: the mean of r^3 is (b^4 - a^4)/(4 (b - a)); even masses of 2 and 8 mm: (1 + 1)/(1/a^3 + 1/b^3). Of
// 20,000 drawn the mean of r^3 errs by 1 % at most and 4 %, where one in 65 is a large one; of the radius by a third.
TEST(BedSizes, RadiusOfMeanVolume) {
  const double a = 0.002, b = 0.008;
  EXPECT_EQ(radius_of_mean_volume(EqualRadius{a}, ShareOf::mass), a);
  const double uniform = std::cbrt((std::pow(b, 4) - std::pow(a, 4)) / (4 * (b - a)));
  EXPECT_NEAR(radius_of_mean_volume(UniformRadius{a, b}, ShareOf::number), uniform, 0.01 * uniform);
  const double table = std::cbrt(2 / (std::pow(a, -3) + std::pow(b, -3)));
  EXPECT_NEAR(radius_of_mean_volume(TableRadius{{a, b}, {1, 1}}, ShareOf::mass), table, 0.04 * table);
}

TEST(BedSizes, NormalNumbersAndBall) {
  RandomNumbers random(5);
  double mean = 0, square = 0, fourth = 0, radius = 0;
  for (int k = 0; k < draws; ++k) {
    const double x = random.normal();
    mean += x / draws, square += x * x / draws, fourth += x * x * x * x / draws;
    radius += norm(random.in_unit_ball()) / draws;
  }
  EXPECT_NEAR(mean, 0, error_of_mean(1));
  EXPECT_NEAR(square, 1, error_of_mean(std::sqrt(2)));
  EXPECT_NEAR(fourth, 3, error_of_mean(std::sqrt(96)));
  EXPECT_NEAR(radius, 0.75, error_of_mean(std::sqrt(3.0 / 5 - 9.0 / 16)));
}

TEST(BedSizes, RefusesNonsense) {
  EXPECT_THROW(RadiusSampler(EqualRadius{0}, ShareOf::number), std::invalid_argument);
  EXPECT_THROW(RadiusSampler(UniformRadius{0.01, 0.005}, ShareOf::number), std::invalid_argument);
  EXPECT_THROW(RadiusSampler(NormalRadius{0.01, 0.001, 0.02, 0.03}, ShareOf::number), std::invalid_argument);
  EXPECT_THROW(RadiusSampler(TableRadius{{0.01}, {0}}, ShareOf::number), std::invalid_argument);
  EXPECT_THROW(RadiusSampler(TableRadius{{0.01}, {}}, ShareOf::number), std::invalid_argument);
}

}  // namespace
}  // namespace subsoil::dem::test::bed_placement
