#pragma once

namespace subsoil::sim {

struct Checks;
struct Scenario;

/// What a scenario cannot hold whose spheres LIGGGHTS steps (docs/reference/many-nodes.md).
void check_engine(Checks& checks, const Scenario& s);

}  // namespace subsoil::sim
