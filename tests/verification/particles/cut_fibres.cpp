#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <memory>

#include "libdem/geometry/cutting_edges.hpp"
#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/packing/fibres.hpp"
#include "libdem/step/stability.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/verified.hpp"

/// Fibres under a cutting edge: a force of sigma_e A/sin(alpha) cuts, less does not, the balance closes. The force is
/// that on the knife, read at its boundary; the bond is that under the edge.
namespace subsoil::dem::test::cut_fibres {
namespace {

using subsoil::test::share;
using subsoil::test::Verified;

constexpr double kR = 2e-3, kD = 2 * kR, kStrength = 1e4, kArea = pi * kR * kR, kForce = kStrength * kArea;
constexpr double kStiffness = 1e3, kSpeed = 0.01;
constexpr int kSpheres = 9;

Linear straw(double mu = 0) {
  Linear law = grains(kStiffness, 0.5, mu, 0);
  law.bond = {.kind = Bond::Kind::fibre, .modulus = 1e7, .tensile = 1e6, .shear = 1e6, .cutting = kStrength};
  law.bond.damping = 0.2;
  return law;
}

/// A wedge of 30 degrees with its edge along z at the origin, below the rest of it.
TriangleMesh wedge() {
  const double w = 0.01, h = 0.01, b = h * std::tan(pi / 12);
  return TriangleMesh({{0, 0, -w}, {-b, h, -w}, {b, h, -w}, {0, 0, w}, {-b, h, w}, {b, h, w}},
                      {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1}, {0, 2, 5}, {0, 5, 3}, {1, 4, 5}, {1, 5, 2}});
}
constexpr double kSharp = pi / 6;  ///< angle of the wedge, with which its edge cuts

/// Spheres that are fixed: without friction a knife beside the middle of a sphere pushes the fibre away.
using Held = std::function<bool(std::uint32_t id)>;
bool at_both_ends(std::uint32_t id) { return id == 0 || id == kSpheres - 1; }
bool at_one_end(std::uint32_t id) { return id == 0; }
bool every_other(std::uint32_t id) { return id % 2 == 0; }

/// A fibre lies along x on a floor, its middle sphere at the origin of x, and the knife comes down at x.
struct Cut {
  Bed bed;
  Motion knife;
  double dt;
  double before = 0, now = 0;  ///< force on the knife in the last two steps, N

  Cut(double x, double angle, const Held& held = at_both_ends, int threads = 1,
      Precision precision = Precision::doubles, double mu = 0)
      : bed(table(straw(mu)), options(threads, precision)) {
    const FibreShape shape{.length = kSpheres * kD, .diameter = kD, .of = {.density = 200, .material = 0}};
    const StepQuestion q{.smallest_radius = kR, .largest_radius = kR, .density = 300, .speed = kSpeed, .neighbours = 4};
    dt = 0.2 * stable_step(straw(), q).step;
    add_plane(bed, {0, 0, 0}, {0, 1, 0});
    const FibrePose pose{{0, kR, 0}, {1, 0, 0}};
    bed.insert(fibres_at(shape, {&pose, 1}, 0));
    bed.fix_if([&](const Sphere& sphere) { return held(sphere.id); });
    Boundary b;
    b.name = "knife", b.shape = MeshSurface(wedge()), b.edges = cutting_edges(wedge(), kSharp);
    knife = {
        bed.add(std::move(b)), {{x, 2 * kR, 0}, Quaternion::from_rotation_vector({0, angle, 0})}, {0, -kSpeed, 0}, {}};
    knife.place(bed);
    bed.step(dt, {.energy = true});
  }
  static BedOptions options(int threads, Precision precision) {
    BedOptions o = quiet({}, threads);
    o.precision = precision;
    return o;
  }
  void step() {
    knife.place(bed);
    bed.step(dt, {.energy = true});
    before = now, now = bed.boundary(knife.boundary).wrench.force.y;
  }
  /// Down to the first bond that breaks. A step later than the force that cuts it: `before` is that force.
  void until_cut(double deepest) {
    while (bed.bonds().broken() == 0 && kSpeed * bed.time() < deepest) {
      last_held_ = before;
      step();
    }
  }
  double last_held() const { return last_held_; }

 private:
  double last_held_ = 0;
};

TEST(CuttingEdges, AreTheSharpConvexOnes) {
  const std::vector<WedgeEdge> of_wedge = wedge_edges(wedge());
  EXPECT_EQ(of_wedge.size(), 9U) << "of a prism; diagonals of its faces are flat";
  const std::vector<CuttingEdge> edges = cutting_edges(wedge(), kSharp);
  EXPECT_TRUE(cutting_edges(wedge(), 0.999 * kSharp).empty());
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_EQ(edges[0].from, (Vec3{0, 0, -0.01}));
  EXPECT_EQ(edges[0].to, (Vec3{0, 0, 0.01}));
  for (const WedgeEdge& e : wedge_edges(box_mesh({1, 2, 3}))) EXPECT_NEAR(e.angle, pi / 2, 1e-12);
  EXPECT_EQ(wedge_edges(box_mesh({1, 2, 3})).size(), 12U);
  EXPECT_NEAR(norm(edges[0].outward - Vec3{0, -1, 0}), 0, 1e-15);
  // Of a sheet of two triangles the rim, not the fold; of an L without its hollow edge.
  const TriangleMesh sheet({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.2}}, {{0, 1, 2}, {1, 3, 2}});
  const std::vector<WedgeEdge> rims = wedge_edges(sheet);
  EXPECT_EQ(rims.size(), 4U);
  for (const WedgeEdge& e : rims) {
    EXPECT_EQ(e.angle, 0);
    EXPECT_GT(dot(e.edge.outward, 0.5 * (e.edge.from + e.edge.to) - Vec3{0.5, 0.5, 0}), 0);
  }
  const std::vector<Point2> outline{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  EXPECT_EQ(wedge_edges(extruded_mesh(outline, 1)).size(), 18U - 1U);
  EXPECT_TRUE(edge_at(edges, {0, 0, 0.003}, 1e-12));
  EXPECT_FALSE(edge_at(edges, {0, 0, 0.0100001}, 1e-12));
  EXPECT_FALSE(edge_at(edges, {1e-9, 0, 0}, 1e-12));
  EXPECT_TRUE(edge_at(edges, {1e-9, 0, 0}, 1e-8));
}

/// In a step the force of the knife grows by less than k_n v dt, a share 5e-4 of the force at the cut. The load
/// is that in the direction of the edge, wherever on a sphere it stands, with friction and without.
TEST(CutFibre, BreaksAtTheStrengthTimesTheSection) {
  const Verified row("Fibres", "Fibre on a floor under a knife, sigma_e 10 kPa, d 4 mm", "sigma_e A/sin(alpha)");
  const struct {
    const char* name;
    double x, angle;
    std::array<std::uint32_t, 2> ids;
    double mu = 0;
  } cases[] = {{"force that cuts across, over a sphere", 0.3 * kR, 0, {4, 5}},
               {"over the gap of two spheres", kR, 0, {4, 5}},
               {"over the gap, with friction of 0.3", kR, 0, {4, 5}, 0.3},
               {"at 45 degrees", 0.05 * kR, pi / 4, {4, 5}},
               {"at 60 degrees from across", -0.05 * kR, pi / 3, {3, 4}}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    Cut cut(c.x, c.angle, at_both_ends, 1, Precision::doubles, c.mu);
    cut.until_cut(1.8 * kR);
    ASSERT_EQ(cut.bed.bonds().cut, 1U);
    EXPECT_EQ(cut.bed.bonds().broken(), 1U);
    EXPECT_EQ(cut.bed.broken_bonds()[0].ids, c.ids);
    EXPECT_TRUE(cut.bed.broken_bonds()[0].by_edge);
    const double force = kForce / std::cos(c.angle);
    row.near(c.name, "N", cut.before, force, share(2e-3), "a step of the knife; bent by a hundredth");
    EXPECT_LT(cut.last_held(), cut.before) << "the force before did not cut";
  }
}

/// In the step after the cut the bond is gone; over it the balance closes to the first order of that step.
TEST(CutFibre, EnergyCloses) {
  for (const double x : {0.3 * kR, kR}) {
    Cut cut(x, 0);
    const BedEnergy start = cut.bed.energy();
    cut.until_cut(1.8 * kR);
    ASSERT_EQ(cut.bed.bonds().cut, 1U);
    const double lost = cut.bed.broken_bonds()[0].energy;
    EXPECT_GT(lost, 0) << "that the bond held";
    EXPECT_EQ(cut.bed.energy().lost.breaking, lost);
    for (int k = 0; k < 500; ++k) cut.step();
    EXPECT_EQ(cut.bed.bonds().cut, 1U) << "the halves are not cut again";
    const BedEnergy& end = cut.bed.energy();
    const double work = end.boundary_work - start.boundary_work;
    EXPECT_GT(work, 1e-6);
    EXPECT_NEAR(end.total() - start.total(), work, 2e-3 * work);
  }
}

/// Held at 0.97 of the force, with an edge along the fibre, or by a knife without edges that cut, the fibre holds.
TEST(CutFibre, LessForceOrNoEdgeAcrossDoesNotCut) {
  Cut held(0.3 * kR, 0);
  while (held.now < 0.97 * kForce) held.step();
  held.knife.start.position.y -= kSpeed * held.bed.time(), held.knife.velocity = {};
  held.bed.set_time(0);
  for (int k = 0; k < 5000; ++k) held.step();
  EXPECT_GT(held.now, 0.9 * kForce);
  EXPECT_EQ(held.bed.bonds().broken(), 0U);

  Cut along(0, pi / 2, every_other);
  along.until_cut(0.3 * kR);
  EXPECT_GT(along.now, 4 * kForce) << "spread over spheres";
  EXPECT_EQ(along.bed.bonds().broken(), 0U);

  Cut blunt(0.3 * kR, 0);
  blunt.bed.boundary(blunt.knife.boundary).edges.clear();
  blunt.until_cut(0.3 * kR);
  EXPECT_GT(blunt.now, 2 * kForce);
  EXPECT_EQ(blunt.bed.bonds().broken(), 0U);
}

/// A knife near the middle of the last sphere cuts nothing off; between it and the next one it does.
TEST(CutFibre, EndsAreCutOffAtTheirBond) {
  const double last = 0.5 * (kSpheres - 1) * kD;
  Cut beyond(last - 0.2 * kR, 0, at_one_end), between(last - kR, 0, at_one_end);
  beyond.until_cut(0.3 * kR), between.until_cut(1.8 * kR);
  EXPECT_EQ(beyond.bed.bonds().broken(), 0U);
  EXPECT_EQ(between.bed.bonds().cut, 1U);
}

/// Bits on threads, in mixed precision, and of a run that continues from a state saved between mark and break.
TEST(CutFibre, SameBitsOnAnyNumberOfThreadsAndAfterARestart) {
  for (const Precision precision : {Precision::doubles, Precision::mixed}) {
    const auto end = [&](int threads, bool saved) {
      auto cut = std::make_unique<Cut>(0.3 * kR, 0.0, at_both_ends, threads, precision);
      for (long k = std::lround(0.2 * kR / kSpeed / cut->dt); k > 0; --k) {
        if (saved && cut->now >= kForce) {
          saved = false;
          const Bed::State state = cut->bed.save();
          auto again = std::make_unique<Cut>(0.3 * kR, 0.0, at_both_ends, threads, precision);
          again->bed.restore(state);
          cut = std::move(again);
        }
        cut->step();
      }
      EXPECT_FALSE(saved);
      EXPECT_EQ(cut->bed.bonds().cut, 1U);
      return hash(cut->bed);
    };
    const std::uint64_t one = end(1, false);
    EXPECT_EQ(end(3, false), one);
    EXPECT_EQ(end(2, true), one);
  }
}

}  // namespace
}  // namespace subsoil::dem::test::cut_fibres
