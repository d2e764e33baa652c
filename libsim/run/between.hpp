#pragma once
#include "libdem/geometry/boundary.hpp"
#include "libdem/particles/particles.hpp"
#include "libdem/particles/periodic.hpp"
#include "libmbd/base/body.hpp"

/// What a frame shows between two instants of the step, `share` of the step before the second.
namespace subsoil::sim {

/// Spheres of `before`, a step apart, in a bed that may have periodic sides: positions on the cubic through x and v of
/// both (exact under constant acceleration, up to x'''' dt^4/384), vectors on a line (up to y'' dt^2/8), counts those
/// of the nearer instant. Those that are gone in `now` go straight on (up to x'' dt^2/2); those that are new in `now`
/// are not there yet.
/// @param memory whose arrays the result takes over: those of the frame before, since new pages cost as much as numbers
dem::Snapshot interpolate(const dem::Snapshot& before, const dem::Snapshot& now, double step, double share,
                          const dem::PeriodicCell& cell = {}, dem::Snapshot memory = {});

/// Position on a line, attitude by the shorter turn about one axis at constant rate.
dem::Pose interpolate(const dem::Pose& before, const dem::Pose& now, double share);

mbd::BodyState interpolate(const mbd::BodyState& before, const mbd::BodyState& now, double share);

}  // namespace subsoil::sim
