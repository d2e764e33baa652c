// Layers: lattices one upon the other, layers by depth, layers rained one after the other.
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "libdem/packing/layers.hpp"
#include "tests/unit/libdem/bed_support.hpp"

namespace subsoil::dem::test::bed_layers {
namespace {

constexpr double r = 0.010;
constexpr BedMaterial upper{.density = 1500, .material = 1};

LatticePlan plan_of(double height) {
  LatticePlan plan;
  plan.region = {{0, 0, 0}, {0.1, height, 0.08}};
  plan.floor_overlap = 0.002;
  return plan;
}
LatticeLayer layer_of(double top, double radius, BedMaterial of, double pitch, double rise) {
  return {{.top = top, .radius = EqualRadius{radius}, .of = of}, pitch, rise};
}

/// Two layers of the same spheres are the bed without layers, wherever the interface lies: no row is lost at it.
TEST(BedLayers, LatticesOfTheSameSpheresAreOneLattice) {
  LatticePlan whole = plan_of(0.2);
  whole.radius = EqualRadius{r}, whole.pitch = 0.018;
  const auto one = lattice(whole, soil_material);
  for (const double interface : {0.05, 0.083, 0.11}) {
    std::vector<std::size_t> numbers;
    const LatticeLayer layers[] = {layer_of(interface, r, soil_material, 0.018, 0),
                                   layer_of(0.2, r, upper, 0.018, 0.018)};
    const auto two = layered_lattice(plan_of(0.2), layers, numbers);
    ASSERT_EQ(two.size(), one.size());
    ASSERT_EQ(numbers[0] + numbers[1], one.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_NEAR(norm(two[i].position - one[i].position), 0, 1e-15);
      EXPECT_EQ(two[i].material, i < numbers[0] ? 0 : 1);
      EXPECT_EQ(two[i].density, i < numbers[0] ? density : 1500);
    }
    // The row nearest to the interface: half a pitch off at most.
    EXPECT_NEAR(two[numbers[0] - 1].position.y + r, interface, 0.5 * 0.018 + 1e-12);
  }
}

/// Spheres of two sizes: a row of the upper ones rests on those below at the distance that is given, none is nearer,
/// and the bed ends below its depth by less than a pitch.
TEST(BedLayers, RowsOfOtherSpheresRestOnThoseBelow) {
  std::vector<std::size_t> numbers;
  const double small = 0.006, rise = r + small - 0.001;
  const LatticeLayer layers[] = {layer_of(0.06, r, soil_material, 0.019, 0),
                                 layer_of(0.15, small, upper, 0.0115, rise)};
  const auto spheres = layered_lattice(plan_of(0.15), layers, numbers);
  double lower_top = 0, upper_low = 1, top = 0, nearest = 1;
  for (const SphereSpec& s : spheres) {
    if (s.material == 0) lower_top = std::max(lower_top, s.position.y);
    if (s.material == 1) upper_low = std::min(upper_low, s.position.y);
    top = std::max(top, s.position.y + s.radius);
    for (const SphereSpec& t : spheres)
      if (s.material != t.material) nearest = std::min(nearest, norm(s.position - t.position));
  }
  EXPECT_NEAR(upper_low - lower_top, rise, 1e-15);
  EXPECT_GE(nearest, rise - 1e-15);
  EXPECT_LE(top, 0.15 + 1e-12);
  EXPECT_GT(top, 0.15 - 0.0115);
}

TEST(BedLayers, RefusesALayerWithoutARow) {
  std::vector<std::size_t> numbers;
  const LatticeLayer layers[] = {layer_of(0.06, r, soil_material, 0.019, 0), layer_of(0.07, r, upper, 0.019, 0.019)};
  try {
    layered_lattice(plan_of(0.07), layers, numbers);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "bed: layer 1 of 2 is too thin for a row of its spheres; make it thicker, or its spheres smaller");
  }
}

/// A column of spheres whose surface is at 0.1: depths count from there, whatever the floor is.
TEST(BedLayers, ByDepthBelowTheMeanSurface) {
  std::vector<Sphere> column(10);
  for (std::size_t i = 0; i < 10; ++i)
    column[i].x = {0.01, 0.005 + 0.01 * static_cast<double>(i), 0.01}, column[i].r = 0.005;
  const BedLayer layers[] = {{.top = 0.02, .of = {}}, {.top = 0.035, .of = {}}, {.top = 0.06, .of = {}}};
  const Bounds region{{0, -1, 0}, {0.02, 1, 0.02}};
  // 60 mm of layers below 100 mm: interfaces at 60 and 75 mm; what is deeper than all belongs to the lowest.
  EXPECT_EQ(layers_by_depth(column, region, layers), (std::vector<int>{0, 0, 0, 0, 0, 0, 1, 2, 2, 2}));
}

/// Wet spheres of two sizes and densities, rained. Each layer is levelled to its height within a sphere's step in one
/// of the columns, as a bed without layers is (FillsToTheDepthAsked), and gives way under the next by less than that;
/// what of the upper layer lies below the interface fills the hollows of a rough surface, a diameter at most.
TEST(BedLayers, RainOneAfterTheOther) {
  LawTable laws = soft_wet();
  laws.materials = 3;  // 0 below, 1 walls, 2 above
  laws.index = {0, 0, 0, 0, -1, 0, 0, 0, 0};
  const Bounds box{{0, 0, 0}, {0.1, 0.5, 0.1}};
  RandomFill fill;
  fill.region = box;
  fill.seed = 5;
  fill.layers = {{.top = 0.05, .radius = UniformRadius{0.009, 0.011}, .of = soil_material},
                 {.top = 0.09, .radius = EqualRadius{0.008}, .of = {.density = 1700, .material = 2}}};
  SettlePlan plan;
  plan.step = 0.9 * soft_step;  // whose spheres of 8 mm have 1800 kg/m3
  plan.staged = true;
  Bed bed = boxed_bed(laws, box);
  const SettleReport report = fill_at_random(bed, laws, fill, plan);
  ASSERT_EQ(report.layer_ends.size(), 2u);
  std::vector<int> layer(report.layer_ends[1], 1);
  std::fill_n(layer.begin(), report.layer_ends[0], 0);
  for (const Sphere& s : bed.spheres()) {
    EXPECT_EQ(s.material, layer[s.id] == 0 ? 0 : 2);
    EXPECT_NEAR(dem::density(s), layer[s.id] == 0 ? density : 1700, 1e-9);
    if (layer[s.id] == 1) {
      EXPECT_GT(s.x.y, 0.05 - 2 * 0.011) << "a pit in the layer below is as deep as its largest sphere is wide";
    }
    if (layer[s.id] == 0) {
      EXPECT_LT(s.x.y, 0.05 + 0.01);
    }
  }
  const auto layers = report_layers(bed.spheres(), box, layer, 2);
  EXPECT_NEAR(layers[0].thickness, 0.05, 0.5 * r);
  EXPECT_NEAR(layers[1].top, 0.09, 0.25 * r);
  EXPECT_EQ(layers[0].spheres + layers[1].spheres, bed.spheres().size());
  EXPECT_NEAR(layers[0].thickness + layers[1].thickness, report.surface.mean, 1e-15);
}

}  // namespace
}  // namespace subsoil::dem::test::bed_layers
