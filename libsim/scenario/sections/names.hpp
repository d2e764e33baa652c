#pragma once
#include "libsim/scenario/checks.hpp"

namespace subsoil::sim {

/// Owners of columns, of surfaces in the frames and of what `soil force` asks for have one name each: the program's own
/// (`time`, `energy`; with soil `soil`, `container`, `floor`, ...), boundaries, fixed spheres, all of the machine. A
/// surface may be called like anything of the machine, whose columns are others. Needs the machine's beams in place.
void check_names(Checks& checks, const Scenario& scenario);

}  // namespace subsoil::sim
