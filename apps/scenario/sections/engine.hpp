#pragma once

namespace subsoil::app {

struct Checks;
struct Scenario;

/// What a scenario cannot hold whose spheres LIGGGHTS steps (docs/reference/many-nodes.md).
void check_engine(Checks& checks, const Scenario& s);

}  // namespace subsoil::app
