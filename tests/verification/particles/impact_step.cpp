#include <gtest/gtest.h>

#include "libdem/bed_impact.hpp"
#include "libdem/impact/hertz.hpp"
#include "libdem/impact/hysteretic.hpp"
#include "libdem/impact/jkr.hpp"
#include "tests/tools/laws.hpp"

/// The engine's step beside the closed forms of impact: Hunt-Crossley, and Hertz by a law of its own.
namespace subsoil::dem::test::impact_step {
namespace {

using impact::Event;
using impact::Strikers;

struct Errors {
  double restitution, largest, duration, force;
};
Errors errors(const Event& got, const Event& exact) {
  return {std::abs(got.restitution - exact.restitution), std::abs(got.largest / exact.largest - 1),
          std::abs(got.duration() / exact.duration() - 1), std::abs(got.peak_force / exact.peak_force - 1)};
}

/// Steel ball on a plate at 2 m/s, and two different spheres. Damping takes the rate of half a step before: the largest
/// indentation is of order 1. The restitution is better than that, n + 1: dv/(1 + b v) = -f(x) dt/m by steps is still a
/// sum of functions of v and of x, so what is lost on the way does not depend on the step but where x^n begins and
/// ends.
TEST(ImpactStep, HuntCrossleyConverges) {
  struct {
    double n, c, b;
    Strikers bodies;
  } const cases[] = {{1.5, 1.7135e10, 0.1, {.mass_1 = 0.1, .radius_1 = 14.52e-3}},
                     {1.5, 1e9, 0.5, {.mass_1 = 0.1, .radius_1 = 14.52e-3, .mass_2 = 0.04, .radius_2 = 8e-3}},
                     {1, 1e6, 0.3, {.mass_1 = 0.1, .radius_1 = 14.52e-3}},
                     {1.7, 1e9, 0.3, {.mass_1 = 0.1, .radius_1 = 14.52e-3}}};
  for (const auto& c : cases) {
    const HuntCrossley law = viscoelastic(c.n, c.c, c.b, 0);
    const Event exact = law.impact.strike({.mass = c.bodies.mass()}, 2);
    Errors before{};
    for (const int steps : {200, 400, 800}) {
      const Errors e = errors(strike_in_bed(law, c.bodies, 2, exact.duration() / steps), exact);
      SCOPED_TRACE(testing::Message() << "n " << c.n << ", " << steps << " steps");
      if (steps > 200) {
        EXPECT_NEAR(std::log2(before.restitution / e.restitution), c.n + 1, 0.1);
        EXPECT_NEAR(std::log2(before.largest / e.largest), 1, 0.1);
      }
      EXPECT_LT(e.restitution, 1.0 / steps);
      EXPECT_LT(e.force, 1.0 / steps);
      EXPECT_LT(e.duration, 1.0 / steps);
      before = e;
    }
  }
}

/// Without damping the step is of second order, by Hunt-Crossley's law and by Hertz-Mindlin's alike.
TEST(ImpactStep, ElasticImpactConvergesWithOrderTwo) {
  const Strikers bodies{.mass_1 = 0.1, .radius_1 = 14.52e-3};
  const impact::Pair pair{.mass = 0.1, .radius = 14.52e-3, .E_eff = 1.1e11};
  HuntCrossley viscous = viscoelastic(1.5, pair.hertz(), 0, 0);
  HertzMindlin hertz;
  hertz.E_eff = pair.E_eff, hertz.G_eff = 1e10, hertz.restitution = 1, hertz.friction.mu = 0;
  const Event exact = impact::Hertz{}.strike(pair, 2);
  for (const Law& law : {Law(viscous), Law(hertz)}) {
    double before = 0;
    for (const int steps : {100, 200, 400}) {
      const Errors e = errors(strike_in_bed(law, bodies, 2, exact.duration() / steps), exact);
      if (before > 0) {
        EXPECT_NEAR(before / e.largest, 4, 0.5);
      }
      // The leapfrog of an oscillator: (omega dt)^2/24 with omega dt = pi/steps, 0.4/steps^2; F ~ x^1.5.
      EXPECT_LT(e.largest, 1.0 / (steps * steps));
      EXPECT_LT(e.force, 2.0 / (steps * steps));
      EXPECT_LT(e.restitution, 2.0 / (steps * steps));
      before = e.largest;
    }
  }
}

/// Adhesion jumps when the surfaces snap together and part: of first order in the step.
TEST(ImpactStep, JkrConverges) {
  const Strikers bodies{.mass_1 = 1e-4, .radius_1 = 2e-3};
  const impact::Pair pair{.mass = 1e-4, .radius = 2e-3, .E_eff = 5e6};
  impact::Jkr model;
  model.w = 0.4;
  Jkr law;
  law.E_eff = pair.E_eff, law.G_eff = 1e6, law.work = model.w, law.restitution = 1, law.friction.mu = 0;
  for (const double v : {1.5, 6.0}) {
    const Event exact = model.strike(pair, v * model.sticking_speed(pair));
    for (const int steps : {500, 2000}) {
      const Errors e = errors(strike_in_bed(law, bodies, exact.speed, exact.time_in / steps), exact);
      SCOPED_TRACE(testing::Message() << v << " sticking speeds, " << steps << " steps");
      EXPECT_LT(e.restitution, 5.0 / steps);
      EXPECT_LT(e.largest, 2.0 / steps);
      EXPECT_LT(e.force, 3.0 / steps);
      EXPECT_LT(e.duration, 5.0 / steps);
    }
  }
}

/// Walton and Braun's spring: the step passes over the turn, where the indentation changes by the square of it, and
/// over the end of the force, which is straight there.
TEST(ImpactStep, HystereticSpringOfSecondOrder) {
  const Strikers bodies{.mass_1 = 1e-3, .radius_1 = 5e-3};
  const impact::Pair pair{.mass = 1e-3, .radius = 5e-3, .yield = 588e3};
  for (const double e : {0.3, 0.6, 1.0}) {
    impact::Hysteretic model;
    model.restitution = e;
    Hysteretic law;
    law.yield = 588e3, law.restitution = e, law.friction.mu = 0;
    const Event exact = model.strike(pair, 2);
    for (const int steps : {100, 400, 1600}) {
      const Errors err = errors(strike_in_bed(law, bodies, 2, exact.time_in / steps), exact);
      SCOPED_TRACE(testing::Message() << e << ", " << steps << " steps");
      // omega_2 dt = (pi/2)/(e steps) on the way out; the turn is off by half a step at most, (omega_2 dt)^2/8.
      const double fine = 2.5 / (e * e * steps * steps);
      EXPECT_LT(err.largest, fine);
      EXPECT_LT(err.force, fine);
      EXPECT_LT(err.restitution, fine);
      EXPECT_LT(err.duration, fine + 1e-12);
    }
  }
}

/// Restitution given at a speed comes out at that speed, in the bed, over a wide range; below that speed it is higher.
TEST(ImpactStep, RestitutionAtASpeedComesOut) {
  const Strikers bodies{.mass_1 = 1e-3, .radius_1 = 5e-3};
  for (const double k : {0.05, 0.1, 0.3, 0.6, 0.9, 1.0})
    for (const double v : {0.03, 1.0, 30.0}) {
      HuntCrossley law = viscoelastic(1.5, 1e8, NAN, 0);
      law.impact.restitution = k, law.impact.at_speed = v;
      const Event exact = law.impact.strike({.mass = 1e-3}, v);
      EXPECT_NEAR(exact.restitution, k, 1e-14);
      // At k = 0.05 the bodies creep out at the speed 1/b: the force falls over a small part of the duration, which the
      // lagged rate resolves to some 20 steps less.
      const Event got = strike_in_bed(law, bodies, v, exact.time_in / 2000);
      EXPECT_NEAR(got.restitution, k, 2e-3) << k << " at " << v;
    }
}

}  // namespace
}  // namespace subsoil::dem::test::impact_step
