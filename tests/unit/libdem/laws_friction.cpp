#include <gtest/gtest.h>

#include "libdem/step/stability.hpp"
#include "tests/tools/every_law.hpp"
#include "tests/tools/laws.hpp"

/// The limited spring and dashpot of friction.hpp, by itself along given paths and in the engine, contact by contact.
namespace subsoil::dem::test::laws_friction {
namespace {

constexpr FrictionRule kRules[] = {FrictionRule::spring_and_dashpot, FrictionRule::spring_only,
                                   FrictionRule::spring_only_undamped};

/// Law with a friction rule and with rolling and twist that reach their limits.
Law with_rule(const Law& law, FrictionRule rule, double kept) {
  Friction friction = law->friction();
  friction.rule = rule, friction.rolling_damping_at_limit = kept, friction.mu_t = 0.02;
  return law->with_friction(friction);
}

/// One element led along a path, with its energy balance.
template <int D>
struct Led {
  double x[D] = {}, dashpot[D] = {}, force[D] = {}, stored = 0, slid = 0, damped = 0, work = 0, least = 0, scale = 0;

  /// After a step at v: `now` is what the element answers, `k` its stiffness then.
  void take(const Slip<double, D>& now, const double (&v)[D], double dt, double k) {
    stored = 0;
    for (int d = 0; d < D; ++d) {
      work += 0.5 * (force[d] + now.force[d]) * v[d] * dt;
      x[d] = now.x[d], dashpot[d] = now.dashpot[d], force[d] = now.force[d];
      stored += 0.5 * k * x[d] * x[d];
    }
    slid += now.slid, damped += now.damped;
    least = std::min(least, now.slid);
    scale = std::max({scale, stored, std::abs(work)});
  }
};

/// A contact whose overlap and velocities follow random paths: sines of several periods for the overlap, so that
/// contacts come, press, tear and go; velocities that turn, jump and stand still.
struct Path {
  Dice dice;
  double amplitude, phase[3], v[3] = {}, w[3] = {}, twist = 0;
  explicit Path(std::uint32_t seed) : dice(seed) {
    amplitude = 1e-3 * dice.between(0.2, 2);
    for (double& p : phase) p = dice.between(0, 2 * pi);
  }
  double overlap(double t) const {
    return amplitude *
           (std::sin(40 * t + phase[0]) + 0.5 * std::sin(170 * t + phase[1]) + 0.2 * std::sin(900 * t + phase[2]));
  }
  void turn() {
    const double size = std::pow(10, dice.between(-3, 1));
    for (int d = 0; d < 2; ++d) v[d] = dice.between(-size, size), w[d] = dice.between(-size, size) / 5e-3;
    twist = dice.between(-size, size) / 5e-3;
  }
};

/// Leads a law's contact along a path; the normal is z, so springs stay across it.
void lead(const Law& law, std::uint32_t seed, Led<3>& slide, Led<3>& roll, Led<1>& twist) {
  Path path(seed);
  const Friction& friction = law->friction();
  double own[kOwnMemory] = {}, slipping = 0;
  const double dt = 2e-6 * std::pow(10, path.dice.between(0, 1.5)), r_eff = 5e-3, root_m = 3e-2, root_i = 2e-4;
  for (int n = 0; n < 3000; ++n) {
    if (n % 50 == 0) path.turn();
    const double t = n * dt, overlap = path.overlap(t), rate = n == 0 ? 0 : (overlap - path.overlap(t - dt)) / dt;
    const auto f = law->normal(Approach<double>{overlap, rate, root_m, r_eff, n == 0 ? 0 : dt}, own);
    const auto s = friction.slide(f, slide.x, path.v, slide.dashpot, slipping, dt);
    slide.take(s, path.v, dt, friction.tangential == Tangential::spring ? f.k_t : 0);
    slipping = s.slipping;
    if (friction.rolling == Rolling::elastic_plastic)
      roll.take(
          friction.roll(f, roll.x, path.w, roll.dashpot, r_eff, 1 / r_eff, root_i, dt), path.w, dt,
          std::isnan(friction.k_r) ? f.k_n * Friction::turning_share(friction.mu_r) * r_eff * r_eff : friction.k_r);
    const double w[1] = {path.twist};
    twist.take(friction.twist(f, twist.x[0], path.twist, twist.dashpot[0], r_eff, 1 / r_eff, root_i, dt), w, dt,
               f.k_n * Friction::turning_share(friction.mu_t) * r_eff * r_eff);
  }
}

template <int D>
void expect_never_gains(const Led<D>& led, const std::string& what) {
  EXPECT_GE(led.least, -1e-13 * led.scale) << what;  // rounding of one step
  // Of order dt: the half step in which a contact parts, and the fall of k_t in a step, are not in the mean of two
  // ends.
  EXPECT_NEAR(led.work, led.stored + led.slid + led.damped, 0.01 * led.scale) << what;
}

TEST(Friction, SlidingNeverGainsAlongRandomPaths) {
  double slid = 0, rolled = 0, twisted = 0;
  for (const auto& [name, given] : every_law())
    for (const FrictionRule rule : kRules)
      for (std::uint32_t seed = 0; seed < 12; ++seed) {
        Led<3> slide, roll;
        Led<1> twist;
        lead(with_rule(given, rule, 0.5 * (seed % 3)), seed, slide, roll, twist);
        const std::string what =
            name + ", rule " + std::to_string(static_cast<int>(rule)) + ", path " + std::to_string(seed);
        expect_never_gains(slide, what);
        expect_never_gains(roll, what + ", rolling");
        expect_never_gains(twist, what + ", twist");
        slid += slide.slid, rolled += roll.slid, twisted += twist.slid;
      }
  for (const double lost : {slid, rolled, twisted}) EXPECT_GT(lost, 0);
}

/// The same in the engine, where each contact is alone in its bed: two spheres that meet, in both precisions.
TEST(Friction, SlidingNeverGainsInTheEngine) {
  for (const auto& [name, given] : every_law())
    for (const Precision precision : {Precision::doubles, Precision::mixed})
      for (std::uint32_t seed = 0; seed < 6; ++seed) {
        BedOptions options = quiet();
        options.precision = precision, options.overlap_limit = 0.95;
        const LawTable laws = table(with_rule(given, kRules[seed % 3], 0.5 * (seed % 3)));
        const StepQuestion extremes{
            .smallest_radius = 3e-3, .largest_radius = 8e-3, .density = 1800, .speed = 3, .neighbours = 1};
        const double dt = (seed < 3 ? 0.5 : 0.05) * stable_step(laws.laws[0], extremes).step;
        Bed bed(laws, options);
        Dice dice(100 + seed);
        SphereSpec a, b;
        a.radius = 5e-3, b.radius = dice.between(3e-3, 8e-3), a.density = b.density = 1800;
        b.position = {0, a.radius + b.radius + 5e-5, 0};
        a.velocity = dice.ball(0.5), b.velocity = dice.ball(0.5) + Vec3{0, -0.6, 0};
        a.angular_velocity = dice.ball(200), b.angular_velocity = dice.ball(200);
        bed.add(std::vector<SphereSpec>{a, b});
        double before = 0, least = 0;
        for (int n = 0; n < 1000; ++n) {
          bed.step(dt, {.energy = true, .snapshot = nullptr});
          least = std::min(least, bed.energy().lost.sliding - before);
          before = bed.energy().lost.sliding;
        }
        const double kinetic = 2e-3;  // J, of some grams at 1 m/s
        EXPECT_GE(least, (precision == Precision::mixed ? -1e-8 : -1e-15) * kinetic) << name << ", path " << seed;
      }
}

/// At constant velocity the limit is all that is left: force mu N, spring the limit less the dashpot's part, or 0 where
/// the dashpot alone exceeds it; of the other rules mu N/k and the dashpot beside it or not.
TEST(Friction, SteadySlidingByEachRule) {
  for (const double v : {0.01, 5.0}) {
    for (const FrictionRule rule : kRules) {
      Linear given = grains(1e5, 0.6, 0.4, 0);
      given.friction.rule = rule;
      const Linear law = given.resolved();
      const NormalForce<double> n = law.normal(Approach<double>{1e-4, 0, 3e-2, 5e-3, 0});
      const double limit = 0.4 * n.force, viscous = n.c_t * v, dt = 1e-9 / v;
      double x[3] = {}, dashpot[3] = {}, slid = 0;
      const double along[3] = {v, 0, 0};
      Slip<double> s{};
      for (double path = 0; path < 3 * limit / n.k_t; path += v * dt) {
        s = law.friction.slide(n, x, along, dashpot, 0.0, dt);
        std::copy(s.x, s.x + 3, x), std::copy(s.dashpot, s.dashpot + 3, dashpot);
        slid = s.slid / dt;
      }
      const double spring = rule == FrictionRule::spring_and_dashpot ? std::max(0.0, limit - viscous) : limit;
      const double beside = rule == FrictionRule::spring_only ? viscous : 0;
      // The step that the spring grows before it slides back.
      EXPECT_NEAR(n.k_t * x[0], spring, 1.01 * n.k_t * v * dt);
      EXPECT_NEAR(s.force[0], limit + beside, 1e-12 * limit);
      EXPECT_NEAR(slid, limit * v, 1e-3 * limit * v);
    }
  }
}

/// Ai's type C at a constant rolling velocity: k rho + c w until k rho is the cap, then the cap and f c w.
TEST(Friction, RollingSpringIsCappedAlone) {
  for (const double kept : {0.0, 0.4, 1.0}) {
    Linear law = grains(1e5, 0.6, 0.4, 0.1);
    law.friction.rolling_damping_at_limit = kept;
    const double r = 5e-3, root_i = 3e-4, dt = 1e-5, w = 3;
    const NormalForce<double> n = law.resolved().normal(Approach<double>{1e-4, 0, 3e-2, r, 0});
    const double k = 2.25 * n.k_n * 0.1 * 0.1 * r * r, cap = 0.1 * r * n.force;
    const double c = 2 * law.friction.rolling_damping * root_i * std::sqrt(k);
    double rho[3] = {}, dashpot[3] = {};
    const double turning[3] = {0, w, 0};
    for (int step = 1; step < 4000; ++step) {
      const auto s = law.friction.roll(n, rho, turning, dashpot, r, 1 / r, root_i, dt);
      std::copy(s.x, s.x + 3, rho);
      const double spring = k * w * dt * step;
      const bool at_cap = spring > cap;
      if (std::abs(spring - cap) < 1e-6 * cap) continue;
      ASSERT_NEAR(s.force[1], at_cap ? cap + kept * c * w : spring + c * w, 1e-9 * (cap + c * w)) << step;
    }
    EXPECT_NEAR(k * rho[1], cap, 1e-9 * cap);
  }
}

}  // namespace
}  // namespace subsoil::dem::test::laws_friction
