#pragma once
#include <string>

#include "libdem/step/stability.hpp"

/// Longest step that resolves a contact: the speed after an impact, over the speed before, is off by no more than a
/// tolerance.
///
/// One body of mass m_eff meets the law along the normal at a speed, stepped as the bed steps (leapfrog, damping by the
/// velocity of half a step before). Restitution e(dt) depends on where between two steps the touch begins; the error is
/// the maximum over eight such phases,
///     error(dt) = max_phase |e(dt, phase) - e|,   e from steps that are 600 times finer than the stable step.
/// and, where a pull begins at once (DMT, liquid bridges, adhesion), over four phases in which the contact ends, by
/// steps shorter by up to one part in n: F_jump v dt/2 of energy each time that a pull begins or ends between two
/// steps, which a contact of just so many steps would cancel. Of slower impacts it is a larger share. It falls with the
/// step, in first order where the law damps: as 0.3/n to 0.6/n in a contact of n steps. Few steps may hit e by chance,
/// so a contact gets 0.4/tolerance steps at least. Pairs that stick have e = 0 at any step. A contact lasts from first
/// reach to last; without rebound there is no such time.
///
/// A body of a machine that is struck yields. It is stepped as the coupling steps it, by the force of t_n held over the
/// step:  X_{n+1} = X_n + V_n dt + (F_n/M) dt^2/2,  V_{n+1} = V_n + (F_n/M) dt, against the sphere's leapfrog. An
/// undamped contact of both gains energy by that: with w^2 = k (1/m + 1/M) the product of the two roots of a step is 1
/// + k dt^2/(2 M), so that the relative speed grows over the contact, pi/(w dt) steps, by
///     exp((pi/4) w dt m*/M),   1/m* = 1/m + 1/M
/// which calls for more steps than the law does once M is no longer large against m.
namespace subsoil::dem {

struct Impact {
  double restitution = 0;
  double duration = 0;  ///< s; 0 where the bodies do not come apart
  double touching = 0;  ///< s of it, without gaps; 0 where it is not counted
};

/// Two bodies along the normal at `speed`, m/s, in steps of dt, s; `phase` of a step, 0 to 1, passes before they reach
/// each other. Gives up, restitution 0, after `longest`, s.
Impact impact_in_steps(const Law& law, double m_eff, double r_eff, double per_sum, double speed, double dt,
                       double phase, double longest);

/// A sphere of mass m hits a body of mass M at rest, which takes a step every `body_steps` soil steps by the mean
/// force. Restitution is that of the relative speed.
Impact impact_on_body_in_steps(const Law& law, double m, double r, double body_mass, int body_steps, double speed,
                               double dt, double phase, double longest);

/// Restitution that fine steps have of the smallest sphere on a surface, that of a yielding body among them: laws take
/// the sphere's own mass at surfaces, whatever the body's is. @param stable a stable step, s
double restitution_at_surface(const Law& law, const StepQuestion& question, double stable);

struct AccurateStep {
  double step = 0;      ///< s, the stable step at most and a sixtieth of it at least
  double error = 0;     ///< of the restitution at this step
  double contact = 0;   ///< s that the contact lasts; 0 without rebound
  std::string cause{};  ///< "impact at 2 m/s, 31 steps of a contact", for the message
};

/// Maximum error of restitution at a step, over the phases.
double restitution_error(const Law& law, const StepQuestion& question, bool at_surface, double step, double stable);

/// Speed at which bodies enter the reach of a law, m/s, where `met` is the most that its pull makes of it on the way
/// in:
///     sqrt(met^2 - 2 W/m),   W = -int F d(overlap) up to where F > 0, from fine steps of an approach at `met`
/// 0 where the pull alone makes more. Without a pull it is `met`.
double speed_before_pull(const Law& law, const StepQuestion& question, bool at_surface, double met, double stable);

/// Of impacts between the smallest spheres, or of one on a fixed surface.
/// @param tolerance of the restitution; @param stable the law's stable step, s
AccurateStep accurate_step(const Law& law, const StepQuestion& question, bool at_surface, double tolerance,
                           double stable);

}  // namespace subsoil::dem
