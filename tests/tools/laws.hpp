#pragma once
#include "libdem/laws/eepa.hpp"
#include "libdem/laws/hunt_crossley.hpp"
#include "libdem/laws/hysteretic.hpp"
#include "libdem/laws/jkr.hpp"
#include "libdem/laws/luding.hpp"
#include "libdem/laws/variable_restitution.hpp"
#include "tests/tools/dem_beds.hpp"

/// Laws with usual numbers, beside those of dem_beds.hpp.
namespace subsoil::dem::test {

/// Hunt-Crossley with c of its own.
inline HuntCrossley viscoelastic(double n, double c, double b, double mu, double mu_r = 0) {
  HuntCrossley h;
  h.impact.n = n, h.impact.c = c, h.impact.b = b;
  h.friction.mu = mu, h.friction.mu_r = mu_r;
  return h;
}

/// Soil after Ucgul, Fielke & Saunders: loading stiffness from the yield strength.
inline Hysteretic compactable(double yield = 5.88e5, double restitution = 0.6, double mu = 0.4, double mu_r = 0.05) {
  Hysteretic h;
  h.yield = yield, h.restitution = restitution;
  h.friction.mu = mu, h.friction.mu_r = mu_r;
  return h;
}

inline Luding sticky(double k1 = 1e4, double k2 = 5e4, double k_c = 1e4, double phi_f = 0.1, double mu = 0.4) {
  Luding l;
  l.k1 = k1, l.k2 = k2, l.k_c = k_c, l.phi_f = phi_f, l.damping = 0.05;
  l.friction.mu = mu, l.friction.mu_r = 0.05;
  return l;
}

inline Eepa powder(double n, double k1, double plasticity, double surface_energy, double restitution = 0.7) {
  Eepa e;
  e.n = n, e.k1 = k1, e.plasticity = plasticity, e.w = surface_energy, e.restitution = restitution;
  e.friction.mu = 0.4, e.friction.mu_r = 0.05;
  return e;
}

/// Softer than the map's metals, so that it yields in a test's bed; what is placed in touch bounces less each time.
inline VariableRestitution yielding(VariableRestitution::Normal part) {
  VariableRestitution v;
  v.part = part, v.E_eff = 1e7, v.map.S_y = 2e5, v.map.density = 1800, v.largest = 0.95;
  if (part == VariableRestitution::Normal::linear) v.k_n = 1e5;
  v.friction.mu = 0.4, v.friction.mu_r = 0.05;
  return v;
}

/// Soft adhesive spheres, a contact radius of 0.3 mm without load.
inline Jkr tacky(double work = 1, double restitution = 0.7, double mu = 0.4, double mu_r = 0.05) {
  Jkr j;
  j.take_materials(1e7, 0.3, 1e7, 0.3);
  j.work = work, j.restitution = restitution;
  j.friction.mu = mu, j.friction.mu_r = mu_r;
  return j;
}

inline Cohesion cohesion_by_area(double density, Cohesion::Area area = Cohesion::Area::lens) {
  Cohesion c;
  c.kind = Cohesion::Kind::linear, c.density = density, c.area = area;
  return c;
}
inline Cohesion dmt(double work) {
  Cohesion c;
  c.kind = Cohesion::Kind::dmt, c.work = work;
  return c;
}
/// Water between spheres of some millimetres.
inline Cohesion water(double volume = 1e-9, double angle = 0.3) {
  Cohesion c;
  c.kind = Cohesion::Kind::liquid_bridge;
  c.tension = 0.072, c.angle = angle, c.volume = volume;
  return c;
}
/// Cement between spheres of some millimetres that grains thrown about in a test break in part.
inline Bond cement(double modulus = 1.5e7, double strength = 2e5) {
  Bond b;
  b.kind = Bond::Kind::parallel;
  b.modulus = modulus, b.tensile = strength, b.shear = strength, b.gap = 1e-3;
  return b;
}
template <class Normal>
Normal with(Normal law, const Bond& bond) {
  law.bond = bond;
  return law;
}
template <class Normal>
Normal with(Normal law, const Cohesion& cohesion) {
  law.cohesion = cohesion;
  return law;
}

}  // namespace subsoil::dem::test
