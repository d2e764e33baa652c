#include "apps/scenario/sections/limits.hpp"

namespace subsoil::app {

void describe(Fields& v, Limits& l) {
  v.quantity("overlap", l.overlap, "1", "(0, 2]", "share of a radius; a deeper contact stops the run");
  v.quantity("speed", l.speed, "m/s", "(0, inf)", "a faster sphere stops the run");
}

}  // namespace subsoil::app
