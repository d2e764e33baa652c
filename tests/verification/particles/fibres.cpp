#include "libdem/packing/fibres.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <type_traits>
#include <variant>

#include "libdem/law_list.hpp"
#include "libdem/step/stability.hpp"
#include "tests/tools/attraction.hpp"
#include "tests/tools/message_of.hpp"
#include "tests/tools/verified.hpp"

/// Fibres of bonded spheres against the theory of beams, chains and plastic sections.
namespace subsoil::dem::test::fibres {
namespace {

using subsoil::test::absolute;
using subsoil::test::share;
using subsoil::test::Verified;

const std::string kField = "Fibres";
constexpr double kR = 2e-3, kD = 2 * kR, kE = 1e8, kRatio = 2.5, kDensity = 200;
constexpr double kArea = pi * kR * kR, kI = pi * kR * kR * kR * kR / 4;
constexpr double kNever = 1e30;  ///< Pa

/// Rough contacts, softer than the bonds unless given, so that bonds alone decide the step.
Linear straw(double strength = kNever, double k_n = 1e3) {
  Linear law = grains(k_n, 0.5, 0.5, 0.1);
  law.bond.kind = Bond::Kind::fibre;
  law.bond.modulus = kE, law.bond.ratio = kRatio, law.bond.tensile = strength, law.bond.shear = strength;
  return law;
}

FibreShape shape_of(int n) { return {.length = n * kD, .diameter = kD, .of = {.density = kDensity, .material = 0}}; }

double stable(const Law& law, double density = 1.5 * kDensity) {
  const StepQuestion q{.smallest_radius = kR, .largest_radius = kR, .density = density, .speed = 1, .neighbours = 2};
  return stable_step(law, q).step;
}

/// A fibre of n spheres that begins at the origin with its first sphere held.
struct Held {
  Bed bed;
  int n;
  double m;  ///< kg, of a sphere
  double dt;

  Held(const Linear& law, int spheres, const Vec3& direction, const Vec3& gravity, double tip_mass = 0,
       const std::function<void(std::vector<Sphere>&)>& change = {})
      : bed(table(law), quiet(gravity)), n(spheres - 1), dt(0.4 * stable(law)) {
    const FibrePose pose{0.5 * n * kD * direction, direction};
    Bed::State state = fibres_at(shape_of(spheres), {&pose, 1}, 0);
    m = state.spheres[0].m;
    if (tip_mass > 0) state.spheres.back().m = tip_mass;
    if (change) change(state.spheres);
    bed.insert(state);
    bed.fix_if([](const Sphere& s) { return s.id == 0; });
  }
  const Sphere& tip() const { return sphere(bed, static_cast<std::uint32_t>(n)); }
  /// Stopped whenever the kinetic energy has passed a peak, until that is a share of the maximum.
  void relax(double until) {
    double before = 0, largest = 0;
    for (long k = 0; k < 2000000; ++k) {
      bed.step(dt);
      const double now = bed.kinetic_energy();
      largest = std::max(largest, now);
      if (now >= before) {
        before = now;
        continue;
      }
      if (now < until * largest) return;
      bed.freeze(), before = 0;
    }
    FAIL() << "did not come to rest";
  }
};

/// Neighbours in a fibre do not touch: no force at rest, and pressed together they resist by the bond alone, E A x/d.
TEST(Fibre, ABondReplacesTheContact) {
  const FibrePose pose{{0, 0, 0}, {1, 0, 0}};
  const auto pressed = [&](double by) {
    Bed bed(table(straw(kNever, 1e6)), quiet());  // a contact stiffer than the bond would show
    Bed::State state = fibres_at(shape_of(2), {&pose, 1}, 0);
    state.spheres[1].x.x -= by;
    bed.insert(state);
    return observe(bed, 1e-9);
  };
  EXPECT_LT(norm(pressed(0).force[0]), kE * kArea * 1e-15 / kD) << "at rest a fibre is free of load";
  const double by = 1e-6;
  const Snapshot in = pressed(by), out = pressed(-by);
  const Verified row(kField, "Two spheres of a fibre of 4 mm, E 100 MPa, pressed together by 1 um", "E A x/d");
  row.near("force", "N", -in.force[0].x, kE * kArea * by / kD, share(1e-9), "rounding of x: 1e-18 of 1e-6 m");
  EXPECT_NEAR(out.force[0].x, -in.force[0].x, 1e-9 * in.force[1].x);
  EXPECT_EQ(in.contacts[0], 0);
  EXPECT_EQ(in.bonds[0], 1);
}

/// Springs in series: bond k carries the weight beyond it, P and the moment of that, and bends by M d/(E I) and shears
/// by P d ratio/(E A) at its middle. Every stop of the relaxation drops the slip of a step, omega dt of the swing.
/// Beam theory, (P/3 + w L/8) L^3/(E I) + P L ratio/(E A), up to 1/(4 n^2) and the coarse spread of the weight w L, 1/n
/// of its share of 7 %.
TEST(Fibre, CantileverDeflectsLikeABeam) {
  const int n = 20;
  const double L = n * kD, tip = 1e-3, load = 1e-3 * L * 3 * kE * kI / (L * L * L);
  Held fibre(straw(), n + 1, {1, 0, 0}, {0, -load / tip, 0}, tip);
  fibre.relax(1e-12);
  const double own = fibre.m * load / tip;
  double y = 0;
  for (int k = 1; k <= n; ++k) {
    double force = load, moment = load * (n - k + 0.5) * kD;
    for (int j = k; j < n; ++j) force += own, moment += own * (j - k + 0.5) * kD;
    y += moment * kD / (kE * kI) * (n - k + 0.5) * kD + force * kD * kRatio / (kE * kArea);
  }
  const Verified row(kField, "Cantilever of 20 bonds with a weight at its tip", "springs in series; beam theory");
  row.near("sinking of the tip, springs in series", "m", -fibre.tip().x.y, y, share(5e-4),
           "stops of the relaxation drop the slip of a step");
  row.near("sinking of the tip, Timoshenko", "m", -fibre.tip().x.y,
           (load / 3 + n * own / 8) * L * L * L / (kE * kI) + load * L * kRatio / (kE * kArea), share(6e-3),
           "1/(4 n^2) = 6e-4, and the coarse spread of the weight, 1/n of 7 %");
}

/// A column with a mass at its free end: P_cr = pi^2 E I/(4 L^2) by Euler, less what its own weight takes, 0.2974 m g L
/// (Rayleigh's quotient of the buckled shape), and softer by shear, 1/P = 1/P_E + ratio/(E A). Bent by a hair in the
/// shape in which it buckles, free of load, it swings about 1/(1 - P/P_cr) hairs and passes A = 2/(1 - P/P_cr) - 1 of
/// them, so that P_cr = P (A + 1)/(A - 1). Above the critical load it falls.
TEST(Fibre, BucklesAtEulersLoad) {
  const int n = 10;
  const double L = n * kD, euler = pi * pi * kE * kI / (4 * L * L), critical = 1 / (1 / euler + kRatio / (kE * kArea));
  const double tip = 30 * n * shape_of(1).mass(), omega = std::sqrt(3 * kE * kI / (L * L * L * tip)), hair = 1e-6 * L;
  const auto passes = [&](double load, double time) {
    const double g = load / (tip + 0.2974 * n * shape_of(1).mass());
    Held column(straw(), n + 1, {0, 1, 0}, {0, -g, 0}, tip, [&](std::vector<Sphere>& s) {
      double sunk = 0;
      for (std::size_t k = 1; k < s.size(); ++k) {
        double above = 0;
        for (std::size_t j = k; j < s.size(); ++j) above += s[j].m * g;
        sunk += above * kD / (kE * kArea);
        s[k].x.y -= sunk;  // as it stands at rest under its load
        s[k].x.x += hair * (1 - std::cos(0.5 * pi * static_cast<double>(k) / n));
      }
    });
    double largest = 0;
    for (const long end = std::lround(time / column.dt); column.bed.steps() < end && largest < 100 * hair;) {
      column.bed.step(column.dt);
      largest = std::max(largest, std::abs(column.tip().x.x));
    }
    return largest / hair;
  };
  const double load = 0.8 * critical, most = passes(load, 12 / omega);
  const Verified row(kField, "Column of 10 bonds with a mass at its free end", "Euler, with shear and own weight");
  row.near("critical load", "N", load * (most + 1) / (most - 1), critical, share(0.01),
           "pi^2/(48 n^2) = 0.2 %, and the shape under its own weight");
  EXPECT_GT(passes(1.03 * critical, 40 / omega), 99) << "it falls";
}

/// N equal masses at distances d on a string without weight swing at omega^2 = x g/d, x the zeros of the Laguerre
/// polynomial L_N (Lagrange 1762); for large N it is Bernoulli's chain, omega = 1.2024 sqrt(g/L). A fibre whose bonds
/// are so thin that bending bears nothing is such a string: bonds pull along the lines of centres. It is 0.1 % longer
/// under its weight, and bends at the top within sqrt(E I/(N m g)) = 0.3 mm.
TEST(Fibre, HangsAndSwingsLikeAChain) {
  const int n = 24, masses = n - 1;
  Linear law = straw();
  law.bond.radius = 0.02;
  const double g = 9.81;
  double least = 0, high = 0.1;  // the first zero: L_N(0) = 1
  while (high - least > 1e-12)
    (std::laguerre(static_cast<unsigned>(masses), 0.5 * (least + high)) > 0 ? least : high) = 0.5 * (least + high);
  Held chain(law, n, {0, -1, 0}, {0, -g, 0}, 0, [&](std::vector<Sphere>& s) {
    double stretch = 0;
    for (std::size_t k = 1; k < s.size(); ++k) {
      const double below = static_cast<double>(s.size() - k) * s[k].m * g, thin = law.bond.radius;
      stretch += below * kD / (kE * kArea * thin * thin);
      s[k].x.y -= stretch;  // as it hangs at rest
      s[k].x.x += 1e-3 * kD * std::laguerre(static_cast<unsigned>(s.size() - 1 - k), least);
    }
  });
  std::vector<double> zeros;
  double before = chain.tip().x.x;
  for (long k = 0; zeros.size() < 11; ++k) {
    ASSERT_LT(k, 4000000);
    chain.bed.step(chain.dt);
    const double now = chain.tip().x.x;
    if (before * now < 0) zeros.push_back(chain.bed.time() - chain.dt * now / (now - before));
    before = now;
  }
  const double omega = 2 * pi * 5 / (zeros.back() - zeros.front());
  const Verified row(kField, "Hanging fibre of 24 spheres with thin bonds", "zero of a Laguerre polynomial");
  row.near("circular frequency of the first mode", "rad/s", omega, std::sqrt(least * g / kD), share(3e-3),
           "0.1 % longer under its weight, bending at the top");
}

// ---- plastic bending -----------------------------------------------------------------------------------------------

/// Two spheres of a fibre so heavy that they keep the motion they are given.
struct Machine {
  Bed bed;
  double dt;
  Snapshot now;

  explicit Machine(const Linear& law, double step = 1e-5) : bed(table(law), quiet()), dt(step) {
    const FibrePose pose{{0, 0, 0}, {1, 0, 0}};
    Bed::State state = fibres_at(shape_of(2), {&pose, 1}, 0);
    for (Sphere& s : state.spheres) s.m = 1e20;
    bed.insert(state);
    now = observe(bed, dt);
  }
  void bend(double rate, double time) {
    Bed::State s = bed.save();
    for (Sphere& one : s.spheres) one.w = {0, 0, one.id == 0 ? -0.5 * rate : 0.5 * rate};
    bed.restore(s);
    for (long n = std::lround(time / dt); n > 0; --n) now = observe(bed, dt);
  }
  double moment() const { return -now.torque[1].z; }
};

/// M grows as E I phi/d up to M_p = (4/3) R^3 sigma_y and stays there; back it falls elastically, and what is left when
/// it is zero is the permanent angle. Plastic work is M_p times that angle.
TEST(Fibre, BendsPlasticallyAtThePlasticMoment) {
  const double yield = 1e5, plateau = 4.0 / 3 * kR * kR * kR * yield, at_yield = plateau * kD / (kE * kI);
  Linear law = straw();
  law.bond.yield = yield;
  Machine m(law);
  const double angle = 3 * at_yield, rate = angle / 0.05;
  m.bend(rate, 0.05 / 6);
  EXPECT_NEAR(m.moment(), kE * kI / kD * angle / 6, 2e-3 * plateau) << "elastic below the plateau";
  EXPECT_EQ(m.bed.energy().lost.yielding, 0);
  m.bend(rate, 0.05 * 5 / 6);
  const Verified row(kField, "Fibre bent to three times its yield angle, sigma_y 100 kPa", "limit analysis");
  row.near("plastic moment, (4/3) R^3 sigma_y", "N m", m.moment(), plateau, share(1e-12), "exact, but for rounding");
  row.near("plastic work, M_p (phi - phi_y)", "J", m.bed.energy().lost.yielding, plateau * 2 * at_yield, share(2e-3),
           "two of 10,000 steps of the way are not led");
  EXPECT_NEAR(m.bed.energy().stored, 0.5 * plateau * at_yield, 1e-9 * plateau * at_yield);
  m.bend(-rate, 0.05 / 3);
  row.near("moment after unloading by the yield angle", "N m", m.moment(), 0, absolute(2e-3 * plateau),
           "two steps of the way");
  EXPECT_NEAR(m.bed.energy().lost.yielding, plateau * 2 * at_yield, 2e-3 * plateau * 2 * at_yield)
      << "unloading is elastic";
  EXPECT_EQ(m.bed.bonds().intact(), 1u);
}

/// A fibre that yields in bending breaks by tension all the same, and one whose strength is below the stress of the
/// plastic moment, 16/(3 pi) sigma_y, breaks before it yields.
TEST(Fibre, BreaksByTheStressOfTensionAndBending) {
  Linear law = straw(1e5);
  law.bond.yield = 1e6;
  Machine m(law);
  const double at_break = 1e5 * kI / kR * kD / (kE * kI);
  m.bend(2 * at_break / 0.01, 0.01);
  ASSERT_EQ(m.bed.broken_bonds().size(), 1u);
  EXPECT_TRUE(m.bed.broken_bonds()[0].in_tension);
  EXPECT_EQ(m.bed.energy().lost.yielding, 0);
  const double energy = 0.5 * 1e5 * kI / kR * at_break;
  const Verified row(kField, "Fibre bent until it breaks, sigma_c 100 kPa", "sigma_c I/R");
  row.near("energy when it breaks", "J", m.bed.broken_bonds()[0].energy, energy, share(5e-3),
           "one of 500 steps, twice");
}

/// Broken ends are spheres like others: a bond that shears off under pressure hands over to the contact, whose energy
/// the book takes from what the bond held.
TEST(Fibre, ABrokenBondHandsOverToTheContact) {
  Linear law = straw(kNever, 1e5);
  law.friction.mu = law.friction.mu_r = 0;
  law.restitution = 1, law.bond.shear = 1;
  Bed bed(table(law), quiet());
  const FibrePose pose{{0, 0, 0}, {1, 0, 0}};
  Bed::State state = fibres_at(shape_of(2), {&pose, 1}, 0);
  state.spheres[1].x.x -= 1e-5;
  state.spheres[1].w = {0, 10, 0};
  const double dt = 0.02 * stable(law);
  bed.insert(state);
  bed.step(dt, {.energy = true});
  const double start = bed.energy().total();
  for (int k = 0; k < 2000; ++k) bed.step(dt, {.energy = true});
  EXPECT_EQ(bed.bonds().broken_in_shear, 1u);
  EXPECT_GT(norm(sphere(bed, 1).v), 0.01) << "the contact pushes them apart";
  // The first step is of first order.
  EXPECT_NEAR(bed.energy().total(), start, 0.02 * 0.5 * kE * kArea / kD * 1e-10);
}

// ---- every contact law ---------------------------------------------------------------------------------------------

/// Examples of all laws with the bonds of a fibre.
template <class... L>
std::vector<Law> with_bonds(const Bond& bond, std::type_identity<std::variant<L...>>) {
  const auto with_bond = [&](auto example) {
    example.bond = bond;
    return Law(example);
  };
  return {with_bond(L::example())...};
}
std::vector<Law> every_law_with(const Bond& bond) { return with_bonds(bond, std::type_identity<GivenLaw>{}); }

/// Neighbours in a fibre feel the bond and nothing else, whatever attraction or residual overlap the contact would
/// have: pressed together by x they resist by E A x/d, pulled apart likewise.
TEST(FibreOfEveryLaw, ABondReplacesTheContact) {
  const FibrePose pose{{0, 0, 0}, {1, 0, 0}};
  for (const Law& law : every_law_with(straw().bond)) {
    SCOPED_TRACE(law->name());
    for (const double by : {0.0, 1e-6, -1e-6}) {
      Bed bed(table(law), quiet());
      Bed::State state = fibres_at(shape_of(2), {&pose, 1}, 0);
      state.spheres[1].x.x -= by;
      bed.insert(state);
      const Snapshot now = observe(bed, 1e-9);
      EXPECT_NEAR(-now.force[0].x, kE * kArea * by / kD, 1e-9 * kE * kArea * 1e-6 / kD);
      EXPECT_EQ(now.contacts[0], 0);
      EXPECT_EQ(now.bonds[0], 1);
    }
  }
}

/// Shears off under pressure: the contact takes over, and the balance keeps what bond, contact, friction and plasticity
/// held and lost, to a share of what the bond held or the contact turns over. The step that breaks is of first order.
TEST(FibreOfEveryLaw, EnergyClosesAcrossABreak) {
  const FibrePose pose{{0, 0, 0}, {1, 0, 0}};
  Bond bond = straw().bond;
  bond.shear = 1;
  for (const Law& law : every_law_with(bond)) {
    SCOPED_TRACE(law->name());
    Bed bed(table(law), quiet());
    bed.set_limits(500, 2);  // wet spheres of this size rest deep in each other
    Bed::State state = fibres_at(shape_of(2), {&pose, 1}, 0);
    state.spheres[1].x.x -= 1e-5;
    state.spheres[1].w = {0, 10, 0};
    bed.insert(state);
    const double dt = 0.005 * stable(law), held = 0.5 * kE * kArea / kD * 1e-10;
    bed.step(dt, {.energy = true});
    const double start = bed.energy().total();
    double turned_over = held;
    for (int k = 0; k < 4000; ++k) {
      bed.step(dt, {.energy = true});
      turned_over = std::max(turned_over, bed.energy().kinetic);
    }
    EXPECT_EQ(bed.bonds().broken_in_shear, 1u);
    EXPECT_NEAR(bed.energy().total(), start, 0.02 * turned_over);
  }
}

/// Spheres that are not bonded meet as under the law without bonds, whichever kernel takes it: they approach aslant and
/// spinning, stick or part, and meet a third. Rounding grows little in two contacts.
TEST(FibreOfEveryLaw, SpheresWithoutABondMeetAsByTheLawAlone) {
  const std::vector<Law> alone = every_law_with({}), bondable = every_law_with(straw().bond);
  const auto after = [](const Law& law, Precision precision) {
    BedOptions options = quiet();
    options.precision = precision;
    Bed bed(table(law), options);
    constexpr double r = 0.01;
    bed.add(std::vector<SphereSpec>{{.position = {0, 0, 0},
                                     .velocity = {0.3, 0.1, 0},
                                     .angular_velocity = {5, -20, 10},
                                     .radius = r,
                                     .density = 1800},
                                    {.position = {1.81 * r, 0.2 * r, 0},
                                     .velocity = {-0.2, 0, 0.1},
                                     .angular_velocity = {0, 8, 0},
                                     .radius = 0.8 * r,
                                     .density = 1800},
                                    {.position = {-1.4 * r, -1.45 * r, 0},
                                     .velocity = {0.1, 0.2, 0},
                                     .angular_velocity = {},
                                     .radius = r,
                                     .density = 1800}});
    for (int k = 0; k < 2500; ++k) bed.step(2e-6, {.energy = true});
    std::vector<double> out{bed.energy().lost.total(), bed.energy().stored};
    for (std::uint32_t id = 0; id < 3; ++id)
      for (int d = 0; d < 3; ++d) out.push_back(sphere(bed, id).v[d]), out.push_back(r * sphere(bed, id).w[d]);
    return out;
  };
  for (std::size_t k = 0; k < alone.size(); ++k)
    for (const Precision precision : {Precision::doubles, Precision::mixed}) {
      SCOPED_TRACE(alone[k]->name());
      ASSERT_EQ(alone[k]->bond(), nullptr);
      ASSERT_NE(bondable[k]->bond(), nullptr);
      const std::vector<double> a = after(alone[k], precision), b = after(bondable[k], precision);
      EXPECT_GT(a[0], 0) << "they have met";
      for (std::size_t n = 0; n < a.size(); ++n)
        EXPECT_NEAR(b[n], a[n], precision == Precision::doubles ? 1e-9 : 2e-4) << n;
    }
}

/// A fibre that falls across another: the spheres that meet are not bonded with each other, and their contact is that
/// of the law.
TEST(FibreOfEveryLaw, FibresMeetByTheContact) {
  for (const Law& law : every_law_with(straw().bond)) {
    SCOPED_TRACE(law->name());
    const std::vector<FibrePose> poses{{{0, 0, 0}, {1, 0, 0}}, {{0.5 * kD, 1.2 * kD, 0.5 * kD}, {0, 0, 1}}};
    Bed bed(table(law), quiet());
    bed.set_limits(500, 2);
    Bed::State state = fibres_at(shape_of(8), poses, 0);
    for (Sphere& s : state.spheres)
      if (s.id >= 8) s.v.y = -0.5;
    bed.insert(state);
    const double dt = 0.1 * stable(law);
    bed.step(dt, {.energy = true});
    const double start = bed.energy().total();
    double worst = 0, most = bed.energy().kinetic;
    std::size_t pairs = 0;
    for (long k = 0; k < std::lround(0.005 / dt); ++k) {
      bed.step(dt, {.energy = k % 50 == 0});
      if (k % 50 != 0) continue;
      pairs = std::max(pairs, bed.touching_pairs());
      most = std::max(most, bed.energy().kinetic);
      worst = std::max(worst, std::abs(bed.energy().total() - start));
    }
    EXPECT_GT(pairs, 0U);
    EXPECT_EQ(bed.bonds().broken(), 0u);
    EXPECT_LT(worst, 0.02 * most);
  }
}

// ---- energy, damping, bits -----------------------------------------------------------------------------------------

/// A fibre that is thrown so that it bends plastically and rings: kinetic + stored + lost closes with the square of the
/// step.
TEST(Fibre, EnergyClosesToSecondOrder) {
  const auto off = [](double share_of_stable) {
    Linear law = straw();
    law.bond.yield = 5e4, law.bond.damping = 0.02;
    const double dt = share_of_stable * stable(law);
    Bed bed(table(law), quiet());
    const FibrePose pose{{0, 0, 0}, {1, 0, 0}};
    Bed::State state = fibres_at(shape_of(8), {&pose, 1}, 0);
    for (Sphere& s : state.spheres) s.v.z = 3 * std::sin(200 * s.x.x), s.w.x = 50 * s.x.x / kD;
    bed.insert(state);
    const long steps = std::lround(2e-3 / dt);
    double start = 0;
    for (long k = 0; k <= steps; ++k) {
      bed.step(dt, {.energy = true});
      if (k == 0) start = bed.energy().total();
    }
    const Losses& lost = bed.energy().lost;
    EXPECT_GT(lost.yielding, 0.05 * start);
    EXPECT_GT(lost.damping, 0.01 * start);
    EXPECT_EQ(bed.bonds().broken(), 0u);
    return std::abs(bed.energy().total() - start) / start;
  };
  const double coarse = off(0.2), fine = off(0.1), finest = off(0.05);
  EXPECT_LT(coarse, 5e-3);
  EXPECT_LT(fine, coarse / 3);
  EXPECT_LT(finest, fine / 3);
}

/// Dashpots are of mass and stiffness and not of the step: a pair rings down by exp(-2 pi zeta/sqrt(1 - zeta^2)) in
/// each period whatever the step, up to the lag of half a step in the damping.
TEST(Fibre, DampingDoesNotDependOnTheStep) {
  const double zeta = 0.05;
  Linear law = straw();
  law.bond.damping = zeta;
  const FibrePose pose{{0, 0, 0}, {1, 0, 0}};
  const auto decrement = [&](double omega_dt) {
    Bed bed(table(law), quiet());
    Bed::State state = fibres_at(shape_of(2), {&pose, 1}, 0);
    const double omega = std::sqrt(2 * kE * kArea / kD / state.spheres[0].m);
    state.spheres[0].v.x = -1e-3, state.spheres[1].v.x = 1e-3;
    bed.insert(state);
    std::vector<double> peaks;
    double a = 0, b = 0;
    while (peaks.size() < 2) {
      bed.step(omega_dt / omega);
      const double x = sphere(bed, 1).x.x - sphere(bed, 0).x.x - kD;
      // Of the parabola through three points.
      if (b > a && b > x && b > 0) peaks.push_back(b + (x - a) * (x - a) / (8 * (2 * b - a - x)));
      a = b, b = x;
    }
    return std::log(peaks[0] / peaks[1]);
  };
  const double exact = 2 * pi * zeta / std::sqrt(1 - zeta * zeta);
  const Verified row(kField, "Two spheres of a fibre that ring down, bond damping 0.05", "2 pi zeta/sqrt(1 - zeta^2)");
  row.near("logarithmic decrement, omega dt = 0.2", "1", decrement(0.2), exact, share(0.03),
           "lag of half a step, zeta omega dt");
  row.near("logarithmic decrement, omega dt = 0.02", "1", decrement(0.02), exact, share(3e-3), "the same");
}

/// Tangle of fibres that fall on a plane, with breaking and yielding.
Bed tangle(int threads, Precision precision = Precision::doubles) {
  Linear law = straw(1e6, 1e5);
  law.bond.yield = 4e5, law.bond.damping = 0.05;
  BedOptions options = quiet({0, -9.81, 0}, threads);
  options.precision = precision;
  Bed bed(table(law), options);
  add_plane(bed, {0, 0, 0}, {0, 1, 0});
  const FibreField field{.shape = shape_of(15), .count = 60, .region = {{0, 2e-3, 0}, {0.1, 0.06, 0.1}}, .piles = true};
  Bed::State state = fibres_at(field.shape, place_fibres(field), 0);
  for (Sphere& s : state.spheres) s.v.y = -8;
  bed.insert(state);
  return bed;
}

TEST(FibreTangle, SameBitsOnAnyNumberOfThreadsAndAfterARestart) {
  const double dt = 0.3 * stable(straw(kNever, 1e5));
  for (const Precision precision : {Precision::doubles, Precision::mixed}) {
    const auto run = [&](int threads, bool saved) {
      auto bed = std::make_unique<Bed>(tangle(threads, precision));
      for (int k = 0; k < 3000; ++k) {
        bed->step(dt, {.energy = k == 2999});
        if (!saved || k != 1500) continue;
        const Bed::State state = bed->save();
        bed = std::make_unique<Bed>(tangle(threads, precision));
        bed->restore(state);
      }
      return bed;
    };
    const auto one = run(1, false), three = run(3, false), again = run(2, true);
    EXPECT_GT(one->bonds().broken(), 5u);
    EXPECT_GT(one->energy().lost.yielding, 0);
    for (const Bed* other : {three.get(), again.get()}) {
      EXPECT_EQ(hash(*other), hash(*one));
      EXPECT_EQ(other->bonds().broken(), one->bonds().broken());
      EXPECT_EQ(other->energy().lost.yielding, one->energy().lost.yielding);
    }
    EXPECT_EQ(one->bonds().formed, 60u * 14u);
  }
}

// ---- placement, the step, refusals ---------------------------------------------------------------------------------

TEST(FibreField, PlacesFibresApartInsideItsRegion) {
  const FibreField field{.shape = shape_of(20), .count = 50, .region = {{0, 0, 0}, {0.2, 0.1, 0.2}}};
  const std::vector<FibrePose> poses = place_fibres(field);
  const Bed::State state = fibres_at(field.shape, poses, 7);
  ASSERT_EQ(state.spheres.size(), 1000u);
  EXPECT_EQ(state.bonds.size(), 950u);
  double mass = 0;
  for (const Sphere& a : state.spheres) {
    mass += a.m;
    EXPECT_GE(std::min({a.x.x, a.x.y, a.x.z}), a.r * (1 - 1e-12));
    EXPECT_LE(std::max({a.x.x, 2 * a.x.y, a.x.z}), 0.2 + a.r);
    for (const Sphere& b : state.spheres)
      if ((a.id - 7) / 20 != (b.id - 7) / 20) {
        ASSERT_GT(norm(a.x - b.x), 1.0999 * kD);
      }
  }
  EXPECT_NEAR(mass, 50 * kDensity * pi * kR * kR * 20 * kD, 1e-12 * mass) << "of round rods";
  FibreField crowd = field;
  crowd.count = 100000;
  EXPECT_NE(subsoil::test::message_of([&] { place_fibres(crowd); }).find("find room"), std::string::npos);
  FibreField still = field;
  still.orientation = FibreField::Orientation::along, still.axis = {0, 0, 1};
  for (const FibrePose& p : place_fibres(still)) EXPECT_NEAR(p.direction.z, 1, 1e-15);
}

/// A fibre at 0.95 of the bound keeps its energy in every mode that noise excites; far beyond it does not.
TEST(Fibre, StableStepHolds) {
  const auto grows = [](double part) {
    Bed bed(table(straw()), quiet());
    const FibrePose pose{{0, 0, 0}, {1, 0, 0}};
    Bed::State state = fibres_at(shape_of(12), {&pose, 1}, 0);
    Dice dice(3);
    for (Sphere& s : state.spheres) s.v = dice.ball(1e-6), s.w = dice.ball(1e-6 / kR);
    bed.insert(state);
    const double dt = part * stable(straw());
    bed.step(dt);
    const double before = bed.kinetic_energy();
    for (int n = 0; n < 20000 && bed.kinetic_energy() < 1e6 * before; ++n) bed.step(dt);
    return bed.kinetic_energy() > 100 * before;
  };
  EXPECT_FALSE(grows(0.95));
  EXPECT_TRUE(grows(1.6));
}

TEST(Fibre, RefusesWhatCannotBe) {
  const auto refusal = [](const Linear& law) {
    return subsoil::test::message_of([&] { static_cast<void>(Law(law)); });
  };
  Linear law = straw();
  law.bond.tensile = NAN;
  EXPECT_NE(refusal(law).find("bond: fibre needs `bond tensile strength`"), std::string::npos) << refusal(law);
  law = straw();
  law.bond.gap = 1e-4;
  EXPECT_NE(refusal(law).find("`bond gap` has no effect"), std::string::npos) << refusal(law);
  law = straw();
  law.bond.kind = Bond::Kind::none, law.bond.modulus = law.bond.tensile = law.bond.shear = NAN, law.bond.yield = 1e6;
  EXPECT_NE(refusal(law).find("`bond yield stress` belongs to"), std::string::npos) << refusal(law);
  Bed bed(table(grains()), quiet());
  const FibrePose pose{{0, 0, 0}, {1, 0, 0}};
  const Bed::State state = fibres_at(shape_of(2), {&pose, 1}, 0);
  EXPECT_NE(subsoil::test::message_of([&] { bed.insert(state); }).find("their law has no bond"), std::string::npos);
}

}  // namespace
}  // namespace subsoil::dem::test::fibres
