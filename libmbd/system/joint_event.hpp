#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "libmbd/controllers/pid.hpp"

namespace subsoil::mbd {

/// A joint opens (release, shear pin) or closes (latch) when something happens: a time comes, a measure passes a value,
/// the force of its reaction exceeds a limit. Located like a contact, and the integration restarts there.
/// An open joint has no equations. One that closes does so where its bodies are: a pin in the point of the first body,
/// a weld at their angle, a link at its length then. Velocities v- become v+ = v- - M^-1 Phi_q^T P with all constraints
/// satisfied, Phi_q v+ = -Phi_t, a perfectly plastic impact; it loses (v+ - v-)^T M (v+ - v-)/2 (Carnot), and drivers
/// that move do P^T Phi_t. A joint that opens loses nothing. A joint that events only close starts open, unless given.
/// A measure must pass its value: where it is beyond at the start, or when the joint itself has just changed, it has to
/// come back first. Events that come at the same instant all happen, in any order, as one change with one
/// impact; those that come due by it (another reaction jumps above its limit, a velocity past its value) follow at that
/// instant.
/// Source of the impact: Pfeiffer & Glocker 1996, Multibody Dynamics with Unilateral Contacts, section 8.1.
struct JointEvent {
  enum class Does { opens, closes };
  /// Of the joint; by events: open where events only close it.
  enum class Starts { by_events, open, closed };
  std::string joint{};
  Does does = Does::opens;
  double at = std::numeric_limits<double>::quiet_NaN();              ///< s
  double reaction_above = std::numeric_limits<double>::quiet_NaN();  ///< N
  std::shared_ptr<ControllerInput> input{};
  double above = std::numeric_limits<double>::quiet_NaN(), below = std::numeric_limits<double>::quiet_NaN();
  Starts starts = Starts::by_events;
  // Set by the system:
  std::size_t index = 0;  ///< of the joint

  bool timed() const { return !std::isnan(at); }
  /// How far a value must come back before it can be passed again: more than rounding.
  double hysteresis() const {
    const double level = !std::isnan(above) ? above : !std::isnan(below) ? below : reaction_above;
    return std::fmax(1e-6 * std::abs(level), 1e-9);
  }
  void check() const {
    const int conditions = (timed() ? 1 : 0) + (std::isnan(reaction_above) ? 0 : 1) + (std::isnan(above) ? 0 : 1) +
                           (std::isnan(below) ? 0 : 1);
    if (conditions != 1)
      throw std::invalid_argument("needs one condition: a time, a limit of the reaction, or a measure above or below");
    if (!input && !(std::isnan(above) && std::isnan(below)))
      throw std::invalid_argument("a value is passed by nothing; name a measure");
    if (does == Does::closes && reaction_above > 0)
      throw std::invalid_argument("a joint that is open has no reaction; let a measure or a time close it");
  }
};

}  // namespace subsoil::mbd
