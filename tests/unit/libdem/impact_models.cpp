#include <gtest/gtest.h>

#include <array>
#include <boost/math/special_functions/gamma.hpp>
#include <boost/numeric/odeint.hpp>
#include <cmath>

#include "libdem/impact/models.hpp"
#include "tests/tools/message_of.hpp"

/// Impact models against printed values and against an independent integration of m x'' = -F in time; the tables of
/// their sources: tests/verification/particles/impact_published.cpp.
namespace subsoil::dem::impact::test::impact_models {
namespace {

using subsoil::test::message_of;

/// Steel ball of 0.1 kg on a steel plate as the preprint of Borovin, Dyagel, Lapshin has it.
HuntCrossleyModel steel() {
  HuntCrossleyModel law;
  law.c = 1.7135e10, law.b = 0.1;
  return law;
}
const Pair ball{.mass = 0.1};

/// Printed digits: relative to one unit of the last of `digits`.
void expect_digits(double got, double printed, int digits, const char* what) {
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(printed))) - (digits - 1));
  EXPECT_NEAR(got, printed, 0.51 * unit) << what;
}

TEST(HuntCrossleyImpact, RestitutionAtPrintedPointsAndInBothLimits) {
  expect_digits(hunt_crossley_restitution(0.1), 0.9374755799, 10, "nu = 0.1");
  expect_digits(hunt_crossley_restitution(0.9), 0.6197364661, 10, "nu = 0.9");
  EXPECT_EQ(hunt_crossley_restitution(0), 1);
  // The series 1 - 2/3 nu + 4/9 nu^2 - 44/135 nu^3 + 104/405 nu^4; the next term is below 0.25 nu^5. Where W alone
  // would leave 1e-8 (argument within nu^2/2 of -1/e) rounding is kept.
  for (const double nu : {1e-12, 1e-8, 1e-6, 1e-4, 1e-3}) {
    const double series = 1 - nu * (2.0 / 3 - nu * (4.0 / 9 - nu * (44.0 / 135 - nu * 104.0 / 405)));
    EXPECT_NEAR(hunt_crossley_restitution(nu), series, 0.25 * std::pow(nu, 5) + 4e-16) << nu;
  }
  // The defining equation k nu + ln(1 - k nu) = ln(1 + nu) - nu, in long double; 1 - k nu -> exp(-1 - nu)(1 + nu).
  for (const double nu : {0.01, 0.019, 0.021, 0.3, 1.0, 3.0, 10.0}) {
    const long double p = static_cast<long double>(hunt_crossley_restitution(nu)) * nu;
    const long double residual = p + std::log1p(-p) - (std::log1p(static_cast<long double>(nu)) - nu);
    // d(residual)/dp = -p/(1 - p), times the rounding of k.
    EXPECT_LT(std::abs(residual), 8e-16L * p * p / (1 - p)) << nu;
  }
  EXPECT_NEAR(hunt_crossley_restitution(1e4) * 1e4, 1, 1e-15) << "rebound tends to 1/b";
}

TEST(HuntCrossleyImpact, RestitutionAtASpeedGivesBack) {
  for (const double k : {0.05, 0.2, 0.5, 0.9, 0.999, 1.0})
    EXPECT_NEAR(hunt_crossley_restitution(hunt_crossley_nu(k)), k, 4e-16) << k;
  HuntCrossleyModel law;
  law.c = 1e7, law.restitution = 0.7, law.at_speed = 1.5;
  EXPECT_NEAR(law.strike(ball, 1.5).restitution, 0.7, 1e-14);
  EXPECT_GT(law.strike(ball, 0.5).restitution, 0.8) << "it falls with the speed";
}

TEST(HuntCrossleyImpact, ElasticLimitIsHertz) {
  HuntCrossleyModel law = steel();
  law.b = 0;
  for (const double b : {0.0, 1e-120, 1e-14}) {
    law.b = b;
    const Event e = law.strike(ball, 2);
    const double x = std::pow(15.0 / 8 * 0.1 * 4 / (1.5 * law.c), 0.4);  // (15 m v^2/(16 E sqrt R))^(2/5)
    EXPECT_NEAR(e.largest, x, 1e-12 * x) << b;
    // 2 x/V int_0^1 dy/sqrt(1 - y^(5/2)) = (4/5) sqrt(pi) Gamma(2/5)/Gamma(9/10) x/V = 2.943275184 x/V
    const double time = 0.8 * std::sqrt(std::acos(-1.0)) * boost::math::tgamma_ratio(0.4, 0.9) * x / 2;
    EXPECT_NEAR(e.duration(), time, 1e-11 * time) << b;
    EXPECT_NEAR(e.peak_force, law.c * std::pow(x, 1.5), 1e-12 * e.peak_force) << b;
    EXPECT_NEAR(e.restitution, 1, 1e-13) << b;
  }
}

/// What an integration in time finds, with no use of first integrals: events by bisection of the last step.
struct Measured {
  double rebound = 0, largest = 0, time_in = 0, duration = 0, peak = 0, peak_time = 0;
};
template <class Force>
Measured integrate(Force force, double mass, double speed, double scale, double end) {
  using State = std::array<double, 2>;
  namespace ode = boost::numeric::odeint;
  const auto rhs = [&](const State& y, State& d, double) { d = {y[1], -force(y[0], y[1]) / mass}; };
  ode::runge_kutta_fehlberg78<State> step;
  State y{0, speed}, before = y;
  const double dt = scale / 4000;
  Measured m;
  double t = 0;
  const auto refine = [&](auto crossed) {  // the part of the step at which `crossed` becomes true
    double low = 0, high = dt;
    for (int k = 0; k < 60; ++k) {
      State trial = before;
      const double h = 0.5 * (low + high);
      step.do_step(rhs, trial, t, h);
      (crossed(trial) ? high : low) = h;
    }
    State at = before;
    step.do_step(rhs, at, t, high);
    return std::pair(t + high, at);
  };
  double f_before = 0, f_two = 0;
  for (int n = 0; n < 100000; ++n, t += dt) {
    before = y;
    step.do_step(rhs, y, t, dt);
    const double f = force(y[0], y[1]);
    // Crest of the parabola through three steps.
    if (const double bend = f_two - 2 * f_before + f; f_before > f_two && f_before >= f && bend < 0) {
      const double part = 0.5 * (f_two - f) / bend, crest = f_before - 0.125 * (f - f_two) * (f - f_two) / bend;
      if (crest >= m.peak) m.peak = crest, m.peak_time = t + part * dt;
    }
    f_two = f_before, f_before = f;
    if (before[1] > 0 && y[1] <= 0) {
      const auto [at, state] = refine([](const State& s) { return s[1] <= 0; });
      m.time_in = at, m.largest = state[0];
    }
    if (y[1] < 0 && y[0] <= end) {
      const auto [at, state] = refine([&](const State& s) { return s[0] <= end; });
      m.duration = at, m.rebound = -state[1];
      return m;
    }
  }
  ADD_FAILURE() << "never came apart; last force " << f_before;
  return m;
}

void expect_agree(const Event& e, const Measured& m, double share, double peak_share) {
  EXPECT_NEAR(e.largest, m.largest, share * m.largest);
  EXPECT_NEAR(e.time_in, m.time_in, share * m.duration);
  EXPECT_NEAR(e.duration(), m.duration, share * m.duration);
  EXPECT_NEAR(e.rebound, m.rebound, share * e.speed);
  EXPECT_NEAR(e.peak_force, m.peak, peak_share * m.peak);
}

TEST(HuntCrossleyImpact, AgreesWithIntegrationInTimeForAnyExponent) {
  for (const double n : {1.0, 1.5, 1.7, 3.0})
    for (const double b : {0.0, 0.02, 0.5, 20.0}) {
      HuntCrossleyModel law;
      law.n = n, law.c = 2e6, law.b = b;
      const Pair pair{.mass = 0.3};
      const Event e = law.strike(pair, 2);
      const auto force = [&](double x, double v) { return x > 0 ? law.c * std::pow(x, n) * (1 + b * v) : 0.0; };
      const Measured m = integrate(force, 0.3, 2, e.duration(), 0);
      SCOPED_TRACE(testing::Message() << "n " << n << " b " << b);
      // x^n is not smooth at 0 (n = 1.5: x'' bends like t^1.5), which the first and last steps pay. The crest through
      // three of 4000 steps misses by the fourth difference; at b = 20 (nu = 40) the peak is 50 times narrower than the
      // impact, so that a step is 1/80 of it.
      expect_agree(e, m, 1e-8, 2e-6);
      EXPECT_NEAR(e.peak_time, m.peak_time, 2 * e.duration() / 4000);
    }
}

TEST(HuntCrossleyImpact, CourseIsTheMotion) {
  const Event e = steel().strike(ball, 5);
  double worst = 0, most = 0;
  for (std::size_t k = 1; k < e.course.size(); ++k) {
    const Sample &a = e.course[k - 1], &s = e.course[k];
    // Momentum over an interval: m dv = -int F dt by the trapezoidal rule, off by (dt^2/12) F'' ~ 1e-4 of the peak (dt
    // = T/400).
    worst = std::max(worst, std::abs(0.1 * (s.v - a.v) / (s.t - a.t) + 0.5 * (a.f + s.f)) / e.peak_force);
    most = std::max(most, s.f);
  }
  EXPECT_LT(worst, 3e-4);
  EXPECT_NEAR(most, e.peak_force, 1e-4 * e.peak_force);
  EXPECT_EQ(e.course.front().t, 0);
  EXPECT_NEAR(e.course.back().v, -e.rebound, 1e-13);
  EXPECT_NEAR(e.course.back().x, 0, 1e-20);
}

/// Millimetre sphere of a soft metal.
const Pair metal{.mass = 7800 * 4.0 / 3 * 3.14159265358979 * 1e-9, .radius = 1e-3, .E_eff = 1e11, .density = 7800};

TEST(Thornton, PublishedValuesAndItsOwnForces) {
  const Thornton law{.p_y = 1e9};
  const double v_y = law.yield_speed(metal);
  EXPECT_NEAR(v_y, 3.194 * std::sqrt(std::pow(1e9, 5) * 1e-9 / (std::pow(1e11, 4) * metal.mass)), 3e-4 * v_y);
  expect_digits(law.restitution_at(metal, 2 * v_y), 0.93063, 5, "2 V_y");
  expect_digits(law.restitution_at(metal, 10 * v_y), 0.65856, 5, "10 V_y");
  expect_digits(law.restitution_at(metal, 100 * v_y), 0.37430, 5, "100 V_y");
  EXPECT_EQ(law.restitution_at(metal, v_y), 1);
  // The forces, written down again from the card: the plastic branch and an unloading with the flattened radius.
  const double k = 4.0 / 3 * 1e11 * std::sqrt(1e-3), x_y = std::pow(std::acos(-1.0) * 1e9 / 2e11, 2) * 1e-3;
  const auto loading = [&](double x) {
    return x < x_y ? k * std::pow(std::max(x, 0.0), 1.5)
                   : k * std::pow(x_y, 1.5) + std::acos(-1.0) * 1e9 * 1e-3 * (x - x_y);
  };
  for (const double u : {0.5, 1.5, 5.0, 40.0}) {
    const Event e = law.strike(metal, u * v_y);
    double deepest = 0;
    const auto force = [&](double x, double v) {
      if (v >= 0) return deepest = std::max(deepest, x), loading(x);
      const double f = loading(e.largest), flat = 1e-3 * k * std::pow(e.largest, 1.5) / f;
      const double k_flat = 4.0 / 3 * 1e11 * std::sqrt(flat), x_p = e.largest - std::pow(f / k_flat, 2.0 / 3);
      return x > x_p ? k_flat * std::pow(x - x_p, 1.5) : 0.0;
    };
    const double f = loading(e.largest), flat = 1e-3 * k * std::pow(e.largest, 1.5) / f;
    const double x_p = e.largest - std::pow(f / (4.0 / 3 * 1e11 * std::sqrt(flat)), 2.0 / 3);
    SCOPED_TRACE(u);
    // The force bends at x_y and at the turn; steps across them err by (h^2): 1e-6 of the whole.
    expect_agree(e, integrate(force, metal.mass, u * v_y, e.duration(), u < 1 ? 0 : x_p), 3e-6, 1e-6);
  }
}

/// Walton and Braun: the two half swings by hand, and the motion integrated under the path-dependent force. The force
/// bends at the turn; steps across it err by (h^2), 1e-6 of the whole.
TEST(HystereticImpact, TwoQuarterSwingsAndTheMotion) {
  const Pair grain{.mass = 1.4e-3, .radius = 5e-3, .yield = 588e3};
  const double k1 = 5 * 5e-3 * 588e3;
  for (const double e : {0.3, 0.6, 1.0})
    for (const double v : {0.1, 2.0}) {
      Hysteretic model;
      model.restitution = e;
      const Event event = model.strike(grain, v, 400);
      SCOPED_TRACE(testing::Message() << "e " << e << ", " << v << " m/s");
      EXPECT_NEAR(event.restitution, e, 1e-15);
      EXPECT_NEAR(event.largest, v * std::sqrt(1.4e-3 / k1), 1e-15);
      EXPECT_NEAR(event.peak_force, v * std::sqrt(1.4e-3 * k1), 1e-12 * event.peak_force);
      EXPECT_NEAR(event.duration(), std::acos(-1.0) / 2 * (1 + e) * std::sqrt(1.4e-3 / k1), 1e-15);
      EXPECT_NEAR(event.lost, 0.5 * 1.4e-3 * v * v * (1 - e * e), 1e-15);
      const double k2 = k1 / (e * e), stays = (1 - e * e) * event.largest;
      EXPECT_NEAR(event.course.back().x, stays, 1e-15);
      const auto force = [&](double x, double speed) { return speed >= 0 ? k1 * x : std::max(0.0, k2 * (x - stays)); };
      expect_agree(event, integrate(force, 1.4e-3, v, event.duration(), stays), 3e-6, 2e-6);
      // The course: momentum over an interval by the trapezoidal rule, (dt^2/12) F'' = (pi/800)^2/12 of the peak.
      for (std::size_t k = 1; k < event.course.size(); ++k) {
        const Sample &a = event.course[k - 1], &s = event.course[k];
        EXPECT_NEAR(1.4e-3 * (s.v - a.v), -0.5 * (a.f + s.f) * (s.t - a.t), 2e-6 * event.peak_force * (s.t - a.t));
      }
    }
  Hysteretic by_k2;
  by_k2.K1 = 1e4, by_k2.K2 = 4e4;
  EXPECT_EQ(by_k2.restitution_at(grain, 1), 0.5);
  by_k2.K2 = 5e3;
  EXPECT_EQ(message_of([&] { by_k2.check(); }),
            "K2 must not be below K1: unloading cannot give back more than loading");
  Hysteretic nothing;
  nothing.restitution = 0.5;
  EXPECT_EQ(message_of([&] { static_cast<void>(nothing.strike({.mass = 1}, 1)); }),
            "needs K1, or a yield strength (S_y, or that of a body) and the radius of a body");
}

TEST(JacksonGreen, PublishedValuesAndCompressionByItsForce) {
  Pair pair = metal;
  const JacksonGreen law{.S_y = 1e8, .poisson = 0.3};  // eps_y = 0.001
  const double v_c = law.critical_speed(pair);
  expect_digits(law.restitution_at(pair, 2 * v_c), 0.9633, 4, "2 V_c");
  expect_digits(law.restitution_at(pair, 10 * v_c), 0.8283, 4, "10 V_c");
  expect_digits(law.restitution_at(pair, 100 * v_c), 0.5339, 4, "100 V_c");
  // C = 1.295 exp(0.736 nu); V_c^2 = 4/(5 pi) (pi C/2)^5 S_y^5/(E*^4 rho) of a whole sphere on a flat.
  const double rho = metal.mass / (4.0 / 3 * std::acos(-1.0) * 1e-9), C = 1.295 * std::exp(0.736 * 0.3);
  EXPECT_NEAR(v_c * v_c, 0.8 / std::acos(-1.0) * std::pow(std::acos(-1.0) * C / 2, 5) * 1e40 / (1e44 * rho),
              1e-12 * v_c * v_c);
  for (const double r : {0.7, 1.5, 20.0, 300.0}) {
    const Event e = law.strike(pair, r * v_c);
    const double stroke = e.restitution * e.restitution * 2.5 * 0.5 * metal.mass * std::pow(r * v_c, 2) / e.peak_force;
    const auto force = [&](double x, double v) {
      if (v >= 0) return law.force(pair, x);
      return e.peak_force * std::pow(std::max(0.0, 1 - (e.largest - x) / stroke), 1.5);
    };
    SCOPED_TRACE(r);
    // The published loading steps by 0.5 % at 1.9 x_c, which costs a fixed step of time h/2 of that force.
    expect_agree(e, integrate(force, metal.mass, r * v_c, e.duration(), e.largest - stroke), 1e-5, 1e-4);
  }
  EXPECT_NE(message_of([&] { static_cast<void>(law.strike(pair, 1e9 * v_c)); }).find("beyond the range"),
            std::string::npos);
}

TEST(EnergyEquivalent, MapLimitsAndRebound) {
  const EnergyEquivalent law{.S_y = 2e8, .poisson = 0.3};  // eps_y = 0.002
  const double v_c = std::sqrt(law.critical_lambda(metal) * 2e8 / 7800);
  EXPECT_EQ(law.restitution_at(metal, 0.99 * v_c), 1);
  for (const double r : {3.0, 30.0, 1000.0}) {
    const double strain = 0.0649 * (std::pow(r * r, 0.3256) - 1);
    EXPECT_NEAR(law.restitution_at(metal, r * v_c), std::pow(1 + 2 * strain, -0.5), 1e-13);
    const Event e = law.strike(metal, r * v_c);
    EXPECT_NEAR(e.rebound, r * v_c * law.restitution_at(metal, r * v_c), 1e-12 * e.speed);
  }
  // The default map was fitted to the Jackson-Green loading with F ~ (x - x_res)^1.5 down to their residual
  // indentation, x_res/x* = 1.02 (1 - ((w + 5.9)/6.9)^-0.54): that integration anew. Energy back: (2/5) F* (x* -
  // x_res).
  const JacksonGreen loading{.S_y = 2e8, .poisson = 0.3};
  const double x_c = std::pow(std::acos(-1.0) * yield_coefficient(0.3) * 2e8 / 2e11, 2) * 1e-3;
  for (const double r : {2.0, 10.0, 100.0, 800.0}) {
    const Event e = loading.strike(metal, r * v_c);
    const double kept = 1.02 * (1 - std::pow((e.largest / x_c + 5.9) / 6.9, -0.54));
    const double back = 0.4 * e.peak_force * e.largest * (1 - kept);
    const double ce = std::sqrt(back / (0.5 * metal.mass * e.speed * e.speed));
    EXPECT_NEAR(law.restitution_at(metal, e.speed), ce, 0.009) << r;
  }
}

TEST(Jkr, PullOffStickingSpeedAndIntegrationInTime) {
  const Pair pair{.mass = 1e-8, .radius = 1e-4, .E_eff = 1e9};
  const Jkr law{.w = 0.05};
  const double pi = std::acos(-1.0);
  EXPECT_NEAR(law.pull_off(pair), 1.5 * pi * 0.05 * 1e-4, 1e-20);
  double least = 0;
  for (int k = 0; k <= 20000; ++k) least = std::min(least, law.force(pair, law.rupture(pair) * (1 - k / 10000.0)));
  EXPECT_NEAR(-least, law.pull_off(pair), 1e-7 * law.pull_off(pair));
  // x_f by setting dx/da = 0: a_f^3 = pi w R^2/(8 E*).
  const double a = std::cbrt(pi * 0.05 * 1e-8 / 8e9), x_f = a * a / 1e-4 - std::sqrt(2 * pi * 0.05 * a / 1e9);
  EXPECT_NEAR(law.rupture(pair), x_f, 1e-12 * std::abs(x_f));
  EXPECT_NEAR(law.force(pair, x_f), -5.0 / 6 * pi * 0.05 * 1e-4, 1e-7 * law.pull_off(pair));  // sqrt of rounding there
  EXPECT_NEAR(law.force(pair, 0), -4.0 / 3 * pi * 0.05 * 1e-4, 1e-12 * law.pull_off(pair));
  // Thornton & Ning 1998: V_s = 1.84 ((w/R)^5/(rho^3 E*^2))^(1/6) of a sphere on a flat, from
  // (14.18/m)^(1/2)(...)^(1/6).
  const double v_s = law.sticking_speed(pair);
  EXPECT_NEAR(v_s, std::sqrt(14.18 / 1e-8) * std::pow(std::pow(0.05, 5) * 1e-16 / 1e18, 1.0 / 6), 1e-3 * v_s);
  EXPECT_EQ(law.restitution_at(pair, 0.999 * v_s), 0);
  const Event held = law.strike(pair, 0.9 * v_s);
  EXPECT_TRUE(held.sticks && held.rebound == 0 && std::isnan(held.time_out));
  // F(x) through a(x), found by bisection of x(a): no formula of the product.
  const auto force = [&](double x, double) {
    double low = a, high = 1e-4;
    for (int k = 0; k < 80; ++k) {
      const double mid = 0.5 * (low + high);
      (mid * mid / 1e-4 - std::sqrt(2 * pi * 0.05 * mid / 1e9) > x ? high : low) = mid;
    }
    return 4e9 * low * low * low / 3e-4 - std::sqrt(8 * pi * 0.05 * 1e9 * low * low * low);
  };
  for (const double r : {1.2, 3.0, 20.0}) {
    const Event e = law.strike(pair, r * v_s);
    SCOPED_TRACE(r);
    EXPECT_NEAR(e.restitution, std::sqrt(1 - 1 / (r * r)), 1e-12);
    // At the rupture F(x) ends with an upright tangent, of which the last step of 1/4000 sees the root of its length.
    expect_agree(e, integrate(force, 1e-8, r * v_s, e.duration(), x_f), 3e-5, 1e-6);
  }
}

TEST(Impact, RefusesWithTheCure) {
  HuntCrossleyModel law;
  const auto says = [](auto act) { return message_of(act); };
  EXPECT_NE(says([&] { static_cast<void>(law.completed()); }).find("needs b, or restitution and at speed"),
            std::string::npos);
  law.b = 0.1, law.restitution = 0.5;
  EXPECT_NE(says([&] { static_cast<void>(law.completed()); }).find("keep one of them"), std::string::npos);
  law.b = NAN;
  EXPECT_NE(says([&] { static_cast<void>(law.completed()); }).find("belong together"), std::string::npos);
  law.restitution = NAN, law.b = 0.1, law.n = 1;
  EXPECT_NE(says([&] { static_cast<void>(law.completed()); }).find("needs c"), std::string::npos);
  EXPECT_NE(says([&] { static_cast<void>(Hertz{}.strike(ball, 1)); }).find("give young and poisson"),
            std::string::npos);
}

}  // namespace
}  // namespace subsoil::dem::impact::test::impact_models
