#pragma once
#include <optional>
#include <string>
#include <vector>

#include "libmbd/integrators/integrator.hpp"
#include "libsim/keys/fields.hpp"
#include "libsim/scenario/sections/defaults.hpp"

/// End, steps, integrator.
namespace subsoil::sim {

/// automatic: see integrator_of() in libsim/scenario/integrator_choice.hpp.
enum class IntegratorWord { automatic, adams_moulton, cvode, ida };
struct MachineTime {
  IntegratorWord integrator = IntegratorWord::automatic;
  std::optional<long> order;         // of adams-moulton
  std::optional<double> rtol, atol;  // cvode, ida
  mbd::IdaFormulation formulation = mbd::IdaFormulation::stabilised_index_2;
  bool locate_events = true;
  long soil_steps = 1;         // soil steps per machine step
  std::optional<double> step;  // without soil; with soil it is soil_steps * soil step
};
void describe(Fields& v, MachineTime& t);

/// A condition that ends a run in order.
struct StopSection {
  std::string name, column;
  std::string above, below;  // the value with the column's unit; one of them
  std::optional<double> held;
};
void describe(Fields& v, StopSection& s);

/// How often soil and machine exchange motion and force: once per machine step, or until they agree.
enum class CouplingWord { once, iterated };

struct Time {
  double end = required;            // of dynamics and kinematics
  std::optional<double> soil_step;  // empty: auto
  double safety = 0.8;              // auto step / stable step (a bound on the safe side)
  double accuracy = 0.01;           // of the restitution, with the auto step
  CouplingWord coupling = CouplingWord::once;
  double coupling_tolerance = 1e-9;  // m
  long coupling_iterations = 20;
  MachineTime machine;
  std::vector<StopSection> stop_when;
  long threads = 0;  // 0: by the size of the bed
};
void describe(Fields& v, Time& t);

struct Checks;
struct Scenario;
void check_time(Checks& checks, const Scenario& s);

}  // namespace subsoil::sim
