#include "libsim/scenario/sections/engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "libsim/scenario/checks.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {
namespace {

void refuse_by_engine(Checks& checks, const std::string& path, const char* what) {
  checks.refuse(path, fmt::format("`engine: liggghts` cannot do {}; leave it out, or leave `engine` out", what));
}

void check_engine_soil(Checks& checks, const Soil& soil) {
  if (soil.active) refuse_by_engine(checks, "soil.active", "frozen spheres");
  if (!soil.inlets.empty()) refuse_by_engine(checks, "soil.inlets", "spheres that come during the run");
  if (soil.moving) refuse_by_engine(checks, "soil.moving", "a moving bed");
  if (!soil.clumps.empty()) refuse_by_engine(checks, "soil.clumps", "clumps");
  if (soil.container)
    for (const bool periodic : soil.container->periodic)
      if (periodic) return refuse_by_engine(checks, "soil.container.periodic", "periodic sides");
  if (!soil.bed) return;
  if (soil.bed->rough_floor) refuse_by_engine(checks, "soil.bed.rough floor", "fixed spheres");
  for (std::size_t i = 0; i < soil.bed->particles.size(); ++i)
    if (!soil.bed->particles[i].fixed.empty())
      refuse_by_engine(checks, fmt::format("soil.bed.particles[{}].fixed", i), "fixed spheres");
}

}  // namespace

void check_engine(Checks& checks, const Scenario& s) {
  if (s.engine == SoilEngine::subsoil) return;
  if (!s.has_bed()) checks.refuse("engine", "liggghts", "steps spheres, and there is no soil; leave it out");
  if (s.precision == dem::Precision::mixed)
    checks.refuse("precision", "mixed", "`engine: liggghts` has double only; leave it out, or leave `engine` out");
  if (s.soil) check_engine_soil(checks, *s.soil);
  for (std::size_t i = 0; i < s.boundaries.size(); ++i)
    if (s.boundaries[i].wear) refuse_by_engine(checks, fmt::format("boundaries[{}].wear", i), "wear");
  if (s.machine)
    for (const Surface& surface : s.machine->surfaces)
      if (surface.wear) refuse_by_engine(checks, "machine.surfaces." + surface.name + ".wear", "wear");
  if (s.time.coupling == CouplingWord::iterated)
    checks.refuse("time.coupling", "iterated",
                  "repeats steps from a checkpoint, which `engine: liggghts` has not; take `explicit`, or leave "
                  "`engine` out");
  if (s.output.contact_forces) refuse_by_engine(checks, "output.contact forces", "single contacts in frames");
}

}  // namespace subsoil::sim
