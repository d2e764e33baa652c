// Outlines: distances and normals in closed form, the energy account of every pair, the handover between a corner and a
// side, refusals.

#include "libmbd/base/outline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "force_support.hpp"
#include "libmbd/forces/outline_contact.hpp"

namespace subsoil::mbd::outline_test {
namespace {

const PolygonOutline square{.points = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};

void expect_near(const Outline& o, Vec2 w, double distance, Vec2 normal) {
  const Outline::Near n = o.near(w);
  EXPECT_NEAR(n.distance, distance, 1e-14);
  EXPECT_NEAR(n.normal.x, normal.x, 1e-14);
  EXPECT_NEAR(n.normal.y, normal.y, 1e-14);
}

TEST(Outline, DistancesFromAPolygon) {
  const double s = std::sqrt(0.5);
  for (const bool clockwise : {false, true}) {
    Outline::Points points = square.points;
    if (clockwise) std::reverse(points.begin(), points.end());
    const Outline o = Outline::polygon(points, 0);
    expect_near(o, {0.3, 1.5}, 0.5, {0, 1});
    expect_near(o, {0.3, 0.8}, -0.2, {0, 1});
    expect_near(o, {-0.9, 0.2}, -0.1, {-1, 0});
    expect_near(o, {1.3, 1.4}, 0.5, {0.6, 0.8});
    expect_near(o, {1, 1}, 0, o.near({1, 1}).normal);
  }
  // Rounded: sides where they were, corners of radius 0.2.
  const Outline round = Outline::polygon(square.points, 0.2);
  expect_near(round, {0.3, 1.5}, 0.5, {0, 1});
  expect_near(round, {0.8 + 0.5 * s, 0.8 + 0.5 * s}, 0.3, {s, s});
}

// An L: the corner (0, 0) is concave. Its own point lies on the outline, and what is in the hollow is outside.
TEST(Outline, DistancesFromAConcavePolygon) {
  const Outline o = Outline::polygon({{-1, -1}, {1, -1}, {1, 0}, {0, 0}, {0, 1}, {-1, 1}}, 0);
  expect_near(o, {0.4, 0.1}, 0.1, {0, 1});
  expect_near(o, {0.1, 0.4}, 0.1, {1, 0});
  expect_near(o, {-0.03, -0.04}, -0.05, {0.6, 0.8});
  EXPECT_EQ(o.corners().size(), 5U);
  EXPECT_EQ(o.faces().size(), 6U);
}

const PolygonOutline angle{.points = {{-1, -1}, {1, -1}, {1, 0}, {0, 0}, {0, 1}, {-1, 1}}};

/// The first `count` of what is near w, and no more.
void expect_all_near(const Outline& o, Vec2 w, const std::vector<Outline::Near>& expected) {
  Outline::Nears all;
  o.all_near(w, all);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const bool there = k < expected.size();
    EXPECT_NEAR(all[k].distance, there ? expected[k].distance : Outline::nowhere, 1e-14) << k;
    if (!there) continue;
    EXPECT_NEAR(all[k].normal.x, expected[k].normal.x, 1e-14) << k;
    EXPECT_NEAR(all[k].normal.y, expected[k].normal.y, 1e-14) << k;
  }
}

// Both sides of the hollow, the nearer first, also from beneath one of them and from within the solid of both; a side
// ends at a convex corner, and the corner stands for itself.
TEST(Outline, AllThatIsNearInAHollow) {
  const Outline o = Outline::polygon(angle.points, 0);
  expect_all_near(o, {0.4, 0.1}, {{0.1, {0, 1}}, {0.4, {1, 0}}});
  expect_all_near(o, {0.1, 0.4}, {{0.1, {1, 0}}, {0.4, {0, 1}}});
  expect_all_near(o, {0.2, -0.1}, {{-0.1, {0, 1}}, {0.2, {1, 0}}});
  expect_all_near(o, {-0.03, -0.04}, {{-0.04, {0, 1}}, {-0.03, {1, 0}}});
  expect_all_near(o, {1.3, 0.4}, {{0.5, {0.6, 0.8}}});
  expect_all_near(o, {0.6, 0.2}, {{0.2, {0, 1}}, {0.6, {1, 0}}});
  const Outline slot = Outline::polygon({{0, -1}, {3, -1}, {3, 0}, {0.5, 0}, {0.5, 0.4}, {3, 0.4}, {3, 1}, {0, 1}}, 0);
  expect_all_near(slot, {0.6, 0.15}, {{0.1, {1, 0}}, {0.15, {0, 1}}, {0.25, {0, -1}}});
  // Far away nothing but the nearest.
  expect_all_near(o, {4, 4}, {o.near({4, 4})});
}

TEST(Outline, DistancesFromDiskAndFlat) {
  expect_near(Outline::disk({1, 0}, 0.5), {1, 2}, 1.5, {0, 1});
  expect_near(Outline::flat({0, 0.2}, 0), {5, 0.1}, -0.1, {0, 1});
  EXPECT_THROW(Outline::disk({1, 0}, 0.5).near({1, 0}), std::runtime_error);
}

ProfileOutline egg() {
  ProfileOutline p;
  for (int i = 0; i < 36; ++i) {
    const double a = 2 * std::numbers::pi * i / 36;
    p.angles.push_back(a), p.radii.push_back(1 + 0.2 * std::cos(a));
  }
  return p;
}

/// A wall with one hump, free below as it is listed: a hollow there.
const FlankOutline hump{.points = {{3, 0}, {2, 0}, {1, 0.1}, {0, 0.4}, {-1, 0.1}, {-2, 0}, {-3, 0}}};

struct Pair {
  const char* name;
  OutlineForm first, second;
};
std::vector<Pair> pairs() {
  PolygonOutline rounded = square;
  rounded.corner_radius = 0.2;
  FlankOutline above = hump;
  std::reverse(above.points.begin(), above.points.end());
  return {{"disk on disk", DiskOutline{1, {0.1, 0}}, DiskOutline{0.9}},
          {"disk on polygon", DiskOutline{1, {0.1, 0}}, square},
          {"polygon on disk", rounded, DiskOutline{0.8}},
          {"polygons", square, rounded},
          {"polygon on flat", FlatOutline{{0, 0}, 0.1}, square},
          {"flat under profile", FlatOutline{{0, 0}, 0.1}, egg()},
          {"disk on profile", egg(), DiskOutline{0.8}},
          {"polygon on profile", egg(), rounded},
          {"profile on polygon", square, egg()},
          {"disk on flank", above, DiskOutline{0.5}},
          {"polygon on flank", above, square},
          {"disk in a hollow", angle, DiskOutline{0.4}},
          {"polygon in a hollow", angle, rounded}};
}

// Power on both bodies = -d(stored)/dt without damping, on random paths through shallow contact. Central differences of
// 1e-6 err by rounding of the stored energy, some 1e-10 of it, and by the jump of the second derivative where a contact
// opens: 1e-5 of the power is wide. Every pair is seen touching.
TEST(OutlineContact, GivesBackWhatItStores) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const Pair& p : pairs()) {
    SCOPED_TRACE(p.name);
    OutlineContact f{.body_a = 1, .body_b = 2, .first = p.first, .second = p.second};
    f.law.normal = {.n = 2, .stiffness = 1e3};
    f.check();
    f.prepare();
    int acting = 0;
    for (int trial = 0; trial < 4000 && acting < 150; ++trial) {
      const Vec2 v{number(random), number(random)};
      const double turn = 3 * number(random), spin = number(random), angle = 3 * number(random);
      const Vec2 r{2.2 * number(random), 2.2 * number(random)};
      const auto at = [&](double t) { return BodyState{r + t * v, turn + t * spin, v, spin}; };
      const BodyState first{{0, 0}, std::holds_alternative<FlatOutline>(p.first) ? 0 : angle, {0, 0}, 0};
      const Felt now = feel(f, first, at(0));
      if (now.power.stored == 0 || now.values[2] < -0.15) continue;
      ++acting;
      const double power = now.wrench[2][0] * v.x + now.wrench[2][1] * v.y + now.wrench[2][2] * spin;
      constexpr double h = 1e-6;
      const double rate = (feel(f, first, at(h)).power.stored - feel(f, first, at(-h)).power.stored) / (2 * h);
      EXPECT_NEAR(power, -rate, 1e-5 * (1 + std::abs(power))) << trial;
    }
    EXPECT_GE(acting, 20);
  }
}

// A box slides over the top of an egg, pressed 1 mm into it: from its side to its corner and off. Gap and direction are
// continuous at the handover; the depth beyond it is that of the corner.
TEST(OutlineContact, HandsOverFromSideToCorner) {
  OutlineContact f{.body_a = 1, .body_b = 2, .first = egg(), .second = square};
  f.law.normal = {.n = 1, .stiffness = 1e3};
  f.prepare();
  double before = 0, most = 0;
  for (int i = 0; i <= 4000; ++i) {
    const double x = 0.5 + 0.6 * i / 4000;
    const Felt felt = feel(f, {{0, 0}, std::numbers::pi / 2, {}, 0}, {{x, 2.2 - 1e-3}, 0, {}, 0});
    EXPECT_LE(felt.values[4], 1);
    if (i > 0) most = std::max(most, std::abs(felt.values[0] - before));
    before = felt.values[0];
  }
  EXPECT_LT(most, 0.01);  // of 1 N, in steps of 0.15 mm
}

// A disk goes through a hollow of 90 and of 150 deg, 3 mm deep in the sides that it passes and between them: force and
// moment move by small steps, where the nearest side alone would turn 0.3 N by 90 or 30 deg at once.
TEST(OutlineContact, ChangesSidesInAHollowWithoutAJump) {
  for (const double opening : {90.0, 150.0}) {
    SCOPED_TRACE(opening);
    const double a = (180 - opening) / 2 * std::numbers::pi / 180, c = std::cos(a), s = std::sin(a), radius = 0.1;
    OutlineContact f{.body_a = 1,
                     .body_b = 2,
                     .first = PolygonOutline{.points = {{-c, s}, {-2, -1}, {2, -1}, {c, s}, {0, 0}}},
                     .second = DiskOutline{radius}};
    f.law.normal = {.n = 1, .stiffness = 100};
    f.prepare();
    const double height = (radius - 3e-3) / c;  // above the corner, at that depth in both
    Vec2 before;
    double jump = 0, most_contacts = 0;
    for (int i = 0; i <= 4000; ++i) {
      const double x = 0.2 * (i - 2000) / 2000.0;
      const Vec2 at{x * c, height + std::abs(x) * s - 1e-5 * x};
      const Felt felt = feel(f, {{0, 0}, 0, {}, 0}, {at, 0, {}, 0});
      const Vec2 force{felt.wrench[2][0], felt.wrench[2][1]};
      if (i > 0) jump = std::max(jump, length(force - before));
      before = force, most_contacts = std::max(most_contacts, felt.values[4]);
    }
    EXPECT_LT(jump, 0.02);  // steps of 0.1 mm by 100 N/m make 0.01 N a side
    EXPECT_EQ(most_contacts, 2);
  }
}

std::string refused(OutlineForm first, OutlineForm second) {
  OutlineContact f{.body_a = 1, .body_b = 2, .first = std::move(first), .second = std::move(second)};
  f.law.normal.stiffness = 1e3;
  return refusal([&] { f.check(); });
}

TEST(OutlineContact, RefusesWithRuleAndCure) {
  EXPECT_EQ(refused(PolygonOutline{.points = {{0, 0}, {1, 1}, {1, 0}, {0, 1}}}, square),
            "side 1 of the polygon meets another side; list its corners once around in order");
  EXPECT_EQ(refused(PolygonOutline{.points = {{0, 0}, {1, 0}, {1, 0}, {0, 0}}}, square),
            "a polygon needs at least three corners that differ");
  EXPECT_EQ(refused(PolygonOutline{square.points, 1.1}, square),
            "the corner radius leaves nothing of side 1 of the polygon; take a smaller one");
  EXPECT_EQ(refused(PolygonOutline{square.points, -1}, square), "the corner radius must not be negative; 0 is sharp");
  EXPECT_EQ(refused(DiskOutline{}, square), "the disk's radius must be given and above 0");
  EXPECT_EQ(refused(egg(), egg()),
            "two outlines that are both curves or flat have no point that can touch; give one of them as a polygon or "
            "disk, or a flat's partner as a closed profile");
  FlankOutline loop{.points = {{0, 0}, {2, 0}, {2, 1}, {1, -1}, {0, 1}}};
  EXPECT_TRUE(refused(loop, square).starts_with("the flank crosses itself near ")) << refused(loop, square);
  const std::string hollow = refused(hump, DiskOutline{3});
  EXPECT_TRUE(hollow.starts_with("a radius of 3.000000 m does not fit into the curve's hollow of radius ")) << hollow;
}

}  // namespace
}  // namespace subsoil::mbd::outline_test
