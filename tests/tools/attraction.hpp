#pragma once
#include "tests/tools/dem_beds.hpp"

/// Cohesion and cement for the laws that have them.
namespace subsoil::dem::test {

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
/// Pull that is constant while touching and falls across a gap.
inline Cohesion adhesion(double force, double stiffness, Cohesion::Forms forms = Cohesion::Forms::on_contact) {
  Cohesion c;
  c.kind = Cohesion::Kind::linear_adhesion, c.force = force, c.stiffness = stiffness, c.forms = forms;
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
