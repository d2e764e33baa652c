#include <gtest/gtest.h>

#include "tests/tools/every_law.hpp"
#include "tests/tools/laws.hpp"

/// One property for every law of the list: the elastic force is the slope of the stored energy, and what a law calls
/// damping is all of the force that the rate changes.
namespace subsoil::dem::test::laws_energy {
namespace {

NormalForce<double> at(const Law& law, double overlap, double rate) {
  double own[kOwnMemory] = {};
  return law->normal({overlap, rate, 3.77e-3, 5e-3, 0.0}, own);
}

TEST(EveryLaw, ElasticForceIsTheSlopeOfTheStoredEnergy) {
  for (const auto& [name, law] : every_law()) {
    if (law->plastic()) continue;  // laws_memory.cpp has theirs
    const double h = 1e-8;
    const bool begins_at_touch = law->own_memory() > 0;
    for (int k = -300; k <= 400; ++k) {
      if (k == 0 && begins_at_touch) continue;  // attraction sets in: force and stored energy may jump
      const double overlap = k * 1.003e-5;
      const double slope = (at(law, overlap + h, 0).stored - at(law, overlap - h, 0).stored) / (2 * h);
      // Central difference: rounding 1e-16 x 0.1 J/1e-8 m = 1e-9 N, plus the bend at a threshold inside +-h, K h/4.
      const double stiffness = at(law, 1e-3, 0).k_n + at(law, 4e-3, 0).k_n + 2e4;
      EXPECT_NEAR(slope, at(law, overlap, 0).force, stiffness * h + 1e-7) << name << " at " << overlap;
    }
  }
}

TEST(EveryLaw, DampingIsTheWholeEffectOfTheRateAndNeverFeedsEnergy) {
  for (const auto& [name, law] : every_law())
    for (const double overlap : {-3e-3, -1e-3, -1e-9, 0.0, 1e-6, 1e-3, 2e-3, 4e-3})
      for (const double rate : {-2.0, -0.01, 0.01, 2.0}) {
        const auto moving = at(law, overlap, rate), still = at(law, overlap, 0);
        EXPECT_NEAR(moving.force - moving.damping, still.force, 1e-12 * std::abs(moving.force) + 1e-15) << name;
        EXPECT_GE(moving.damping * rate, 0) << name;
        EXPECT_GE(moving.limiting_force, 0) << name;
        EXPECT_EQ(moving.stored, still.stored) << name;
      }
}

TEST(EveryLaw, IsSilentBeyondItsCutoff) {
  for (const auto& [name, law] : every_law()) {
    const double cutoff = law->cutoff(5e-3);
    for (const double rate : {-1.0, 0.0, 1.0}) {
      const auto n = at(law, -cutoff - 1e-9, rate);
      EXPECT_EQ(n.force, 0) << name;
      EXPECT_EQ(n.stored, 0) << name;
      EXPECT_FALSE(n.in_contact) << name;
    }
  }
}

TEST(EveryLaw, ClippedForceNeverPulls) {
  Linear l = grains(1e5, 0.1);
  HertzMindlin h = elastic(1e7, 0.3, 0.1, 0.3);
  VariableRestitution v = yielding(VariableRestitution::Normal::hertz);
  l.clip = h.clip = v.clip = true;
  for (const Law& law : {Law(l), Law(h), Law(v)})
    for (const double rate : {-5.0, -0.5, 0.0, 0.5}) {
      const auto n = at(law, 1e-4, rate);
      EXPECT_GE(n.force, 0);
      EXPECT_GE(n.damping * rate, 0);
    }
}

/// Hertz by its textbook formula: F = 4/3 E* sqrt(R) delta^1.5.
TEST(HertzMindlin, TextbookForceAndStiffnesses) {
  const double young = 4.8e10, poisson = 0.2, r = 5e-3, d = 2.5e-4;
  const HertzMindlin law = elastic(young, poisson, 1, 0.3);
  const double e_eff = young / (2 * (1 - 0.04)), shear = young / 2.4, g_eff = shear / (2 * 1.8);
  const auto n = law.normal(Approach<double>{d, 0, 1, r, 0});
  EXPECT_NEAR(n.force, 4.0 / 3 * e_eff * std::sqrt(r) * std::pow(d, 1.5), 1e-12 * n.force);
  EXPECT_NEAR(n.k_n, 2 * e_eff * std::sqrt(r * d), 1e-12 * n.k_n);
  EXPECT_NEAR(n.k_t, 8 * g_eff * std::sqrt(r * d), 1e-12 * n.k_t);
}

}  // namespace
}  // namespace subsoil::dem::test::laws_energy
