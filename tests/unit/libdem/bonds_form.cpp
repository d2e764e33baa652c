#include <gtest/gtest.h>

#include "tests/tools/attraction.hpp"
#include "tests/tools/dem_beds.hpp"

/// Which pairs are bonded.
namespace subsoil::dem::test::bonds_form {
namespace {

constexpr double radius = 5e-3;

std::size_t formed_in_row(int spheres, double start, double pitch, double gap) {
  Linear law = grains(1e5, 0.5, 0.4, 0);
  law.bond = cement(1e8, 1e6);
  law.bond.gap = gap;
  Bed bed(table(law), quiet());
  std::vector<SphereSpec> row;
  for (int k = 0; k < spheres; ++k) row.push_back({{start + pitch * k, 0, 0}, {}, {}, radius, 2500, 0});
  bed.add(row);
  bed.let_bonds_form();
  bed.step(1e-7);
  return bed.bonds().formed;
}

/// At 0.03 m the pitch of 0.01 m is no longer 2 r to the last bit: coordinates round to 3e-18 m there, to 1.4e-14 m at
/// 100 m, and spheres that touch may stand apart by two such roundings.
TEST(BondsForm, BetweenSpheresThatTouchButForRounding) {
  for (const double start : {0.0, 0.1, -0.37, 3.3, 100.0})
    EXPECT_EQ(formed_in_row(40, start, 2 * radius, 0), 39u) << "from " << start << " m";
}

/// A ten-thousandth of a micrometre is a gap, as is more than `bond gap`.
TEST(BondsForm, NotAcrossAGap) {
  EXPECT_EQ(formed_in_row(40, 0, 2 * radius + 1e-10, 0), 0u);
  EXPECT_EQ(formed_in_row(40, 0, 2 * radius + 1e-4, 1e-4), 39u) << "but for rounding again";
  EXPECT_EQ(formed_in_row(40, 0, 2 * radius + 1e-4, 0.999e-4), 0u);
}

}  // namespace
}  // namespace subsoil::dem::test::bonds_form
