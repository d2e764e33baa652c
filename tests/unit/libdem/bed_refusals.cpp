#include <gtest/gtest.h>

#include <stdexcept>

#include "libdem/bed.hpp"
#include "libdem/laws/linear.hpp"
#include "tests/tools/message_of.hpp"

/// What a C++ program is refused: parameters of laws and tables of laws that a scenario would be refused too.
namespace subsoil::dem::bed_refusals {
namespace {

Linear good() {
  Linear law;
  law.k_n = 1e5, law.restitution = 0.5;
  return law;
}
std::string refusal(const Linear& law) {
  return subsoil::test::message_of([&] { static_cast<void>(Law(law)); });
}

TEST(LawParameters, AreCheckedAgainstTheirRanges) {
  EXPECT_EQ(refusal(good()), "accepted");
  Linear law = good();
  law.restitution = 2;
  EXPECT_EQ(refusal(law), "restitution = 2.000000: must be in (0, 1]");
  law = good(), law.restitution = 1;
  EXPECT_EQ(refusal(law), "accepted") << "the bound belongs to the range";
  law = good(), law.k_n = -1;
  EXPECT_EQ(refusal(law), "k_n = -1.000000: must be in (0, inf)");
  law = Linear{}, law.restitution = 0.5;
  EXPECT_EQ(refusal(law), "k_n: is missing; its range is (0, inf)");
  law = good(), law.friction.mu = -0.1;
  EXPECT_NE(refusal(law).find("mu = -0.1"), std::string::npos);
}

/// A sphere that slides on a plane keeps its velocity: friction that is left out is none.
TEST(LawParameters, FrictionLeftOutIsNone) {
  Bed bed({.materials = 1, .index = {0}, .laws = {Law(good())}}, {.gravity = {0, -9.81, 0}, .threads = 1});
  Boundary floor;
  floor.shape = Plane({0, 0, 0}, {0, 1, 0});
  bed.add(std::move(floor));
  const SphereSpec sphere{
      .position = {0, 0.01, 0}, .velocity = {1, 0, 0}, .angular_velocity = {}, .radius = 0.01, .density = 2500};
  bed.add(std::span(&sphere, 1));
  for (int k = 0; k < 2000; ++k) bed.step(1e-5);
  EXPECT_EQ(bed.spheres()[0].v.x, 1);
  EXPECT_EQ(bed.spheres()[0].w.z, 0);
}

TEST(LawTables, AreWholeSymmetricAndNameLawsThatThereAre) {
  const Law law(good());
  const auto refused = [&](int materials, std::vector<int> index) {
    return subsoil::test::message_of(
        [&] { Bed({.materials = materials, .index = std::move(index), .laws = {law}}, {}); });
  };
  EXPECT_EQ(refused(2, {0, -1, -1, 0}), "accepted");
  EXPECT_EQ(refused(2, {0, 0}), "LawTable: index has 2 entries; 2 materials need 4");
  EXPECT_EQ(refused(1, {1}), "LawTable: index of materials 0 and 0 = 1: there are 1 laws, counted from 0; -1 is none");
  EXPECT_EQ(refused(2, {0, 0, -1, 0}),
            "LawTable: index of materials 0 and 1 is another than the other way round; a pair has one law");
  Bed bed({.materials = 1, .index = {0}, .laws = {law}}, {});
  Boundary floor;
  floor.name = "floor", floor.material = 7;
  EXPECT_EQ(subsoil::test::message_of([&] { bed.add(floor); }),
            "boundary 'floor': material 7: the laws are of 1, counted from 0");
}

}  // namespace
}  // namespace subsoil::dem::bed_refusals
