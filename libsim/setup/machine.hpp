#pragma once
#include <memory>

#include "libmbd/machine.hpp"
#include "libsim/scenario/integrator_choice.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {

/// What a run from a state has to know of the start that the state goes back to.
struct MachineStart {
  const Scenario* begun_by = nullptr;  ///< its drivers hold the machine at the start; null: the scenario's own
  double time = 0;                     ///< of the state, s; drivers of the scenario act from there on
};

/// The machine of a scenario at its start: assembled from the given pose, or in the steady towing equilibrium. Null
/// when the scenario has none. Throws ScenarioError (place added) for what libmbd refuses.
std::unique_ptr<mbd::Machine> build_machine(const Loaded& loaded, const MachineStart& start = {});

/// Absolute error that the machine's method is asked for; of one without a tolerance that of cvode by default.
double atol_of(const Scenario& s);

/// The longest part of a machine step that fixed steps can take for the waves of beams, s; infinity without beams.
double longest_machine_step(const Scenario& s, const mbd::Model& model);

}  // namespace subsoil::sim
