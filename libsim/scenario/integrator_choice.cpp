#include "libsim/scenario/integrator_choice.hpp"

#include <algorithm>

#include "libmbd/forces/hydraulic_cylinder.hpp"
#include "libsim/scenario/scenario.hpp"

namespace subsoil::sim {
namespace {

/// A chamber answers its valves within 10 us, below the step of most soils: fixed steps would lose the oil's energy.
bool has_oil(const Scenario& s) {
  if (!s.machine || !s.machine->beams.empty()) return false;  // the waves of beams would make cvode slow
  const auto& forces = s.machine->forces;
  return std::any_of(forces.begin(), forces.end(),
                     [](const NamedForce& f) { return f.element.get_if<mbd::HydraulicCylinder>() != nullptr; });
}

}  // namespace

mbd::IntegratorKind integrator_of(const Scenario& s) {
  if (s.analysis == Analysis::kinematics) return mbd::IntegratorKind::kinematic;
  const MachineTime& time = s.time.machine;
  switch (time.integrator) {
    case IntegratorWord::cvode:
      return mbd::IntegratorKind::cvode;
    case IntegratorWord::ida:
      return mbd::IntegratorKind::ida;
    case IntegratorWord::adams_moulton:
      return mbd::IntegratorKind::adams_moulton;
    case IntegratorWord::automatic:
      break;
  }
  const bool alone = !s.soil && s.boundaries.empty();
  if (time.step || time.order) return mbd::IntegratorKind::adams_moulton;
  if (!alone) return has_oil(s) ? mbd::IntegratorKind::cvode : mbd::IntegratorKind::adams_moulton;
  // The fastest wave of a beam is a thousand times faster than what bends it: stiff.
  return !s.machine || s.machine->beams.empty() ? mbd::IntegratorKind::cvode : mbd::IntegratorKind::ida;
}

}  // namespace subsoil::sim
