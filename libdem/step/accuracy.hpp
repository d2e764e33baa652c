#pragma once
#include <string>

#include "libdem/step/stability.hpp"

/// Longest step that resolves a contact: the speed after an impact, over the speed before, is off by no more than a
/// tolerance.
///
/// One body of mass m_eff meets the law along the normal at a speed, stepped as the bed steps (leapfrog, damping by the
/// velocity of half a step before). Restitution e(dt) depends on where between two steps the touch begins; the error is
/// the largest over eight such phases,
///     error(dt) = max_phase |e(dt, phase) - e|,   e from steps that are 600 times finer than the stable step.
/// It falls with the step, in first order where the law damps: as 0.3/n to 0.6/n in a contact of n steps. Few steps may
/// hit e by chance, so a contact gets 0.4/tolerance steps at least. Pairs that stick have e = 0 at any step. A contact
/// lasts from first reach to last; without rebound there is no such time.
namespace subsoil::dem {

struct Impact {
  double restitution = 0;
  double duration = 0;  ///< s; 0 where the bodies do not come apart
};

/// Two bodies along the normal at `speed`, m/s, in steps of dt, s; `phase` of a step, 0 to 1, passes before they reach
/// each other. Gives up, restitution 0, after `longest`, s.
Impact impact_in_steps(const Law& law, double m_eff, double r_eff, double per_sum, double speed, double dt,
                       double phase, double longest);

struct AccurateStep {
  double step = 0;      ///< s, the stable step at most and a sixtieth of it at least
  double error = 0;     ///< of the restitution at this step
  double contact = 0;   ///< s that the contact lasts; 0 without rebound
  std::string cause{};  ///< "impact at 2 m/s, 31 steps of a contact", for the message
};

/// Largest error of restitution at a step, over the phases.
double restitution_error(const Law& law, const StepQuestion& question, bool at_surface, double step, double stable);

/// Of impacts between the smallest spheres, or of one on a fixed surface.
/// @param tolerance of the restitution; @param stable the law's stable step, s
AccurateStep accurate_step(const Law& law, const StepQuestion& question, bool at_surface, double tolerance,
                           double stable);

}  // namespace subsoil::dem
