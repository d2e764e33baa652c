#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "libdem/contacts/lane_copy.hpp"
#include "libdem/step/stability.hpp"
#include "tests/tools/contact_path.hpp"
#include "tests/tools/every_law.hpp"
#include "tests/tools/laws.hpp"

/// Laws whose contacts remember, led along prescribed overlaps: the loops of their sources by hand, and what holds for
/// each of them. Every path is quasi-static (a step lasts 1 s, dashpots are nought) unless it says otherwise.
namespace subsoil::dem::test::laws_memory {
namespace {

constexpr double kRounding = 1e-12;  ///< a few operations, relative to the largest term

/// All of the list that remember, along any path.
void each_with_memory(const std::function<void(const std::string&, const Law&)>& use) {
  for (const auto& [name, law] : every_law())
    if (law->own_memory() > 0) use(name, law);
}

/// What a path puts in is stored, lost or damped. Forces and stored energy are exact at every overlap, so only a step
/// across a kink or a jump (f0) is not summed exactly by its mean force: of some 40 legs each errs by K step^2 at most.
TEST(MemoryOfAContact, WorkIsStoredOrLostOnAnyPath) {
  each_with_memory([](const std::string& name, const Law& law) {
    Dice dice(5);
    ContactPath path(law);
    double travelled = 0, force = 0;
    for (int leg = 0; leg < 40; ++leg) {
      const double next = leg % 7 == 6 ? -2e-4 : dice.between(0, 1.5e-3);
      travelled += std::abs(next - path.overlap());
      path.to(next, 2000, 1e-6);  // some 0.5 m/s
      force = std::fmax(force, std::abs(path.force()));
      EXPECT_NEAR(path.gap(), 0, 2e-4 * force * travelled) << name << ", leg " << leg;
    }
    EXPECT_GT(path.lost + path.damped, 0.005 * force * travelled) << name;
    // Loading and tearing only ever lose; the mean force over a step may miss by its curvature. (What a law
    // gives by convention where a contact parts, it declares.)
    if (!law->may_gain()) {
      EXPECT_GT(path.least_loss, -1e-6 * force * 1e-3) << name;
    }
  });
}

/// A law may have room for what its cohesion keeps (a wetted bridge) and a cohesion that keeps nothing. Then its force
/// is that of a fresh contact at every overlap, and at every gap across which it acts.
void expect_no_trace_of_the_path(const std::string& name, const Law& law) {
  for (const double end : {3e-4, -0.5 * law->cutoff(5e-3)}) {
    ContactPath there_and_back(law), fresh(law);
    fresh.to(-law->cutoff(5e-3) - 1e-6, 1), fresh.to(end, 100);
    there_and_back.to(1e-3, 100), there_and_back.to(end, 100);
    fresh.to(end, 1), there_and_back.to(end, 1);  // at rest, so that no dashpot takes part
    EXPECT_NEAR(there_and_back.force(), fresh.force(), kRounding * std::abs(fresh.force())) << name << " at " << end;
  }
}

TEST(MemoryOfAContact, EndsWhereSurfacesPart) {
  each_with_memory([](const std::string& name, const Law& law) {
    ContactPath path(law), fresh(law);
    const double apart = -law->cutoff(5e-3) - 1e-6;
    path.to(1e-3, 100), path.to(3e-4, 100);
    if (path.memory()[0] == 0) expect_no_trace_of_the_path(name, law);
    path.to(apart, 1000);
    for (int k = 0; k < kOwnMemory; ++k) EXPECT_EQ(path.memory()[k], 0) << name;
    EXPECT_EQ(path.stored(), 0) << name;
    fresh.to(apart, 1);
    path.to(5e-4, 100), fresh.to(5e-4, 100);
    EXPECT_EQ(path.force(), fresh.force()) << name;
  });
}

/// The bound is the steepest branch that a path below the expected overlap meets.
TEST(MemoryOfAContact, NoBranchIsStifferThanTheBound) {
  each_with_memory([](const std::string& name, const Law& law) {
    const double m = 1e-3, r = 5e-3, speed = 3;
    const StiffnessBound bound = law->bound({.m_eff = m, .r_eff = r, .r_min = 2 * r, .speed = speed});
    // As deep as a body of this speed gets: by energy, along the law itself.
    ContactPath in(law, r, m);
    while (in.work < 0.5 * m * speed * speed) in.to(in.overlap() + 1e-6, 1, 1e3);
    const double deepest = in.overlap();
    ContactPath path(law, r, m);
    double steepest = 0;
    for (const double turn : {1.0, 0.3, 0.8, -0.01, 0.9}) {
      const double from = path.overlap(), step = (turn * deepest - from) / 300;
      for (int k = 0; k < 300; ++k) {
        const double before = path.force(), at = path.overlap();
        path.to(at + step, 1, 1e3);
        // f0 jumps where surfaces touch: no stiffness.
        if (at > 0 && path.overlap() > 0) steepest = std::fmax(steepest, (path.force() - before) / step);
      }
    }
    EXPECT_LE(steepest, bound.k_n * (1 + 1e-3)) << name;  // `deepest` is found to a micrometre
    EXPECT_GT(steepest, 0.5 * bound.k_n) << name;
  });
}

/// Walton & Braun by hand: K1 = 10 kN/m, e = 1/2, so K2 = 40 kN/m; to 1 mm, back, and again.
TEST(Hysteretic, LoopOfWaltonAndBraun) {
  Hysteretic law = compactable();
  law.yield = NAN, law.K1 = 1e4, law.restitution = 0.5;
  ContactPath path(law);
  path.to(1e-3, 10);
  EXPECT_NEAR(path.force(), 10, 10 * kRounding);
  EXPECT_NEAR(path.stored(), 10 * 10 / (2 * 4e4), kRounding);
  EXPECT_NEAR(path.memory()[0], 0.75e-3, 1e-3 * kRounding);
  EXPECT_NEAR(path.lost, 0.5 * 10 * 0.75e-3, kRounding);  // K1 M^2/2 (1 - e^2): the area of the loop
  path.to(0.8e-3, 10);
  EXPECT_NEAR(path.force(), 4e4 * 0.05e-3, 10 * kRounding);
  path.to(0.9e-3, 10);  // reloading goes up the same line
  EXPECT_NEAR(path.force(), 4e4 * 0.15e-3, 10 * kRounding);
  path.to(1.2e-3, 10);  // and on along K1
  EXPECT_NEAR(path.force(), 12, 12 * kRounding);
  path.to(0.5e-3, 10);
  EXPECT_EQ(path.force(), 0);
  EXPECT_EQ(path.stored(), 0);
}

TEST(Hysteretic, ResidualOverlapFollowsOrIsKept) {
  Hysteretic law = compactable();
  law.yield = NAN, law.K1 = 1e4, law.restitution = 0.5;
  ContactPath follows(law);
  law.residual = Hysteretic::Residual::kept;
  ContactPath kept(law);
  for (auto* path : {&follows, &kept}) path->to(1e-3, 10), path->to(0.3e-3, 10), path->to(0.35e-3, 10);
  EXPECT_NEAR(follows.force(), 4e4 * 0.05e-3, 10 * kRounding);
  EXPECT_EQ(kept.force(), 0);
  // From 0.3 mm the line K2 meets K1 delta at 0.4 mm; from 0.75 mm at 1 mm.
  for (auto* path : {&follows, &kept}) path->to(0.9e-3, 60);
  EXPECT_NEAR(follows.force(), 9, 10 * kRounding);
  EXPECT_NEAR(kept.force(), 4e4 * 0.15e-3, 10 * kRounding);
}

/// K1 = 5 r_eff S_y, and the dashpot is n_c times that of the restitution with the spring K1.
TEST(Hysteretic, YieldStrengthAndDampingFactor) {
  Hysteretic law = compactable(6e5, 0.5);
  law.damping_factor = 0.25;
  const double k1 = 5 * 5e-3 * 6e5, m = 1e-3, ln = std::log(0.5);
  double own[1] = {};
  const auto n = law.resolved().normal(Approach<double>{1e-3, 0.4, std::sqrt(m), 5e-3, 0}, own);
  EXPECT_NEAR(n.force - n.damping, k1 * 1e-3, k1 * 1e-3 * kRounding);
  // Ucgul et al.: sqrt(4 m K1/(1 + (pi/ln e)^2)) v, times n_c.
  EXPECT_NEAR(n.damping, 0.25 * std::sqrt(4 * m * k1 / (1 + std::pow(pi / ln, 2))) * 0.4, kRounding * 10);
  EXPECT_NEAR(n.c_t, std::sqrt(4 * m * law.stiffness_ratio * k1 / (1 + std::pow(pi / ln, 2))), kRounding * 10);
}

/// Ucgul's cohesive soil: the spring less k pi R delta. A loop gives back e^2 = (K1 e0^2 - q)/(K1 - q), q = k pi R.
TEST(Hysteretic, CohesionByContactArea) {
  Hysteretic law = compactable();
  law.yield = NAN, law.K1 = 1e4, law.restitution = 0.5;
  law.cohesion = cohesion_by_area(1e5, Cohesion::Area::hertz);
  const double q = 1e5 * pi * 5e-3, M = 1e-3;
  ContactPath path(law);
  path.to(M, 1000);
  EXPECT_NEAR(path.force(), (1e4 - q) * M, 10 * kRounding);
  EXPECT_NEAR(path.now().limiting_force, 1e4 * M, 10 * kRounding);
  const double in = path.work;
  path.to(0.5e-3, 1000);
  EXPECT_NEAR(path.force(), -q * 0.5e-3, 10 * kRounding);
  path.to(0, 1000);
  // Mean forces over a thousand steps: one kink, K2 step^2/8.
  EXPECT_NEAR((in - path.work) / in, (1e4 * 0.25 - q) / (1e4 - q), 1e-5);
  EXPECT_NEAR(path.lost, 0.5 * 1e4 * M * M * 0.75, 1e-12);
  // Attraction may exceed what comes back, not what it takes to load.
  const auto refuses = [&](double density) {
    law.cohesion.density = density;
    try {
      Law(law)->refuse_collapse(5e-3);
      return false;
    } catch (const std::invalid_argument&) {
      return true;
    }
  };
  EXPECT_FALSE(refuses(0.9e4 / (pi * 5e-3)));
  EXPECT_TRUE(refuses(1.1e4 / (pi * 5e-3)));
}

/// Luding's branches with numbers that come out even: k1 = 10, k2 = 50, k_c = 10 kN/m, delta_f = 1.25 mm.
TEST(Luding, LoopByHand) {
  Luding law = sticky(1e4, 5e4, 1e4, 0.1);
  law.damping = 0;
  ContactPath path(law);  // r_eff 5 mm: phi_f 2 r_eff = 1 mm, delta_f = 5/4 of it
  path.to(0.625e-3, 10);
  EXPECT_NEAR(path.force(), 6.25, 10 * kRounding);
  const double p = 3e4;  // half-way
  path.to(0.5e-3, 10);
  EXPECT_NEAR(path.force(), 6.25 - p * 0.125e-3, 10 * kRounding);
  path.to((1 - 1e4 / p) * 0.625e-3, 10);
  EXPECT_NEAR(path.force(), 0, 10 * kRounding);
  const double tear = 2e4 * 0.625e-3 / (p + 1e4);
  path.to(tear, 1000);
  EXPECT_NEAR(path.force(), -1e4 * tear, 10 * kRounding);
  EXPECT_NEAR(path.stored(), 0, kRounding);
  EXPECT_NEAR(path.lost, 0.5e4 * 0.625e-3 * 0.625e-3 - (6.25 * 6.25 - std::pow(1e4 * tear, 2)) / (2 * p), kRounding);
  path.to(0.5 * tear, 1000);
  EXPECT_NEAR(path.force(), -0.5e4 * tear, 10 * kRounding);
  const double before = path.lost;
  path.to(-1e-6, 1000);
  EXPECT_NEAR(path.lost - before, 0.5e4 * 0.25 * tear * tear, kRounding);
}

/// Pressed again from the adhesive branch: up the line k2*(M)(delta - delta_0(M)) that passes there, M by bisection.
TEST(Luding, ReloadsFromTheAdhesiveBranch) {
  Luding law = sticky(1e4, 5e4, 1e4, 0.1);
  law.damping = 0;
  const double torn = 1.5e-4, fluid = 1.25e-3;
  const auto force = [&](double M, double d) {
    const double p = 1e4 + 4e4 * M / fluid;
    return p * (d - (1 - 1e4 / p) * M);
  };
  double low = torn, high = 1e-3;
  for (int k = 0; k < 100; ++k) {
    const double mid = 0.5 * (low + high);
    (force(mid, torn) > -1e4 * torn ? low : high) = mid;
  }
  ContactPath path(law);
  path.to(1e-3, 1000), path.to(torn, 100000);
  EXPECT_NEAR(path.memory()[0], low, 1e-12);
  path.to(0.8 * low, 10);
  EXPECT_NEAR(path.force(), force(low, 0.8 * low), 1e-9);
  path.to(1.1 * low, 10);
  EXPECT_NEAR(path.force(), 1.1e4 * low, 1e-9);
}

/// One dashpot given by its coefficient and by its restitution: c = 2 beta sqrt(m k1), across it sqrt(ratio) c.
TEST(Luding, OneDampingRatioHoweverItIsGiven) {
  const double m = 1e-3, ln = std::log(0.5), c = 2 * std::sqrt(m * 1e4 / (1 + std::pow(pi / ln, 2)));
  Luding coefficient = sticky(1e4, 5e4, 1e4, 0.1), restitution = coefficient;
  coefficient.damping = c, coefficient.restitution = NAN;
  restitution.damping = NAN, restitution.restitution = 0.5;
  for (const Luding& law : {coefficient, restitution}) {
    double own[1] = {};
    const auto n = law.normal(Approach<double>{1e-4, 0.4, std::sqrt(m), 5e-3, 0}, own);
    EXPECT_NEAR(n.c_n, c, 10 * kRounding);
    EXPECT_NEAR(n.c_t, std::sqrt(law.stiffness_ratio) * c, 10 * kRounding);
    EXPECT_NEAR(law.bound({.m_eff = m, .r_eff = 5e-3, .r_min = 5e-3, .speed = 1}).c_t, n.c_t, 10 * kRounding);
  }
}

/// Beyond delta_f the branch k2 is elastic both ways.
TEST(Luding, LimitBranchIsElastic) {
  Luding law = sticky(1e4, 5e4, 1e4, 0.1);
  law.damping = 0;
  ContactPath path(law);
  path.to(1.25e-3, 100);
  const double lost = path.lost;
  path.to(1.75e-3, 100);
  EXPECT_NEAR(path.force(), 5e4 * 0.75e-3, 40 * kRounding);
  path.to(1.3e-3, 100);
  EXPECT_NEAR(path.force(), 5e4 * 0.3e-3, 40 * kRounding);
  EXPECT_EQ(path.lost, lost);
}

/// Loop of EEPA with n = 3/2 and the surface energy: forces at the corners and the area enclosed, by its integrals.
void expect_loop(double n, double chi, double w) {
  SCOPED_TRACE(testing::Message() << "n " << n << ", chi " << chi << ", w " << w);
  const double k1 = n == 1 ? 1e4 : 3e5, lambda = 0.6, k2 = k1 / (1 - lambda), M = 1e-3, r = 5e-3;
  Eepa law = powder(n, k1, lambda, w, 1);
  law.chi = chi;
  const double top = lambda * std::pow(M, n), residual = std::pow(top, 1 / n);
  const double pull = std::fmin(1.5 * pi * w * std::sqrt(2 * r * residual), 0.5 * k2 * top);
  const double corner = std::pow(top - pull / k2, 1 / n);
  ContactPath path(law, r);
  path.to(M, 4000);
  EXPECT_NEAR(path.force(), k1 * std::pow(M, n), 10 * kRounding);
  path.to(residual, 4000);
  EXPECT_NEAR(path.force(), 0, 1e-10);
  path.to(corner, 4000);
  EXPECT_NEAR(path.force(), -pull, 1e-10);
  path.to(0.5 * corner, 4000);
  EXPECT_NEAR(path.force(), -pull * std::pow(0.5, chi), 1e-10);
  path.to(0, 4000);
  const double m = n + 1, loading = k1 * std::pow(M, m) / m;
  const double back = k2 * ((std::pow(M, m) - std::pow(corner, m)) / m - top * (M - corner));
  // Sums of mean forces over 4000 steps: curvature/12/4000^2 of each leg, below 1e-7 of the loading.
  EXPECT_NEAR(path.lost, loading - back + pull * corner / (chi + 1), 1e-7 * loading);
  EXPECT_NEAR(path.work, path.lost, 1e-7 * loading);
}

TEST(Eepa, LoopByItsIntegrals) {
  expect_loop(1, 1, 20);
  expect_loop(1.5, 1.5, 20);
  expect_loop(1.5, 1, 20);
  expect_loop(1.5, 5.3, 20);
  expect_loop(1.5, 1.5, 1e5);  // the pull is bounded by k2 delta_p^n/2
  expect_loop(1.2, 2, 20);
  expect_loop(2, 3, 20);
  expect_loop(1.5, 1.5, 0);
}

/// The constant pull shifts the force and stores what it takes to open the contact.
TEST(Eepa, ConstantPull) {
  Eepa law = powder(1.5, 3e5, 0.6, 20, 1);
  ContactPath without(law);
  law.f0 = 0.5;
  ContactPath with(law);
  for (const double d : {1e-3, 2e-4, 8e-4}) {
    without.to(d, 10), with.to(d, 10);
    EXPECT_NEAR(with.force(), without.force() - 0.5, 20 * kRounding);
    EXPECT_NEAR(with.stored(), without.stored() - 0.5 * d, kRounding);
    EXPECT_NEAR(with.now().limiting_force, without.now().limiting_force, 20 * kRounding);
  }
}

/// Three laws of three files are one where they meet: EEPA with n = chi = 1 is Luding's with constant k2, and without
/// adhesion the hysteretic spring; without plasticity EEPA is Hertz with Tsuji's dashpot.
void expect_same(const Law& a, const Law& b, double dt) {
  ContactPath one(a), other(b);
  Dice dice(3);
  double largest = 0;
  for (int leg = 0; leg < 60; ++leg) {
    const double next = leg % 9 == 8 ? -1e-4 : dice.between(0, 1e-3);
    for (int k = 0; k < 20; ++k) {
      const double to = one.overlap() + (next - one.overlap()) / (20 - k);
      one.to(to, 1, dt), other.to(to, 1, dt);
      largest = std::fmax(largest, std::abs(one.force()));
      ASSERT_NEAR(one.force(), other.force(), 1e-11 * largest) << leg;
      ASSERT_NEAR(one.now().limiting_force, other.now().limiting_force, 1e-11 * largest) << leg;
      ASSERT_NEAR(one.stored(), other.stored(), 1e-14 * largest) << leg;
    }
  }
}

TEST(LawsWithMemory, AgreeWhereTheyMeet) {
  Luding l = sticky(1e4, 2.5e4, 6e3, 1);  // phi_f 1: never the limit branch
  l.unloading = Luding::Unloading::constant, l.damping = 0;
  Eepa e = powder(1, 1e4, 0.6, NAN, 1);
  e.adhesive_ratio = 0.6;
  expect_same(l, e, 1);
  l.k_c = e.adhesive_ratio = 0;
  Hysteretic h = compactable();
  h.yield = NAN, h.K1 = 1e4, h.restitution = std::sqrt(0.4);
  expect_same(l, e, 1);
  expect_same(l, h, 1);
  HertzMindlin tsuji = elastic(1e7, 0.3, 0.5, 0.4);
  Eepa elastic_eepa = powder(1.5, NAN, 0, 10, 0.5);
  elastic_eepa.E_eff = tsuji.E_eff;
  elastic_eepa.limit = AdhesiveLimit::repulsion_only;
  expect_same(tsuji, elastic_eepa, 1e-3);
}

TEST(AdhesiveLimit, ThreeConventions) {
  using enum AdhesiveLimit;
  EXPECT_EQ(limiting_force_of(force_plus_adhesion, -2.0, 3.0), 1);
  EXPECT_EQ(limiting_force_of(force_plus_adhesion, -4.0, 3.0), 0);
  EXPECT_EQ(limiting_force_of(absolute_force, -2.0, 3.0), 2);
  EXPECT_EQ(limiting_force_of(repulsion_only, -2.0, 3.0), 0);
  EXPECT_EQ(limiting_force_of(repulsion_only, 2.0, 3.0), 2);
}

/// The damping is that of the speed at first touch, through the map; a rebound of other speed does not change it.
TEST(VariableRestitution, DampingOfTheSpeedAtFirstTouch) {
  VariableRestitution law = yielding(VariableRestitution::Normal::linear);
  law.largest = 0.99;
  const auto resolved = law.resolved();
  for (const double v : {1e-4, 0.05, 0.5, 5.0}) {
    const double strain = law.map.A * (std::pow(1800 * v * v / (2e5 * resolved.map.lambda_c), law.map.B) - 1);
    const double e = std::fmin(0.99, strain > 0 ? 1 / std::sqrt(1 + 2 * strain) : 1);
    const double c = 2 * damping_ratio(e) * std::sqrt(1e-3 * 1e5);
    double own[1] = {};
    for (const double rate : {v, 0.3 * v, -0.7 * v}) {
      const auto n = resolved.normal(Approach<double>{1e-4, rate, std::sqrt(1e-3), 5e-3, 1e-6}, own);
      EXPECT_NEAR(n.damping, c * rate, 1e-12 * c * v) << v;
    }
  }
}

/// Relations between parameters are refused with the cure.
TEST(LawsWithMemory, RefuseWhatCannotBe) {
  const auto refusal = [](const auto& law) -> std::string {
    try {
      static_cast<void>(law.resolved());
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  Hysteretic h = compactable();
  h.K1 = 1e4;
  EXPECT_NE(refusal(h).find("either K1 or the yield strength"), std::string::npos);
  h.yield = NAN, h.restitution = NAN, h.K2 = 5e3;
  EXPECT_NE(refusal(h).find("K2 must not be below K1"), std::string::npos);
  h.K2 = 4e4;
  EXPECT_EQ(h.resolved().restitution, 0.5);
  EXPECT_NE(refusal(sticky(1e4, 1e4)).find("k2 must be above k1"), std::string::npos);
  Luding l = sticky();
  l.restitution = 0.5;
  EXPECT_NE(refusal(l).find("either damping or restitution"), std::string::npos);
  Eepa e = powder(1, NAN, 0.5, 1);
  e.E_eff = 1e7;
  EXPECT_NE(refusal(e).find("needs k1"), std::string::npos);
  e = powder(1.5, 1e5, 0.5, NAN);
  EXPECT_NE(refusal(e).find("surface energy"), std::string::npos);
  e.adhesive_ratio = 0.5, e.chi = 2;
  EXPECT_NE(refusal(e).find("chi = n"), std::string::npos);
  VariableRestitution v = yielding(VariableRestitution::Normal::linear);
  v.k_n = NAN;
  EXPECT_NE(refusal(v).find("normal: linear"), std::string::npos);
  v.k_n = 1e5, v.map.density = NAN;
  EXPECT_NE(refusal(v).find("rho"), std::string::npos);
}

/// Memory of a block of a law, by itself.
struct OneBlock {
  MemoryShape shape;
  std::vector<Line> lines;

  explicit OneBlock(const MemoryShape& of) : shape(of), lines(of.lines(1)) {}
  BlockMemory memory() { return BlockMemory::at(lines.data(), 1, shape, 0); }
  bool operator==(const OneBlock& other) const {
    return std::memcmp(lines.data(), other.lines.data(), lines.size() * sizeof(Line)) == 0;
  }
};

/// What a contact keeps goes from lane to lane as by way of PairState, whatever law it has, for both precisions, and
/// also with i and j exchanged; a lane that keeps one number of any kind counts, one of zeros and minus zeros does not.
TEST(MemoryOfAContact, GoesFromLaneToLane) {
  for (const auto& [name, law] : every_law())
    for (const bool single : {false, true}) {
      const MemoryShape shape = MemoryShape::of(law, single);
      const LaneCopy lanes(shape);
      OneBlock from(shape);
      int fields = 0;
      PairState any;
      const auto count = [&](auto&, int) { ++fields; };
      each_field(shape, any, count, count);
      for (int only = 0; only <= fields; ++only) {  // the number that is there; of the last all
        PairState s;
        int k = 0;
        const auto set = [&](auto& number, int) {
          using Number = std::remove_reference_t<decltype(number)>;
          number = only == fields ? static_cast<Number>(k + 1)
                   : only == k    ? std::numeric_limits<Number>::min()
                                  : -Number{0};
          if (single && only == k) number = static_cast<Number>(std::numeric_limits<float>::denorm_min());
          ++k;
        };
        each_field(shape, s, set, set);
        write_lane(from.memory(), shape, static_cast<std::uint32_t>(only) % kBlock, s);
        const std::uint32_t lane = static_cast<std::uint32_t>(only) % kBlock, to_lane = (lane + 3) % kBlock;
        EXPECT_EQ(lanes.filled(from.memory(), kBlock), 1u << lane) << name << ", number " << only;
        EXPECT_EQ(lanes.filled(from.memory(), lane), 0u) << name;
        for (const bool turned_over : {false, true}) {
          OneBlock copied(shape), written(shape);
          lanes.copy(from.memory(), lane, copied.memory(), to_lane, turned_over);
          write_lane(written.memory(), shape, to_lane, turned_over ? s.turned_over() : s);
          EXPECT_TRUE(copied == written) << name << ", number " << only;
        }
        write_lane(from.memory(), shape, lane, {});
      }
      PairState zeros;
      const auto minus = [](auto& number, int) { number = -0.0f; };
      each_field(shape, zeros, minus, minus);
      write_lane(from.memory(), shape, 2, zeros);
      EXPECT_EQ(lanes.filled(from.memory(), kBlock), 0u) << name;
    }
}

}  // namespace
}  // namespace subsoil::dem::test::laws_memory
