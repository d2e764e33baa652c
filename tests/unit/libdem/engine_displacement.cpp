#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "libdem/neighbours/relative_displacement.hpp"
#include "tests/tools/dem_beds.hpp"

namespace subsoil::dem::test::engine_displacement {
namespace {

constexpr double kEdge = 0.024, kSkin = 0.004;

/// Points in a box of 7 x 6 x 5 cells, sorted by cell as spheres are.
struct Cloud {
  Grid grid;
  std::vector<Vec3> at;
  RelativeDisplacement displacement;

  explicit Cloud(int count) {
    grid.low = {3, -1, 0.5}, grid.cell = kEdge;
    grid.n[0] = 7, grid.n[1] = 6, grid.n[2] = 5;
    grid.cut(2);
    Dice dice(3);
    for (int i = 0; i < count; ++i)
      at.push_back(dice.in_box(grid.low, grid.low + Vec3{7 * kEdge, 6 * kEdge, 5 * kEdge}));
    std::sort(at.begin(), at.end(), [&](const Vec3& a, const Vec3& b) { return grid.index(a) < grid.index(b); });
    grid.start.assign(7 * 6 * 5 + 1, 0);
    for (const Vec3& x : at) ++grid.start[grid.index(x) + 1];
    std::partial_sum(grid.start.begin(), grid.start.end(), grid.start.begin());
  }

  RelativeDisplacement::Found measure(const std::vector<Vec3>& ways, const std::vector<Vec3>& boundaries, int threads) {
    displacement.begin(grid, kSkin, at.size(), boundaries.size(), threads, [&](std::size_t i) { return at[i]; });
    return displacement.measure(boundaries, Bounds::infinity, threads, [&](std::size_t i) { return at[i] + ways[i]; });
  }
};

/// By all pairs: none within two cells' edges parts by more than is said. What is said is at most what boxes around the
/// ways of a cell's points allow, three cells away in each direction.
TEST(RelativeDisplacement, IsABoundForAllNeighbours) {
  Cloud cloud(600);
  Dice dice(4);
  for (int round = 0; round < 20; ++round) {
    // Most stay; those of a random ball go one way, each a little otherwise.
    const Vec3 centre = cloud.at[static_cast<std::size_t>(dice.between(0, 599))], push = dice.ball(kSkin);
    std::vector<Vec3> ways;
    for (const Vec3& x : cloud.at)
      ways.push_back(norm(x - centre) < dice.between(0.01, 0.05) ? push + dice.ball(0.2 * kSkin) : dice.ball(1e-4));
    const Vec3 tool = 0.7 * push;
    const RelativeDisplacement::Found found = cloud.measure(ways, {tool, {}}, 1);
    double parted = 0, gone = 0, against = 0, in_reach_of_boxes = 0.5 * kSkin;
    for (std::size_t i = 0; i < ways.size(); ++i) {
      gone = std::max(gone, norm(ways[i])), against = std::max(against, norm(ways[i] - tool));
      for (std::size_t j = 0; j < i; ++j) {
        const Vec3 gap = cloud.at[i] - cloud.at[j];
        if (norm(gap) < 2 * kEdge) parted = std::max(parted, norm(ways[i] - ways[j]));
        if (std::max({std::abs(gap.x), std::abs(gap.y), std::abs(gap.z)}) < 3 * kEdge)
          in_reach_of_boxes = std::max(in_reach_of_boxes, norm(ways[i] - ways[j]));
      }
    }
    EXPECT_GE(found.parted, parted);
    EXPECT_GE(found.gone, gone);
    EXPECT_GE(found.against[0], against);
    EXPECT_GE(found.against[1], gone);
    EXPECT_LE(found.parted, std::sqrt(3.0) * in_reach_of_boxes);
    EXPECT_LE(found.gone, std::sqrt(3.0) * gone);
    EXPECT_LE(found.against[0], std::sqrt(3.0) * against);
  }
}

/// A bed that moves as one does not part, wherever it goes; a shear does by what two to three cells' edges see of it.
TEST(RelativeDisplacement, SeesWhatPartsAndNotWhatMovesTogether) {
  Cloud cloud(5000);
  const Vec3 push{0.003, -0.002, 0.001};
  std::vector<Vec3> together(cloud.at.size(), push), shear;
  EXPECT_NEAR(cloud.measure(together, {push}, 2).parted, 0.5 * kSkin, 1e-6);
  EXPECT_NEAR(cloud.measure(together, {push}, 2).against[0], 0, 1e-6);
  EXPECT_NEAR(cloud.measure(together, {push}, 2).gone, norm(push), 1e-6);
  const double rate = 0.05;
  for (const Vec3& x : cloud.at) shear.push_back({rate * (x.y - cloud.grid.low.y), 0, 0});
  const double parted = cloud.measure(shear, {}, 2).parted;
  EXPECT_GT(parted, 2 * rate * kEdge);
  EXPECT_LT(parted, 3 * rate * kEdge + 1e-6);
}

}  // namespace
}  // namespace subsoil::dem::test::engine_displacement
