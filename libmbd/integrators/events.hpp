#pragma once

#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "libmbd/system/system.hpp"

namespace subsoil::mbd {

/// A switching function has passed through zero.
struct Event {
  double t = 0;
  std::string name;   ///< of the force or joint it belongs to
  int direction = 0;  ///< -1: closed (the gap became negative) or began to stick, +1: opened or began to slide
  bool of_friction = false;

  const char* word() const {
    if (of_friction) return direction < 0 ? "sticks" : "slides";
    return direction < 0 ? "closes" : "opens";
  }
};

/// The switching functions of a system: forces with a member `double gap(const Scene&) const`, a signed distance or
/// angle on whose sign the force's law depends: > 0 open, < 0 in contact; with several of them, `gaps`; or with `double
/// hold(const Scene&, k) const`, which falls through 0 where friction at a place k changes between sliding and
/// sticking, decided by `pass_event(const Scene&, k)`. Smooth methods keep their order only between the zeros of these;
/// a zero is located, the method restarted there, the event counted. Gaps pass 0 by their rounding before it is one,
/// either way: surfaces that touch without load would open and close with every rounding. A contact that closes and
/// opens again within one step leaves no change of sign: integrators with a dense output look for it inside the step
/// (find_hidden_contact).
class Switches {
 public:
  explicit Switches(const System& system);

  /// Those of forces first, then those of events of joints.
  std::size_t count() const { return of_forces_.size() + system_.model().events.size(); }
  const std::string& name(std::size_t i) const;  ///< of the force, or of the joint
  std::size_t force(std::size_t i) const { return of_forces_[i].force; }
  std::size_t place(std::size_t i) const { return of_forces_[i].place; }  ///< of the force
  bool of_joint(std::size_t i) const { return i >= of_forces_.size(); }
  std::size_t event(std::size_t i) const { return i - of_forces_.size(); }
  /// Whether it is one of friction, which is positive before and after an event.
  bool of_friction(std::size_t i) const { return !of_joint(i) && of_forces_[i].friction; }
  bool of_gap(std::size_t i) const { return !of_joint(i) && !of_forces_[i].friction; }
  /// Whether any is the gap of a contact; the others belong to friction and to events of joints.
  bool has_gaps() const { return has_gaps_; }
  /// All gaps at the state, with multipliers where there is friction, that the system was set to last. Events of joints
  /// are asked with accelerations and multipliers of that state; without them they count as far away.
  void gaps(std::span<double> out, const Eigen::VectorXd* acceleration = nullptr,
            const Eigen::VectorXd* lambda = nullptr) const;

  /// Bounds on how fast gaps change at the state set last (m/s, rad/s); 0 for what is no gap.
  void gap_speeds(std::span<double> out) const;

  /// Sides begin as the gaps at the state set last have them (0 counts as open).
  void take_sides();
  int side(std::size_t i) const { return sides_[i]; }
  void set_side(std::size_t i, int side) { sides_[i] = side; }

 private:
  double rounding() const;  ///< of gaps at the state set last

  const System& system_;
  struct OfForce {
    std::size_t force, place;
    bool friction;
  };
  std::vector<OfForce> of_forces_;
  bool has_gaps_ = false;
  std::vector<int> sides_;
  std::vector<double> work_;
};

/// Whether a force changes at its events, so that these have to be located: friction that sticks, impacts of a given
/// restitution.
bool needs_events(const AnyForce& force);

/// True when any force does.
bool needs_events(const Model& model);

/// True when friction of a force can stick.
bool can_stick(const Model& model);

/// True when forces remember accepted states (ruts): then no step may run ahead of what is accepted.
bool remembers(const Model& model);

/// The share in (0, 1] of a step at which `gap(share)` has just come to the other side, to 1e-12 of the step. At share
/// 0 the gap counts as on `side`, whatever its rounding; gap(1) is on the other. Regula falsi of Illinois, bisection
/// while the left end is unknown.
double locate_crossing(const std::function<double(double)>& gap, int side, double gap_at_start, double gap_at_end);

}  // namespace subsoil::mbd
