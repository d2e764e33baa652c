#include <gtest/gtest.h>

#include <boost/numeric/odeint.hpp>

#include "libdem/bed_impact.hpp"
#include "tests/tools/laws.hpp"
#include "tests/tools/verified.hpp"

/// Restitution out = restitution in for every law that promises one, over e from 0.05 to 1 and three decades of speed;
/// and the map where clipping changes it.
namespace subsoil::dem::test::restitution {
namespace {

using impact::Strikers;
using subsoil::test::absolute;
using subsoil::test::Verified;
using subsoil::test::VerifiedCurve;
using subsoil::test::Worst;

const std::string kField = "Restitution";
const Strikers kBall{.mass_1 = 1e-3, .radius_1 = 5e-3};
constexpr double kGiven[] = {0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0};
constexpr double kSpeeds[] = {0.03, 0.3, 3, 30};

/// A quarter period of stiffness k, s.
double quarter(double k) { return 0.5 * pi * std::sqrt(kBall.mass() / k); }
/// Tangent stiffness of c x^n at the depth that the speed reaches, N/m.
double tangent(double c, double n, double speed) {
  const double depth = std::pow((n + 1) * kBall.mass() * speed * speed / (2 * c), 1 / (n + 1));
  return n * c * std::pow(depth, n - 1);
}

/// `law_of(e, v)` and the stiffness that sets its step.
void expect_given(const std::string& name, double steps, double tolerance, const std::string& because,
                  const std::function<Law(double e, double v)>& law_of,
                  const std::function<double(double e, double v)>& stiffness) {
  const Verified row(kField, "e out = e in, 0.05 to 1, at 0.03 to 30 m/s",
                     "the law's promise; sphere on a plane, two-body impact");
  Worst worst;
  for (const double e : kGiven)
    for (const double v : kSpeeds) {
      const auto event = strike_in_bed(law_of(e, v), kBall, v, quarter(stiffness(e, v)) / steps);
      char at[40];
      std::snprintf(at, sizeof at, "e = %g, %g m/s", e, v);
      worst.take(at, event.restitution, e);
    }
  worst.near(row, name, "1", absolute(tolerance), because);
}

const char* const kLag = "damping takes the rate of half a step before: of first order, a 5000th of a quarter period";

TEST(Restitution, LinearSpring) {
  expect_given(
      "linear", 5000, 1e-4, kLag, [](double e, double) { return grains(1e6, e, 0); },
      [](double, double) { return 1e6; });
}

TEST(Restitution, HertzMindlin) {
  const double young = 1e8 * 3 / (4 * std::sqrt(5e-3));
  expect_given(
      "hertz-mindlin", 5000, 1e-4, kLag,
      [&](double e, double) {
        HertzMindlin h;
        h.E_eff = young, h.G_eff = young, h.restitution = e, h.friction.mu = 0;
        return h;
      },
      [](double, double v) { return tangent(1e8, 1.5, v); });
}

TEST(Restitution, HuntCrossleyAtItsSpeed) {
  expect_given(
      "hunt-crossley, restitution given at the speed", 2000, 2e-3,
      "at e = 0.05 the bodies creep out at 1/b: the force falls within a few steps",
      [](double e, double v) {
        HuntCrossley h = viscoelastic(1.5, 1e8, NAN, 0);
        h.impact.restitution = e, h.impact.at_speed = v;
        return h;
      },
      [](double, double v) { return tangent(1e8, 1.5, v); });
}

TEST(Restitution, HystereticSpring) {
  expect_given(
      "hysteretic", 100, 1e-4, "(omega dt)^2/24 = 1e-5 of a branch, and a kink within a step",
      [](double e, double) { return compactable(4e7, e, 0, 0); }, [](double e, double) { return 1e6 / (e * e); });
}

TEST(Restitution, EdinburghWithoutPlasticity) {
  for (const double n : {1.0, 1.5}) {
    const double k1 = n == 1 ? 1e6 : 1e8;
    expect_given(
        n == 1 ? "eepa, lambda_p = 0, n = 1" : "eepa, lambda_p = 0, n = 1.5", 5000, 1e-4, kLag,
        [&](double e, double) { return powder(n, k1, 0, 0, e); }, [&](double, double v) { return tangent(k1, n, v); });
  }
}

/// Ce by the law's own map at each speed: what it promises.
TEST(Restitution, VariableRestitution) {
  for (const auto part : {VariableRestitution::Normal::hertz, VariableRestitution::Normal::linear}) {
    const bool flat = part == VariableRestitution::Normal::linear;
    VariableRestitution law = yielding(part);
    law.E_eff = 2e11, law.map.S_y = 2e8, law.map.density = 7800, law.largest = 1;
    const double lambda_c = 4 / (5 * pi) * std::pow(pi * 1.295 * std::exp(0.736 * 0.3) / 2, 5) * 1e-12;
    const Verified row(kField, "Energy-equivalent restitution, V/V_c from 0.5 to 1000",
                       "Ce = (1 + 2 eps_p/eps_y)^(-1/2) by hand");
    Worst worst;
    for (const double ratio : {0.5, 1.0, 2.0, 10.0, 100.0, 1000.0}) {
      const double v = ratio * std::sqrt(lambda_c * 2e8 / 7800);
      const double strain = ratio > 1 ? 0.0649 * (std::pow(ratio * ratio, 0.3256) - 1) : 0;
      const double k = flat ? law.k_n : tangent(4.0 / 3 * 2e11 * std::sqrt(5e-3), 1.5, v);
      const auto event = strike_in_bed(law, kBall, v, quarter(k) / 2000);
      worst.take("V/V_c = " + std::to_string(static_cast<int>(10 * ratio) / 10.0).substr(0, 6), event.restitution,
                 1 / std::sqrt(1 + 2 * strain));
    }
    worst.near(row, flat ? "restitution, linear spring" : "restitution, Hertz spring", "1", absolute(1e-4), kLag);
  }
}

// ---- `clip attraction` ---------------------------------------------------------------------------------------------

/// Linear spring and dashpot, force cut off where it would pull: they part where x'' = 0 first, at
/// omega t = atan2(2 b sqrt(1 - b^2), 2 b^2 - 1), with e = exp(-b omega_0 t) (Schwager & Poeschel 2007).
double clipped_linear(double given) {
  const double b = -std::log(given) / std::hypot(pi, std::log(given)), root = std::sqrt(1 - b * b);
  return std::exp(-b / root * std::atan2(2 * b * root, 2 * b * b - 1));
}

/// The same of Hertz with Tsuji's dashpot, by RKF78 in units of speed and (m/k)^(2/5) V^(1/5).
double clipped_hertz(double given) {
  const double b = -std::log(given) / std::hypot(pi, std::log(given)),
               damp = 2 * std::sqrt(5.0 / 6) * b * std::sqrt(1.5);
  using State = std::array<double, 2>;
  const auto force = [&](const State& s) { return std::pow(s[0], 1.5) + damp * std::pow(s[0], 0.25) * s[1]; };
  boost::numeric::odeint::runge_kutta_fehlberg78<State> step;
  State y{1e-12, 1}, before = y;
  const auto slope = [&](const State& s, State& d, double) { d = {s[1], -force({std::max(s[0], 0.0), s[1]})}; };
  for (double t = 0; force(y) > 0 && t < 40; t += 1e-4) {
    before = y;
    step.do_step(slope, y, t, 1e-4);
  }
  const double part = force(before) / (force(before) - force(y));
  return -(before[1] + part * (y[1] - before[1]));
}

TEST(Restitution, ClippedAttraction) {
  const Verified flat(kField, "Linear spring with `clip attraction`",
                      "Schwager & Poeschel 2007, doi:10.1007/s10035-007-0065-z");
  const Verified round(kField, "Hertz-Mindlin with `clip attraction`", "the same equation of motion by RKF78");
  VerifiedCurve curve("clip");
  for (const double e : {0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95}) {
    Linear linear = grains(1e6, e, 0);
    linear.clip = true;
    const double of_linear = strike_in_bed(linear, kBall, 1, quarter(1e6) / 5000).restitution;
    HertzMindlin hertz;
    hertz.E_eff = hertz.G_eff = 1e8 * 3 / (4 * std::sqrt(5e-3)), hertz.restitution = e, hertz.friction.mu = 0;
    hertz.clip = true;
    const double of_hertz = strike_in_bed(hertz, kBall, 1, quarter(tangent(1e8, 1.5, 1)) / 5000).restitution;
    curve.point(e, of_linear, of_hertz);
    char given[40];
    std::snprintf(given, sizeof given, "restitution out at e = %g", e);
    flat.near(given, "1", of_linear, clipped_linear(e), absolute(1e-4), kLag);
    round.near(given, "1", of_hertz, clipped_hertz(e), absolute(1e-4), kLag);
  }
}

}  // namespace
}  // namespace subsoil::dem::test::restitution
