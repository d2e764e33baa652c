#include <gtest/gtest.h>

#include "libdem/bed_impact.hpp"
#include "tests/tools/laws.hpp"
#include "tests/tools/verified.hpp"

/// Two-body impacts in the engine by laws whose contacts remember, beside what their loops enclose: m (V^2 - V'^2)/2.
namespace subsoil::dem::test::impact_memory {
namespace {

using impact::Strikers;
using subsoil::test::absolute;
using subsoil::test::Verified;
using subsoil::test::Worst;

const std::string kField = "Restitution";
const char* const kBranch = "1e-5 of a branch a step, and as much at a kink";

const Strikers kBall{.mass_1 = 1e-3, .radius_1 = 5e-3};                                      ///< on a plane
const Strikers kPair{.mass_1 = 1e-3, .radius_1 = 5e-3, .mass_2 = 4e-4, .radius_2 = 3.6e-3};  ///< two spheres

/// A hundredth of a quarter period of the stiffest branch, N/m.
double hundredth(double mass, double stiffness) { return 0.01 * 0.5 * pi * std::sqrt(mass / stiffness); }

/// The step errs by (omega dt)^2/24 = 1e-5 of a branch, and by as much where it meets a kink within a step.
constexpr double kStep = 2e-4;

TEST(ImpactMemory, HystereticSpringGivesItsRestitution) {
  for (const Strikers& bodies : {kBall, kPair})
    for (const double e : {0.05, 0.2, 0.5, 0.8, 0.95, 1.0})
      for (const double v : {0.03, 0.3, 3.0, 30.0}) {
        Hysteretic law = compactable();
        law.yield = 4e7, law.restitution = e;
        const double k1 = 5 * bodies.radius() * law.yield;
        const auto event = strike_in_bed(law, bodies, v, hundredth(bodies.mass(), k1 / (e * e)));
        EXPECT_NEAR(event.restitution, e, kStep) << v;
        EXPECT_NEAR(event.largest, v * std::sqrt(bodies.mass() / k1), kStep * event.largest);
        EXPECT_NEAR(event.peak_force, v * std::sqrt(bodies.mass() * k1), kStep * event.peak_force);
      }
}

/// Without adhesion and dashpot e^2 is what the unloading curve gives back of the loading: of lambda_p alone.
TEST(ImpactMemory, EepaReturnsWhatItsLoopLeaves) {
  const Verified row(kField, "EEPA without adhesion: what the loop leaves, 0.03 to 30 m/s",
                     "sqrt(1 - lambda_p) for n = 1, integrals of the loop for n = 3/2");
  Worst linear, hertz;
  for (const double v : {0.03, 1.0, 30.0})
    for (const double lambda : {0.1, 0.5, 0.9, 0.99}) {
      const double k2 = 1e6 / (1 - lambda);
      const auto flat = strike_in_bed(powder(1, 1e6, lambda, 0, 1), kBall, v, hundredth(1e-3, k2));
      char at[48];
      std::snprintf(at, sizeof at, "lambda_p = %g, %g m/s", lambda, v);
      linear.take(at, flat.restitution, std::sqrt(1 - lambda));
      const double k1 = 1e8, deepest = std::pow(2.5 * 1e-3 * v * v / (2 * k1), 0.4);
      const double stiffest = 1.5 * k1 / (1 - lambda) * std::sqrt(deepest);
      const auto round = strike_in_bed(powder(1.5, k1, lambda, 0, 1), kPair, v, hundredth(2.5e-4, stiffest));
      const double l = lambda;
      const double e2 = (1 - std::pow(l, 5 / 3.) - 2.5 * l * (1 - std::pow(l, 2 / 3.))) / (1 - l);
      hertz.take(at, round.restitution, std::sqrt(e2));
    }
  linear.near(row, "restitution, n = 1, lambda_p 0.1 to 0.99", "1", absolute(kStep), kBranch);
  hertz.near(row, "restitution, n = 1.5, lambda_p 0.1 to 0.99", "1", absolute(kStep), kBranch);
}

/// Elastic, the dashpot alone: restitution in is restitution out, for n = 1, 3/2 and 2.
TEST(ImpactMemory, EepaWithoutPlasticityGivesItsRestitution) {
  for (const double n : {1.0, 1.5, 2.0})
    for (const double e : {0.05, 0.3, 0.7, 1.0})
      for (const double v : {0.03, 1.0, 30.0}) {
        const double k1 = n == 1 ? 1e6 : n == 1.5 ? 1e8 : 1e10;
        const double deepest = std::pow((n + 1) * 1e-3 * v * v / (2 * k1), 1 / (n + 1));
        const double stiff = n * k1 * std::pow(deepest, n - 1);
        const auto event = strike_in_bed(powder(n, k1, 0, 0, e), kBall, v, 0.02 * hundredth(1e-3, stiff));
        // Damping takes the rate of half a step before: of first order, 1/5000 of a quarter period each.
        EXPECT_NEAR(event.restitution, e, 2e-3) << "n " << n << " at " << v;
      }
}

/// Adhesion takes the pull-off work besides: e^2 = 1 - (area of the loop)/(m V^2/2), and below some speed they stick.
TEST(ImpactMemory, AdhesionTakesTheWorkOfTearing) {
  const Verified torn(kField, "Adhesion takes the work of tearing", "e^2 = 1 - (area of the loop)/(m V^2/2)");
  const auto at = [](const char* format, double v) {
    char text[64];
    std::snprintf(text, sizeof text, format, v);
    return std::string(text);
  };
  const double k1 = 1e4, k2 = 5e4, k_c = 5e3, m = 1e-3;
  Luding law = sticky(k1, k2, k_c, 0.2);
  law.damping = 0;
  for (const double v : {0.02, 0.2, 1.0}) {
    const double M = v * std::sqrt(m / k1), fluid = k2 / (k2 - k1) * 0.2 * 2 * 5e-3;
    const double p = k1 + (k2 - k1) * M / fluid, tear = (p - k1) * M / (p + k_c);
    const double area =
        0.5 * k1 * M * M - 0.5 * (k1 * k1 * M * M - std::pow(k_c * tear, 2)) / p + 0.5 * k_c * tear * tear;
    const double e2 = 1 - area / (0.5 * m * v * v);
    const auto event = strike_in_bed(law, kBall, v, hundredth(m, k2));
    torn.near(at("Luding, k2/k1 = 5, k_c/k1 = 0.5, %g m/s", v), "1", event.restitution, std::sqrt(e2), absolute(kStep),
              kBranch);
  }
  // Of more adhesion than elastic energy comes back at this speed.
  law.k_c = 2e5;
  EXPECT_THROW(strike_in_bed(law, kBall, 3, hundredth(m, k2), 20000), std::runtime_error);
  Eepa glue = powder(1.5, 1e8, 0.3, 50, 1);
  for (const double v : {0.5, 2.0, 10.0}) {
    const double depth = std::pow(2.5 * 0.5 * m * v * v / 1e8, 0.4), unload = 1e8 / 0.7;
    const double top = 0.3 * std::pow(depth, 1.5), residual = std::pow(top, 2 / 3.);
    const double pull = std::fmin(1.5 * pi * 50 * std::sqrt(2 * 5e-3 * residual), 0.5 * unload * top);
    const double corner = std::pow(top - pull / unload, 2 / 3.);
    const double back = unload * ((std::pow(depth, 2.5) - std::pow(corner, 2.5)) / 2.5 - top * (depth - corner));
    const double e2 = (back - pull * corner / 2.5) / (0.5 * m * v * v);
    ASSERT_GT(e2, 0) << v;
    const auto event = strike_in_bed(glue, kBall, v, hundredth(m, 1.5 * unload * std::sqrt(depth)));
    torn.near(at("EEPA, n = 1.5, lambda_p 0.3, 50 J/m^2, %g m/s", v), "1", event.restitution, std::sqrt(e2),
              absolute(kStep), kBranch);
  }
}

/// Cohesion over Hertz's area on the hysteretic spring (Ucgul, Fielke & Saunders): q = k_c pi R off both branches.
TEST(ImpactMemory, CohesiveHystereticSpring) {
  const Verified row(kField, "Hysteretic spring with linear cohesion (Ucgul 2014), 0.03 to 30 m/s",
                     "e^2 = (K1 e0^2 - q)/(K1 - q), q = k_c pi R");
  for (const double e0 : {0.5, 0.8}) {
    Worst worst;
    for (const double v : {0.03, 0.3, 3.0, 30.0}) {
      const double k1 = 5 * kBall.radius() * 4e7, q = 0.1 * k1;
      Hysteretic law = compactable(4e7, e0, 0, 0);
      law.cohesion = cohesion_by_area(q / (pi * kBall.radius()), Cohesion::Area::hertz);
      const auto event = strike_in_bed(law, kBall, v, hundredth(1e-3, k1 / (e0 * e0)));
      char at[32];
      std::snprintf(at, sizeof at, "%g m/s", v);
      worst.take(at, event.restitution, std::sqrt((k1 * e0 * e0 - q) / (k1 - q)));
    }
    worst.near(row, e0 < 0.6 ? "restitution, e0 0.5, q = K1/10" : "restitution, e0 0.8, q = K1/10", "1",
               absolute(5 * kStep), "1e-5 of a branch a step; the parting is found to a step of the unloading");
  }
}

/// Ce over three decades of V/V_c, by both springs; beside it the Jackson-Green values that the map was fitted to (its
/// own error is 0.009, and the lagged rate of the step adds little).
TEST(ImpactMemory, VariableRestitutionMeetsItsMap) {
  struct {
    double ratio, jackson_green;
  } const cases[] = {{0.5, 1}, {1, 1}, {2, 0.9633}, {10, 0.8283}, {100, 0.5339}, {1000, NAN}};
  for (const auto part : {VariableRestitution::Normal::hertz, VariableRestitution::Normal::linear})
    for (const auto& c : cases) {
      VariableRestitution law = yielding(part);
      law.E_eff = 2e11, law.map.S_y = 2e8, law.map.density = 7800, law.largest = 1;  // eps_y = 0.001
      const double yield_coefficient = 1.295 * std::exp(0.736 * 0.3);
      const double lambda_c = 4 / (5 * pi) * std::pow(pi * yield_coefficient / 2, 5) * 1e-12;
      const double v = c.ratio * std::sqrt(lambda_c * 2e8 / 7800);
      const double strain = c.ratio > 1 ? 0.0649 * (std::pow(c.ratio * c.ratio, 0.3256) - 1) : 0;
      const double m = kBall.mass(), deepest = std::pow(15 * m * v * v / (16 * 2e11 * std::sqrt(5e-3)), 0.4);
      const double stiff = part == VariableRestitution::Normal::linear ? law.k_n : 4e11 * std::sqrt(5e-3 * deepest);
      const auto event = strike_in_bed(law, kBall, v, 0.05 * hundredth(m, stiff));
      EXPECT_NEAR(event.restitution, 1 / std::sqrt(1 + 2 * strain), 1e-3) << c.ratio;
      if (!std::isnan(c.jackson_green)) {
        EXPECT_NEAR(event.restitution, c.jackson_green, 0.01) << c.ratio;
      }
    }
}

}  // namespace
}  // namespace subsoil::dem::test::impact_memory
