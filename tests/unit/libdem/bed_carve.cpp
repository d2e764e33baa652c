// Carving: no sphere is left on or in the tool, and none further away is taken.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libdem/geometry/mesh_builders.hpp"
#include "libdem/packing/carve.hpp"
#include "tests/unit/libdem/bed_support.hpp"

namespace subsoil::dem::test::bed_carve {
namespace {

Bed full_bed() {
  Bed bed(table_3(), {});
  LatticePlan plan;
  plan.region = {{-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}};
  plan.radius = EqualRadius{0.010};
  plan.jitter = 0.3;
  bed.add(rest_lattice(plan, 0.002, soil_material));
  return bed;
}

/// Distance from p to a box of half edges h about the origin, negative inside; independent of the mesh.
double distance_to_box(const Vec3& p, const Vec3& h) {
  const Vec3 q{std::abs(p.x) - h.x, std::abs(p.y) - h.y, std::abs(p.z) - h.z};
  const Vec3 out{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)};
  return norm(out) + std::min(0.0, std::max({q.x, q.y, q.z}));
}

TEST(BedCarve, TakesExactlyWhatABoxCoversHoweverThick) {
  const Vec3 half{0.05, 0.06, 0.04};  // centres up to 40 mm inside: out of reach of the surface
  Bed bed = full_bed();
  Boundary tool;
  tool.name = "tool";
  tool.shape = MeshSurface(box_mesh(2.0 * half));
  tool.material = 1;
  tool.pose = {{0.01, 0.02, -0.005}, Quaternion::from_rotation_vector({0.3, -0.2, 0.5})};
  const int index = bed.add(tool);
  std::vector<std::uint32_t> expected;
  for (const Sphere& s : bed.spheres())
    if (distance_to_box(tool.pose.to_local(s.x), half) < s.r) expected.push_back(s.id);
  std::sort(expected.begin(), expected.end());
  ASSERT_GT(expected.size(), 100u);
  const std::array which{index};
  EXPECT_EQ(spheres_in_the_way(bed, which), expected);
  const std::size_t before = bed.spheres().size();
  EXPECT_EQ(carve(bed, which), expected.size());
  EXPECT_EQ(bed.spheres().size(), before - expected.size());
  for (const Sphere& s : bed.spheres()) EXPECT_GE(distance_to_box(tool.pose.to_local(s.x), half), s.r);
  EXPECT_TRUE(spheres_in_the_way(bed, which).empty());
}

TEST(BedCarve, CylinderPlaneAndClearance) {
  Bed bed = full_bed();
  Boundary wheel;
  wheel.shape = Cylinder({}, {0, 0, 1}, 0.06, 0.05);
  wheel.material = 1;
  Boundary cut;
  cut.shape = Plane({0, -0.05, 0}, {0, 1, 0});
  cut.material = 1;
  const std::array which{bed.add(wheel), bed.add(cut)};
  carve(bed, which, 0.003);
  ASSERT_GT(bed.spheres().size(), 50u);
  for (const Sphere& s : bed.spheres()) {
    const double radial = std::hypot(s.x.x, s.x.y) - 0.06, axial = std::abs(s.x.z) - 0.025;
    const double distance =
        std::hypot(std::max(radial, 0.0), std::max(axial, 0.0)) + std::min(0.0, std::max(radial, axial));
    EXPECT_GE(distance, s.r + 0.003 - 1e-12);
    EXPECT_GE(s.x.y + 0.05, s.r + 0.003 - 1e-12);
  }
}

TEST(BedCarve, LeavesABedThatIsClear) {
  Bed bed = full_bed();
  Boundary tool;
  tool.shape = MeshSurface(box_mesh({0.02, 0.02, 0.02}));
  tool.material = 1;
  tool.pose.position = {0, 0.3, 0};
  const std::array which{bed.add(tool)};
  EXPECT_EQ(carve(bed, which), 0u);
}

}  // namespace
}  // namespace subsoil::dem::test::bed_carve
