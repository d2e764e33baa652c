#include <gtest/gtest.h>

#include "libdem/step/accuracy.hpp"
#include "tests/tools/attraction.hpp"
#include "tests/tools/dem_beds.hpp"
#include "tests/tools/every_law.hpp"

/// The step that resolves a contact, judged by the engine: a sphere on a plane that comes back with the restitution
/// that its law promises.
namespace subsoil::dem::test::step_accuracy {
namespace {

constexpr double kRadius = 5e-3, kDensity = 2500;

StepQuestion alone(double speed) {
  return {.smallest_radius = kRadius, .largest_radius = kRadius, .density = kDensity, .speed = speed, .neighbours = 1};
}
double stable(const Law& law, double speed) { return 0.8 * stable_step_at_surface(law, alone(speed)).step; }

/// Speed after over speed before in the bed; the touch begins `phase` of a step after a step.
double in_bed(const Law& law, double speed, double step, double phase) {
  Bed bed(table(law), quiet());
  add_plane(bed, {}, {0, 1, 0});
  SphereSpec s;
  s.radius = kRadius, s.density = kDensity;
  s.position = {0, kRadius + phase * speed * step, 0}, s.velocity = {0, -speed, 0};
  bed.add(std::vector<SphereSpec>{s});
  for (int n = 0; n < 100000; ++n) {
    bed.step(step);
    const Sphere& now = bed.spheres()[0];
    if (now.v.y > 0 && now.x.y > kRadius) return now.v.y / speed;
  }
  return 0;
}

TEST(AccurateStep, TheBedKeepsWhatItPromises) {
  for (const double e : {1.0, 0.95, 0.8, 0.6, 0.3, 0.1})
    for (const double speed : {0.1, 3.0})
      for (const Law& given : {Law(grains(1e5, e, 0)), Law(elastic(1e7, 0.3, e, 0))})
        for (const double tolerance : {0.03, 0.01, 0.003}) {
          const Law& law = given;
          const AccurateStep a = accurate_step(law, alone(speed), true, tolerance, stable(law, speed));
          EXPECT_LE(a.error, tolerance);
          EXPECT_LE(a.step, stable(law, speed));
          // Phases between the eight that were tried may be a little worse.
          for (const double phase : {0.05, 0.3, 0.55, 0.8})
            EXPECT_NEAR(in_bed(given, speed, a.step, phase), e, 1.2 * tolerance) << e << ", " << speed << " m/s";
        }
}

/// What it is for: at the stable step a lone sphere comes back with anything.
TEST(AccurateStep, TheStableStepIsNotAccurate) {
  const Law law = grains(1e5, 0.6, 0.4);
  const double step = stable(law, 1);
  EXPECT_GT(restitution_error(law, alone(1), true, step, step), 0.1);
  double worst = 0;
  for (const double phase : {0.05, 0.3, 0.55, 0.8})
    worst = std::max(worst, std::abs(in_bed(law, 1, step, phase) - 0.6));
  EXPECT_GT(worst, 0.05);
}

/// The impact of one body in numbers is that of the bed, step by step: the same restitution at any step and phase.
TEST(AccurateStep, ImpactInStepsIsThatOfTheBed) {
  for (const Law& given : {Law(grains(1e5, 0.7, 0)), Law(elastic(1e7, 0.3, 0.7, 0))}) {
    const Law& law = given;
    for (const double share : {1.0, 0.3, 0.05})
      for (const double phase : {0.1, 0.6}) {
        const double step = share * stable(law, 2), m = kDensity * 4 / 3 * pi * std::pow(kRadius, 3);
        EXPECT_NEAR(impact_in_steps(law, m, kRadius, 0, 2, step, phase, 1).restitution, in_bed(given, 2, step, phase),
                    1e-9);
      }
  }
}

/// A bridge of liquid that forms at the touch and takes W = int F dS up to its rupture, e = sqrt(1 - W/(m_eff v^2/2)),
/// or one that forms from afar and takes nothing. Its pull sets in between two steps, and whether that error is met
/// again at the end hangs on the steps of the contact.
void expect_counted(Cohesion::Forms forms) {
  Linear given = grains(1e4, 1, 0, 0);
  given.cohesion = water(1e-11, 0.349);
  given.cohesion.forms = forms;
  const Law law = given;
  const double r = 2e-3, m = kDensity * 4 / 3 * pi * r * r * r / 2, r_eff = r / 2, speed = 0.1;
  const StepQuestion pair{
      .smallest_radius = r, .largest_radius = r, .density = kDensity, .speed = speed, .neighbours = 1};
  const double rupture = (1 + 0.349 / 2) * std::cbrt(1e-11), b = 1e-11 / (pi * r_eff);
  const double work =
      4 * pi * r_eff * 0.072 * std::cos(0.349) * (rupture - std::sqrt(rupture * rupture + b) + std::sqrt(b));
  const double lost = forms == Cohesion::Forms::on_contact ? work / (0.5 * m * speed * speed) : 0;
  const double e = std::sqrt(1 - lost);
  const double longest = 0.8 * stable_step(law, pair).step;
  const AccurateStep a = accurate_step(law, pair, false, 0.01, longest);
  EXPECT_LE(a.error, 0.01);
  EXPECT_GT(a.step, longest / 20) << "and no more than it takes";
  for (int k = 0; k < 40; ++k) {
    const double step = a.step * (1 - 0.001 * k);
    for (const double phase : {0.05, 0.3, 0.55, 0.8})
      EXPECT_NEAR(impact_in_steps(law, m, r_eff, 0.5 / r, speed, step, phase, 1).restitution, e, 0.012)
          << step << " s, phase " << phase;
  }
}

TEST(AccurateStep, APullThatSetsInBetweenStepsIsCounted) {
  expect_counted(Cohesion::Forms::on_contact);
  expect_counted(Cohesion::Forms::at_rupture_distance);
}

/// Bodies that stick have no restitution to be wrong: the stable step stays.
TEST(AccurateStep, StickingPairsKeepTheStableStep) {
  const Law law = soil();
  const AccurateStep a = accurate_step(law, alone(1), false, 0.01, 1e-5);
  EXPECT_EQ(a.step, 1e-5);
  EXPECT_EQ(a.error, 0);
  EXPECT_EQ(a.contact, 0);
}

TEST(AccurateStep, FinerToleranceFinerStep) {
  for (const auto& [name, given] : every_law()) {
    const Law& law = given;
    const double longest = 0.8 * stable_step(law, alone(1)).step;
    double before = longest;
    for (const double tolerance : {1.0, 0.1, 0.03, 0.01}) {
      const AccurateStep a = accurate_step(law, alone(1), false, tolerance, longest);
      EXPECT_LE(a.step, 1.2 * before) << name;  // eight phases scatter
      if (a.contact > 0) {
        EXPECT_LE(a.step, tolerance / 0.4 * a.contact * (1 + 1e-12)) << name;
      }
      before = a.step;
    }
  }
}

/// The pull f - k_a S of an approach does the work f^2/(2 k_a): met^2 = v^2 + f^2/(k_a m), half the mass between
/// spheres. In touch the pull goes on below the overlap f/k_n, by the work f^2/(2 k_n) without a dashpot.
TEST(AccurateStep, TheSpeedFarAwayIsWithoutThePull) {
  constexpr double f = 0.3, k_a = 1e3, k_n = 2e4;
  const double m = kDensity * 4 / 3 * pi * std::pow(kRadius, 3);
  Linear given = grains(k_n, 1, 0, 0);
  given.cohesion = adhesion(f, k_a, Cohesion::Forms::at_rupture_distance);
  const Law law = given;
  for (const bool at_surface : {true, false})
    for (const double v : {0.1, 0.5, 2.0}) {
      const double gained = f * f * (1 / k_a + 1 / k_n) / (at_surface ? m : m / 2), met = std::sqrt(v * v + gained);
      EXPECT_NEAR(speed_before_pull(law, alone(1), at_surface, met, stable(law, v)), v, 2e-3 * v) << at_surface;
      EXPECT_EQ(speed_before_pull(law, alone(1), at_surface, 0.5 * std::sqrt(gained), stable(law, v)), 0);
    }
  EXPECT_EQ(speed_before_pull(Law(grains(k_n, 0.5, 0)), alone(1), true, 0.7, 1e-6), 0.7);
}

}  // namespace
}  // namespace subsoil::dem::test::step_accuracy
