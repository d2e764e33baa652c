#include <gtest/gtest.h>

#include "tests/tools/laws.hpp"
#include "tests/tools/verified.hpp"

/// Two-body results that other programs publish: their recorded numbers, with their conventions where ours differ.
namespace subsoil::dem::test::peers {
namespace {

using subsoil::test::absolute;
using subsoil::test::share;
using subsoil::test::Verified;

const std::string kField = "Other programs";

/// LAMMPS's material: E* and G* of two bodies of one material, which it takes at walls too.
HertzMindlin lammps_material(double young, double poisson, double restitution, double mu) {
  return elastic(young, poisson, restitution, mu);
}

void run_to(Bed& bed, long steps, double dt) {
  while (bed.time() < (static_cast<double>(steps) - 0.5) * dt) bed.step(dt);
}

/// examples/granular/in.restitution: two spheres of 4 mm head-on at 1 m/s each, E 1 MPa, nu 0.4, e 0.8.
TEST(Peers, LammpsRestitution) {
  const double r = 2e-3, dt = 1e-8;
  Bed bed(table(lammps_material(1e6, 0.4, 0.8, 0.5)), quiet());
  const std::vector<SphereSpec> two{{{0, 0, 0.04}, {0, 0, 1}, {}, r, 2500, 0},
                                    {{0, 0, 0.04416}, {0, 0, -1}, {}, r, 2500, 0}};
  bed.add(two);
  // What LAMMPS prints every 10 us: distance, velocity, force.
  struct {
    int us;
    double v, f;
  } const printed[] = {{200, 0.90389221, -0.12468011}, {300, 0.69263807, -0.22744912}, {400, 0.37315233, -0.2998624},
                       {470, 0.11337783, -0.31665837}, {600, -0.35144026, -0.2659288}, {800, -0.76669467, -0.075759891},
                       {950, -0.80241211, 0.015295834}};
  const Verified row(kField, "LAMMPS examples/granular/in.restitution",
                     "its log of 4 Feb 2025: hertz/material, coeff_restitution");
  // Step of 10 ns where LAMMPS takes 1: damping lags by half of it, 5e-6 of the contact's duration, and the printed
  // instant is met to as much.
  const char* const why = "damping lags by half a step of 10 ns; forces are steep";
  double nearest = 1;
  std::size_t next = 0;
  for (long n = 0; n < 100000; ++n) {
    const Snapshot s = observe(bed, dt);
    nearest = std::min(nearest, s.position[1].z - s.position[0].z);
    if (next < std::size(printed) && n == printed[next].us * 100) {
      const std::string at = " at " + std::to_string(printed[next].us) + " us";
      row.near("velocity" + at, "m/s", s.velocity[0].z, printed[next].v, absolute(1e-4), why);
      row.near("force" + at, "N", s.force[0].z, printed[next].f, absolute(1e-4), why);
      ++next;
    }
  }
  row.near("smallest distance of the centres", "m", nearest, 0.0034610388, share(1e-5), "printed every 10 us: 1e-8 m");
  row.near("velocity after", "m/s", sphere(bed, 0).v.z, -0.79999999, share(1e-4), why);
}

/// unittest/granular/tests/dem04-mindlin-oblique and -sticking: aluminium on a plane, 3.9 m/s at 40 deg, e 0.98.
TEST(Peers, LammpsObliqueImpact) {
  const double dt = 1e-9, r = 2.5e-3;
  const Verified row(kField, "LAMMPS unittest/granular dem04-mindlin",
                     "its recorded velocities (4 Jul 2026), tangential mindlin: moment arm radius, keep-spring");
  struct {
    const char* name;
    double v_t, out, spin, tolerance;
    const char* why;
  } const cases[] = {{"sliding", 2.5069, 1.9626460766213021, 544.25392337870403, 2e-3,
                      "moment arm r - delta: delta = 0.9 % of r, in angular velocity alone"},
                     {"sticking", 0.5, 0.34437890244522057, 155.62109755477954, 0.015,
                      "tangential dashpot: there half of the normal one, here sqrt(k_t/k_n) of it"}};
  for (const auto& c : cases) {
    HertzMindlin law = lammps_material(70e9, 0.33, 0.98, 0.092);
    law.friction.moment_arm = MomentArm::radius, law.friction.changing = Changing::keep_spring;  // LAMMPS's
    Bed bed(table(law), quiet());
    const SphereSpec s{{0, 0.00255, 0}, {c.v_t, -2.9876, 0}, {}, r, 2700, 0};
    bed.add(std::span(&s, 1));
    add_plane(bed, {}, {0, 1, 0});
    run_to(bed, 42000, dt);
    const Sphere& out = sphere(bed, 0);
    row.near(std::string("normal velocity after, ") + c.name, "m/s", out.v.y, 2.9278423105668629, share(1e-4),
             "step of 1 ns for 10");
    row.near(std::string("tangential velocity after, ") + c.name, "m/s", out.v.x, c.out, share(c.tolerance), c.why);
    row.near(std::string("angular velocity after, ") + c.name, "rad/s", -out.w.z, c.spin, share(c.tolerance), c.why);
  }
}

/// unittest/granular/tests/dem06-hookehistory-spin: a spinning sphere meets a large heavy one; friction there is
/// limited by |F|, the pulling end of the dashpot included. Cohesion of no strength brings that limit: `friction limit:
/// net-force`.
TEST(Peers, LammpsSpinImpact) {
  const double k = 1.2e8;
  const auto run = [&](bool net_force) {
    Linear law = grains(k, 0.5, 0.4, 0);
    law.stiffness_ratio = 3.4e7 / k;
    law.friction.moment_arm = MomentArm::radius;
    if (net_force) {
      law.cohesion = cohesion_by_area(1e-9);
      law.cohesion.limit = Cohesion::FrictionLimit::net_force;
    }
    Bed bed(table(law), quiet());
    const std::vector<SphereSpec> two{{{0, 0, 0.60001}, {0, 0, -0.2}, {0, 22.86, 0}, 0.1, 2700, 0},
                                      {{0, 0, 0}, {}, {}, 0.5, 2.7e6, 0}};
    bed.add(two);
    run_to(bed, 13000, 1e-7);
    return sphere(bed, 0);
  };
  const Verified row(kField, "LAMMPS unittest/granular dem06-hookehistory-spin",
                     "its recorded velocities (4 Jul 2026), hooke");
  const Sphere like = run(true);
  const char* const why = "LAMMPS steps by 1 us, a 570th of the contact";
  row.near("normal velocity after, friction limit net-force", "m/s", like.v.z, 9.9865657293162532e-02, share(3e-3),
           why);
  row.near("tangential velocity after, friction limit net-force", "m/s", like.v.x, 1.2706938882175314e-01, share(1e-2),
           why);
  row.near("angular velocity after, friction limit net-force", "rad/s", like.w.y, 19.683950332657247, share(2e-3), why);
  const Sphere ours = run(false);
  // Pressing part of the impulse, unclipped linear spring-dashpot: 1 + e^(-gamma t) where the force passes zero.
  const double b = std::log(2) / std::hypot(pi, std::log(2)), root = std::sqrt(1 - b * b);
  const double pressing = 1 + std::exp(-b / root * std::atan2(2 * b * root, 2 * b * b - 1));
  const Verified own(kField, "The same with friction under the pressing force",
                     "closed form mu V (1 + e_+), e_+ where the force passes zero");
  own.near("tangential velocity after", "m/s", ours.v.x, 0.4 * 0.2 * pressing, share(1e-3),
           "the spring loads up over some steps");
}

/// unittest/granular/tests/dem05-mindlin-slip: sliding to rolling on a plane so soft that a sphere sinks in by 2.4 % of
/// its radius; LAMMPS's arm of friction is the radius there.
TEST(Peers, LammpsSlip) {
  const double dt = 1e-5;
  HertzMindlin law = lammps_material(1e4, 0.33, 1, 0.4);
  law.friction.moment_arm = MomentArm::radius;
  Bed bed(table(law), quiet({0, -1, 0}));
  const SphereSpec s{{0, 0.0024393, 0}, {1, 0, 0}, {}, 2.5e-3, 2700, 0};
  bed.add(std::span(&s, 1));
  add_plane(bed, {}, {0, 1, 0});
  const Verified row(kField, "LAMMPS unittest/granular dem05-mindlin-slip",
                     "its recorded velocities (4 Jul 2026), moment arm: radius");
  struct {
    int steps;
    double v, w;
  } const recorded[] = {{25000, 9.0000134588013636e-01, 9.9998654119854535e+01},
                        {50000, 8.0000429385394667e-01, 1.9999570614603323e+02},
                        {75000, 7.1426001642140247e-01, 2.8573998357857914e+02}};
  for (const auto& c : recorded) {
    run_to(bed, c.steps, dt);
    char at[32];
    std::snprintf(at, sizeof at, " at %.2f s", c.steps * dt);
    const char* const why = "velocities of half a step before; the weight swings on its spring";
    row.near(std::string("speed") + at, "m/s", sphere(bed, 0).v.x, c.v, share(1e-4), why);
    row.near(std::string("angular velocity") + at, "rad/s", -sphere(bed, 0).w.z, c.w, share(1e-4), why);
  }
}

/// MercuryDPM's unit test of Luding's law: k1 100, k2 500, kc 100, phi_f 0.05, spheres of mass 1 and radius 0.5 that
/// reach a share chi of the plastic overlap; without dashpot. It steps by a 25th of the collision.
TEST(Peers, MercuryPlasticForce) {
  const Verified row(kField, "MercuryDPM PlasticForceUnitTest",
                     "its expected velocities; Luding's law, k1 100, k2 500, k_c 100");
  const Verified exact("Plastic laws", "Luding: restitution of MercuryDPM's four impacts", "e^2 = 1 - loop/(m V^2/2)");
  struct {
    const char* name;
    double chi, v;
  } const cases[] = {{"0.34", 0.34, 0.032721738352012},
                     {"0.69", 0.69, 0},  // of it they expect a position within the contact
                     {"1.1", 1.1, 0},
                     {"1.37", 1.37, 0.163049415300304}};
  for (const auto& c : cases) {
    Luding law = sticky(100, 500, 100, 0.05, 0);
    law.damping = 0;
    const double limit = 500.0 / 400 * 0.05 * 0.5, v = std::sqrt(2 * 100) * c.chi * limit;
    BedOptions options = quiet();
    options.overlap_limit = 10;
    Bed bed(table(law), options);
    const double density = 6 / pi;
    const std::vector<SphereSpec> two{{{-0.5, 0, 0}, {v / 2, 0, 0}, {}, 0.5, density, 0},
                                      {{0.5, 0, 0}, {-v / 2, 0, 0}, {}, 0.5, density, 0}};
    bed.add(two);
    for (int n = 0; n < 200000 && (n < 100 || bed.touching_pairs() > 0); ++n) bed.step(2e-5);
    const double got = bed.touching_pairs() > 0 ? 0 : std::abs(sphere(bed, 0).v.x);
    row.near(std::string("speed after, chi = ") + c.name, "m/s", got, c.v, absolute(0.005 * v),
             "their 25 steps a collision leave some 0.5 % of the speed before; 0: they stick");
    // Loop to M, beyond the plastic limit back along the line k2: what it takes of m V^2/2; all of it, and they stick.
    const double m_eff = 0.5, M = std::min(c.chi, 1.0) * limit, p = 100 + 400 * M / limit;
    const double tear = (p - 100) * M / (p + 100);
    const double loop =
        100 * M * M / 2 - (std::pow(100 * M, 2) - std::pow(100 * tear, 2)) / (2 * p) + 100 * tear * tear / 2;
    exact.near(std::string("restitution, chi = ") + c.name, "1", 2 * got / v,
               std::sqrt(std::max(0.0, 1 - 2 * loop / (m_eff * v * v))), absolute(2e-4),
               "1e-5 of a branch a step, and a kink within a step; 0: they stick");
  }
}

}  // namespace
}  // namespace subsoil::dem::test::peers
