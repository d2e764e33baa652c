#pragma once
#include <cmath>
#include <limits>

#include "libdem/impact/impact.hpp"
#include "libdem/laws/law.hpp"

namespace subsoil::dem::impact {

/// The bodies of an impact as the bed takes them.
struct Strikers {
  double mass_1 = 0, radius_1 = 0;
  double mass_2 = std::numeric_limits<double>::infinity();    ///< infinite: fixed
  double radius_2 = std::numeric_limits<double>::infinity();  ///< infinite: flat

  /// Two spheres when both are free and round; else a sphere of the effective mass and radius on a fixed plane, whose
  /// relative motion is the same.
  bool two_spheres() const { return std::isfinite(mass_2) && std::isfinite(radius_2); }
  double mass() const { return std::isfinite(mass_2) ? mass_1 * mass_2 / (mass_1 + mass_2) : mass_1; }
  double radius() const { return 1 / (1 / radius_1 + 1 / radius_2); }
};

/// The same event stepped by a Bed of one contact, without gravity: what the engine makes of a law at a given step, s.
/// It ends where the surfaces part, of plastic bodies where their force ends before that.
/// Times of first touch, turn and separation are interpolated between steps; course holds every step. Errors are of
/// the order of the step where the law damps (its rate is that of half a step before), of its square where it does not.
/// Throws std::runtime_error when the bodies have not come apart after `most_steps`.
Event strike_in_bed(const Law& law, const Strikers& bodies, double speed, double step, long most_steps = 2000000);

}  // namespace subsoil::dem::impact
