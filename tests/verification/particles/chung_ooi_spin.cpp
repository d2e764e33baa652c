#include <gtest/gtest.h>

#include <array>
#include <boost/numeric/odeint.hpp>

#include "tests/tools/verified.hpp"
#include "tests/verification/particles/oblique_impact.hpp"

/// Chung & Ooi 2011, tests 6 to 8: spheres that spin when they meet, aluminium alloy and nylon, R = 0.1 m, V_n = 0.2
/// m/s, mu = 0.4, e = 0.5. The engine is held against an integration of its own force law in dimensionless form; the
/// points read off the paper's figures belong to another convention and are shown beside it (ConventionOfThePaper).
namespace subsoil::dem::test::chung_ooi_spin {
namespace {

using subsoil::test::absolute;
using subsoil::test::share;
using subsoil::test::Verified;
using subsoil::test::VerifiedCurve;
using subsoil::test::Worst;

constexpr double r = 0.1, v_n = 0.2, mu = 0.4, e = 0.5;
const Material aluminium{"aluminium alloy", 70e9, .33, 2700}, nylon{"nylon", 2.5e9, .4, 1000};

/// Damping of Tsuji's dashpot in units of speed V and time (m/k)^(2/5) V^(-1/5), k = 4/3 E* sqrt R:
/// x'' = -(x^1.5 + damp x^0.25 x').
double damping_of(double restitution) {
  const double b = restitution < 1 ? -std::log(restitution) / std::hypot(pi, std::log(restitution)) : 0;
  return 2 * std::sqrt(5.0 / 6) * b * std::sqrt(1.5);
}

/// Impulse of the pressing part of the force over m V, for Hertz with Tsuji's dashpot and restitution e: 1 + e and what
/// the dashpot pulls back at the end, by an integration of its own. Friction acts under the pressing part alone.
double pressing_impulse() {
  const double damp = damping_of(e);
  using State = std::array<double, 3>;  // x, v, impulse
  const auto force = [&](double x, double v) { return std::pow(x, 1.5) + damp * std::pow(x, 0.25) * v; };
  boost::numeric::odeint::runge_kutta_fehlberg78<State> step;
  State y{1e-12, 1, 0};
  for (double t = 0; t < 20; t += 1e-4) {
    step.do_step(
        [&](const State& s, State& d, double) {
          const double x = std::max(s[0], 0.0), f = force(x, s[1]);
          d = {s[1], -f, std::max(f, 0.0)};
        },
        y, t, 1e-4);
    if (y[0] <= 0) break;
  }
  return y[2];
}

/// Conventions of friction that published programs have. `ours`: what rises in the spring keeps its force, what falls
/// its length; spring and dashpot are limited together by the whole pressing force, and at the limit the spring slides
/// back by what exceeds it, at most by what it had before the step (theory.md, section 5). `paper`: the spring keeps
/// its length always, it alone is limited, by Hertz's force without the dashpot's, and the tangential dashpot acts only
/// while the contact sticks.
enum class Convention { ours, paper };

/// Tangential velocity of the contact point after the impact over that before, reversed: beta. A sphere without
/// tangential velocity of its centre strikes with a spin of V_st/R.
/// @param x 3.5 mu (1 + e) V_n/V_st; @param arm_loss how much shorter the moment arm is than R, over the overlap
double beta_of(double x, double poisson, Convention convention, double tau_v_over_r, double arm_loss) {
  const double k_t_over_k_n = 2 * (1 - poisson) / (2 - poisson);  // 4 G*/E* of Mindlin
  const double damp = damping_of(e), dt = 3.2 / 40000;            // a contact lasts 3.2
  const double spin = 3.5 * mu * (1 + e) / x;
  double depth = 1e-12, speed = 1, v_t = 0, w = spin, spring = 0, k_before = 0;  // w: R omega/V
  const auto normal = [&](double d) { return std::pow(d, 1.5) + damp * std::pow(d, 0.25) * speed; };
  while (true) {
    speed -= 0.5 * dt * normal(depth);
    depth += dt * speed;
    if (depth <= 0) return -(v_t + w) / spin;
    const double force = normal(depth), k = 1.5 * k_t_over_k_n * std::sqrt(depth),
                 c = damp * std::sqrt(k_t_over_k_n) * std::pow(depth, 0.25);
    const double arm = 1 - arm_loss * tau_v_over_r * depth, slip = v_t + arm * w;
    if (convention == Convention::ours && k_before > 0) spring *= std::min(1.0, k_before / k);
    k_before = k;
    const double spring_0 = spring;
    spring += slip * dt;
    double friction = k * spring + c * slip;
    if (convention == Convention::ours) {
      const double limit = mu * std::max(force, 0.0), over = std::abs(friction) - limit;
      if (over > 0) {
        const double way = std::copysign(1.0, friction);
        spring -= way * std::min(over / k, std::max(0.0, way * spring_0));
        friction = way * limit;
      }
    } else if (const double limit = mu * std::pow(depth, 1.5); std::abs(k * spring) > limit) {
      friction = std::copysign(limit, spring), spring = friction / k;
    }
    v_t -= dt * friction;
    w -= 2.5 * dt * friction * arm;
    speed -= 0.5 * dt * force;
  }
}
/// V (m/k)^(2/5) V^(-1/5) / R, k = 4/3 E* sqrt(R_eff): the unit of the overlap over the radius.
double unit_of_overlap(double mass, double e_eff, double r_eff) {
  return std::pow(mass * v_n * v_n / (4.0 / 3 * e_eff * std::sqrt(r_eff)), 0.4) / r;
}

constexpr double kReading = 0.01;
const char* const kStep = "4000 steps a contact: where a contact begins, slips and parts lies within one";
const char* const kOther = "read to 0.01; the paper's friction is of another convention, see the text above the table";

/// The engine at the paper's abscissae against the integration of its own convention, and beside the paper's points.
void hold(const Verified& engine, const Verified& paper, const std::string& which, const std::vector<Point>& points,
          const std::function<double(double)>& ours, const std::function<double(double)>& integrated) {
  Worst worst;
  for (const Point& p : points) {
    char at[32];
    std::snprintf(at, sizeof at, " = %.3f", p.in);
    const double beta = ours(p.in);
    worst.take("at" + std::string(at), beta, integrated(p.in));
    paper.compare(std::string("beta at 3.5 mu (1+e) V_n/V_st") + at + ", " + which, "1", beta, p.out, kReading, kOther);
  }
  worst.near(engine, "beta, " + which, "1", absolute(1e-3), kStep);
}

const std::vector<Point> kAluminiumPoints = {{0.1762, -0.820}, {0.3524, -0.633}, {0.5507, -0.445}, {0.7709, -0.243},
                                             {0.9692, -0.028}, {1.1894, 0.097},  {1.4537, 0.119},  {1.7401, 0.100},
                                             {2.0925, 0.058},  {2.9956, -0.050}, {4.5154, -0.140}};
const std::vector<Point> kNylonPoints = {{0.1762, -0.824}, {0.3744, -0.638}, {0.5727, -0.443}, {0.7489, -0.243},
                                         {0.9692, -0.026}, {1.1894, 0.093},  {1.4537, 0.119},  {1.7401, 0.117},
                                         {2.0925, 0.095},  {2.9956, 0.007},  {4.5154, -0.120}};

TEST(ChungOoi, Test6ConstantNormalVelocityAndSpin) {
  const Verified engine(kImpactField, "Normal impact with rotation, e = 0.5",
                        "an integration of the engine's convention");
  const Verified paper(kImpactField, "Chung-Ooi 6: normal impact with rotation", kReadPoints);
  for (const auto& [material, points] : {std::pair{aluminium, kAluminiumPoints}, {nylon, kNylonPoints}}) {
    const Material& m = material;
    const auto run = [&](double x) {
      const double patch = 3.5 * mu * (1 + e) * v_n / x;
      return -strike(against_wall(m, e, mu), r, m.density, 0, v_n, patch / r, fine_step(m, r, v_n)).patch / patch;
    };
    const double unit = unit_of_overlap(m.density * 4 / 3 * pi * r * r * r, m.young / (1 - m.poisson * m.poisson), r);
    hold(engine, paper, m.name, points, run,
         [&](double x) { return beta_of(x, m.poisson, Convention::ours, unit, 1); });
    VerifiedCurve curve(std::string("chung-ooi-6-") + m.name);
    for (double x = 0.1; curve.drawn() && x < 25; x *= 1.05) curve.point(x, run(x));
  }
}

TEST(ChungOoi, GrossSlidingOfASpinningSphere) {
  const Verified exact(kImpactField, "Gross sliding of a rotating sphere, e = 0.5",
                       "V_st' = V_st - 3.5 mu I/m, I the impulse of the pressing force by RKF78");
  const double pressing = pressing_impulse();
  const Rebound slides =
      strike(against_wall(aluminium, e, mu), r, aluminium.density, 0, v_n, 20 * v_n / r, fine_step(aluminium, r, v_n));
  exact.near("tangential velocity", "m/s", -slides.v_t, mu * pressing * v_n, share(1e-3),
             "the spring loads up over some steps; damping lags by half a step");
  exact.near("angular velocity", "rad/s", slides.spin, 20 * v_n / r - 2.5 * mu * pressing * v_n / r, share(1e-3),
             "moment arm r - delta");
}

/// Where the points of 6 belong: of the conventions that programs publish the one named here fits best. The engine with
/// that convention, against its integration and against the points.
TEST(ChungOoi, ConventionOfThePaper) {
  const char* const keys =
      "`changing stiffness: keep-spring`, `friction rule: spring-only-undamped`, `limiting force: elastic-force`";
  const Verified points_row(kImpactField, "Chung-Ooi 6 by the paper's conventions", kReadPoints + "; " + keys);
  const Verified engine(kImpactField, "The same, against its equations", "an integration of that convention");
  for (const auto& [material, points] : {std::pair{aluminium, kAluminiumPoints}, {nylon, kNylonPoints}}) {
    const Material& m = material;
    HertzMindlin law = against_wall(m, e, mu);
    law.friction.changing = Changing::keep_spring, law.friction.rule = FrictionRule::spring_only_undamped;
    law.friction.limiting = LimitingForce::elastic, law.friction.moment_arm = MomentArm::radius;
    Worst from_points, from_integration;
    for (const Point& p : points) {
      char at[32];
      std::snprintf(at, sizeof at, "at %.3f", p.in);
      const double patch = 3.5 * mu * (1 + e) * v_n / p.in;
      const double beta = -strike(law, r, m.density, 0, v_n, patch / r, fine_step(m, r, v_n)).patch / patch;
      from_points.take(at, beta, p.out);
      from_integration.take(at, beta, beta_of(p.in, m.poisson, Convention::paper, 0, 0));
    }
    from_points.near(points_row, std::string("beta where farthest from the points, ") + m.name, "1", absolute(0.04),
                     "read to 0.01; what else the paper's program does is not known");
    from_integration.near(engine, std::string("beta, ") + m.name, "1", absolute(2e-3), kStep);
  }
}

/// Two spheres that meet along x with spins about z.
struct Pair {
  Sphere a, b;
};
Pair meet(const HertzMindlin& law, const SphereSpec& one, const SphereSpec& other, double dt) {
  Bed bed(table(law), quiet());
  const std::vector<SphereSpec> both{one, other};
  bed.add(both);
  for (int n = 0; n < 200000 && (n < 100 || bed.touching_pairs() > 0); ++n) bed.step(dt);
  return {sphere(bed, 0), sphere(bed, 1)};
}

TEST(ChungOoi, Test7IdenticalSpheresWithOppositeSpins) {
  const Material& m = aluminium;
  const Verified row(kImpactField, "Chung-Ooi 7: identical spheres with opposite angular velocities",
                     "they roll on each other: nothing changes; " + kChungOoi);
  Worst spin, speed;
  for (const double w : {0.175, 1.155, 4.289, 22.86}) {
    const HertzMindlin law = elastic(m.young, m.poisson, e, mu);
    const Pair p = meet(law, {{-r * (1 + 1e-7), 0, 0}, {v_n, 0, 0}, {0, 0, w}, r, m.density, 0},
                        {{r * (1 + 1e-7), 0, 0}, {-v_n, 0, 0}, {0, 0, -w}, r, m.density, 0}, 2 * fine_step(m, r, v_n));
    const std::string at = "omega = " + std::to_string(w).substr(0, 6) + " rad/s";
    spin.take(at, p.a.w.z, w);
    speed.take(at, p.a.v.y, 0);
  }
  spin.near(row, "angular velocity after, of 0.175 to 22.86 rad/s before", "rad/s", share(1e-12),
            "no sliding anywhere: rounding");
  speed.near(row, "tangential velocity of the centre after", "m/s", absolute(1e-12), "rounding");
  const Verified own(kImpactField, "Identical spheres with equal angular velocities",
                     "own case; gross sliding, I by RKF78");
  const HertzMindlin law = elastic(m.young, m.poisson, e, mu);
  const Pair p = meet(law, {{-r * (1 + 1e-7), 0, 0}, {v_n, 0, 0}, {0, 0, 30}, r, m.density, 0},
                      {{r * (1 + 1e-7), 0, 0}, {-v_n, 0, 0}, {0, 0, 30}, r, m.density, 0}, 2 * fine_step(m, r, v_n));
  const double pressing = pressing_impulse();
  own.near("tangential velocity after", "m/s", std::abs(p.a.v.y), mu * pressing * v_n, share(1e-3), "as above");
  own.near("angular velocity after", "rad/s", p.b.w.z, 30 - 2.5 * mu * pressing * v_n / r, share(1e-3),
           "moment arm r - delta/2");
}

TEST(ChungOoi, Test8SpheresOfDifferentSize) {
  // The large sphere is five times the radius and a thousand times the density; in case A it is a thousand times as
  // stiff.
  const Material& m = aluminium;
  const std::vector<Point> points = {{0.1872, -0.815}, {0.3583, -0.626}, {0.5508, -0.439}, {0.7647, -0.238},
                                     {0.9786, -0.017}, {1.2139, 0.096},  {1.4920, 0.111},  {1.7701, 0.090},
                                     {2.0909, 0.058},  {2.9893, -0.049}, {4.5080, -0.139}};
  const Verified engine(kImpactField, "Spheres of different size with rotation, e = 0.5",
                        "an integration of the engine's convention");
  const Verified paper(kImpactField, "Chung-Ooi 8: spheres of different size with rotation", kReadPoints);
  for (const bool stiff : {true, false}) {
    HertzMindlin law;
    law.take_materials(m.young, m.poisson, stiff ? 1000 * m.young : m.young, m.poisson);
    law.restitution = e, law.friction.mu = mu;
    const double unit = unit_of_overlap(m.density * 4 / 3 * pi * r * r * r, law.E_eff, r * 5 / 6);
    hold(
        engine, paper, stiff ? "case A" : "case B", points,
        [&](double x) {
          const double patch = 3.5 * mu * (1 + e) * v_n / x;
          const Pair p = meet(law, {{-r * (1 + 1e-7), 0, 0}, {v_n, 0, 0}, {0, 0, patch / r}, r, m.density, 0},
                              {{5 * r, 0, 0}, {}, {}, 5 * r, 1000 * m.density, 0}, fine_step(m, r, v_n));
          return -(p.a.v.y + r * p.a.w.z) / patch;
        },
        [&](double x) { return beta_of(x, m.poisson, Convention::ours, unit, 0.5); });
  }
}

}  // namespace
}  // namespace subsoil::dem::test::chung_ooi_spin
