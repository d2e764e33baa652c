#pragma once
#include "libsim/io/summary.hpp"
#include "libsim/setup/world.hpp"

/// Wear of surfaces from what their triangles have borne (libdem/geometry/surface_loads.hpp).
namespace subsoil::sim {

/// K/H int F_n |v_t| dt, m^3 (Archard 1953).
double archard_volume(const WearSection& wear, const dem::FaceLoad& load);
/// k int |F| |v| f(a) dt, m^3 (Finnie 1960).
double finnie_volume(const WearSection& wear, const dem::FaceLoad& load);

/// Section `wear` of the summary: of each surface that keeps loads its totals up to the bed's last step and
/// its most worn triangle.
void write_wear(Summary& summary, const World& world);

}  // namespace subsoil::sim
