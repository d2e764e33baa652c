#include <gtest/gtest.h>

#include <map>

#include "libdem/geometry/mesh_builders.hpp"
#include "tests/tools/dem_beds.hpp"

/// Single contacts as results show them. The oracle of forces is the bed's own sum over the contacts of a sphere, which
/// comes by another way (the sweep); of loads on triangles it is closed forms of sliding and impact.
namespace subsoil::dem::test::contact_records {
namespace {

/// Spheres of several sizes that fall on a floor of triangles between planes; a box on edge stands out of it.
Bed pile(Precision precision, int threads, bool loads = false) {
  BedOptions options = quiet({0.3, -30, 0}, threads);
  options.precision = precision;
  Bed bed(table(grains(5e4, 0.5, 0.4, 0.1)), options);
  Dice dice(7);
  bed.add(loose_lattice({0, 0.028, 0}, 9, 5, 8, 0.0198, 0.01, 0.3, 0.5, dice));
  for (const auto& [at, normal] : {std::pair<Vec3, Vec3>{{0, 0, 0}, {1, 0, 0}},
                                   {{0.18, 0, 0}, {-1, 0, 0}},
                                   {{0, 0, 0}, {0, 0, 1}},
                                   {{0, 0, 0.16}, {0, 0, -1}}})
    add_plane(bed, at, normal);
  Boundary floor;
  floor.shape = MeshSurface(box_mesh({0.4, 0.02, 0.4}));
  floor.pose.position = {0.09, -0.01, 0.08};
  if (loads) floor.loads.emplace(floor.shape);
  bed.add(std::move(floor));
  Boundary tool;
  tool.shape = MeshSurface(box_mesh({0.03, 0.03, 0.03}));
  tool.pose = {{0.09, 0, 0.08}, Quaternion::from_rotation_vector({0.3, 0.4, 0.5})};
  if (loads) tool.loads.emplace(tool.shape);
  bed.add(std::move(tool));
  return bed;
}

constexpr double step = 2e-5;

/// Sum of what the contacts give each sphere, by id.
std::map<std::uint32_t, Vec3> sums(const std::vector<ContactRecord>& contacts) {
  std::map<std::uint32_t, Vec3> sum;
  for (const ContactRecord& c : contacts) {
    sum[c.i] += c.force;
    if (!c.at_surface) sum[c.j] += -c.force;
  }
  return sum;
}

void expect_sums(Precision precision, double tolerance) {
  Bed bed = pile(precision, 1);
  for (int n = 0; n < 8000; ++n) bed.step(step);
  Snapshot s;
  std::vector<ContactRecord> contacts;
  bed.step(step, {.snapshot = &s, .contacts = &contacts});
  std::map<std::uint32_t, Vec3> sum = sums(contacts);
  double largest = 0, off = 0;
  int pairs = 0, surfaces = 0;
  for (const ContactRecord& c : contacts)
    c.at_surface ? ++surfaces : ++pairs, largest = std::max(largest, norm(c.force));
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    const double mass = 1800 * sphere_volume(s.radius[k]);
    off = std::max(off, norm(sum[s.id[k]] + mass * bed.options().gravity - s.force[k]));
  }
  EXPECT_GT(pairs, 300);
  EXPECT_GT(surfaces, 40);
  EXPECT_GT(largest, 0.1);
  EXPECT_LT(off, tolerance * largest);
  for (int b = 0; b < bed.boundary_count(); ++b) {
    Vec3 on;
    for (const ContactRecord& c : contacts)
      if (c.at_surface && c.j == static_cast<std::uint32_t>(b)) on += -c.force;
    EXPECT_LT(norm(on - bed.boundary(b).wrench.force), 1e-9 * largest) << b;
  }
}

/// Another order of a dozen additions.
TEST(ContactRecords, AddUpToTheForceOnEverySphereAndSurface) { expect_sums(Precision::doubles, 1e-13); }
/// Sums of floats: a dozen times 6e-8.
TEST(ContactRecords, AddUpInMixedPrecision) { expect_sums(Precision::mixed, 1e-6); }

TEST(ContactRecords, AskingForThemChangesNoBitNorDoThreads) {
  std::vector<std::uint64_t> hashes;
  std::vector<double> works;
  for (const auto& [threads, asks] : {std::pair{1, false}, {1, true}, {3, true}}) {
    Bed bed = pile(Precision::doubles, threads, asks);
    std::vector<ContactRecord> contacts;
    for (int n = 0; n < 2600; ++n) bed.step(step, {.contacts = asks && n % 20 == 19 ? &contacts : nullptr});
    hashes.push_back(hash(bed));
    double work = 0;
    for (const ContactRecord& c : contacts) work = 0.7 * work + dot(c.force, c.velocity);
    if (asks)
      for (const FaceLoad& f : bed.boundary(4).loads->faces) work = 0.7 * work + f.shear_work + f.rubbing;
    works.push_back(work);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[1], hashes[2]);
  EXPECT_EQ(works[1], works[2]) << "the order of contacts";
}

TEST(ContactRecords, BeginAtTheSurfaceAndPointAtTheSphere) {
  Bed bed = pile(Precision::doubles, 1);
  for (int n = 0; n < 8000; ++n) bed.step(step);
  Snapshot s;
  std::vector<ContactRecord> contacts;
  bed.step(step, {.snapshot = &s, .contacts = &contacts});
  for (const ContactRecord& c : contacts) {
    const Vec3 to_centre = s.position[c.i] - c.point;  // ids begin at 0 and nobody has left
    EXPECT_NEAR(norm(c.normal), 1, 1e-12);
    EXPECT_GT(dot(to_centre, c.normal), 0.9 * s.radius[c.i]);
    EXPECT_LT(norm(to_centre - dot(to_centre, c.normal) * c.normal), 1e-12);
    if (c.at_surface) continue;
    EXPECT_LT(dot(s.position[c.j] - c.point, c.normal), -0.9 * s.radius[c.j]);
  }
}

/// A sphere of mass m on a floor of 20 strips of 2 cm, each of two triangles.
struct OnStrips {
  static constexpr double radius = 0.01, density = 2500;
  double mass = density * sphere_volume(radius);
  Bed bed;
  explicit OnStrips(const Linear& law) : bed(table(law), quiet({0, -9.81, 0})) {
    std::vector<Vec3> v;
    std::vector<Triangle> t;
    for (std::uint32_t k = 0; k <= 20; ++k)
      for (const double z : {-0.05, 0.05}) v.push_back({0.02 * k, 0, z});
    for (std::uint32_t k = 0; k < 20; ++k)
      t.push_back({2 * k, 2 * k + 1, 2 * k + 2}), t.push_back({2 * k + 1, 2 * k + 3, 2 * k + 2});
    Boundary floor;
    floor.shape = MeshSurface(TriangleMesh(v, t));
    floor.loads.emplace(floor.shape);
    bed.add(std::move(floor));
    const double rest = mass * 9.81 / law.k_n;
    const SphereSpec ball{{0.05, radius - rest, 0.001}, {0.5, 0, 0}, {}, radius, density, 0};
    bed.add(std::span(&ball, 1));
  }
  const std::vector<FaceLoad>& faces() const { return bed.boundary(0).loads->faces; }
  FaceLoad total() const {
    FaceLoad sum;
    for (const FaceLoad& f : faces()) sum += f;
    return sum;
  }
};

/// Without friction it goes on at v: a load m g over a path s = v t rubs m g s, of which each strip of length L bears
/// m g L. (Archard: worn volume K m g s/H.) Forces of t_n times the path of the step before: exact up to the step at
/// either end of a strip.
TEST(SurfaceLoads, RubbingIsLoadTimesPathAndLiesWhereItIs) {
  OnStrips one(grains(1e5, 0.5, 0, 0));
  const double v = 0.5, dt = 1e-5;
  const int steps = 40000;  // 0.2 m: from x = 0.05 to 0.25
  for (int n = 0; n <= steps; ++n) one.bed.step(dt);
  const double weight = one.mass * 9.81;
  const FaceLoad sum = one.total();
  EXPECT_NEAR(sum.rubbing, weight * v * steps * dt, 1e-6 * weight * v);
  EXPECT_NEAR(sum.impulse, weight * steps * dt, 1e-6 * weight);
  EXPECT_LT(std::abs(sum.shear_work), 1e-12);
  for (std::size_t strip = 3; strip < 12; ++strip) {
    const double rubbed = one.faces()[2 * strip].rubbing + one.faces()[2 * strip + 1].rubbing;
    EXPECT_NEAR(rubbed, weight * 0.02, 1.01 * weight * v * dt) << strip;
  }
  EXPECT_EQ(one.faces()[0].rubbing, 0);
  EXPECT_EQ(one.faces()[30].rubbing, 0);
}

/// With friction the slip velocity v - (7/2) mu g t falls to zero over v^2/(7 mu g): rubbing m v^2/(7 mu), shear work
/// m v^2/7 (MFiX DEM04). The tangential spring k_t keeps (mu m g)^2/(2 k_t) = 1e-3 of the shear work, and sticking
/// creeps on it: 1 % covers both.
TEST(SurfaceLoads, SlidingToRollingCostsAShareOfTheKineticEnergy) {
  const double mu = 0.3, v = 0.5;
  OnStrips one(grains(1e5, 0.5, mu, 0));
  for (int n = 0; n < 10000; ++n) one.bed.step(1e-5);  // 2 v/(7 mu g) = 49 ms
  const FaceLoad sum = one.total();
  EXPECT_NEAR(sum.shear_work, one.mass * v * v / 7, 0.01 * one.mass * v * v / 7);
  EXPECT_NEAR(sum.rubbing, one.mass * v * v / (7 * mu), 0.01 * one.mass * v * v / (7 * mu));
}

/// An elastic blow: on approach the floor takes the kinetic energy (gravity off), impulse is 2 m v.
TEST(SurfaceLoads, BlowGivesItsEnergyAndImpulse) {
  Bed bed(table(grains(1e5, 1, 0, 0)), quiet());
  Boundary floor;
  floor.shape = MeshSurface(box_mesh({0.2, 0.02, 0.2}));
  floor.pose.position.y = -0.01;
  floor.loads.emplace(floor.shape);
  bed.add(std::move(floor));
  const SphereSpec ball{{0.013, 0.0101, 0.02}, {0, -1, 0}, {}, 0.01, 2500, 0};
  bed.add(std::span(&ball, 1));
  for (int n = 0; n < 2000; ++n) bed.step(1e-6);
  const double m = 2500 * sphere_volume(0.01);
  FaceLoad sum;
  for (const FaceLoad& f : bed.boundary(0).loads->faces) sum += f;
  // First order in the step, of which the blow lasts pi sqrt(m/k) = 1,000.
  EXPECT_NEAR(sum.normal_work, 0.5 * m, 2e-3 * m);
  EXPECT_NEAR(sum.impulse, 2 * m, 2e-3 * m);
}

/// Finnie's function: Q of ductile materials at K = 2, both branches meet at tan a = 1/3 where f = 0.3.
TEST(SurfaceLoads, FinnieSharesByAngle) {
  const auto at = [](double degrees) {
    const double a = degrees * pi / 180;
    return finnie_share(3 * std::sin(a), 3 * std::cos(a));
  };
  EXPECT_NEAR(finnie_share(1, 3), 0.3, 1e-15);
  EXPECT_NEAR(finnie_share(1 + 1e-9, 3), 0.3, 1e-8);
  EXPECT_NEAR(at(10), std::sin(20 * pi / 180) - 3 * std::pow(std::sin(10 * pi / 180), 2), 1e-15);
  EXPECT_NEAR(at(60), 0.25 / 3, 1e-15);
  EXPECT_NEAR(at(90), 0, 1e-15);
  EXPECT_EQ(finnie_share(0, 1), 0);
  EXPECT_EQ(finnie_share(-1, 1), 0) << "it recedes";
}

TEST(SurfaceLoads, CylinderBearsThemOnTheTrianglesThatDrawIt) {
  Bed bed(table(grains(1e5, 0.5, 0.3, 0)), quiet({0, -9.81, 0}));
  Boundary roll;
  roll.shape = Cylinder({}, {0, 0, 1}, 0.1, 0.2);
  roll.loads.emplace(roll.shape);
  bed.add(std::move(roll));
  const SphereSpec ball{{0, 0.11, 0.03}, {}, {}, 0.01, 2500, 0};
  bed.add(std::span(&ball, 1));
  for (int n = 0; n < 2000; ++n) bed.step(1e-5);
  const std::vector<TriangleMesh> drawn = drawing(bed.boundary(0).shape, 1);
  const std::vector<FaceLoad>& faces = bed.boundary(0).loads->faces;
  ASSERT_EQ(faces.size(), drawn.front().triangles().size());
  double impulse = 0;
  for (std::size_t t = 0; t < faces.size(); ++t) {
    impulse += faces[t].impulse;
    if (faces[t].impulse == 0) continue;
    EXPECT_GT(drawn.front().normal(t).y, 0.9) << "on top";
  }
  EXPECT_GT(impulse, 0);
}

/// Through a saved state as through none.
TEST(SurfaceLoads, GoOnFromAState) {
  Bed straight = pile(Precision::doubles, 1, true), half = pile(Precision::doubles, 1, true);
  for (int n = 0; n < 4000; ++n) straight.step(step);
  for (int n = 0; n < 2000; ++n) half.step(step);
  const Bed::State state = half.save();
  Bed on = pile(Precision::doubles, 1, true);
  on.restore(state);
  for (int n = 0; n < 2000; ++n) on.step(step);
  ASSERT_EQ(hash(on), hash(straight));
  const auto &a = straight.boundary(4).loads->faces, &b = on.boundary(4).loads->faces;
  double sum = 0;
  for (std::size_t t = 0; t < a.size(); ++t) {
    EXPECT_EQ(a[t].rubbing, b[t].rubbing);
    EXPECT_EQ(a[t].impulse, b[t].impulse);
    sum += a[t].rubbing;
  }
  EXPECT_GT(sum, 0);
  Bed without = pile(Precision::doubles, 1, false);
  EXPECT_THROW(without.restore(state), std::invalid_argument);
}

}  // namespace
}  // namespace subsoil::dem::test::contact_records
