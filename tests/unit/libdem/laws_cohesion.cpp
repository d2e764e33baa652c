#include <gtest/gtest.h>

#include <boost/math/tools/roots.hpp>

#include "libdem/laws/cohesive.hpp"
#include "libdem/step/stability.hpp"
#include "tests/tools/laws.hpp"
#include "tests/tools/message_of.hpp"

/// Cohesion beside a normal law: the attraction alone (with less without), each against its own source.
namespace subsoil::dem::test::laws_cohesion {
namespace {

using subsoil::test::message_of;
constexpr double kRadius = 4e-3;  ///< r_eff

/// One contact whose overlap is prescribed.
struct Contact {
  Law law;
  double per_sum = 0.25 / kRadius;  ///< two equal spheres
  double memory[kOwnMemory] = {};
  NormalForce<double> at(double overlap, double rate = 0) {
    return law->normal({overlap, rate, 0.1, kRadius, 1e-6, per_sum}, memory);
  }
};
Contact contact(const Cohesion& c) { return {with(grains(), c)}; }
/// Attraction: what the force lacks of the law's without cohesion.
double pull(Contact& c, double overlap) { return Contact{grains()}.at(overlap).force - c.at(overlap).force; }

/// The lens of two equal spheres of radius 2 r_eff by the formula of LIGGGHTS's manual (sjkr), sjkr2's, and Hertz's a^2
/// = R delta.
TEST(Cohesion, ByAreaFollowsEachConvention) {
  const double k = 3e5, r = 2 * kRadius;
  Contact lens = contact(cohesion_by_area(k)), hertz = contact(cohesion_by_area(k, Cohesion::Area::hertz)),
          sjkr2 = contact(cohesion_by_area(k, Cohesion::Area::sjkr2));
  for (const double overlap : {1e-6, 1e-4, 1e-3}) {
    const double d = 2 * r - overlap;
    const double area = -pi / 4 * (d - r - r) * (d + r - r) * (d - r + r) * (d + r + r) / (d * d);
    EXPECT_NEAR(pull(lens, overlap), k * area, 1e-10 * k * area + 1e-11);  // d - 2 r: 1e-18 m x 7e3 N/m
    EXPECT_NEAR(pull(sjkr2, overlap), k * 2 * pi * overlap * 2 * kRadius, 1e-10);
    EXPECT_NEAR(pull(hertz, overlap), k * pi * overlap * kRadius, 1e-10);
  }
  for (Contact* c : {&lens, &hertz, &sjkr2}) EXPECT_EQ(pull(*c, -1e-6), 0);
}

/// Spheres of different radii: LIGGGHTS's formula holds for them too (its own derivation: the circle in which two
/// spheres cut, by Heron's formula for the triangle of both centres and a point of it). A boundary is the limit of a
/// large partner, pi delta (2 r - delta). The energy is the integral of the force, here by Simpson's rule, exact for
/// the cubic of a boundary and to 1e-10 otherwise.
TEST(Cohesion, LensIsTheCircleOfBothSpheres) {
  const double k = 3e5;
  const auto area = [](double r1, double r2, double overlap) {
    const double d = r1 + r2 - overlap;
    return -pi / 4 * (d - r1 - r2) * (d + r1 - r2) * (d - r1 + r2) * (d + r1 + r2) / (d * d);
  };
  for (const double ratio : {1.0, 1.5, 4.0, 100.0, 1e300}) {
    const bool wall = ratio == 1e300;
    const double r1 = kRadius * (1 + 1 / ratio), r2 = ratio * r1;
    Contact lens = contact(cohesion_by_area(k));
    lens.per_sum = wall ? 0 : 1 / (r1 + r2);
    for (const double overlap : {1e-5, 1e-4, 1e-3, 0.5 * kRadius}) {
      const double exact = wall ? pi * overlap * (2 * r1 - overlap) : area(r1, r2, overlap);
      // d - r1 - r2 is known to 1e-16 of r2 only.
      EXPECT_NEAR(pull(lens, overlap), k * exact, 1e-10 * k * exact + 1e-13 * k * r1 * (wall ? 1 : r2)) << ratio;
      const int n = 200;
      double work = 0;
      for (int i = 0; i <= n; ++i)
        work += (i == 0 || i == n ? 1 : i % 2 == 1 ? 4 : 2) * pull(lens, overlap * i / n) * overlap / n / 3;
      const double stored = Contact{grains()}.at(overlap).stored - lens.at(overlap).stored;
      EXPECT_NEAR(stored, work, 1e-9 * work) << ratio << ", " << overlap;
    }
  }
}

/// Ucgul, Fielke & Saunders 2014: the hysteretic spring less the energy density over Hertz's area; loading along K1,
/// unloading along K2 = K1/e^2 from the residual overlap.
TEST(Cohesion, UcgulsSpringPullsBetweenResidualOverlapAndParting) {
  const double k = 2e5, k1 = 5 * kRadius * 5.88e5, k2 = k1 / 0.36;
  Contact c{with(compactable(), cohesion_by_area(k, Cohesion::Area::hertz))};
  const auto adhesion = [&](double overlap) { return k * pi * kRadius * overlap; };
  const double most = 1e-4, residual = (1 - k1 / k2) * most;
  for (const double x : {2e-5, 6e-5, most}) EXPECT_NEAR(c.at(x).force, k1 * x - adhesion(x), 1e-9);
  const double half_way = 0.5 * (most + residual);
  EXPECT_NEAR(c.at(half_way).force, k2 * (half_way - residual) - adhesion(half_way), 1e-9);
  EXPECT_NEAR(c.at(0.9 * residual).force, -adhesion(0.9 * residual), 1e-9);
}

TEST(Cohesion, DmtIsTwoPiWRWhileTouching) {
  Contact c = contact(dmt(0.7));
  for (const double overlap : {1e-9, 1e-4}) EXPECT_NEAR(pull(c, overlap), 2 * pi * 0.7 * kRadius, 1e-12);
  EXPECT_EQ(c.at(-1e-9).force, 0);
}

/// A bridge with a flat meniscus between the paraboloids r^2/(2 R): pi a^2 S + pi a^4/(4 R) = V gives its radius a, the
/// Laplace pressure 2 gamma cos(theta)/h at the rim h = S + a^2/(2 R) pulls on pi a^2.
double meniscus(double gap, double volume, double angle) {
  std::uintmax_t turns = 200;
  const auto excess = [&](double a) { return pi * a * a * (gap + a * a / (4 * kRadius)) - volume; };
  const auto [low, high] =
      boost::math::tools::toms748_solve(excess, 1e-7, 1e-2, boost::math::tools::eps_tolerance<double>(50), turns);
  const double a = 0.5 * (low + high);
  return pi * a * a * 2 * 0.072 * std::cos(angle) / (gap + a * a / (2 * kRadius));
}

TEST(Cohesion, BridgePullsAsItsMeniscus) {
  for (const double volume : {1e-12, 1e-10, 6e-10})
    for (const double angle : {0.0, 0.3, 1.2}) {
      Contact c = contact(water(volume, angle));
      const double end = (1 + angle / 2) * std::cbrt(volume);
      EXPECT_EQ(pull(c, -0.5 * end), 0) << "dry until it has touched";
      EXPECT_NEAR(pull(c, 1e-5), 4 * pi * kRadius * 0.072 * std::cos(angle), 1e-12);
      for (const double share : {1e-4, 0.1, 0.5, 0.9999}) {
        const double want = meniscus(share * end, volume, angle);
        EXPECT_NEAR(pull(c, -share * end), want, 1e-9 * want);
      }
      EXPECT_EQ(pull(c, -1.0001 * end), 0);
      EXPECT_EQ(pull(c, -0.5 * end), 0) << "a ruptured bridge forms anew by touching only";
    }
}

/// Willett, Adams, Johnson & Seville 2000, Langmuir 16, 9396, fitted to solutions of the Laplace-Young equation for
/// equal spheres of radius R: F = 2 pi R gamma cos(theta)/(1 + 1.05 s + 2.5 s^2), s = S sqrt(R/V), for V <= 1e-3 R^3;
/// within 6 % of them (their Fig. 8). The flat meniscus is within some per cent of both.
TEST(Cohesion, BridgeIsNearWillettsFit) {
  const double r = 2 * kRadius;
  for (const double volume : {1e-5, 1e-4}) {
    Contact c = contact(water(volume * r * r * r, 0));
    c.at(1e-6);
    for (const double gap : {0.0, 0.05, 0.2, 0.5}) {
      const double s = gap * std::cbrt(volume * r * r * r) * std::sqrt(1 / (volume * r * r));
      const double fit = 2 * pi * r * 0.072 / (1 + 1.05 * s + 2.5 * s * s);
      EXPECT_NEAR(pull(c, -gap * std::cbrt(volume * r * r * r)) / fit, 1, 0.15) << volume << ", s " << s;
    }
  }
}

TEST(Cohesion, BridgeMayFormFromAfar) {
  Cohesion c = water(1e-10, 0.3);
  c.forms = Cohesion::Forms::at_rupture_distance;
  Contact near = contact(c);
  const double end = 1.15 * std::cbrt(1e-10);
  EXPECT_NEAR(pull(near, -0.5 * end), meniscus(0.5 * end, 1e-10, 0.3), 1e-9);
  EXPECT_EQ(near.at(-0.5 * end).lost + near.at(1e-6).lost + near.at(-0.5 * end).lost, 0);
}

/// Around a loop in and out: the work put in is what is counted as lost, by a fine trapezoidal path.
TEST(Cohesion, AroundALoopTheBalanceCloses) {
  HertzMindlin hertz = elastic(1e7, 0.3, 1, 0.4);
  const std::pair<Law, bool> laws[] = {{with(hertz, cohesion_by_area(1e5)), false},
                                       {with(hertz, dmt(1)), false},
                                       {with(hertz, water(1e-10)), true},
                                       {with(hertz, water(1e-9, 1)), true},
                                       {with(compactable(), cohesion_by_area(1e5)), true}};
  for (const auto& [law, loses] : laws) {
    Contact loop{law};
    const double far = 2e-3, deep = 2e-4;
    const int steps = 200000;
    double work = 0, lost = 0, before = 0;
    for (int k = 0; k <= 2 * steps; ++k) {
      const double x = k <= steps ? -far + (far + deep) * k / steps : deep - (far + deep) * (k - steps) / steps;
      const auto n = loop.at(x);
      if (k > 0) work += 0.5 * (before + n.force) * (far + deep) / steps * (k <= steps ? 1 : -1);
      before = n.force, lost += n.lost;
      EXPECT_TRUE(x > -1.6e-3 || (n.stored == 0 && n.force == 0));
    }
    // Where the force jumps half a step is missed: 0.02 N x 7 nm.
    EXPECT_NEAR(work, lost, 1e-9);
    EXPECT_EQ(lost > 0, loses);
  }
}

TEST(Cohesion, GripFollowsItsOption) {
  const double overlap = 2e-5, repulsion = 1e5 * overlap, adhesion = 2 * pi * 50 * kRadius;
  for (const auto& [limit, want] : {std::pair{Cohesion::FrictionLimit::pressing_force, repulsion},
                                    {Cohesion::FrictionLimit::net_force, std::abs(repulsion - adhesion)},
                                    {Cohesion::FrictionLimit::thornton, repulsion + adhesion}}) {
    Cohesion c = dmt(50);
    c.limit = limit;
    Contact one = contact(c);
    EXPECT_NEAR(one.at(overlap).limiting_force, want, 1e-12);
  }
}

TEST(Cohesion, IsALawOfItsOwnOnlyWhereItActs) {
  EXPECT_NE(Law(grains()).get_if<Linear>(), nullptr);
  const Law sticky = with(grains(), dmt(1));
  EXPECT_NE(sticky.get_if<Cohesive<Linear>>(), nullptr);
}

TEST(Cohesion, RefusesWhatItsKindDoesNotUseOrLacks) {
  Cohesion c = dmt(1);
  c.density = 1e5;
  EXPECT_EQ(
      message_of([&] { c.completed(); }),
      "`cohesion energy density` belongs to cohesion: linear, which here is dmt; leave it out, or change the word");
  c = water();
  c.volume = NAN;
  EXPECT_EQ(message_of([&] { c.completed(); }), "cohesion: liquid-bridge needs `liquid volume`");
}

/// Attraction over the contact area grows with the overlap as the linear spring does: stronger than the spring, nothing
/// would stop it. It grows with the radius, so the largest spheres decide. Hertz's force wins in the end, but may do so
/// too deep.
TEST(Cohesion, RefusesAttractionThatNoContactHolds) {
  const double limit = 1e5 / (2 * pi * kRadius);  // k_n = k 2 pi R
  const auto accepts = [&](const Law& law, double largest) {
    const std::string said = message_of([&] {
      stable_step(law, {.smallest_radius = 0.1 * kRadius,
                        .largest_radius = largest,
                        .density = 2000,
                        .speed = 0.1,
                        .neighbours = 6});
    });
    EXPECT_TRUE(said == "accepted" || said.find("stronger than the contact") != said.npos ||
                said.find("contact radius without load") != said.npos)
        << said;
    return said == "accepted";
  };
  const Law by_area = with(grains(), cohesion_by_area(limit, Cohesion::Area::lens));
  EXPECT_TRUE(accepts(by_area, 1.8 * kRadius));
  EXPECT_FALSE(accepts(by_area, 2.5 * kRadius));  // the lens grows a little slower than the overlap
  EXPECT_TRUE(accepts(with(elastic(1e7, 0.3, 0.5, 0.3), dmt(1)), kRadius));
  EXPECT_FALSE(accepts(with(elastic(1e5, 0.3, 0.5, 0.3), dmt(100)), kRadius));
  EXPECT_TRUE(accepts(tacky(1), kRadius));
  EXPECT_FALSE(accepts(tacky(5e3), kRadius));
}

/// The stable step sees the stiffness of the overlap that attraction presses spheres to.
TEST(Cohesion, StiffensTheBoundOfHertz) {
  const HertzMindlin plain = elastic(1e7, 0.3, 0.5, 0.3);
  const Law pressed = with(plain, dmt(50));
  Contact c{pressed};
  double rest = 1e-7;
  while (c.at(rest).force < 0) rest *= 1.001;
  const StiffnessBound b = pressed->bound({1e-3, kRadius, 2 * kRadius, 1e-6});
  // Falling together from rest they go on to where U = 0: deeper than the rest, (5/2)^(2/3) of it for Hertz's spring
  // under a constant pull, and stiffer by the root of that.
  EXPECT_NEAR(b.k_n / c.at(rest).k_n, std::pow(2.5, 1.0 / 3), 2e-3);
}

}  // namespace
}  // namespace subsoil::dem::test::laws_cohesion
