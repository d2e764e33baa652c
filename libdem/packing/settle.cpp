#include "libdem/packing/settle.hpp"

#include "libdem/laws/friction.hpp"
#include "libdem/packing/settler.hpp"

namespace subsoil::dem {

Law softened(const Law& law, double attraction, double friction) {
  Friction f = law->friction();
  f.mu *= friction;
  f.mu_d *= friction;  // NaN, left out, stays NaN
  f.mu_r *= friction;
  f.mu_t *= friction;
  return law->weakened(attraction)->with_friction(f);
}

LawTable softened(LawTable laws, double attraction, double friction) {
  for (Law& law : laws.laws) law = softened(law, attraction, friction);
  return laws;
}

SettleReport settle(Bed& bed, const LawTable& laws, const SettlePlan& plan, const Bounds& region) {
  Settler settler(bed, laws, plan, region);
  if (plan.staged) {
    settler.soften();
    settler.rain();
    settler.raise();
  }
  settler.harden();
  settler.finish();
  settler.aim_at_once();
  settler.compact();
  settler.require_density();
  settler.cover();
  return settler.done();
}

}  // namespace subsoil::dem
