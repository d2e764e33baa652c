#include <gtest/gtest.h>

#include "tests/tools/dem_beds.hpp"

/// Chung & Ooi 2011 (doi:10.1007/s10035-011-0277-0), tests 1 to 4. Figures of 1 and 2 follow from Hertz's closed form
/// for an elastic impact, evaluated here from E, nu, rho; they round to the table of verification.md.
namespace subsoil::dem::test {
namespace {

struct Impact {
  double force = 0, overlap = 0, duration = 0;
};

/// Hertz: delta = (15 m v^2/(16 E sqrt R))^(2/5), F = 4/3 E sqrt(R) delta^1.5, T = 2.9432 delta/v.
Impact hertz(double e_eff, double r, double m, double v) {
  const double d = std::pow(15 * m * v * v / (16 * e_eff * std::sqrt(r)), 0.4);
  // 2 int_0^1 dx/sqrt(1 - x^2.5) = (4/5) sqrt(pi) Gamma(2/5)/Gamma(9/10)
  const double time = 0.8 * std::sqrt(pi) * std::tgamma(0.4) / std::tgamma(0.9);
  return {4.0 / 3 * e_eff * std::sqrt(r) * std::pow(d, 1.5), d, time * d / v};
}

/// Steps until sphere 0 is free again; duration between the interpolated ends of touch.
Impact measure(Bed& bed, double dt, const std::function<double(const Snapshot&)>& overlap_of) {
  Impact out;
  double before = -1, begin = NAN;
  for (int n = 0; n < 200000; ++n) {
    const double t = bed.time();
    const Snapshot s = observe(bed, dt);
    const double overlap = overlap_of(s);
    if (n > 0 && overlap > 0 && before <= 0) begin = t - dt * overlap / (overlap - before);
    if (overlap <= 0 && before > 0) {
      out.duration = t - dt * overlap / (overlap - before) - begin;
      return out;
    }
    out.force = std::max(out.force, norm(s.force[0]));
    out.overlap = std::max(out.overlap, overlap);
    before = overlap;
  }
  ADD_FAILURE() << "never came apart";
  return out;
}

void expect_close(const Impact& got, const Impact& exact, const Impact& printed) {
  // 2000 steps a contact: leapfrog's error is (pi/2000)^2/24 = 1e-7 in the period, the ends are interpolated across the
  // force's kink; 1e-4 holds both. The printed figures carry four digits.
  EXPECT_NEAR(got.force, exact.force, 1e-4 * exact.force);
  EXPECT_NEAR(got.overlap, exact.overlap, 1e-4 * exact.overlap);
  EXPECT_NEAR(got.duration, exact.duration, 3e-4 * exact.duration);
  EXPECT_NEAR(got.force, printed.force, 1e-3 * printed.force);
  EXPECT_NEAR(got.overlap, printed.overlap, 1e-3 * printed.overlap);
  EXPECT_NEAR(got.duration, printed.duration, 2e-3 * printed.duration);
}

TEST(ChungOoi, Test1TwoSpheresHeadOn) {
  struct {
    double young, poisson, density;
    Impact printed;
  } const cases[] = {{48e9, .20, 2800, {10.70e3, 274.1e-6, 40.3e-6}}, {20e9, .25, 2500, {7.11e3, 368.3e-6, 54.2e-6}}};
  for (const auto& c : cases) {
    Bed bed(table(elastic(c.young, c.poisson, 1, 0.35)), quiet());
    const double r = 0.01, m = c.density * 4 / 3 * pi * r * r * r;
    const std::vector<SphereSpec> pair{{{-0.010001, 0, 0}, {10, 0, 0}, {}, r, c.density, 0},
                                       {{0.010001, 0, 0}, {-10, 0, 0}, {}, r, c.density, 0}};
    bed.add(pair);
    const Impact got =
        measure(bed, 2e-8, [&](const Snapshot& s) { return 2 * r - norm(s.position[0] - s.position[1]); });
    const double e_eff = c.young / (2 * (1 - c.poisson * c.poisson));
    expect_close(got, hertz(e_eff, r / 2, m / 2, 20), c.printed);
  }
}

TEST(ChungOoi, Test2SphereOnRigidWall) {
  struct {
    double young, poisson, density;
    Impact printed;
  } const cases[] = {{70e9, .30, 2699, {11.37e3, 49.7e-6, 732e-6}}, {40e9, .35, 1800, {7.23e3, 52.1e-6, 767e-6}}};
  for (const auto& c : cases) {
    Bed bed(table(against_rigid(c.young, c.poisson, 1, 0)), quiet());
    const double r = 0.1, m = c.density * 4 / 3 * pi * r * r * r;
    const SphereSpec s{{0, r + 1e-6, 0}, {0, -0.2, 0}, {}, r, c.density, 0};
    bed.add(std::span(&s, 1));
    add_plane(bed, {}, {0, 1, 0});
    const Impact got = measure(bed, 4e-7, [&](const Snapshot& n) { return r - n.position[0].y; });
    expect_close(got, hertz(c.young / (1 - c.poisson * c.poisson), r, m, 0.2), c.printed);
  }
}

/// The map e -> damping is that of the unclipped force, so restitution out equals restitution in.
TEST(ChungOoi, Test3RestitutionOutIsRestitutionIn) {
  struct {
    double young, poisson, density;
  } const materials[] = {{380e9, .23, 4000}, {100e9, .25, 7000}};
  for (const auto& c : materials)
    for (const double e : {0.1, 0.2, 0.4, 0.6, 0.8, 0.98, 1.0}) {
      Bed bed(table(against_rigid(c.young, c.poisson, e, 0)), quiet());
      const double r = 2.5e-3;
      const SphereSpec s{{0, r + 1e-8, 0}, {0, -3.9, 0}, {}, r, c.density, 0};
      bed.add(std::span(&s, 1));
      add_plane(bed, {}, {0, 1, 0});
      for (int n = 0; n < 20000 && (n < 100 || sphere(bed, 0).x.y < r); ++n) bed.step(5e-9);
      // Some 2000 steps a contact; damping lags by half a step: relative error beta omega dt ~ 1e-3 at e = 0.1.
      EXPECT_NEAR(sphere(bed, 0).v.y / 3.9, e, 1e-3) << e;
    }
}

/// Oblique impact at constant speed; table of verification.md. Published codes stay within about 2 %.
TEST(ChungOoi, Test4ObliqueImpactOnRigidWall) {
  struct {
    double angle, e_t, omega, rebound;
  } const cases[] = {{10, .687, -213, -1.6}, {20, .616, -511, -7.5}, {30, .684, -617, -3.5},
                     {40, .781, -545, 11.6}, {60, .893, -357, 47.8}, {80, .966, -126, 78.7}};
  for (const auto& c : cases) {
    HertzMindlin law = against_rigid(380e9, .23, .98, .092);
    Bed bed(table(law), quiet());
    const double r = 2.5e-3, a = c.angle * pi / 180;
    const SphereSpec s{{0, r + 1e-8, 0}, {3.9 * std::sin(a), -3.9 * std::cos(a), 0}, {}, r, 4000, 0};
    bed.add(std::span(&s, 1));
    add_plane(bed, {}, {0, 1, 0});
    for (int n = 0; n < 40000 && (n < 100 || sphere(bed, 0).x.y < r); ++n) bed.step(2e-9);
    const Sphere& out = sphere(bed, 0);
    const double patch = out.v.x + r * out.w.z;
    // At 10 deg the contact sticks nearly all the time, and there the simplified unloading of hertz_mindlin.hpp differs
    // from Mindlin and Deresiewicz by 2.4 %; omega follows from e_t by the impulse's moment about the centre.
    const double share = c.angle < 15 ? 0.03 : 0.02, v_t = 3.9 * std::sin(a);
    EXPECT_NEAR(out.v.x / v_t, c.e_t, share * c.e_t) << c.angle;
    EXPECT_NEAR(out.w.z, c.omega, 2.5 * share * c.e_t * v_t / r) << c.angle;
    EXPECT_NEAR(out.w.z, -2.5 * (v_t - out.v.x) / r, 4e-3 * std::abs(out.w.z)) << "lever r - delta";
    EXPECT_NEAR(std::atan2(patch, out.v.y) * 180 / pi, c.rebound, 1.5) << c.angle;
  }
}

}  // namespace
}  // namespace subsoil::dem::test
