#include <gtest/gtest.h>

#include "tests/tools/dem_beds.hpp"

/// The wet law against its piecewise definition (model.md section 2), written here a second time and differently: as a
/// table of straight lines between the corners of the force-gap curve.
namespace subsoil::dem::test::laws_wet {
namespace {

struct Corner {
  double overlap, force;
};

/// Force without damping by linear interpolation over the curve's corners.
double curve(const Wet& w, double overlap) {
  const double deepest = -w.K_B * w.dB;
  const Corner corners[] = {{w.D - w.dB, 0}, {w.D, deepest}, {w.D + w.dc, 0}, {w.D + w.dc + 1, w.K_X}};
  if (overlap <= corners[0].overlap) return 0;
  for (int k = 0; k < 3; ++k) {
    const Corner &a = corners[k], &b = corners[k + 1];
    if (overlap <= b.overlap) return a.force + (b.force - a.force) * (overlap - a.overlap) / (b.overlap - a.overlap);
  }
  return NAN;
}

NormalForce<double> at(const Wet& w, double overlap, double rate = 0) {
  return w.normal(Approach<double>{overlap, rate, 3.77e-3, 5e-3, 1e-5});
}

std::vector<Wet> variants() {
  Wet a = soil(), b = soil(), c = soil(), d = soil();
  b.D = -0.7e-3, b.dc = 1.3e-3;
  c.D = 0.4e-3, c.dB = 0.9e-3, c.K_X = 16000, c.K_B = 3000;
  d.K_B = 0;
  return {a.resolved(), b.resolved(), c.resolved(), d.resolved()};
}

TEST(WetLaw, FollowsTheForceGapCurve) {
  // A force of at most K_X 3 dc = 60 N is a difference of lengths near 5 mm, each rounded to 1e-18 m, times 1e4 N/m.
  for (const Wet& w : variants())
    for (int k = -2000; k <= 4000; ++k) {
      const double overlap = k * 1.7e-6;
      EXPECT_NEAR(at(w, overlap).force, curve(w, overlap), 1e-13 * w.K_X * w.dc) << overlap;
    }
}

TEST(WetLaw, IsContinuousAtEveryThresholdAndOneUlpBeside) {
  for (const Wet& w : variants())
    for (const double threshold : {w.D - w.dB, w.D, w.D + w.dc}) {
      const double below = std::nextafter(threshold, -1.0), above = std::nextafter(threshold, 1.0);
      // One ulp of a length is 4e-19 m; a jump would be K dc = 6 N or more.
      const double here = at(w, threshold).force;
      EXPECT_NEAR(at(w, below).force, here, 1e-12);
      EXPECT_NEAR(at(w, above).force, here, 1e-12);
      EXPECT_NEAR(at(w, below).stored, at(w, threshold).stored, 1e-15);
      EXPECT_NEAR(at(w, above).stored, at(w, threshold).stored, 1e-15);
      EXPECT_NEAR(here, curve(w, threshold), 1e-12);
    }
}

TEST(WetLaw, ReachIsWhereTheAttractionEnds) {
  for (const Wet& w : variants()) {
    EXPECT_EQ(at(w, -w.cutoff() - 1e-9).force, 0);
    if (w.K_B > 0) {
      EXPECT_LT(at(w, -w.cutoff() + 1e-9).force, 0);
    }
    EXPECT_NEAR(at(w, w.rest_overlap()).force, 0, 1e-12);
  }
}

TEST(WetLaw, DampingActsWhereItsOptionSays) {
  Wet printed = soil().resolved(), all = printed;
  all.damping = Wet::Damping::all_bands;
  const double rate = 0.3, viscous = printed.C_X * rate;
  for (const double overlap : {-3e-3, -1e-3, 1e-3, 3e-3}) {
    EXPECT_NEAR(at(printed, overlap, rate).force - curve(printed, overlap), overlap > 2e-3 ? viscous : 0, 1e-12);
    EXPECT_NEAR(at(all, overlap, rate).force - curve(all, overlap), overlap > -2e-3 ? viscous : 0, 1e-12);
    EXPECT_EQ(at(printed, overlap, rate).damping, overlap > 2e-3 ? viscous : 0);
    EXPECT_EQ(at(all, overlap, rate).damping, overlap > -2e-3 ? viscous : 0);
  }
}

TEST(WetLaw, GripFollowsItsOption) {
  Wet w = soil().resolved();
  const double cohesion = w.K_C * w.dc, rate = -0.4;
  for (const double overlap : {0.3e-3, 1.9e-3, 2.5e-3, 4e-3}) {
    const double repulsion = overlap > 2e-3 ? w.K_X * (overlap - 2e-3) : 0;
    const double total = curve(w, overlap) + (overlap > 2e-3 ? w.C_X * rate : 0);
    w.limit = Wet::FrictionLimit::signed_force;
    EXPECT_NEAR(at(w, overlap, rate).limiting_force, std::max(0.0, total + cohesion), 1e-12);
    w.limit = Wet::FrictionLimit::elastic_force;
    EXPECT_NEAR(at(w, overlap, rate).limiting_force, repulsion + cohesion, 1e-12);
    w.limit = Wet::FrictionLimit::repulsion_only;
    EXPECT_NEAR(at(w, overlap, rate).limiting_force, repulsion, 1e-12);
  }
}

TEST(WetLaw, SignedGripIsMuTimesCohesionAtRestAndFallsToZeroAtD) {
  const Wet w = soil().resolved();
  EXPECT_NEAR(at(w, w.rest_overlap()).limiting_force, 14.0, 1e-12);  // Table 3: 7000 N/m x 2 mm
  EXPECT_NEAR(at(w, std::nextafter(w.D, 1.0)).limiting_force, 0, 1e-12);
  EXPECT_FALSE(at(w, w.D).in_contact);
  EXPECT_TRUE(at(w, std::nextafter(w.D, 1.0)).in_contact);
}

TEST(WetLaw, ValuesOfOneBodyEachAreHalvedBySeries) {
  Wet each = soil();
  each.values = Wet::Values::per_body;
  const Wet pair = soil().resolved(), half = each.resolved();
  for (const double overlap : {-1.5e-3, 0.0, 0.5e-3, 2e-3, 3.3e-3})
    for (const double rate : {-0.2, 0.0, 0.7})
      EXPECT_EQ(at(half, overlap, rate).force, at(pair, overlap, rate).force / 2);  // powers of two: exact
  EXPECT_EQ(half.K_Y, pair.K_Y / 2);
  EXPECT_EQ(half.C_Y, pair.C_Y / 2);
  EXPECT_EQ(half.resolved().K_X, half.K_X) << "resolving twice must not halve twice";
}

TEST(WetLaw, RefusesAForceThatJumps) {
  Wet w = soil();
  w.K_C = 7000;
  EXPECT_NO_THROW(w.resolved());
  w.K_C = 7001;
  EXPECT_THROW(w.resolved(), std::invalid_argument);
  w.K_C = NAN, w.dB = 1e-3;
  EXPECT_NEAR(w.resolved().K_C, 3500, 1e-9);
}

}  // namespace
}  // namespace subsoil::dem::test::laws_wet
