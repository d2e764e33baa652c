#include "libdem/impact/hertz.hpp"

#include "libdem/impact/hunt_crossley.hpp"

namespace subsoil::dem::impact {

Event Hertz::strike(const Pair& pair, double speed, int samples) const {
  HuntCrossleyModel law;
  law.c = pair.hertz(), law.b = 0;
  return law.strike(pair, speed, samples);
}

}  // namespace subsoil::dem::impact
