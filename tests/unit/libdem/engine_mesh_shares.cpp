#include <gtest/gtest.h>

#include "libdem/geometry/mesh_builders.hpp"
#include "tests/tools/dem_beds.hpp"

/// A boundary of several meshes says what acts on each: of contacts on faces, which go to the plane kernel, and of
/// contacts on edges, which do not.
namespace subsoil::dem::engine_mesh_shares {
namespace {

Bed two_boxes() {
  LawTable laws;
  laws.materials = 1, laws.index = {0}, laws.laws = {test::grains()};
  Bed bed(laws, {.gravity = {}, .threads = 1});
  Boundary tool;
  const std::vector<TriangleMesh> meshes{box_mesh({0.1, 0.02, 0.1}).placed({{-0.1, 0, 0}, {}}),
                                         box_mesh({0.1, 0.02, 0.1}).placed({{0.1, 0, 0}, {}})};
  tool.shape = MeshSurface(meshes);
  bed.add(std::move(tool));
  return bed;
}

void expect_alone_on(Bed& bed, const Vec3& centre, std::size_t mesh) {
  bed.add(std::vector<SphereSpec>{
      {.position = centre, .velocity = {}, .angular_velocity = {}, .radius = 0.01, .density = 2000}});
  bed.step(1e-6);
  const Boundary& tool = bed.boundary(0);
  EXPECT_GT(norm(tool.wrench.force), 1.0) << "it must touch";
  EXPECT_EQ(tool.on_mesh(mesh).force, tool.wrench.force);
  EXPECT_EQ(tool.on_mesh(mesh).moment, tool.wrench.moment);
  EXPECT_EQ(norm(tool.on_mesh(1 - mesh).force), 0);
}

TEST(MeshShares, OnAFace) {
  for (const std::size_t mesh : {0U, 1U}) {
    Bed bed = two_boxes();
    expect_alone_on(bed, {mesh == 0 ? -0.1 : 0.1, 0.0199, 0}, mesh);
  }
}

TEST(MeshShares, OnAnEdge) {
  for (const std::size_t mesh : {0U, 1U}) {
    Bed bed = two_boxes();
    expect_alone_on(bed, {mesh == 0 ? -0.157 : 0.157, 0.017, 0}, mesh);  // 9.9 mm from the edge at (0.15, 0.01)
  }
}

TEST(MeshShares, AddUpToTheWholeWhereBothAreTouched) {
  Bed bed = two_boxes();
  bed.add(std::vector<SphereSpec>{
      {.position = {-0.12, 0.0199, 0.01},
       .velocity = {0.3, 0, 0},
       .angular_velocity = {},
       .radius = 0.01,
       .density = 2000},
      {.position = {0.08, 0.0195, 0}, .velocity = {}, .angular_velocity = {0, 0, 9}, .radius = 0.01, .density = 2000},
      {.position = {0.157, 0.017, 0}, .velocity = {}, .angular_velocity = {}, .radius = 0.01, .density = 2000}});
  for (int k = 0; k < 20; ++k) bed.step(1e-6);
  const Boundary& tool = bed.boundary(0);
  const Vec3 force = tool.meshes.at(0).force + tool.meshes.at(1).force;
  const Vec3 moment = tool.meshes.at(0).moment + tool.meshes.at(1).moment;
  EXPECT_LT(norm(force - tool.wrench.force), 1e-14 * norm(tool.wrench.force)) << "two orders of a sum of three";
  EXPECT_LT(norm(moment - tool.wrench.moment), 1e-14 * norm(tool.wrench.moment));
  EXPECT_GT(norm(tool.meshes[0].force), 1.0);
  EXPECT_GT(norm(tool.meshes[1].force), 1.0);
}

}  // namespace
}  // namespace subsoil::dem::engine_mesh_shares
