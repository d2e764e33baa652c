#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include "libdem/laws/jkr.hpp"
#include "tests/tools/attraction.hpp"

/// JKR against its equations in the contact radius a, which the law never solves by itself: a is chosen here, overlap
/// and force follow.
namespace subsoil::dem::test::laws_jkr {
namespace {

struct Neck {
  double R, w, E;
  double overlap(double a) const { return a * a / R - std::sqrt(2 * pi * w * a / E); }
  double force(double a) const { return 4 * E * a * a * a / (3 * R) - std::sqrt(8 * pi * w * E * a * a * a); }
  double radius(double share) const { return std::cbrt(share * pi * w * R * R / E); }  ///< 2: no overlap
  /// Energy from one contact radius to another, by quadrature.
  double work(double from, double to) const {
    return boost::math::quadrature::gauss_kronrod<double, 31>::integrate(
        [&](double a) { return force(a) * (2 * a / R - 0.5 * std::sqrt(2 * pi * w / (E * a))); }, from, to, 5, 1e-12);
  }
};

Jkr law_of(const Neck& n, Jkr::Separation separation = Jkr::Separation::rupture) {
  Jkr j;
  j.E_eff = n.E, j.G_eff = 0.4 * n.E, j.work = n.w, j.restitution = 1, j.friction.mu = 0.5;
  j.separation = separation;
  return j.resolved();
}

/// One contact whose overlap is prescribed.
struct Contact {
  Jkr law;
  double r_eff;
  double memory[Jkr::has.memory] = {};
  NormalForce<double> at(double overlap, double rate = 0) {
    return law.normal(Approach<double>{overlap, rate, 0.1, r_eff, 1e-6}, memory);
  }
};

const Neck necks[] = {{5e-3, 1, 5e6}, {1e-4, 0.05, 1e10}, {0.1, 20, 1e6}};

TEST(Jkr, ForceAndContactRadiusFollowTheBranch) {
  for (const Neck& n : necks) {
    Contact c{law_of(n), n.R};
    c.at(n.overlap(n.radius(3)));  // touches
    const double pull_off = 1.5 * pi * n.w * n.R, last = n.radius(0.125);
    for (double a = last * (1 + 1e-4); a < 40 * last; a *= 1.03) {
      const auto f = c.at(n.overlap(a));
      // Newton's two steps leave 1e-11 of a - a_f. Beside the rupture da/d delta is 1/(a - a_f) and the overlap itself
      // a difference, rounded to 1e-16 of its terms: 1e-12/1e-4.
      EXPECT_NEAR(f.force, n.force(a), 1e-8 * pull_off + 1e-10 * std::abs(n.force(a))) << a / last;
      EXPECT_NEAR(f.k_n, 2 * n.E * a, 1e-8 * f.k_n);
      EXPECT_NEAR(f.k_t, 8 * 0.4 * n.E * a, 1e-8 * f.k_t);
      EXPECT_NEAR(f.limiting_force, n.force(a) + 2 * pull_off, 1e-8 * f.limiting_force);
      EXPECT_TRUE(f.in_contact);
    }
  }
}

TEST(Jkr, PullsAtNoOverlapAtMostAndAtTheEndAsTheTheorySays) {
  for (const Neck& n : necks) {
    Contact c{law_of(n), n.R};
    const double unit = pi * n.w * n.R, last = n.overlap(n.radius(0.125));
    c.at(1e-12);
    EXPECT_NEAR(c.at(0).force, -4.0 / 3 * unit, 1e-9 * unit);
    double most = 0;
    for (int k = 0; k <= 4000; ++k) most = std::min(most, c.at(last * k / 4000.001).force);
    EXPECT_NEAR(most, -1.5 * unit, 1e-6 * unit);                                // flat there: (1/4000)^2
    EXPECT_NEAR(c.at(last * (1 - 1e-12)).force, -5.0 / 6 * unit, 1e-5 * unit);  // a - a_f is the root of the distance
  }
}

TEST(Jkr, BeginsOnTouchAndEndsWhereItsOptionSays) {
  for (const Neck& n : necks) {
    for (const auto& [separation, share] :
         {std::pair{Jkr::Separation::rupture, 0.125}, {Jkr::Separation::pull_off, 1.125}}) {
      Contact c{law_of(n, separation), n.R};
      const double last = n.overlap(n.radius(share));
      EXPECT_EQ(c.at(0.5 * last).force, 0) << "attraction before the surfaces have touched";
      c.at(1e-9);
      EXPECT_LT(c.at(last * (1 - 1e-9)).force, 0);
      EXPECT_EQ(c.at(last * (1 + 1e-9)).force, 0);
      EXPECT_EQ(c.at(0.5 * last).force, 0) << "a broken neck heals only by touching";
      EXPECT_GE(c.law.cutoff(n.R), -last * (1 - 1e-12));
    }
  }
}

/// Snapping together and parting loses what the branch takes: 7.09 (w^5 R^4/E*^2)^(1/3) (Johnson & Pollock 1994).
TEST(Jkr, StoredAndLostEnergyAreThoseOfTheBranch) {
  for (const Neck& n : necks) {
    Contact c{law_of(n), n.R};
    const double first = n.radius(2), last = n.radius(0.125),
                 unit = std::cbrt(std::pow(n.w, 5) * std::pow(n.R, 4) / (n.E * n.E));
    const auto touch = c.at(1e-9 * n.overlap(3 * first));
    const double deep = c.at(n.overlap(5 * first)).stored;
    EXPECT_NEAR(deep - touch.stored, n.work(first, 5 * first), 1e-8 * deep);
    EXPECT_NEAR(c.at(n.overlap(1.0001 * last)).stored - touch.stored, -n.work(1.0001 * last, first), 1e-6 * unit);
    const auto parted = c.at(2 * n.overlap(last));
    EXPECT_EQ(parted.stored, 0);
    EXPECT_NEAR(touch.lost + parted.lost, -n.work(last, first), 1e-7 * unit);
    EXPECT_NEAR(touch.lost + parted.lost, 7.09 * unit, 0.005 * unit);
    EXPECT_EQ(c.at(n.overlap(5 * first)).lost, touch.lost) << "and again, when they meet again";
  }
}

/// The reach for the largest spheres of a bed is the length of their neck at rupture, and covers every smaller one's.
TEST(Jkr, ReachIsTheNeckOfTheLargestSpheresAndStiffnessIsBounded) {
  for (const Neck& n : necks) {
    const Jkr law = law_of(n);
    for (const double r : {1e-6, 1e-3, 0.1, 0.25, 3.0}) {
      const Neck other{r, n.w, n.E};
      const double length = -other.overlap(other.radius(0.125));
      EXPECT_NEAR(law.cutoff(r), length, 1e-9 * length) << r;
      EXPECT_LT(law.cutoff(0.99 * r), law.cutoff(r));
    }
    for (const double speed : {0.0, 0.1, 3.0}) {
      const double m = 1e-3, k = law.bound({m, n.R, 2 * n.R, speed}).k_n;
      Contact c{law, n.R};
      const double start = c.at(1e-15).stored;
      for (double x = 0; c.at(x).stored - start < 0.5 * m * speed * speed; x += 1e-2 * n.overlap(3 * n.radius(2))) {
        const double h = 1e-6 * n.R, tangent = (c.at(x + h).force - c.at(x).force) / h;
        EXPECT_LE(tangent, 1.001 * k) << x;
      }
    }
  }
}

/// A share of the attraction changes the branch of contacts that hold.
TEST(Jkr, WeakenedWhileABedSettles) {
  const Neck n = necks[0];
  Contact c{law_of(n), n.R};
  c.at(1e-5);
  c.law.weaken(0.5);
  const Neck half{n.R, 0.5 * n.w, n.E};
  EXPECT_NEAR(c.at(half.overlap(2 * half.radius(2))).force, half.force(2 * half.radius(2)), 1e-9);
}

}  // namespace
}  // namespace subsoil::dem::test::laws_jkr
