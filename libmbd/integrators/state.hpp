#pragma once

#include <memory>
#include <vector>

#include "libmbd/assembly/partition.hpp"

namespace subsoil::mbd {

/// Energy that entered or left since the start (J): integrals of powers, never remainders.
struct EnergyFlows {
  /// Integrals of MotionState::rates: lost of forces, work of forces, work of drivers (J); then the states themselves.
  Eigen::VectorXd of_elements;
  double external_work = 0;  ///< of external wrenches: wrench times displacement, exact since it is constant per step
  double latched = 0;        ///< lost in impacts of joints that closed
};

/// What a step does not change: memories of elements, external wrenches, and the pose since which these act.
struct StepMemory {
  System::Memory elements;
  Eigen::VectorXd q_begin;
  long start = 0;  ///< number of the start or restoration of the machine that the step belongs to
};

/// A machine at an instant, as a value. Between the ends of a step it lies off Phi = 0 by the error of the dense
/// output; Evaluation puts it on the constraints and gives everything that follows from it.
struct State {
  MotionState motion;
  EnergyFlows flows;
  std::vector<char> open;   ///< joints that are open
  System::Grips grips;      ///< what forces hold from event to event
  bool before_jump = true;  ///< of outputs that jump at this instant, those before it
  bool nearest = false;     ///< beside a singular configuration
  double external_work_begin = 0;
  std::shared_ptr<const Choice> choice;
  std::shared_ptr<const StepMemory> memory;
};

}  // namespace subsoil::mbd
