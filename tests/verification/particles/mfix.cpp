#include <gtest/gtest.h>

#include "tests/tools/dem_beds.hpp"
#include "tests/tools/verified.hpp"

/// MFiX DEM01 to DEM04 (linear spring-dashpot), and sliding and rolling of one sphere, against closed forms.
namespace subsoil::dem::test::mfix {
namespace {

using subsoil::test::absolute;
using subsoil::test::share;
using subsoil::test::Verified;

const std::string kMfix = "MFiX DEM cases", kTurning = "Sliding, rolling, spinning";
const std::string kManual = "MFiX VVUQ manual, chapter 4 (Garg et al. 2012)";

std::string of(const char* format, double a, double b = 0) {
  char text[96];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

/// Speed of rebound of m x'' = -k x - c x' + m g from x = 0 with speed v: the first root of x(t) after its crest.
double soft_rebound(double v, double k, double m, double e, double g) {
  const double beta = -std::log(e) / std::hypot(pi, std::log(e)), omega = std::sqrt(k / m), decay = beta * omega;
  const double w = omega * std::sqrt(1 - beta * beta), s = g / (omega * omega), b = (v - decay * s) / w;
  const auto x = [&](double t) { return s + std::exp(-decay * t) * (b * std::sin(w * t) - s * std::cos(w * t)); };
  double low = 0.6 * pi / w, high = 1.5 * pi / w;
  for (int n = 0; n < 200; ++n) {
    const double middle = 0.5 * (low + high);
    (x(middle) > 0 ? low : high) = middle;
  }
  const double h = 1e-6 / omega;
  return -(x(low + h) - x(low - h)) / (2 * h);
}

/// DEM01/02: contact time pi/omega_d, restitution e; apex heights h_k = (h0 - r) e^(2k) + r as stiffness grows.
TEST(Mfix, Dem01BouncingSphere) {
  const double r = 0.1, density = 2600, h0 = 0.5, g = 9.81;
  const Verified row(kMfix, "DEM02: bouncing sphere, apex heights", kManual + ": (h0 - r) e^(2k) + r of a hard sphere");
  const Verified soft(kMfix, "DEM01: freely falling sphere, three stages",
                      kManual + ": closed form of the soft sphere under gravity");
  for (const double e : {0.6, 0.8}) {
    double error[2];
    for (const int stiff : {0, 1}) {
      Bed bed(table(grains(stiff ? 4e6 : 1e6, e, 0)), quiet({0, -g, 0}));
      const SphereSpec s{{0, h0, 0}, {}, {}, r, density, 0};
      bed.add(std::span(&s, 1));
      add_plane(bed, {}, {0, 1, 0});
      const double dt = stiff ? 5e-6 : 1e-5;  // omega dt = 3e-3: damping that lags costs less than gravity
      double apex[3] = {}, before = 0;
      int bounce = 0;
      for (int n = 0; bounce < 3 && n < 400000; ++n) {
        const double v = sphere(bed, 0).v.y;
        if (before > 0 && v <= 0) apex[bounce++] = sphere(bed, 0).x.y;
        before = v;
        bed.step(dt);
      }
      // While in contact gravity adds about g/omega to speeds of 2.8 m/s: first order in 1/sqrt(k), 1 % and 0.5 %.
      const double m = density * 4 / 3 * pi * r * r * r, omega = std::sqrt((stiff ? 4e6 : 1e6) / m);
      error[stiff] = 0;
      double fall = std::sqrt(2 * g * (h0 - r));
      for (int k = 1; k <= 3; ++k) {
        const double want = (h0 - r) * std::pow(e, 2 * k) + r;
        const double v = std::sqrt(2 * g * (h0 - r)) * std::pow(e, k);
        fall = soft_rebound(fall, stiff ? 4e6 : 1e6, m, e, g);
        soft.near(of("apex %g, e %g, ", k, e) + (stiff ? "k 4 MN/m" : "k 1 MN/m"), "m", apex[k - 1],
                  r + fall * fall / (2 * g), absolute(1.5e-3 * k * (h0 - r) * std::pow(e, 2 * k)),
                  "omega dt = 3e-3: damping lags by half a step, the contact begins within one");
        row.near(of("apex %g, e %g, ", k, e) + (stiff ? "k 4 MN/m" : "k 1 MN/m"), "m", apex[k - 1], want,
                 absolute(4.0 * k * v / omega + 1e-5), "gravity in contact adds g/omega to the speed");
        error[stiff] = std::max(error[stiff], std::abs(apex[k - 1] - want));
      }
    }
    if (e < 1) {
      row.near(of("error at k over error at 4 k, e %g", e), "1", error[0] / error[1], 2, absolute(0.5),
               "first order in 1/sqrt(k)");
    }
  }
}

TEST(Mfix, Dem02ContactTime) {
  const Verified row(kMfix, "DEM01: contact of the linear spring-dashpot", kManual + ": pi/omega_d and e");
  for (const double e : {0.3, 0.7, 1.0}) {
    const double r = 0.1, k = 1e6;
    Bed bed(table(grains(k, e, 0)), quiet());
    const SphereSpec s{{0, r, 0}, {0, -1, 0}, {}, r, 2600, 0};
    bed.add(std::span(&s, 1));
    add_plane(bed, {}, {0, 1, 0});
    const double m = sphere(bed, 0).m, log_e = std::log(e);
    const double beta = -log_e / std::sqrt(pi * pi + log_e * log_e);
    const double period = pi / (std::sqrt(k / m) * std::sqrt(1 - beta * beta)), dt = period / 4000;
    double y = r, t = 0;
    for (; t == 0 || y < r; t += dt) {
      bed.step(dt);
      y = sphere(bed, 0).x.y;
    }
    // The end is found to one step of 4000; lagged damping shifts by as much.
    row.near_by_chance(of("contact time, e %g", e), "s", t, period, share(2e-3),
                       "found to a step of 4000; damping lags by half");
    row.near(of("restitution, e %g", e), "1", sphere(bed, 0).v.y, e, absolute(2e-3), "the same");
  }
}

/// DEM03: two stacked spheres, pressed between floor and ceiling, against the two-degree-of-freedom ODE by RK4.
TEST(Mfix, Dem03TwoStackedSpheres) {
  const double r = 5e-4, k = 1e2, e = 0.8, g = 9.81, gap = 1.8e-3;
  Bed bed(table(grains(k, e, 0)), quiet({0, -g, 0}));
  const std::vector<SphereSpec> two{{{0, 4.5e-4, 0}, {}, {}, r, 20000, 0}, {{0, 1.35e-3, 0}, {}, {}, r, 10000, 0}};
  bed.add(two);
  add_plane(bed, {}, {0, 1, 0});
  add_plane(bed, {0, gap, 0}, {0, -1, 0});
  const double m1 = sphere(bed, 0).m, m2 = sphere(bed, 1).m;
  const double beta = -std::log(e) / std::hypot(pi, std::log(e));
  const auto force = [&](double overlap, double rate, double m) {
    return overlap > 0 ? k * overlap + 2 * beta * std::sqrt(m * k) * rate : 0.0;
  };
  using State = std::array<double, 4>;
  const auto slope = [&](const State& s) -> State {
    const double floor = force(r - s[0], -s[2], m1), ceiling = force(s[1] + r - gap, s[3], m2);
    const double between = force(2 * r - (s[1] - s[0]), s[2] - s[3], m1 * m2 / (m1 + m2));
    return {s[2], s[3], -g + (floor - between) / m1, -g + (between - ceiling) / m2};
  };
  State s{4.5e-4, 1.35e-3, 0, 0};
  const double dt = 2e-7;
  double worst = 0, moved = 0;
  for (int n = 0; n < 100000; ++n) {
    const auto plus = [](State a, const State& b, double h) {
      for (int i = 0; i < 4; ++i) a[static_cast<std::size_t>(i)] += h * b[static_cast<std::size_t>(i)];
      return a;
    };
    const State k1 = slope(s), k2 = slope(plus(s, k1, dt / 2)), k3 = slope(plus(s, k2, dt / 2)),
                k4 = slope(plus(s, k3, dt));
    s = plus(plus(plus(plus(s, k1, dt / 6), k2, dt / 3), k3, dt / 3), k4, dt / 6);
    bed.step(dt);
    worst = std::max({worst, std::abs(sphere(bed, 0).x.y - s[0]), std::abs(sphere(bed, 1).x.y - s[1])});
    moved = std::max(moved, std::abs(s[0] - 4.5e-4));
  }
  EXPECT_GT(moved, 1e-5);
  const Verified row(kMfix, "DEM03: two stacked spheres, pressed", kManual + ": two-degree-of-freedom equation by RK4");
  // Damping lags by dt/2: relative error beta omega dt = 0.07 x 4400/s x 2e-7 s = 6e-5 of a motion of 5e-5 m.
  row.near("maximum difference of a position within 20 ms", "m", worst, 0, absolute(1e-3 * moved),
           "1e-3 of the motion; damping lags by half a step");
}

/// DEM04: sliding sphere on a rough plane rolls at t = 2 u0/(7 mu g) with u = 5 u0/7.
TEST(Mfix, Dem04SlidingToRolling) {
  const double r = 5e-4, u0 = 0.1, g = 9.81;
  const Verified row(kMfix, "DEM04: sphere sliding on a rough plane", kManual + ": rolls at 2 u0/(7 mu g) with 5/7 u0");
  for (const double mu : {0.1, 0.3, 0.8}) {
    Bed bed(table(grains(1e4, 0.9, mu, 0)), quiet({0, -g, 0}));
    const double m = 2600 * 4 / 3 * pi * r * r * r;
    const SphereSpec s{{0, r - m * g / 1e4, 0}, {u0, 0, 0}, {}, r, 2600, 0};
    bed.add(std::span(&s, 1));
    add_plane(bed, {}, {0, 1, 0});
    const double t_roll = 2 * u0 / (7 * mu * g), dt = t_roll / 20000;
    while (bed.time() < 0.5 * t_roll) bed.step(dt);
    row.near(of("speed at half that time, mu %g", mu), "m/s", sphere(bed, 0).v.x, u0 - mu * g * (bed.time() - dt / 2),
             absolute(1e-6 * u0), "linear in time: rounding and the first kick");
    while (bed.time() < 1.3 * t_roll) bed.step(dt);
    // After gripping a tangential vibration remains: its speed is mu g/omega_t, here below 1e-3 of u0.
    row.near(of("speed at 1.3 of it, mu %g", mu), "m/s", sphere(bed, 0).v.x, 5 * u0 / 7, absolute(2e-3 * u0),
             "a tangential vibration remains, mu g/omega_t");
    row.near(of("r omega at 1.3 of it, mu %g", mu), "m/s", -sphere(bed, 0).w.z * r, 5 * u0 / 7, absolute(5e-3 * u0),
             "the same");
  }
}

TEST(Sliding, SlipToRollTable) {
  const double r = 2.5e-3, g = 1;
  const double m = 2700 * 4 / 3 * pi * r * r * r;
  Bed bed(table(grains(1e3, 0.9, 0.4, 0)), quiet({0, -g, 0}));
  const SphereSpec s{{0, r - m * g / 1e3, 0}, {1.4, 0, 0}, {}, r, 2700, 0};
  bed.add(std::span(&s, 1));
  add_plane(bed, {}, {0, 1, 0});
  const Verified row(kTurning, "Slip to roll: 5 mm, 1.4 m/s, mu 0.4, g 1 m/s^2",
                     "u = u0 - mu g t, omega = 5 mu g t/(2 r)");
  const double dt = 1e-5, table_[3][3] = {{.4, 1.24, 160}, {.7, 1.12, 280}, {1.0, 1.00, 400}};
  for (const auto& at : table_) {
    while (bed.time() < at[0] - dt / 2) bed.step(dt);
    const Snapshot now = observe(bed, dt);
    // The moment arm is r - delta: r m g/k = 7e-5 of omega; 1e-4 in u from the first kick on the flat contact.
    row.near(of("speed at %g s", at[0]), "m/s", now.velocity[0].x, at[1], absolute(2e-4),
             "first kick on the flat contact");
    row.near(of("angular velocity at %g s", at[0]), "rad/s", -now.angular_velocity[0].z, at[2], absolute(0.1),
             "moment arm r - delta, 7e-5 of omega");
  }
}

Linear gripping(double mu, double mu_r) {
  Linear law = grains(1e4, 0.9, mu, mu_r);
  law.friction.rolling = Rolling::constant_torque;
  return law;
}

constexpr double kRadius = 5e-3, kGravity = 9.81, kDensity = 2500;

Bed one_on_plane(const Linear& law, const Vec3& gravity, const Vec3& v, const Vec3& w) {
  Bed bed(table(law), quiet(gravity));
  const double m = kDensity * 4 / 3 * pi * std::pow(kRadius, 3);
  const SphereSpec s{{0, kRadius + m * gravity.y / 1e4, 0}, v, w, kRadius, kDensity, 0};
  bed.add(std::span(&s, 1));
  add_plane(bed, {}, {0, 1, 0});
  return bed;
}

/// The moment arm is r minus the overlap of 1.3 um (3e-4 of r), and the onset of friction leaves a vibration that
/// decays.
TEST(RollingResistance, RollingWithoutSlipSlowsDown) {
  const double mu_r = 0.05, w0 = 100, dt = 1e-5;
  Bed bed = one_on_plane(gripping(0.5, mu_r), {0, -kGravity, 0}, {w0 * kRadius, 0, 0}, {0, 0, -w0});
  for (int n = 0; n < 30000; ++n) bed.step(dt);
  const double drop = 5 * mu_r * kGravity / (7 * kRadius) * bed.time();
  const Verified row(kTurning, "Rolling without slip, mu_r 0.05, constant torque", "omega0 - 5 mu_r g t/(7 r)");
  row.near("loss of angular velocity in 0.3 s", "rad/s", w0 + sphere(bed, 0).w.z, drop, share(5e-3),
           "moment arm r - delta; friction starts with a vibration");
}

TEST(RollingResistance, SpinningInPlaceWithoutFriction) {
  const double mu_r = 0.05, w0 = 100, dt = 1e-5;
  Bed bed = one_on_plane(gripping(0, mu_r), {0, -kGravity, 0}, {}, {0, 0, -w0});
  for (int n = 0; n < 20000; ++n) bed.step(dt);
  const double drop = 5 * mu_r * kGravity / (2 * kRadius) * bed.time();
  const Verified row(kTurning, "Spinning in place without friction, mu_r 0.05",
                     "omega0 - 5 mu_r g t/(2 r) (LAMMPS's rolling_decay)");
  row.near("loss of angular velocity in 0.2 s", "rad/s", w0 + sphere(bed, 0).w.z, drop, share(1e-4),
           "exact but for the first half step");
}

TEST(RollingResistance, DownAnIncline) {
  const double mu_r = 0.05, theta = 10 * pi / 180, dt = 1e-5;
  Bed bed = one_on_plane(gripping(0.5, mu_r), kGravity * Vec3{std::sin(theta), -std::cos(theta), 0}, {}, {});
  for (int n = 0; n < 30000; ++n) bed.step(dt);
  const double v = 5.0 / 7 * kGravity * (std::sin(theta) - mu_r * std::cos(theta)) * bed.time();
  const Verified row(kTurning, "Rolling down 10 deg, mu_r 0.05", "(5/7) g (sin theta - mu_r cos theta) t");
  row.near("speed after 0.3 s", "m/s", sphere(bed, 0).v.x, v, share(2e-3),
           "moment arm r - delta; the onset of friction");
}

/// Elastic-plastic form: at rest below the rolling limit it holds for good, above it rolls with the cap's torque.
TEST(RollingResistance, ElasticPlasticHoldsAndYields) {
  for (const double tangent : {0.04, 0.10}) {
    Linear law = grains(1e4, 0.5, 0.5, 0.05);
    const double theta = std::atan(tangent), dt = 1e-5;
    Bed bed = one_on_plane(law, kGravity * Vec3{std::sin(theta), -std::cos(theta), 0}, {}, {});
    for (int n = 0; n < 50000; ++n) bed.step(dt);
    const double v = 5.0 / 7 * kGravity * (std::sin(theta) - 0.05 * std::cos(theta)) * bed.time();
    const Verified row(kTurning, "Elastic-plastic rolling resistance on an incline, mu_r 0.05",
                       "holds below tan theta = mu_r, yields above");
    if (tangent > 0.05) {
      row.near("speed after 0.5 s, tan theta 0.10", "m/s", sphere(bed, 0).v.x, v, share(0.03),
               "less the angle in which the spring loads up");
    } else {
      row.near("speed after 0.5 s, tan theta 0.04", "m/s", sphere(bed, 0).v.x, 0, absolute(1e-7), "kept by its spring");
    }
  }
}

}  // namespace
}  // namespace subsoil::dem::test::mfix
