#include "apps/scenario/sections/engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "apps/scenario/checks.hpp"
#include "apps/scenario/scenario.hpp"

namespace subsoil::app {
namespace {

void check_engine_soil(Checks& checks, const Soil& soil) {
  const auto refuse = [&](const std::string& path, const char* what) {
    checks.refuse(path, fmt::format("`engine: liggghts` cannot do {}; leave it out, or leave `engine` out", what));
  };
  if (soil.active) refuse("soil.active", "frozen spheres");
  if (soil.moving) refuse("soil.moving", "a moving bed");
  if (!soil.clumps.empty()) refuse("soil.clumps", "clumps");
  if (soil.container)
    for (const bool periodic : soil.container->periodic)
      if (periodic) return refuse("soil.container.periodic", "periodic sides");
  if (!soil.bed) return;
  if (soil.bed->rough_floor) refuse("soil.bed.rough floor", "fixed spheres");
  for (std::size_t i = 0; i < soil.bed->particles.size(); ++i)
    if (!soil.bed->particles[i].fixed.empty()) refuse(fmt::format("soil.bed.particles[{}].fixed", i), "fixed spheres");
}

}  // namespace

void check_engine(Checks& checks, const Scenario& s) {
  if (s.engine == SoilEngine::subsoil) return;
  const auto refuse = [&](const std::string& path, const char* what) {
    checks.refuse(path, fmt::format("`engine: liggghts` cannot do {}; leave it out, or leave `engine` out", what));
  };
  if (!s.has_bed()) checks.refuse("engine", "liggghts", "steps spheres, and there is no soil; leave it out");
  if (s.precision == dem::Precision::mixed)
    checks.refuse("precision", "mixed", "`engine: liggghts` has double only; leave it out, or leave `engine` out");
  if (s.soil) check_engine_soil(checks, *s.soil);
  for (std::size_t i = 0; i < s.boundaries.size(); ++i)
    if (s.boundaries[i].wear) refuse(fmt::format("boundaries[{}].wear", i), "wear");
  if (s.machine)
    for (const Surface& surface : s.machine->surfaces)
      if (surface.wear) refuse("machine.surfaces." + surface.name + ".wear", "wear");
  if (s.output.contact_forces) refuse("output.contact forces", "single contacts in frames");
}

}  // namespace subsoil::app
