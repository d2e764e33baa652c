#pragma once
#include <cmath>
#include <string>

#include "tests/tools/dem_beds.hpp"

/// What the tests after Chung & Ooi share: Hertz's impact in closed form, a sphere that strikes a rigid plane.
namespace subsoil::dem::test {

inline const std::string kImpactField = "Impact";
inline const std::string kChungOoi = "Chung & Ooi 2011, doi:10.1007/s10035-011-0277-0";
inline const std::string kReadPoints = kChungOoi + ", points read off its figures (Kratos Multiphysics)";

struct Impact {
  double force = 0, overlap = 0, duration = 0;
};

/// Hertz: delta = (15 m v^2/(16 E sqrt R))^(2/5), F = 4/3 E sqrt(R) delta^1.5, T = 2.9432 delta/v.
inline Impact hertz(double e_eff, double r, double m, double v) {
  const double d = std::pow(15 * m * v * v / (16 * e_eff * std::sqrt(r)), 0.4);
  // 2 int_0^1 dx/sqrt(1 - x^2.5) = (4/5) sqrt(pi) Gamma(2/5)/Gamma(9/10)
  const double time = 0.8 * std::sqrt(pi) * std::tgamma(0.4) / std::tgamma(0.9);
  return {4.0 / 3 * e_eff * std::sqrt(r) * std::pow(d, 1.5), d, time * d / v};
}

/// What an oblique impact on a plane leaves: velocity along x, speed of rebound, spin about z; patch is the velocity of
/// the contact point along x.
struct Rebound {
  double v_t, v_n, spin, patch;
};

/// A sphere of radius r strikes the plane y = 0 with velocity v_t along x, v_n downward, and spin about z.
inline Rebound strike(const Law& law, double r, double density, double v_t, double v_n, double spin, double dt) {
  BedOptions options = quiet();
  options.speed_limit = 1e9;
  Bed bed(table(law), options);
  const SphereSpec s{{0, r * (1 + 1e-7), 0}, {v_t, -v_n, 0}, {0, 0, spin}, r, density, 0};
  bed.add(std::span(&s, 1));
  add_plane(bed, {}, {0, 1, 0});
  for (int n = 0; n < 100000 && (n < 100 || sphere(bed, 0).x.y < r); ++n) bed.step(dt);
  const Sphere& out = sphere(bed, 0);
  return {out.v.x, out.v.y, out.w.z, out.v.x + r * out.w.z};
}

struct Material {
  const char* name;
  double young, poisson, density;
};
inline HertzMindlin against_wall(const Material& m, double restitution, double mu) {
  return against_rigid(m.young, m.poisson, restitution, mu);
}
/// A four-thousandth of Hertz's contact.
inline double fine_step(const Material& m, double r, double v_n) {
  const double mass = m.density * 4 / 3 * pi * r * r * r;
  return hertz(m.young / (1 - m.poisson * m.poisson), r, mass, v_n).duration / 4000;
}

struct Point {
  double in, out;
};

}  // namespace subsoil::dem::test
